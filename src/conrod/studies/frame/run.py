"""A run of a scene with some settings, compared with the exact motion."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any, TypeVar

import numpy as np

from conrod.engines import engine_named
from conrod.engines.engine import CUSTOM, run_of
from conrod.engines.running import run
from conrod.exact.motion import Array
from conrod.runs.comparison import QUANTITIES as COMPARED
from conrod.runs.comparison import Comparison, compare, predicted_errors, signed_error
from conrod.runs.trajectory import FieldByField, Outcome, Settings, Track, Trajectory
from conrod.scenes import Scene
from conrod.studies.frame.case import RESULT_VERSION, Case
from conrod.studies.frame.measurement import QUANTITIES, Measurement

REVOLUTIONS = 2.0
# Every number of steps in the grids is a multiple of this, so that signed errors are kept at angles that all share.
SIGNED_ANGLES = 20
LEAST_STEPS = 3  # of a run: before the first acceleration that is a difference of velocities
# The errors are those of every sample. The prediction from the joints costs several times as much, and proves as much
# at so many samples a turn.
PREDICTED_PER_TURN = 2000


@dataclass(frozen=True)
class RunCase(Case):
    """A run of a scene at constant crank speed.

    Attributes:
        revolutions: of the crank.
        start_angle: of the crank [rad].
        signed_angles: equally spaced crank angles of the last turn at which signed errors are kept.
    """

    settings: Settings
    revolutions: float = REVOLUTIONS
    start_angle: float = 0.0
    signed_angles: int = SIGNED_ANGLES

    def perform(self) -> Measurement:
        return measure(self)

    @property
    def labels(self) -> dict[str, str]:
        return {} if self.settings.preset == CUSTOM else {"label": self.settings.preset}

    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        # Fields that settings gained later are not in it where they are as they always were: keys stay what they were.
        settings = self.settings.as_dict()
        del settings["preset"]
        return {
            "result_version": RESULT_VERSION,
            "scene": self.scene.kind,
            "parameters": parameters,
            "engine": self.settings.engine,
            "engine_version": engine_named(self.settings.engine).version,
            "settings": settings,
            "revolutions": self.revolutions,
            "start_angle": self.start_angle,
            "signed_angles": self.signed_angles,
        }


AnyRun = TypeVar("AnyRun", bound=RunCase)


def as_run(case: AnyRun) -> AnyRun:
    """The case with the stretch that is run: of an input that cannot turn fully its one pass, whatever is asked."""
    if case.scene.kinematics.mechanism.driver.span is None:
        return case
    start, revolutions = run_of(case.scene, case.settings.steps_per_revolution, case.revolutions)
    return replace(case, start_angle=start, revolutions=revolutions)


def too_coarse(case: RunCase) -> str | None:
    """None, or why the one pass of an input that cannot turn fully is not run with so few steps.

    Args:
        case: with the stretch that is run, see `as_run`.
    """
    taken = round(case.settings.steps_per_revolution * case.revolutions)
    if case.scene.kinematics.mechanism.driver.span is None or taken >= LEAST_STEPS:
        return None
    return (
        f"the pass is {taken} steps long at {case.settings.steps_per_revolution} steps a revolution; "
        f"{LEAST_STEPS} are needed to have accelerations"
    )


def measure(case: RunCase) -> Measurement:
    """Run a case and compare it with the exact motion.

    Raises:
        InvalidInput: as `conrod.run`.
    """
    engine, case = engine_named(case.settings.engine), as_run(case)
    refusal = engine.refusal(case.scene, case.settings) or too_coarse(case)
    if refusal:
        return Measurement(Outcome.UNSUPPORTED.slug, refusal)
    trajectory = run(case.scene, case.settings, case.revolutions, case.start_angle)
    if trajectory.outcome is not Outcome.COMPLETED:
        return Measurement(trajectory.outcome.slug, trajectory.reason)
    comparison = compare(trajectory, case.scene)
    some = thinned(trajectory, max(1, case.settings.steps_per_revolution // PREDICTED_PER_TURN))
    return Measurement(
        outcome=trajectory.outcome.slug,
        **errors_of(comparison),
        prediction=prediction_sizes(case.scene, some),
        signed=signed_errors(case, trajectory),
    )


def errors_of(found: Comparison) -> dict[str, Any]:
    """Errors, closure, phase and drive of a comparison as plain values, by their names in a measurement."""
    return {
        "errors": {p: {q: asdict(getattr(e, q).size) for q in COMPARED} for p, e in found.points.items()},
        "closure": asdict(found.closure),
        "phase": {"max": found.phase_max, "final": found.phase_final},
        "drive": {"speed": found.drive_speed, "acceleration": found.drive_acceleration},
    }


def prediction_sizes(scene: Scene, trajectory: Trajectory) -> dict[str, dict[str, float]]:
    """Errors predicted from the joints' gaps alone beside the measured ones; the worst observed point counts."""
    assert trajectory.bodies is not None
    predicted = predicted_errors(scene.kinematics, trajectory.points, trajectory.bodies)
    sizes = {q: {"predicted": 0.0, "difference": 0.0} for q in QUANTITIES}
    for name, tracks in trajectory.points.items():
        for k, quantity in enumerate(QUANTITIES):
            norm = scene.lengths[name] * abs(scene.speed) ** k
            expected = predicted[name][quantity]
            off = expected - signed_error(getattr(tracks, quantity), scene, name, quantity)
            for key, values in (("predicted", expected), ("difference", off)):
                largest = float(np.linalg.norm(values, axis=1).max()) / norm
                sizes[quantity][key] = max(sizes[quantity][key], largest)
    return sizes


