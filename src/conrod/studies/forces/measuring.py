"""Forces that an engine reports against the exact ones, at the angle, rate and acceleration that its crank had.

They are judged by what is required of an engine at 1000 steps a revolution. With fewer the bar is as much higher as the
order of the engine's scheme makes the error; with more it stays. A machine whose motion changes quickly, as beside a
dead centre, has a scheme further off: where the engine's law of its forces (`ForceLaw`) says so, that is allowed.

An error that looks like the effect of a wrong mass on the forces, by the exact sensitivities, is reported as how much
of it: the projection of all errors on its effect, less those that the law has at the same instants. That detects less
than a tolerance has to allow.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from conrod.engines.capabilities import ExpectedForces
from conrod.engines.engine import Preset
from conrod.engines.tracks import ForceTracks
from conrod.exact import ExactReference
from conrod.exact.dynamics.inverse import (
    MIN_RELATIVE_CHANGE,
    TORQUE,
    CrankStates,
    component_names,
    joint_forces,
    quantities,
    sensitivities,
)
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import CamContact, Mechanism
from conrod.runs.comparison import size_of
from conrod.scenes import Scene
from conrod.studies.forces.results import (
    LOOKS_LIKE,
    ForceErrors,
    is_moment,
)

Peaks: TypeAlias = Mapping[str, tuple[float, bool]]  # as `peaks_of` gives them
STEPS = 1000
CHUNK = 4096  # samples of which the exact forces are worked out together
SAMPLES = 361
NEAR = 0.02  # [rad], of a change point, where joint forces are not determined
MOST = 131072  # samples that are looked at: with contact single values scatter, and only many of them show it
PARTS = 64  # of a run
SURE = 3.0  # standard errors of the projection have to lie within it, or within what would be reported
TOGETHER = 16  # steps of which a mean is taken where single values scatter, with contact
# A wrong mass leaves at most this share of the errors that it is claimed for: planted ones leave 0.02; other masses,
# and all masses of healthy runs whose engine's own errors are not taken off, leave 0.64 and more.
MAX_LEFT_SHARE = 0.2
FAR_BETTER_FACTOR, EXPLAINED_SHARE = 10.0, 0.02  # one mass is claimed in place of another that leaves so much more
CLEAR = np.radians(1.0)  # of the crank, that lies between an arc joint of a cam and what is judged


# -- what is exact ---------------------------------------------------------------------------------------------------


def quantities_of(mechanism: Mechanism, group: str) -> tuple[str, ...]:
    """The quantities of a group: "drive torque", or "joint.component".

    The push between cam and roller is the contact; reactions are what all other joints carry.
    """
    if group == "torque":
        return (TORQUE,)
    return tuple(
        f"{joint.name}.{name}"
        for joint in mechanism.joints
        if isinstance(joint, CamContact) == (group == "contact")
        for name in component_names(joint)
    )


def tolerance_of(
    mechanism: Mechanism, preset: Preset[Any], steps: int, groups: Mapping[str, Sequence[str]],
    law: LawOfForces | None = None,
) -> tuple[dict[str, float], str]:  # fmt: skip
    """By group what is allowed, and why; nothing of presets of which nothing is required.

    Args:
        groups: those that are looked at, with the names of their quantities.
        law: what the engine's scheme makes of the exact motion; allowed where it is more than what is required.
    """
    if mechanism.cam_contacts:
        # Where the acceleration jumps all forces do: their largest errors are one step of the jump.
        bar = preset.forces.get("contact")
        if bar is None or "contact" not in groups:
            return {}, ""
        return {"contact": bar}, "required of the contact force: 2 % rms between the cam's arc joints"
    bars, order = preset.forces, preset.forces_order
    coarser = max(1.0, STEPS / steps) ** order
    allowed = {group: bar * coarser for group, bar in bars.items() if group in groups}
    required = ", ".join(f"{group} {bars[group]:g}" for group in allowed)
    reason = f"required at {STEPS} steps a revolution: {required}, of the exact peak" if allowed else ""
    reason += f"; at {steps} times {coarser:.3g}, by order {order}" if coarser > 1.0 and allowed else ""
    expected = {} if law is None else {group: law.largest(groups[group]) for group in allowed}
    if above := {group: size for group, size in expected.items() if size > allowed[group]}:
        allowed |= above
        more = ", ".join(f"{group} {size:.2g}" for group, size in above.items())
        reason += f"; {more} by its law, {law.text if law else ''}"
    return allowed, reason


def exact_quantities(kinematics: Kinematics, state: CrankStates) -> dict[str, Array]:
    """The exact forces in a motion by quantity, (T,) each."""
    parts = []
    for start in range(0, len(state.angle), CHUNK):
        some = slice(start, start + CHUNK)
        one = CrankStates(state.angle[some], state.rate[some], state.acceleration[some], state.time[some])
        parts.append(quantities(joint_forces(kinematics, one)))
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def even_state(scene: ExactReference) -> CrankStates:
    """A turn, or the one pass, at constant speed; change points are left out."""
    angle = np.linspace(*scene.kinematics.span, SAMPLES)
    angle = angle[~scene.kinematics.near_change(angle, NEAR)]
    still = np.zeros_like(angle)
    return CrankStates(angle, still + scene.speed, still, angle / scene.speed)


def peaks_of(scene: Scene) -> dict[str, tuple[float, bool]]:
    """By quantity what errors are divided by, and whether that is its own peak at constant speed.

    What is zero but for rounding has the largest peak of its unit instead, and where moments have none the largest
    force times the size of the machine.
    """
    exact = exact_quantities(scene.kinematics, even_state(scene))
    own = {name: float(np.abs(values).max()) for name, values in exact.items()}
    force = max((peak for name, peak in own.items() if not is_moment(name)), default=0.0) or 1.0
    moment = max((peak for name, peak in own.items() if is_moment(name)), default=0.0)
    lever = force * scene.kinematics.size
    if moment <= MIN_RELATIVE_CHANGE * lever:
        moment = lever
    largest = {True: moment, False: force}
    has = {name: peak > MIN_RELATIVE_CHANGE * largest[is_moment(name)] for name, peak in own.items()}
    return {name: (peak if has[name] else largest[is_moment(name)], has[name]) for name, peak in own.items()}


# -- what is reported ------------------------------------------------------------------------------------------------


class Measured:
    """One run that reported something, by steps of a length [s], beside the exact forces."""

    def __init__(self, scene: ExactReference, tracks: ForceTracks, peaks: Peaks, step: float) -> None:
        at, kinematics = tracks.instants, scene.kinematics
        self.kept = ~kinematics.near_change(at.angle, NEAR)
        self.state = state = CrankStates(*(v[self.kept] for v in (at.angle, at.rate, at.acceleration, at.times)))
        self.angle, self.peaks = state.angle, peaks
        reported = {f"{j}.{name}": values for j, some in tracks.joints.items() for name, values in some.items()}
        if tracks.drive_torque is not None:
            reported = {TORQUE: tracks.drive_torque} | reported
        self.reported = {name: values[self.kept] for name, values in reported.items()}
        self.exact = exact_quantities(kinematics, state)
        spacing = np.diff(at.times[:2], prepend=at.times[0])[-1]
        self._together = max(1, round(TOGETHER * step / max(spacing, step)))
        self._between = _between(self.angle, scene.break_angles()) if kinematics.mechanism.cam_contacts else None

    def signed(self, name: str) -> Array:
        """Errors (T,) of a reported quantity [N] or [N m]."""
        return np.asarray(self.reported[name] - self.exact[name], dtype=float)

    def clear(self) -> NDArray[np.int_]:
        """Indices of the measured values that lie away from arc joints."""
        return np.flatnonzero(np.ones(len(self.angle)) if self._between is None else self._between)

    def errors(self, names: Sequence[str]) -> dict[str, ForceErrors]:
        """Of the quantities that are reported."""
        return {name: self._error(name) for name in names if name in self.reported}

    def _error(self, name: str) -> ForceErrors:
        peak, own = self.peaks[name]
        off = self.signed(name) / peak
        between = None
        if self._between is not None:
            clear = _blocks(self._between, self._together).all(axis=1)
            # Single values scatter from an edge of the cam's polygon to the next, or from catch to catch.
            means = _blocks(off, self._together).mean(axis=1)
            between = size_of(means[clear]).rms if clear.any() else None
        whole = size_of(np.abs(off))
        return ForceErrors(whole.max, whole.rms, between, peak, own)


class LawOfForces:
    """What an engine's scheme makes of the exact forces of a scene, by its law, in steps of a length [s]."""

    def __init__(self, scene: ExactReference, expected: ExpectedForces, peaks: Peaks, step: float) -> None:
        assert expected.tracks is not None
        self._errors, self.text = Measured(scene, expected.tracks, peaks, step), expected.law
        self._share, self._peaks = expected.share, peaks

    def largest(self, names: Sequence[str]) -> float:
        """Largest error over the peak of some quantities, with what the law leaves out."""
        found = [
            float(np.abs(self._errors.signed(name)).max(initial=0.0)) / self._peaks[name][0]
            for name in names
            if name in self._errors.reported
        ]
        return (1.0 + self._share) * max(found, default=0.0)

    def at(self, state: CrankStates, name: str) -> Array:
        """Errors (T,) of a quantity in a run; zero where the law has other instants than these."""
        if np.array_equal(self._errors.state.time, state.time) and name in self._errors.reported:
            return self._errors.signed(name)
        return np.zeros_like(state.time)


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


