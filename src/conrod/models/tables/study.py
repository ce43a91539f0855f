"""The study of a table: its errors against the exact motion, its clock and frame, and likely causes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from conrod.errors import InvalidInput
from conrod.execution.prediction import reference_misfit
from conrod.execution.result import misfit_words
from conrod.execution.tolerances import Limit, exceeded_limits, judged_scale, scale_tolerance, scene_scales
from conrod.models.tables.causes import MIN_NOTEWORTHY_ERROR, Cause, likely_causes
from conrod.models.tables.clock import clock_limits
from conrod.models.tables.columns import TIME, Column, quantities
from conrod.models.tables.consistency import contradictory_quantities
from conrod.models.tables.coverage import RMS, check_moving, limited_quantity, still_columns, unjudged_quantities
from conrod.models.tables.errors import ALL_ERRORS, Errors, TableComparison
from conrod.models.tables.estimation import Estimate, align_clock, estimate
from conrod.models.tables.reading import Reading
from conrod.scenes import Scene

PASS_MARGIN = 1e-6  # [rad], of a pass, by which digits that a table left out may lead
CLOCK_NOTE = (
    "phase and total are held to the scene's speed from crank angle 0 at time 0: --set speed=SPEED gives another, "
    "--estimate time finds an unknown start, and --tolerance phase=ANGLE allows a drive that does not keep its speed"
)


@dataclass(frozen=True)
class TableStudy:
    """Result of `conrod check` for a table, or for an FMU, whose run is judged as a table.

    Attributes:
        file: name of the table.
        scene_name, scene: scene that the table is judged against.
        columns, unused: columns with their quantities, and headings of all other columns.
        form: format of the file, in words.
        rows: number of rows.
        span: first and last time [s].
        errors: errors by point or link and by name of the error.
        phase: largest deviation of the crank from the nominal [rad]; None without a crank angle.
        estimates: estimates that the user asked for.
        tolerance: tolerances asked for, by quantity, and those of the clock that follow; empty if nothing is judged.
        causes: causes that reproduce the errors.
        notes: sentences on what is not judged, or is judged otherwise than expected.
        contradictory: quantities that contradict the table's own columns of what they are the rate of.
        unjudged: quantities outside the verdict, as `position of M`, `velocity`; empty where nothing is judged.
        distrust: how the exact motion contradicts the joints' equations, in words; empty if it does not.
        weights: for tolerances given in units, the weight of each point's error (`scale_tolerance`).
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
    unjudged: tuple[str, ...]
    distrust: str = ""
    weights: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    contradictory: tuple[str, ...] = ()

    @property
    def revolutions(self) -> float:
        """Turns of the crank that the table spans at nominal speed."""
        return (self.span[1] - self.span[0]) / self.scene.period

    def largest(self, name: str) -> float | None:
        """The largest error of a name in `ALL_ERRORS`, `velocity_rms` or `phase` [rad]; None if the table has none."""
        if name == "phase":
            return self.phase
        return max(self.judged_points(name).values(), default=None)

    def judged_points(self, name: str) -> dict[str, float]:
        """Errors of a name in `ALL_ERRORS` or `velocity_rms` by point or link, times their weights."""
        of, measure = ("velocity", "rms") if name == RMS else (name, "max")
        found = {point: getattr(curves[of].size, measure) for point, curves in self.errors.items() if of in curves}
        weights = self.weights.get(name, {})
        return {point: size * weights.get(point, 1.0) for point, size in found.items()}

    def judged_scale(self, name: str) -> float | None:
        """SI size of a share of 1 of a judged error; None for a phase."""
        return judged_scale(
            self.judged_points(name), scene_scales(self.scene).get(name, {}), weighed=name in self.weights
        )

    @property
    def exceeded(self) -> dict[str, tuple[float, float]]:
        """Errors beyond their tolerance: name -> (found, allowed)."""
        return exceeded_limits(self.tolerance, self.largest)

    @property
    def passed(self) -> bool | None:
        """True if every error is within its tolerance; None if nothing is judged."""
        if self.distrust:
            return False
        return not self.exceeded if self.tolerance else None