def signed_errors(case: RunCase, trajectory: Trajectory) -> dict[str, dict[str, list[list[float]]]]:
    """Normalised signed errors at fixed crank angles of the last turn, or of the one pass.

    Where an engine has no sample at an angle (pymunk's velocities lie between), the error is interpolated: that
    costs a share of the error itself that falls with the square of the step.
    """
    scene, first = case.scene, case.start_angle / case.scene.speed
    if scene.kinematics.mechanism.driver.span is None:
        last_turn = first + scene.period * (case.revolutions - 1.0 + np.arange(case.signed_angles) / case.signed_angles)
    else:
        start, stop = scene.kinematics.span
        middles = (np.arange(case.signed_angles) + 0.5) / case.signed_angles
        last_turn = np.sort((start + (stop - start) * middles) / scene.speed)
    return {
        name: {
            quantity: _at(last_turn, getattr(tracks, quantity), scene, name, quantity, k).tolist()
            for k, quantity in enumerate(QUANTITIES)
        }
        for name, tracks in trajectory.points.items()
    }


def _at(times: Array, track: Track, scene: Scene, name: str, quantity: str, k: int) -> Array:
    # Only the samples on both sides of each time are compared.
    after = np.clip(np.searchsorted(track.instants.times, times), 1, len(track.values) - 1)
    near = np.unique(np.concatenate([after - 1, after]))
    kept = Track(track.instants[near], track.values[near])
    errors = signed_error(kept, scene, name, quantity) / (scene.lengths[name] * abs(scene.speed) ** k)
    return np.column_stack([np.interp(times, kept.instants.times, errors[:, axis]) for axis in (0, 1)])


def thinned(trajectory: Trajectory, stride: int) -> Trajectory:
    """Every so-many-th sample, the last one among them."""
    if stride == 1 or trajectory.bodies is None:
        return trajectory
    cut = FieldByField(lambda parts: parts[0][(len(parts[0]) - 1) % stride :: stride])
    points = {name: cut(tracks) for name, tracks in trajectory.points.items()}
    return replace(trajectory, points=points, bodies=cut(trajectory.bodies))
