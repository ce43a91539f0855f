"""A table judged: what it says, how its clock and frame stand, how far it is off, and why."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from conrod.engines.numerics import largest_derivatives, phase_bound
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.tables.causes import Cause, likely_causes
from conrod.own.tables.columns import CRANK_ANGLE, TIME, Column, quantities
from conrod.own.tables.errors import ERRORS, Errors, Exact
from conrod.own.tables.estimation import Estimate, aligned, estimate
from conrod.own.tables.reading import Reading
from conrod.scenes import Scene
from conrod.studies.frame.prediction import misfit_words, reference_misfit

# Below this nobody asks why, but for a tolerance: tables are written with so many digits.
NOTEWORTHY = 1e-6
BEYOND = 1e-6  # [rad], of a pass, by which digits that a table left out may lead
CLOCK_NOTE = (
    "phase and total are held to the scene's speed from crank angle 0 at time 0: --set speed=SPEED gives another, "
    "--estimate time finds an unknown start, and --tolerance phase=ANGLE allows a drive that does not keep its speed"
)
EPS = float(np.finfo(float).eps)
RMS = "velocity_rms"
DIGITS = 17  # that tell doubles apart


@dataclass(frozen=True)
class TableStudy:
    """The result of `conrod validate TABLE --scene SCENE`, or of an FMU, whose run is the table.

    Attributes:
        file: name of the table.
        scene_name, scene: what it is judged against.
        columns, unused: which of its columns are what, and headings of the others.
        form: how the file is written, in words.
        rows: how many it has.
        span: first and last time [s].
        errors: by point and by name.
        phase: largest deviation of the crank from the nominal [rad]; None where the table does not say where it was.
        estimates: of what was to be estimated.
        tolerance: as asked for, by quantity, and what follows from it for the clock; empty where nothing is judged.
        causes: that reproduce what is wrong.
        notes: what is not judged, or not as one might think, a sentence each.
        distrust: how the exact motion contradicts its joints' equations, in words; empty where it does not.
    """

    file: str
    scene_name: str
    scene: Scene
    columns: tuple[Column, ...]
    unused: tuple[str, ...]
    form: str
    rows: int
    span: tuple[float, float]
    errors: Errors
    phase: float | None
    estimates: tuple[Estimate, ...]
    tolerance: Mapping[str, float]
    causes: tuple[Cause, ...]
    notes: tuple[str, ...]
    distrust: str = ""

    @property
    def revolutions(self) -> float:
        """Turns of the crank that the table spans at nominal speed."""
        return (self.span[1] - self.span[0]) / self.scene.period

    def largest(self, name: str) -> float | None:
        """The largest error of a name in `ERRORS`, `velocity_rms` or `phase` [rad]; None where there is none."""
        if name == "phase":
            return self.phase
        of, measure = ("velocity", "rms") if name == RMS else (name, "max")
        return max((getattr(curves[of].size, measure) for curves in self.errors.values() if of in curves), default=None)

    @property
    def exceeded(self) -> dict[str, tuple[float, float]]:
        """Errors beyond their tolerance: name -> (found, allowed)."""
        found = {name: (self.largest(name), allowed) for name, allowed in self.tolerance.items()}
        return {
            name: (size, allowed) for name, (size, allowed) in found.items() if size is not None and not size <= allowed
        }

    @property
    def passed(self) -> bool | None:
        """True if all is within tolerance; None where nothing is judged."""
        if self.distrust:
            return False
        return not self.exceeded if self.tolerance else None


def study_table(
    file: str,
    scene_name: str,
    scene: Scene,
    reading: Reading,
    asked: Sequence[str] = (),
    tolerance: Mapping[str, float] | None = None,
) -> TableStudy:
    """Judge a table.

    Args:
        asked: what to estimate first, of `estimation.CHOICES`.
        tolerance: largest errors allowed, of `ERRORS`, `velocity_rms` and `phase` [rad]; None judges nothing.

    Raises:
        InvalidInput: a tolerance of what the table has not, or an estimate of what it does not tell.
    """
    table, limits = Exact(reading.values, scene), dict(tolerance or {})
    estimates = estimate(table, asked) if asked else ()
    table = aligned(table, estimates)
    _check_pass(table)
    found = TableStudy(
        file=file,
        scene_name=scene_name,
        scene=scene,
        columns=reading.columns,
        unused=reading.unused,
        form=reading.form,
        rows=len(table.times),
        span=(float(reading.values[TIME][0]), float(reading.values[TIME][-1])),
        errors=table.errors,
        phase=table.phase,
        estimates=estimates,
        tolerance={**clock_limits(table, reading, limits), **limits},
        causes=(),
        notes=tuple(_notes(reading, scene)),
        distrust=misfit_words(reference_misfit(scene)),
    )
    for name in limits:
        if found.largest(name) is None:
            what = {"phase": "crank angle", "total": "position"}.get(name, name.removesuffix("_rms"))
            raise InvalidInput(f"--tolerance {name}: the table has no {what} column; conrod does not differentiate")
    if "phase" in found.exceeded and "phase" not in limits:
        found = replace(found, notes=(*found.notes, CLOCK_NOTE))
    # None where all are within tolerance, otherwise all that are worth a note.
    wrong = [name for name in ERRORS if name in found.exceeded or (found.largest(name) or 0.0) > NOTEWORTHY]
    return found if found.passed else replace(found, causes=likely_causes(table, wrong))


def _check_pass(table: Exact) -> None:
    """Refuse a table whose clock leads out of the one pass of an input that cannot turn fully."""
    angle, scene, span = table.nominal_angle, table.scene, table.scene.kinematics.mechanism.driver.span
    if span and (angle.min() < span[0] - BEYOND or angle.max() > span[1] + BEYOND):
        found, allowed = (
            f"{math.degrees(a):.6g} to {math.degrees(b):.6g} deg" for a, b in ((angle.min(), angle.max()), span)
        )
        raise InvalidInput(
            f"the table's times lead from crank angle {found}, out of the pass from {allowed}: time 0 is that of crank "
            f"angle 0, so that the pass begins at {(span[0] if scene.speed > 0.0 else span[1]) / scene.speed:.6g} s"
        )


def _notes(reading: Reading, scene: Scene) -> Iterator[str]:
    if reading.repeated:
        yield f"rows that repeat the time and all values of the row before are left out: {reading.repeated}"
    assumed = [column.name for column in reading.columns if column.unit_from == "assumed"]
    if assumed:
        yield f"no unit is given for {', '.join(assumed)}: taken to be SI (s, m, rad); --unit says otherwise"
    if missing := [name for name in quantities(tuple(scene.lengths)) if name not in reading.values]:
        yield f"not in the table: {', '.join(missing)}; motion is not judged then, and the crank taken at its nominal"


# -- what a clock is allowed where the crank has a prescribed speed ----------------------------------------------------


def clock_limits(table: Exact, reading: Reading, asked: Mapping[str, float]) -> dict[str, float]:
    """Limits that follow from those asked for; none where the table has no crank angle, or the user sets `total`.

    Errors at the angle that a table says show no wrong clock. An angle at the prescribed speed is off by rounding, and
    by the digits that its column and that of the time are written with; the position at the nominal time by what
    `position` is allowed, and by what the phase moves the point.
    """
    values, scene, nominal = reading.values, table.scene, table.nominal_angle
    if CRANK_ANGLE not in values or not asked or "total" in asked:
        return {}
    factors = {column.name: column.factor for column in reading.columns}
    rounding = phase_bound(len(nominal), float(np.abs(nominal).max()) / (2.0 * math.pi))
    written = abs(scene.speed) * _written(values[TIME], values[TIME], factors[TIME])
    written += _written(values[CRANK_ANGLE], np.unwrap(values[CRANK_ANGLE]), factors[CRANK_ANGLE])
    phase = asked.get("phase", rounding + written)
    limits = {"phase": phase}
    if "position" in asked:
        limits["total"] = asked["position"] + phase * largest_derivatives(scene.kinematics, 1)[1]
    return limits


def _written(values: Array, course: Array, factor: float) -> float:
    """Bound on the rounding of a column by the digits that it is written with, SI.

    Half of the last digit, or of a single's; no more than the column leaves equal spacing by, so that whole numbers
    at equal distances are taken at their word.

    Args:
        values, course: (T,) SI; as written, and without jumps by a turn.
        factor: of the unit that it is written in, to SI.
    """
    even = course[0] + np.arange(len(course)) * ((course[-1] - course[0]) / (len(course) - 1))
    written = np.abs(values[values != 0.0]) / factor
    if not len(written):
        return 0.0
    first = np.floor(np.log10(written))
    unknown = 2.0**-24 * written.max() if _same(written, written.astype(np.float32)) else 0.0
    for digits in range(1, DIGITS + 1):
        last = 10.0 ** (first - digits + 1)
        if digits == DIGITS or _same(written, np.rint(written / last) * last):
            unknown = max(unknown, 0.5 * float(last.max()))
            break
    return min(unknown * factor, float(np.abs(course - even).max()))


def _same(written: Array, rounded: Array) -> bool:
    return bool(np.all(np.abs(written - rounded) <= 4.0 * EPS * written))