def study_table(
    file: str,
    scene_name: str,
    scene: Scene,
    reading: Reading,
    asked: Sequence[str] = (),
    tolerance: Mapping[str, Limit] | None = None,
) -> TableStudy:
    """Judge a table against the exact motion of a scene.

    Args:
        asked: quantities to estimate first, of `estimation.CHOICES`.
        tolerance: largest errors allowed, of `ALL_ERRORS`, `velocity_rms` and `phase` [rad]; None judges nothing.

    Raises:
        InvalidInput: a tolerance of what the table has not or of what stands still, or an estimate of what the table
            does not tell.
    """
    table = TableComparison(reading.values, scene)
    limits, weights = scale_tolerance(tolerance or {}, scene_scales(scene) if tolerance else {})
    estimates = estimate(table, asked) if asked else ()
    table = align_clock(table, estimates)
    _check_pass(table)
    allowed = {**clock_limits(table, reading, limits), **limits}
    if "total" not in limits and "position" in weights:
        weights["total"] = weights["position"]
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
        tolerance=allowed,
        causes=(),
        notes=tuple(_notes(reading, table)),
        unjudged=unjudged_quantities(table, allowed),
        distrust=misfit_words(reference_misfit(scene)),
        weights=weights,
        contradictory=contradictory_quantities(table),
    )
    for name in limits:
        if found.largest(name) is None:
            what = {"phase": "crank angle"}.get(name, limited_quantity(name).replace("_", " "))
            raise InvalidInput(f"--tolerance {name}: the table has no {what} column; conrod does not differentiate")
    if found.passed:
        check_moving(table, allowed, limits)
    if "phase" in found.exceeded and "phase" not in limits:
        found = replace(found, notes=(*found.notes, CLOCK_NOTE))
    # None where all are within tolerance, otherwise all that are worth a note.
    wrong = [
        name for name in ALL_ERRORS if name in found.exceeded or (found.largest(name) or 0.0) > MIN_NOTEWORTHY_ERROR
    ]
    return found if found.passed else replace(found, causes=likely_causes(table, wrong, allowed))


def _check_pass(table: TableComparison) -> None:
    """Refuse a table whose times lead beyond the one pass of an input that cannot turn fully."""
    angle, scene, span = table.nominal_angle, table.scene, table.scene.kinematics.mechanism.driver.span
    if span and (angle.min() < span[0] - PASS_MARGIN or angle.max() > span[1] + PASS_MARGIN):
        found, allowed = (
            f"{math.degrees(a):.6g} to {math.degrees(b):.6g} deg" for a, b in ((angle.min(), angle.max()), span)
        )
        raise InvalidInput(
            f"the table's times lead from crank angle {found}, out of the pass from {allowed}: time 0 is that of crank "
            f"angle 0, so that the pass begins at {(span[0] if scene.speed > 0.0 else span[1]) / scene.speed:.6g} s"
        )


def _notes(reading: Reading, table: TableComparison) -> Iterator[str]:
    """Yield remarks on units, repeated rows and missing columns."""
    scene = table.scene
    if reading.repeated:
        yield f"rows that repeat the time and all values of the row before are left out: {reading.repeated}"
    assumed = [column.name for column in reading.columns if column.unit_from == "assumed"]
    if assumed:
        yield f"no unit is given for {', '.join(assumed)}: taken to be SI (s, m, rad); --unit says otherwise"
    if missing := [name for name in quantities(tuple(scene.lengths)) if name not in reading.values]:
        yield f"not in the table: {', '.join(missing)}; motion is not judged then, and the crank taken at its nominal"
    if still := still_columns(table, MIN_NOTEWORTHY_ERROR):
        yield f"{', '.join(still)}: the exact motion stands still there, so that their errors say nothing of it"
