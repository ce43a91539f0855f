"""What one run shows against the exact motion, as plain values that a ledger can keep."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from conrod.engines import engine_named
from conrod.engines.running import run
from conrod.exact.motion import Array
from conrod.runs.closure_prediction import predicted_errors
from conrod.runs.comparison import QUANTITIES as COMPARED
from conrod.runs.comparison import compare, signed_error, size_of
from conrod.runs.trajectory import BodyStates, BodyTracks, Outcome, PointTracks, Track, Trajectory
from conrod.scenes import Scene
from conrod.studies.frame.cell import Cell, as_run, too_coarse
from conrod.studies.validation.results import QUANTITIES

# The errors are those of every sample. What is told from the joints costs several times as much, and proves as much at
# so many samples a turn.
PREDICTED_PER_TURN = 2000

Sizes = Mapping[str, float]


@dataclass(frozen=True)
class Measurement:
    """Outcome and, of a completed run alone, its errors; all normalised as docs/design.md says.

    Attributes:
        errors: point -> position, velocity, acceleration, total -> max, rms, final.
        closure: largest gap of a joint, its rate and its acceleration.
        phase: max and final [rad].
        drive: speed and acceleration.
        prediction: quantity -> largest error told from the joints alone, and its largest difference from the
            measured one.
        signed: point -> position, velocity, acceleration -> signed errors (K, 2) at K equally spaced crank angles of
            the last turn, the first at its start.
        extremes: what was watched of a run at its engine's limits, see `conrod.studies.limits.extremes`.
        beside: what a study's own task found besides; plain values that this study alone reads.
    """

    outcome: str
    reason: str = ""
    errors: Mapping[str, Mapping[str, Sizes]] | None = None
    closure: Sizes | None = None
    phase: Sizes | None = None
    drive: Sizes | None = None
    prediction: Mapping[str, Sizes] | None = None
    signed: Mapping[str, Mapping[str, list[list[float]]]] | None = None
    extremes: Mapping[str, Any] | None = None
    beside: Mapping[str, Any] | None = None

    def largest(self, quantity: str, measure: str = "max") -> float | None:
        """Largest error of a quantity over the observed points; None unless the run completed."""
        return None if self.errors is None else max(point[quantity][measure] for point in self.errors.values())

    def signed_of(self, point: str, quantity: str) -> Array:
        """Signed errors (K, 2) of a point; ValueError unless the run completed."""
        if self.signed is None:
            raise ValueError(f"a run that ended as {self.outcome!r} has no errors")
        return np.asarray(self.signed[point][quantity], dtype=float)

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain values."""
        return asdict(self)

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Measurement:
        """The inverse of `as_dict`."""
        return cls(**values)


def measure(cell: Cell) -> Measurement:
    """Run a cell and compare it with the exact motion.

    Raises:
        InvalidInput: as `conrod.run`.
    """
    engine, cell = engine_named(cell.settings.engine), as_run(cell)
    refusal = engine.refusal(cell.scene, cell.settings) or too_coarse(cell)
    if refusal:
        return Measurement(Outcome.UNSUPPORTED.slug, refusal)
    trajectory = run(cell.scene, cell.settings, cell.revolutions, cell.start_angle)
    if trajectory.outcome is not Outcome.COMPLETED:
        return Measurement(trajectory.outcome.slug, trajectory.reason)
    found = compare(trajectory, cell.scene)
    some = thinned(trajectory, max(1, cell.settings.steps_per_revolution // PREDICTED_PER_TURN))
    return Measurement(
        outcome=trajectory.outcome.slug,
        errors={p: {q: asdict(size_of(getattr(e, q).error)) for q in COMPARED} for p, e in found.points.items()},
        closure=asdict(found.closure),
        phase={"max": found.phase_max, "final": found.phase_final},
        drive={"speed": found.drive_speed, "acceleration": found.drive_acceleration},
        prediction=prediction_sizes(cell.scene, some),
        signed=signed_errors(cell, trajectory),
    )


def prediction_sizes(scene: Scene, trajectory: Trajectory) -> dict[str, dict[str, float]]:
    """Errors told from the joints' gaps alone beside the measured ones (guard 6); the worst observed point counts."""
    assert trajectory.bodies is not None
    predicted = predicted_errors(scene.kinematics, trajectory.points, trajectory.bodies)
    sizes = {q: {"predicted": 0.0, "difference": 0.0} for q in QUANTITIES}
    for name, tracks in trajectory.points.items():
        for k, quantity in enumerate(QUANTITIES):
            norm = scene.lengths[name] * abs(scene.speed) ** k
            told = getattr(predicted[name], quantity)
            off = told - signed_error(getattr(tracks, quantity), scene, name, quantity)
            for key, values in (("predicted", told), ("difference", off)):
                largest = float(np.linalg.norm(values, axis=1).max()) / norm
                sizes[quantity][key] = max(sizes[quantity][key], largest)
    return sizes


def signed_errors(cell: Cell, trajectory: Trajectory) -> dict[str, dict[str, list[list[float]]]]:
    """Normalised signed errors at fixed crank angles of the last turn, or of the one pass.

    Where an engine has no sample at an angle (pymunk's velocities lie between), the error is interpolated: that
    costs a share of the error itself that falls with the square of the step.
    """
    scene, first = cell.scene, cell.start_angle / cell.scene.speed
    if scene.kinematics.mechanism.driver.span is None:
        last_turn = first + scene.period * (cell.revolutions - 1.0 + np.arange(cell.signed_angles) / cell.signed_angles)
    else:
        start, stop = scene.kinematics.span
        middles = (np.arange(cell.signed_angles) + 0.5) / cell.signed_angles
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
    bodies = trajectory.bodies
    if stride == 1 or bodies is None:
        return trajectory
    cut: dict[int, BodyStates] = {}
    for states in (bodies.position, bodies.velocity, bodies.acceleration):
        # Where an engine gives the three at one instant they are one object, and stay one.
        cut.setdefault(id(states), _thinned_states(states, stride))
    points = {
        name: PointTracks(*(_thinned_track(getattr(tracks, q), stride) for q in QUANTITIES))
        for name, tracks in trajectory.points.items()
    }
    kept = BodyTracks(*(cut[id(s)] for s in (bodies.position, bodies.velocity, bodies.acceleration)))
    return replace(trajectory, points=points, bodies=kept)


def _every(length: int, stride: int) -> slice:
    return slice((length - 1) % stride, None, stride)


def _thinned_track(track: Track, stride: int) -> Track:
    keep = _every(len(track.values), stride)
    return Track(track.instants[keep], track.values[keep])


def _thinned_states(states: BodyStates, stride: int) -> BodyStates:
    keep = _every(len(states.poses), stride)
    return BodyStates(states.instants[keep], states.poses[keep], states.rates[keep], states.accelerations[keep])