# -- what forces show of a wrong mass ----------------------------------------------------------------------------------


def seen_in(scene: ExactReference, names: Sequence[str], peaks: Peaks) -> set[tuple[str, str]]:
    """Bodies and properties of theirs that some quantities depend on at constant speed, by what is to be seen."""
    found = sensitivities(scene.kinematics, even_state(scene))
    shown = {
        (one.body, one.quality): max(float(np.abs(one.derivatives[n]).max()) * one.change / peaks[n][0] for n in names)
        for one in found
    }
    return {which for which, share in shown.items() if share >= MIN_RELATIVE_CHANGE}


def likenesses(
    scene: ExactReference, measured: Measured, names: Sequence[str], law: LawOfForces | None = None
) -> dict[str, float]:
    """By "body.property", how many times the change that is to be seen the errors look like.

    That is 1 % of a mass, 1 % of a length, 5 % of an inertia. What no quantity depends on is not among them,
    nor that for which the errors scatter too much: with contact, where a run has few steps. A wrong mass is claimed
    only where it explains the errors, by what it leaves of them (`_explained`): an engine's own errors, where no law
    takes them off, have a projection on every mass.

    Args:
        names: of the quantities that are looked at; those that are not reported are left out.
        law: of the engine's own errors, which are taken off before: no wrong mass makes them.
    """
    reported = [name for name in names if name in measured.reported]
    some = measured.clear()
    some = some[np.unique(np.linspace(0, len(some) - 1, MOST).astype(int))]
    at = measured.state
    state = CrankStates(*(values[some] for values in (at.angle, at.rate, at.acceleration, at.time)))
    peaks = {name: measured.peaks[name][0] for name in reported}
    own = {name: 0.0 if law is None else law.at(at, name) for name in reported}
    errors = np.concatenate([(measured.signed(n) - own[n])[some] / peaks[n] for n in reported])
    # At constant speed, as the machine is meant to run: what ripple of the drive would show is not counted.
    seen = seen_in(scene, reported, measured.peaks)
    found, left_over = {}, {}
    for one in sensitivities(scene.kinematics, state):
        effect = np.concatenate([one.derivatives[n] * one.change / peaks[n] for n in reported])
        if (one.body, one.quality) in seen and effect.any():
            times = float(errors @ effect / (effect @ effect))
            # Values after each other, and quantities, scatter together: single parts of the run are independent.
            left = errors - times * effect
            along = (left * effect).reshape(len(reported), -1).sum(axis=0)
            parts = [part.sum() for part in np.array_split(along, PARTS)]
            scatter = float(np.linalg.norm(parts) / (effect @ effect))
            if SURE * scatter < max(LOOKS_LIKE, abs(times)):
                found[name := f"{one.body}.{one.quality}"] = times
                left_over[name] = float(np.linalg.norm(left) / np.linalg.norm(errors)) if errors.any() else 0.0
    # Single values of a contact scatter by more than any mass changes them: there the projection alone tells.
    return found if scene.kinematics.mechanism.cam_contacts else _explained(found, left_over)


def _explained(times: Mapping[str, float], left: Mapping[str, float]) -> dict[str, float]:
    """Drop claims of a wrong mass that do not explain the errors, or far worse than another does.

    Args:
        times: changes that the errors look like; those of up to `LOOKS_LIKE` are no claim.
        left: norm of the errors without each of them, over the norm of the errors.
    """
    claims = [name for name, size in times.items() if not abs(size) <= LOOKS_LIKE]
    best = min((left[name] for name in claims), default=1.0)
    bound = min(MAX_LEFT_SHARE, max(FAR_BETTER_FACTOR * best, EXPLAINED_SHARE))
    return {name: size for name, size in times.items() if name not in claims or left[name] <= bound}
