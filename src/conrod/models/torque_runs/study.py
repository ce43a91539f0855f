"""The study of a run under a torque: its errors against the exact motion, and likely causes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from conrod.comparison.compare import Size, size_of
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.execution.prediction import reference_misfit
from conrod.execution.result import misfit_words
from conrod.execution.tolerances import Limit, exceeded_limits, judged_scale, point_scales, scale_tolerance
from conrod.models.tables.causes import MIN_NOTEWORTHY_ERROR, Cause
from conrod.models.tables.columns import CRANK_ANGLE, CRANK_SPEED, TIME, Column
from conrod.models.tables.reading import Reading
from conrod.models.torque_runs.causes import likely_run_causes
from conrod.models.torque_runs.comparison import CRANK, JUDGED_QUANTITIES, PHASE, SPEED, RunComparison, check_start
from conrod.models.torque_runs.exact import CrankStart, exact_motion, quantities_of
from conrod.models.torque_runs.question import RunQuestion
from conrod.models.torque_runs.torque import Torque
from conrod.scenes import Scene

MAX_ROWS = 20_000  # that are compared, evenly spread: the exact motion takes some 0.1 ms a row
MAX_CURVE_SPANS = 400  # as many as show in the width of a figure
# A thousandth of a point's travel, or of a radian (0.06 deg): less shows in no plot of the run, and one step of stamps,
# one per cent of torque or of inertia shift the saw's run of a second by 5 to 100 times as much.
USUAL_TOLERANCE = {"position": 1e-3, PHASE: 1e-3}
# Error of the exact motion's energy balance up to which it is fit to judge by.
MAX_EXACT_DRIFT = 1e-10


@dataclass(frozen=True)
class RunError:
    """Normalised error over a run.

    Attributes:
        size: max, rms and final value of all rows.
        time: time of the largest [s].
        at: where each span begins (N,) [s]; at most `MAX_CURVE_SPANS`.
        largest: largest error in each span (N,).
    """

    size: Size
    time: float
    at: Array
    largest: Array


@dataclass(frozen=True)
class TorqueRunStudy:
    """The result of `conrod check TABLE --scene SCENE --torque TORQUE`.

    Attributes:
        file: name of the table.
        scene_name, scene: machine whose exact motion it is judged by.
        torque: the torque on the crank, in words.
        start: crank at time 0: angle [rad] and speed [rad/s], and whether the user gave them.
        columns, unused: columns with their quantities, and headings of all other columns.
        form: format of the file, in words.
        rows: number of rows; compared: of those compared.
        span: first and last time [s].
        speed: omega [rad/s], the largest exact speed of the crank.
        errors: by point, or `crank`, and by name of the error.
        tolerance: allowed errors by quantity.
        causes: causes that reproduce the errors.
        notes: sentences on what is judged otherwise than expected.
        unjudged: quantities outside the verdict.
        drift: error of the energy balance of the exact motion, over the largest energy that took part.
        distrust: how the exact motion contradicts itself, in words; empty if it does not.
        weights: for tolerances given in units, the weight of each point's error (`scale_tolerance`).
    """

    file: str
    scene_name: str
    scene: Scene
    torque: str
    start: tuple[float, float, bool]
    columns: tuple[Column, ...]
    unused: tuple[str, ...]
    form: str
    rows: int
    compared: int
    span: tuple[float, float]
    speed: float
    errors: Mapping[str, Mapping[str, RunError]]
    tolerance: Mapping[str, float]
    causes: tuple[Cause, ...]
    notes: tuple[str, ...]
    unjudged: tuple[str, ...]
    drift: float
    distrust: str = ""
    weights: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    def largest(self, name: str) -> float | None:
        """The largest error of a quantity over all points, or of the crank; None where the run has none."""
        return max(self.judged_points(name).values(), default=None)

    def judged_points(self, name: str) -> dict[str, float]:
        """Errors of a quantity by point, or of the crank, times their weights."""
        found, weights = {p: one[name].size.max for p, one in self.errors.items() if name in one}, self.weights
        return {point: size * weights.get(name, {}).get(point, 1.0) for point, size in found.items()}

    def judged_scale(self, name: str) -> float | None:
        """SI size of a share of 1 of a judged error; None for a phase."""
        scales = {**point_scales(self.scene.lengths, self.speed), SPEED: {CRANK: self.speed}}
        return judged_scale(self.judged_points(name), scales.get(name, {}), weighed=name in self.weights)

    @property
    def exceeded(self) -> dict[str, tuple[float, float]]:
        """Errors beyond their tolerance: name -> (found, allowed)."""
        return exceeded_limits(self.tolerance, self.largest)

    @property
    def passed(self) -> bool:
        """True if every error is within its tolerance, and the exact motion is fit to judge by."""
        return not self.distrust and not self.exceeded


def study_torque_run(
    file: str,
    scene_name: str,
    scene: Scene,
    reading: Reading,
    torque: Torque,
    start: CrankStart,
    tolerance: Mapping[str, Limit] | None = None,
) -> TorqueRunStudy:
    """Judge a run against the exact motion of a scene under a torque on its crank.

    Args:
        tolerance: allowed errors, of `JUDGED_QUANTITIES`; None for `USUAL_TOLERANCE`.

    Raises:
        InvalidInput: the run begins before time 0 or off the mechanism, has no column that a tolerance is of, or the
            machine cannot move so.
    """
    values = _thin_rows(reading.values)
    times = values[TIME]
    if times[0] < 0.0:
        raise InvalidInput(f"the first time is {times[0]:.9g} s: the motion begins at time 0, with the machine's start")
    check_start(scene, values, float(times[0]))
    motion = exact_motion(scene_name, scene, torque, start, times)
    exact = quantities_of(scene, motion.poses, motion.rates, motion.accelerations)
    if not exact[CRANK_SPEED].any():
        raise InvalidInput(f"{scene_name}: it stays at rest: neither the torque nor a weight or load moves it")
    if not exact[CRANK_SPEED].any():
        raise InvalidInput(f"{scene_name}: it stays at rest: neither the torque nor a weight or load moves it")
    run = RunComparison(values, exact, scene.lengths, float(np.abs(exact[CRANK_SPEED]).max()))
    scales = {**point_scales(run.lengths, run.speed), SPEED: {CRANK: run.speed}}
    limits, weights = scale_tolerance(USUAL_TOLERANCE if tolerance is None else tolerance, scales)
    allowed = _judged_tolerances(run, limits, asked=tolerance is not None)
    first = scene.speed if start.speed is None else start.speed
    found = TorqueRunStudy(
        file=file, scene_name=scene_name, scene=scene, torque=torque.words,
        start=(start.angle, first if start else _scene_start_speed(scene), bool(start)),
        columns=reading.columns, unused=reading.unused, form=reading.form,
        rows=len(reading.values[TIME]), compared=len(times), span=(float(times[0]), float(times[-1])),
        speed=run.speed, errors=_error_curves(run), tolerance=allowed, causes=(),
        notes=tuple(_notes(scene, reading, len(times))), unjudged=tuple(_unjudged_quantities(run, allowed)),
        drift=motion.drift, distrust=_distrust(scene, motion.drift), weights=weights,
    )  # fmt: skip
    wrong = [
        name for name in JUDGED_QUANTITIES
        if name in found.exceeded or (name not in allowed and (run.largest(name) or 0.0) > MIN_NOTEWORTHY_ERROR)
    ]  # fmt: skip
    if found.passed:
        return found
    question = RunQuestion(run, scene, torque, start, float(np.median(np.diff(reading.values[TIME]))))
    return replace(found, causes=likely_run_causes(question, wrong))


def _thin_rows(values: Mapping[str, Array]) -> dict[str, Array]:
    """Keep at most `MAX_ROWS` evenly spread rows, the first and the last among them."""
    count = len(values[TIME])
    keep = np.unique(np.rint(np.linspace(0, count - 1, min(count, MAX_ROWS))).astype(int))
    return {name: column[keep] for name, column in values.items()}


def _scene_start_speed(scene: Scene) -> float:
    """Speed of the crank [rad/s] at the scene's own start; NaN where the rate of another body says it."""
    mechanism = scene.kinematics.mechanism
    rates = scene.start_rates
    return mechanism.driver.sense * rates[mechanism.crank] if mechanism.crank in rates else math.nan


