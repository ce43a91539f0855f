"""Errors of the forces that an engine reports, and their tolerance.

They are compared with the exact forces at the angle, rate and acceleration that the engine's crank had. A tolerance
is what is required of the engine at n0 = 1000 steps per revolution; with n < n0 steps it is larger by (n0 / n)^p, p the
order of the engine's scheme. If the motion of a machine changes quickly, as near a dead centre, the scheme's error is
larger: where the engine's law of its forces (`ForceLaw`) says so, that is allowed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from conrod.comparison.compare import size_of
from conrod.engines.capabilities import ExpectedForces
from conrod.engines.engine import Preset
from conrod.engines.tracks import ForceTracks
from conrod.exact.dynamics.inverse import (
    MIN_RELATIVE_CHANGE,
    TORQUE,
    component_names,
    joint_forces,
    quantities,
)
from conrod.exact.kinematics import ExactReference, Kinematics
from conrod.exact.motion import Array, Instants
from conrod.mechanism.mechanism import CamContact, Mechanism
from conrod.scenes import Scene
from conrod.studies.forces.results import (
    ForceErrors,
    is_moment,
)

Peaks: TypeAlias = Mapping[str, tuple[float, bool]]  # as `force_peaks` returns them
REQUIREMENT_STEPS = 1000  # steps per revolution at which requirements are stated
CHUNK_SAMPLES = 4096  # samples of which the exact forces are computed together
CRANK_SAMPLES = 361  # crank angles of a revolution or pass
CHANGE_POINT_MARGIN = 0.02  # [rad], around a change point, where joint forces are not determined
MEAN_STEPS = 16  # steps over which the mean is taken if single values scatter, with contact
ARC_JOINT_MARGIN = np.radians(1.0)  # of the crank, around an arc joint of a cam, where nothing is judged


# -- exact forces ----------------------------------------------------------------------------------------------------


def group_quantities(mechanism: Mechanism, group: str) -> tuple[str, ...]:
    """Return the names of a group's quantities: "drive torque", or "joint.component".

    The group `contact` is the force between cam and roller; `reactions` are those of all other joints.
    """
    if group == "torque":
        return (TORQUE,)
    return tuple(
        f"{joint.name}.{name}"
        for joint in mechanism.joints
        if isinstance(joint, CamContact) == (group == "contact")
        for name in component_names(joint)
    )


def derive_tolerance(
    mechanism: Mechanism, preset: Preset[Any], steps: int, groups: Mapping[str, Sequence[str]],
    law: ExpectedForceErrors | None = None,
) -> tuple[dict[str, float], str]:  # fmt: skip
    """Return the allowed error by group, over the exact peak, and its reason.

    Both are empty if nothing is required of the preset.

    Args:
        steps: steps per revolution.
        groups: names of the quantities by group, for the groups that count.
        law: expected errors of the engine's scheme, which are allowed where they exceed the requirement.
    """
    if mechanism.cam_contacts:
        # Forces jump with the acceleration, and then a largest error is the jump within a step.
        bar = preset.forces.get("contact")
        if bar is None or "contact" not in groups:
            return {}, ""
        return {"contact": bar}, "required of the contact force: 2 % rms between the cam's arc joints"
    bars, order = preset.forces, preset.forces_order
    coarser = max(1.0, REQUIREMENT_STEPS / steps) ** order
    allowed = {group: bar * coarser for group, bar in bars.items() if group in groups}
    required = ", ".join(f"{group} {bars[group]:g}" for group in allowed)
    reason = f"required at {REQUIREMENT_STEPS} steps a revolution: {required}, of the exact peak" if allowed else ""
    reason += f"; at {steps} times {coarser:.3g}, by order {order}" if coarser > 1.0 and allowed else ""
    expected = {} if law is None else {group: law.largest_error(groups[group]) for group in allowed}
    if above := {group: size for group, size in expected.items() if size > allowed[group]}:
        allowed |= above
        more = ", ".join(f"{group} {size:.2g}" for group, size in above.items())
        reason += f"; {more} by its law, {law.text if law else ''}"
    return allowed, reason


def exact_forces(kinematics: Kinematics, state: Instants) -> dict[str, Array]:
    """Return the exact forces (T,) [N] and torques [N m] in states of the crank, by quantity."""
    parts = []
    for start in range(0, len(state.angle), CHUNK_SAMPLES):
        chunk = state[start : start + CHUNK_SAMPLES]
        parts.append(quantities(joint_forces(kinematics, chunk)))
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def constant_speed_states(scene: ExactReference) -> Instants:
    """Return crank states of a revolution or pass at constant speed, without change points."""
    angle = np.linspace(*scene.kinematics.span, CRANK_SAMPLES)
    angle = angle[~scene.kinematics.near_change(angle, CHANGE_POINT_MARGIN)]
    zeros = np.zeros_like(angle)
    return Instants(angle / scene.speed, angle, zeros + scene.speed, zeros)


def force_peaks(scene: Scene) -> dict[str, tuple[float, bool]]:
    """Return by quantity the peak that normalises errors, and whether that is its exact peak.

    The peak is the largest exact value at constant speed. A quantity that is zero to rounding takes the largest peak of
    its unit instead; if all moments are zero, they take the largest force times the size of the machine.
    """
    exact = exact_forces(scene.kinematics, constant_speed_states(scene))
    own = {name: float(np.abs(values).max()) for name, values in exact.items()}
    force = max((peak for name, peak in own.items() if not is_moment(name)), default=0.0) or 1.0
    moment = max((peak for name, peak in own.items() if is_moment(name)), default=0.0)
    lever = force * scene.kinematics.size
    if moment <= MIN_RELATIVE_CHANGE * lever:
        moment = lever
    largest = {True: moment, False: force}
    has = {name: peak > MIN_RELATIVE_CHANGE * largest[is_moment(name)] for name, peak in own.items()}
    return {name: (peak if has[name] else largest[is_moment(name)], has[name]) for name, peak in own.items()}


# -- reported forces -------------------------------------------------------------------------------------------------


class ForceComparison:
    """Reported forces of a run and exact forces at the same instants.

    Attributes:
        kept: mask of the samples away from change points, where joint forces are determined; the other attributes
            hold these samples alone.
        state: states of the crank at these samples.
        reported, exact: forces by quantity (T,) [N] or [N m].
        peaks: peaks that normalise the errors.
    """

    def __init__(self, scene: ExactReference, tracks: ForceTracks, peaks: Peaks, step: float) -> None:
        """Compare reported forces with exact forces at the instants of the run.

        Args:
            step: step size of the run [s].
        """
        at, kinematics = tracks.instants, scene.kinematics
        self.kept = ~kinematics.near_change(at.angle, CHANGE_POINT_MARGIN)
        self.state = state = at[self.kept]
        self.angle, self.peaks = state.angle, peaks
        reported = {f"{j}.{name}": values for j, some in tracks.joints.items() for name, values in some.items()}
        if tracks.drive_torque is not None:
            reported = {TORQUE: tracks.drive_torque} | reported
        self.reported = {name: values[self.kept] for name, values in reported.items()}
        self.exact = exact_forces(kinematics, state)
        spacing = np.diff(at.times[:2], prepend=at.times[0])[-1]
        self._together = max(1, round(MEAN_STEPS * step / max(spacing, step)))
        self._between = (
            _away_from_arc_joints(self.angle, scene.break_angles()) if kinematics.mechanism.cam_contacts else None
        )

    def signed_errors(self, name: str) -> Array:
        """Return reported minus exact values (T,) of a quantity [N] or [N m]."""
        return np.asarray(self.reported[name] - self.exact[name], dtype=float)

    def clear_rows(self) -> NDArray[np.int_]:
        """Return the indices of samples away from arc joints of a cam; all indices without a cam."""
        return np.flatnonzero(np.ones(len(self.angle)) if self._between is None else self._between)

    def errors(self, names: Sequence[str]) -> dict[str, ForceErrors]:
        """Return the errors over the run of those quantities that are reported."""
        return {name: self._error(name) for name in names if name in self.reported}

    def _error(self, name: str) -> ForceErrors:
        """Return the errors of a reported quantity over the run."""
        peak, own = self.peaks[name]
        errors = self.signed_errors(name) / peak
        between = None
        if self._between is not None:
            clear = _split_blocks(self._between, self._together).all(axis=1)
            # Single values scatter from an edge of the cam's polygon to the next, or from one contact to the next.
            means = _split_blocks(errors, self._together).mean(axis=1)
            between = size_of(means[clear]).rms if clear.any() else None
        whole = size_of(np.abs(errors))
        return ForceErrors(whole.max, whole.rms, between, peak, own)


class ExpectedForceErrors:
    """Errors of forces that the engine's law expects of its integration scheme.

    Attributes:
        text: the law, in words.
    """

    def __init__(self, scene: ExactReference, expected: ExpectedForces, peaks: Peaks, step: float) -> None:
        """Compare the forces that the law expects with the exact ones.

        Args:
            step: step size of the run [s].
        """
        assert expected.tracks is not None
        self._errors, self.text = ForceComparison(scene, expected.tracks, peaks, step), expected.law
        self._share, self._peaks = expected.share, peaks

    def largest_error(self, names: Sequence[str]) -> float:
        """Largest expected error of some quantities over their peaks, plus the law's uncertainty."""
        found = [
            float(np.abs(self._errors.signed_errors(name)).max(initial=0.0)) / self._peaks[name][0]
            for name in names
            if name in self._errors.reported
        ]
        return (1.0 + self._share) * max(found, default=0.0)

    def errors_at(self, state: Instants, name: str) -> Array:
        """Return the errors (T,) of a quantity that the law expects in states of a run.

        They are zeros if the law was evaluated at other instants than those of the states.
        """
        if np.array_equal(self._errors.state.times, state.times) and name in self._errors.reported:
            return self._errors.signed_errors(name)
        return np.zeros_like(state.times)


def _away_from_arc_joints(angle: Array, joints: Sequence[float]) -> NDArray[np.bool_]:
    """Mask (T,) of crank angles [rad] that keep a margin from the arc joints [rad] of a cam."""
    clear = np.ones(len(angle), dtype=bool)
    for joint in joints:
        clear &= np.abs((angle - joint + np.pi) % (2.0 * np.pi) - np.pi) > ARC_JOINT_MARGIN
    return clear


def _split_blocks(values: NDArray[Any], together: int) -> NDArray[Any]:
    """Split values (T,) into consecutive blocks (T // together, together), without the rest."""
    count = len(values) // together
    return values[: count * together].reshape(count, together)
