"""Forces that an engine reports against the exact ones, at the angle, rate and acceleration that its crank had.

An error that looks like the effect of a wrong mass on the forces, by the exact sensitivities, is reported as how much
of it: the projection of all errors on its effect. That detects less than a tolerance has to allow, for an engine's own
errors look different.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conrod.engines.forces import ForceTracks
from conrod.exact.dynamics.inverse import State
from conrod.exact.dynamics.sensitivity import TORQUE, sensitivities
from conrod.exact.motion import Array
from conrod.exact.reference import ExactReference
from conrod.runs.comparison import size_of
from conrod.runs.run_errors import CURVE_SAMPLES, largest_in_spans
from conrod.scenes import Scene
from conrod.studies.forces.exact import NEAR, Peaks, effects_on, exact_quantities
from conrod.studies.forces.results import LOOKS_LIKE, ForceErrors, Stamps, TorqueCurve

SAMPLES = 131072  # at most: with contact single values scatter, and only many of them show it

PARTS = 64  # of a run
SURE = 3.0  # standard errors of the projection have to lie within it, or within what would be reported


def likenesses(scene: ExactReference, measured: Measured, names: Sequence[str]) -> dict[str, float]:
    """By "body.property", how many times the change that is to be seen the errors look like.

    That is 1 % of a mass, 1 % of a length, 5 % of an inertia. What no quantity depends on is not among them,
    nor that for which the errors scatter too much: with contact, where a run has few steps.

    Args:
        names: of the quantities that are looked at; those that are not reported are left out.
    """
    reported = [name for name in names if name in measured.reported]
    some = measured.clear()
    some = some[np.unique(np.linspace(0, len(some) - 1, SAMPLES).astype(int))]
    at = measured.state
    state = State(*(values[some] for values in (at.angle, at.rate, at.acceleration, at.time)))
    peaks = {name: measured.peaks[name][0] for name in reported}
    errors = np.concatenate([(measured.reported[n][some] - measured.exact[n][some]) / peaks[n] for n in reported])
    # At constant speed, as the machine is meant to run: what ripple of the drive would show is not counted.
    seen = {
        (effect.body, effect.quality) for effect in effects_on(scene, reported, measured.peaks) if not effect.unseen
    }
    found = {}
    for one in sensitivities(scene.kinematics, state):
        effect = np.concatenate([one.derivatives[n] * one.change / peaks[n] for n in reported])
        if (one.body, one.quality) in seen and effect.any():
            times = float(errors @ effect / (effect @ effect))
            # Values after each other, and quantities, scatter together: single parts of the run are independent.
            left = ((errors - times * effect) * effect).reshape(len(reported), -1).sum(axis=0)
            parts = [part.sum() for part in np.array_split(left, PARTS)]
            scatter = float(np.linalg.norm(parts) / (effect @ effect))
            if SURE * scatter < max(LOOKS_LIKE, abs(times)):
                found[f"{one.body}.{one.quality}"] = times
    return found


TOGETHER = 16  # steps of which a mean is taken where single values scatter, with contact
CLEAR = np.radians(1.0)  # of the crank, that lies between an arc joint of a cam and what is judged


def reported_quantities(tracks: ForceTracks) -> dict[str, Array]:
    """Forces that the engine reports, by quantity, (T,) each."""
    joints = {f"{joint}.{name}": reported for joint, some in tracks.joints.items() for name, reported in some.items()}
    return joints if tracks.drive_torque is None else {TORQUE: tracks.drive_torque} | joints


class Measured:
    """One run that reported something, beside the exact forces."""

    def __init__(self, scene: ExactReference, tracks: ForceTracks, peaks: Peaks, stamps: Stamps) -> None:
        at, kinematics = tracks.instants, scene.kinematics
        self.kept = ~kinematics.near_change(at.angle, NEAR)
        self.state = state = State(*(v[self.kept] for v in (at.angle, at.rate, at.acceleration, at.times)))
        self.angle, self.peaks = state.angle, peaks
        self.reported = {name: values[self.kept] for name, values in reported_quantities(tracks).items()}
        self.exact = exact_quantities(kinematics, state)
        self._together = max(1, round(TOGETHER / max(stamps.spacing, 1.0)))
        self._between = _between(self.angle, scene.break_angles()) if kinematics.mechanism.cam_contacts else None

    def clear(self) -> NDArray[np.int_]:
        """Indices of the measured values that lie away from arc joints."""
        return np.flatnonzero(np.ones(len(self.angle)) if self._between is None else self._between)

    def errors(self, names: Sequence[str]) -> dict[str, ForceErrors]:
        """Of the quantities that are reported."""
        return {name: self._error(name) for name in names if name in self.reported}

    def _error(self, name: str) -> ForceErrors:
        peak, own = self.peaks[name]
        off = self._off(name)
        between = None
        if self._between is not None:
            clear = _blocks(self._between, self._together).all(axis=1)
            # Single values scatter from an edge of the cam's polygon to the next, or from catch to catch.
            means = _blocks((self.reported[name] - self.exact[name]) / peak, self._together).mean(axis=1)
            between = size_of(means[clear]).rms if clear.any() else None
        whole = size_of(off)
        return ForceErrors(whole.max, whole.rms, between, peak, own)

    def _off(self, name: str) -> Array:
        return np.asarray(np.abs(self.reported[name] - self.exact[name]) / self.peaks[name][0])

    def torque_curve(self) -> TorqueCurve | None:
        """For a figure; None where the engine reports no torque."""
        if TORQUE not in self.reported:
            return None
        angle, error = self.angle, self._off(TORQUE)
        turn = np.flatnonzero(np.abs(angle[-1] - angle) <= 2.0 * np.pi + 1e-9)
        keep = turn[np.unique(np.linspace(0, len(turn) - 1, CURVE_SAMPLES).astype(int))]
        spans = [(at.mean(), off.max()) for at, off in largest_in_spans(len(angle)).add(angle, error)]
        return TorqueCurve(angle[keep], self.reported[TORQUE][keep], self.exact[TORQUE][keep], *np.array(spans).T)


def stamps_of(scene: Scene, tracks: ForceTracks, steps: int, start_angle: float) -> Stamps:
    """Instants that the values of a run belong to."""
    at, step = tracks.instants, scene.period / steps
    spacing = float(np.diff(at.times[:2])[0]) / step if len(at.times) > 1 else 0.0
    left_out = int(scene.kinematics.near_change(at.angle, NEAR).sum())
    first = (float(at.times[0]) - start_angle / scene.speed) / step
    return Stamps(round(first, 6), round(spacing, 6), len(at.times), left_out)


def _between(angle: Array, joints: Sequence[float]) -> NDArray[np.bool_]:
    """Mask (T,) of angles [rad] with no arc joint near."""
    clear = np.ones(len(angle), dtype=bool)
    for joint in joints:
        clear &= np.abs((angle - joint + np.pi) % (2.0 * np.pi) - np.pi) > CLEAR
    return clear


def _blocks(values: NDArray[Any], together: int) -> NDArray[Any]:
    """Values (T,) by so many after each other (T // together, together); those left at the end are left out."""
    count = len(values) // together
    return values[: count * together].reshape(count, together)