def _judged_tolerances(run: RunComparison, allowed: Mapping[str, float], *, asked: bool) -> dict[str, float]:
    """Tolerances of quantities in the run; raises InvalidInput if a requested quantity is missing."""
    missing = [name for name in allowed if run.largest(name) is None]
    kept = {name: size for name, size in allowed.items() if name not in missing}
    if (missing and asked) or not kept:
        what = {"phase": "crank angle", "speed": "crank speed"}.get(missing[0], missing[0])
        raise InvalidInput(
            f"--tolerance {missing[0]}: the table has no {what} column; conrod does not differentiate"
            if asked
            else "the table has neither a position nor a crank angle: what else it has is judged by --tolerance alone"
        )
    return kept


def _error_curves(run: RunComparison) -> dict[str, dict[str, RunError]]:
    """Errors over the run, by point or `crank`, and by name."""
    edges = np.unique(np.linspace(0, len(run.times), min(MAX_CURVE_SPANS, len(run.times)) + 1).astype(int))[:-1]
    found: dict[str, dict[str, RunError]] = {}
    for name in JUDGED_QUANTITIES:
        for point, error in run.sizes.get(name, {}).items():
            curve = np.asarray(np.maximum.reduceat(error, edges))
            when = float(run.times[int(np.argmax(error))])
            found.setdefault(point, {})[name] = RunError(size_of(error), when, run.times[edges], curve)
    return found


def _notes(scene: Scene, reading: Reading, compared: int) -> Iterator[str]:
    """Yield remarks on assumed units, skipped rows, and loads that act in addition to the torque."""
    if reading.repeated:
        yield f"rows that repeat the time and all values of the row before are left out: {reading.repeated}"
    assumed = [column.name for column in reading.columns if column.unit_from == "assumed"]
    if assumed:
        yield f"no unit is given for {', '.join(assumed)}: taken to be SI (s, m, rad); --unit says otherwise"
    if compared < len(reading.values[TIME]):
        yield f"{compared} of the {len(reading.values[TIME])} rows are compared, evenly spread"
    if loads := scene.kinematics.mechanism.loads:
        yield f"beside the torque act all loads of the machine: {', '.join(load.name for load in loads)}"


def _unjudged_quantities(run: RunComparison, allowed: Mapping[str, float]) -> Iterator[str]:
    """Yield the quantities that the run has, or should have, and no tolerance is of."""
    for name in JUDGED_QUANTITIES:
        if name not in allowed and name in run.sizes:
            yield {"phase": "crank angle", "speed": "crank speed"}.get(name, name)
    if CRANK_ANGLE not in run.values:
        yield "crank angle"


def _distrust(scene: Scene, drift: float) -> str:
    """Say how the exact motion contradicts itself; empty if it does not."""
    if not drift <= MAX_EXACT_DRIFT:
        return f"the exact motion keeps its balance of energy to {drift:.1g} only"
    return misfit_words(reference_misfit(scene))
