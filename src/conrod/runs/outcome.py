"""Outcomes from the recorded motion alone. One rule for each outcome, the first that applies counts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from conrod.exact.joint_equations import joint_residual, pose_jets
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import CamContact, Mechanism, Prismatic
from conrod.runs.trajectory import BodyTracks, Outcome

# A body this many sizes of the mechanism away from every place it can reach is not in the machine any more.
OUT_OF_REACH = 10.0
# A joint whose gap is a twentieth of the machine's travel is no joint: the loop is open, whatever closes it later.
# (The error that a solver leaves after zero iterations, the tolerance trap, is 7 % of the stroke or more.)
OPEN_GAP = 0.05
# A gap of one per cent of the travel is far beyond what a soft contact rebounds, and far below what a flight reaches.
LOST_GAP = 0.01
# A drive that is off its speed by half is not a constant-speed drive.
STALL = 0.5
# A crank that turns back or stops near a pose where the Jacobian is singular has run into the linkage's limit.
SINGULAR = 0.1
# This near [rad] to a change point, where branches meet, the error of a state may be more than lies between them.
MEETING = 0.1


@dataclass(frozen=True)
class Verdict:
    """An outcome with its details.

    Attributes:
        largest: size that the reason gives [m], with the words before and behind it; None where it gives none.
    """

    outcome: Outcome
    reason: str = ""
    largest: tuple[str, float, str] | None = None

    @classmethod
    def of_size(cls, outcome: Outcome, before: str, size: float, behind: str = " m") -> Verdict:
        """A verdict whose reason gives a size [m]."""
        return cls(outcome, f"{before} {size:.3g}{behind}", (before, size, behind))


# Of what a run shows in several of its parts, the first of these counts for the whole: the order of the rules below,
# after what an engine did by itself.
PREVAILING = (
    Outcome.RESET,
    Outcome.DIVERGED,
    Outcome.EXPLODED,
    Outcome.LOCKED,
    Outcome.STALLED,
    Outcome.TUNNELLED,
    Outcome.LOST_CONTACT,
    Outcome.OPENED,
    Outcome.FLIPPED,
    Outcome.COMPLETED,
)


def prevailing(before: Verdict, after: Verdict) -> Verdict:
    """The verdict on a run of which two parts were judged by themselves; of equal ones the earlier, sized by both."""
    if before.outcome is after.outcome and before.largest and after.largest and before.largest[0] == after.largest[0]:
        words, size, behind = before.largest
        return Verdict.of_size(before.outcome, words, max(size, after.largest[1]), behind)
    return min(before, after, key=lambda verdict: PREVAILING.index(verdict.outcome))


def judge(
    kinematics: Kinematics, bodies: BodyTracks, speed: float, before: Verdict = Verdict(Outcome.COMPLETED)
) -> Verdict:
    """The verdict on a run.

    Args:
        bodies: its states, or those of a stretch of it.
        before: verdict on what went before that.
    """
    rules = (_diverged, _exploded, _stalled_or_locked, _contact, _opened, _flipped)
    found = (verdict for rule in rules if (verdict := rule(kinematics, bodies, speed)) is not None)
    return prevailing(before, next(found, Verdict(Outcome.COMPLETED)))


def _diverged(kinematics: Kinematics, bodies: BodyTracks, speed: float) -> Verdict | None:
    for states in (bodies.position, bodies.velocity, bodies.acceleration):
        for values in (states.poses, states.rates, states.accelerations):
            if not np.all(np.isfinite(values)):
                bad = int(np.argmin(np.all(np.isfinite(values), axis=1)))
                return Verdict(Outcome.DIVERGED, f"not finite from {states.instants.times[bad]:.6g} s on")
    return None


def _exploded(kinematics: Kinematics, bodies: BodyTracks, speed: float) -> Verdict | None:
    positions = bodies.position.poses.reshape(len(bodies.position.poses), -1, 3)[:, :, :2]
    start = kinematics.start.reshape(-1, 3)[:, :2]
    away = np.abs(positions - start).max(axis=(1, 2)) / kinematics.size
    if away.max() > OUT_OF_REACH:
        worst = int(np.argmax(away > OUT_OF_REACH))
        time = float(bodies.position.instants.times[worst])
        return Verdict(Outcome.EXPLODED, f"beyond {OUT_OF_REACH:g} sizes of the mechanism from {time:.6g} s on")
    return None


def _stalled_or_locked(kinematics: Kinematics, bodies: BodyTracks, speed: float) -> Verdict | None:
    ratio = bodies.velocity.instants.rate / speed
    off = np.abs(ratio - 1.0) > STALL
    if not off.any():
        return None
    first = int(np.argmax(off))
    angle = float(np.degrees(bodies.velocity.instants.angle[first]))
    # Smallest singular value of the scaled Jacobian against that of the start pose: near 0 at a limit pose.
    near = kinematics.conditioning(bodies.velocity.poses[off]) / kinematics.conditioning(kinematics.start)
    if near.min() < SINGULAR:
        return Verdict(Outcome.LOCKED, f"the crank stopped at a limit of the linkage, near {angle:.1f} deg")
    return Verdict(Outcome.STALLED, f"the drive was off its speed by half at {angle:.1f} deg")


def _contact(kinematics: Kinematics, bodies: BodyTracks, speed: float) -> Verdict | None:
    for joint in kinematics.mechanism.cam_contacts:
        gap = joint_gaps(kinematics.mechanism, [bodies.position.poses])[joint.name]
        if gap.min() < -joint.roller_radius:
            return Verdict.of_size(Outcome.TUNNELLED, f"{joint.name}: the roller's centre is", -gap.min(), " m deep")
        lost = gap > LOST_GAP * kinematics.travel
        if lost.any():
            angle = float(np.degrees(bodies.position.instants.angle[int(np.argmax(lost))]))
            first = f" m, first near {angle:.1f} deg"
            return Verdict.of_size(Outcome.LOST_CONTACT, f"{joint.name}: gap up to", gap.max(), first)
    return None


def _opened(kinematics: Kinematics, bodies: BodyTracks, speed: float) -> Verdict | None:
    contacts = {joint.name for joint in kinematics.mechanism.cam_contacts}
    for name, gap in joint_gaps(kinematics.mechanism, [bodies.position.poses]).items():
        if name not in contacts and np.abs(gap).max() > OPEN_GAP * kinematics.travel:
            return Verdict.of_size(Outcome.OPENED, f"{name}: gap up to", np.abs(gap).max())
    return None


def _flipped(kinematics: Kinematics, bodies: BodyTracks, speed: float) -> Verdict | None:
    at = bodies.position.instants.angle
    other = kinematics.branch(bodies.position.poses) != kinematics.branch_at(at)
    other &= ~kinematics.near_change(at, MEETING)
    if other.any():
        angle = float(np.degrees(bodies.position.instants.angle[int(np.argmax(other))]))
        return Verdict(Outcome.FLIPPED, f"on the other branch from {angle:.1f} deg on")
    return None


def joint_gaps(mechanism: Mechanism, derivatives: list[Array]) -> dict[str, Array]:
    """The gap of every joint, or its rate, or its acceleration: the highest derivative given.

    Args:
        derivatives: stacked poses, their rates, their accelerations (T, 3 n), as many as are wanted.

    Returns:
        For a pin the length of the gap vector, for a slide the offset from its line, for a cam the signed distance
        between cam and roller [m], [m/s] or [m/s^2]; each (T,).
    """
    order = len(derivatives) - 1
    bodies = pose_jets(mechanism, [d / math.factorial(k) for k, d in enumerate(derivatives)])
    gaps = {}
    for joint in mechanism.joints:
        parts = [math.factorial(order) * np.asarray(e.coefficients[order]) for e in joint_residual(joint, bodies)]
        lengths = parts[:1] if isinstance(joint, Prismatic) else parts
        gaps[joint.name] = lengths[0] if isinstance(joint, CamContact) else np.sqrt(sum(p * p for p in lengths))
    return {name: np.broadcast_to(gap, (len(derivatives[0]),)) for name, gap in gaps.items()}
