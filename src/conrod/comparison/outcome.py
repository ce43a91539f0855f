"""The outcome of a run from its recorded motion alone: the first rule that applies counts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from conrod.comparison.trajectory import ArrayMapper, BodyTracks, Outcome
from conrod.exact.joint_equations import joint_residual, pose_jets
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array, cache_blocks
from conrod.mechanism.mechanism import CamContact, Mechanism, Prismatic

# Distance of a body from its start, in sizes of the mechanism, beyond which it has left the machine.
MAX_REACH_SIZES = 10.0
# Share of the travel: with a larger gap a joint is none, and its loop is open, even if it closes again later. (The
# error that a solver leaves after zero iterations, the tolerance trap, is 7 % of the stroke or more.)
MAX_JOINT_GAP = 0.05
# Share of the travel: far above the rebound of a soft contact, far below the gap of a follower in flight.
MAX_CONTACT_GAP = 0.01
# Relative error of the crank's speed, beyond which the drive is no constant-speed drive.
MAX_SPEED_ERROR = 0.5
# Smallest singular value over that of the start pose: if the crank stops below it, it has reached the linkage's limit.
LIMIT_POSE_RATIO = 0.1
# Distance [rad] from a change point within which the error of a state may exceed the distance of the branches.
CHANGE_POINT_DISTANCE = 0.1
BLOCK_SAMPLES = 8192  # judged at once, so that intermediate arrays stay in a core's cache


@dataclass(frozen=True)
class RunVerdict:
    """How a run ended: its outcome, and the reason in words.

    Whether the errors of a completed run pass is another question, see `JudgedResult.passed`.

    Attributes:
        sized_reason: the reason in three parts if it states a size: words before, size [m], words after.
    """

    outcome: Outcome
    reason: str = ""
    sized_reason: tuple[str, float, str] | None = None

    @classmethod
    def of_size(cls, outcome: Outcome, before: str, size: float, behind: str = " m") -> RunVerdict:
        """A verdict whose reason contains a size [m]."""
        return cls(outcome, f"{before} {size:.3g}{behind}", (before, size, behind))


# If parts of a run have different outcomes, the first of these counts for the whole: the order of the rules below,
# after what an engine did by itself.
VERDICT_ORDER = (
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


def combine_verdicts(before: RunVerdict, after: RunVerdict) -> RunVerdict:
    """Combine the verdicts on two parts of a run; of equal verdicts the earlier, with the larger size."""
    one, other = before.sized_reason, after.sized_reason
    if before.outcome is after.outcome and one and other and one[0] == other[0]:
        return RunVerdict.of_size(before.outcome, one[0], max(one[1], other[1]), one[2])
    return min(before, after, key=lambda verdict: VERDICT_ORDER.index(verdict.outcome))


def judge_outcome(
    kinematics: Kinematics, bodies: BodyTracks, speed: float, before: RunVerdict = RunVerdict(Outcome.COMPLETED)
) -> RunVerdict:
    """Judge a run by its recorded states.

    Args:
        bodies: states of the run, or of a piece of it.
        before: verdict on the part of the run before the piece.
    """
    rules = (
        _find_divergence,
        _find_explosion,
        _find_stopped_crank,
        _find_contact_failure,
        _find_open_joint,
        _find_branch_flip,
    )
    blocks = (_block_of_samples(bodies, rows) for rows in cache_blocks(len(bodies.position.poses), BLOCK_SAMPLES))
    # Most runs have nothing to find, which is seen in less time block by block.
    if all(rule(kinematics, block, speed) is None for block in blocks for rule in rules):
        return combine_verdicts(before, RunVerdict(Outcome.COMPLETED))
    found = (verdict for rule in rules if (verdict := rule(kinematics, bodies, speed)) is not None)
    return combine_verdicts(before, next(found, RunVerdict(Outcome.COMPLETED)))


def _block_of_samples(bodies: BodyTracks, rows: slice) -> BodyTracks:
    """Return consecutive samples of each quantity."""
    return ArrayMapper(lambda parts: parts[0][rows])(bodies)


def _find_divergence(kinematics: Kinematics, bodies: BodyTracks, speed: float) -> RunVerdict | None:
    """DIVERGED if a state is not finite."""
    each = {id(states): states for states in (bodies.position, bodies.velocity, bodies.acceleration)}
    for states in each.values():
        for values in (states.poses, states.rates, states.accelerations):
            if not np.all(np.isfinite(values)):
                bad = int(np.argmin(np.all(np.isfinite(values), axis=1)))
                return RunVerdict(Outcome.DIVERGED, f"not finite from {states.instants.times[bad]:.6g} s on")
    return None


def _find_explosion(kinematics: Kinematics, bodies: BodyTracks, speed: float) -> RunVerdict | None:
    """EXPLODED if a body is out of reach of the mechanism."""
    poses, start = bodies.position.poses, kinematics.start[0]
    farthest = np.maximum(poses.max(axis=0) - start, start - poses.min(axis=0)).reshape(-1, 3)[:, :2]
    if farthest.max() / kinematics.size > MAX_REACH_SIZES:
        away = np.abs(poses - start).reshape(len(poses), -1, 3)[:, :, :2].max(axis=(1, 2)) / kinematics.size
        worst = int(np.argmax(away > MAX_REACH_SIZES))
        time = float(bodies.position.instants.times[worst])
        return RunVerdict(Outcome.EXPLODED, f"beyond {MAX_REACH_SIZES:g} sizes of the mechanism from {time:.6g} s on")
    return None


def _find_stopped_crank(kinematics: Kinematics, bodies: BodyTracks, speed: float) -> RunVerdict | None:
    """LOCKED or STALLED if the crank lost half its speed, near a limit of the linkage or elsewhere."""
    ratio = bodies.velocity.instants.rate / speed
    off = np.abs(ratio - 1.0) > MAX_SPEED_ERROR
    if not off.any():
        return None
    first = int(np.argmax(off))
    angle = float(np.degrees(bodies.velocity.instants.angle[first]))
    # Smallest singular value of the scaled Jacobian against that of the start pose: near 0 at a limit pose.
    near = kinematics.conditioning(bodies.velocity.poses[off]) / kinematics.conditioning(kinematics.start)
    if near.min() < LIMIT_POSE_RATIO:
        return RunVerdict(Outcome.LOCKED, f"the crank stopped at a limit of the linkage, near {angle:.1f} deg")
    return RunVerdict(Outcome.STALLED, f"the drive was off its speed by half at {angle:.1f} deg")


def _find_contact_failure(kinematics: Kinematics, bodies: BodyTracks, speed: float) -> RunVerdict | None:
    """TUNNELLED or LOST_CONTACT if a roller is inside its cam or off it."""
    for joint in kinematics.mechanism.cam_contacts:
        gap = joint_gaps(kinematics.mechanism, [bodies.position.poses])[joint.name]
        if gap.min() < -joint.roller_radius:
            return RunVerdict.of_size(Outcome.TUNNELLED, f"{joint.name}: the roller's centre is", -gap.min(), " m deep")
        lost = gap > MAX_CONTACT_GAP * kinematics.travel
        if lost.any():
            angle = float(np.degrees(bodies.position.instants.angle[int(np.argmax(lost))]))
            first = f" m, first near {angle:.1f} deg"
            return RunVerdict.of_size(Outcome.LOST_CONTACT, f"{joint.name}: gap up to", gap.max(), first)
    return None


def _find_open_joint(kinematics: Kinematics, bodies: BodyTracks, speed: float) -> RunVerdict | None:
    """OPENED if a joint's gap exceeds `MAX_JOINT_GAP` of the travel."""
    contacts = {joint.name for joint in kinematics.mechanism.cam_contacts}
    for name, gap in joint_gaps(kinematics.mechanism, [bodies.position.poses]).items():
        if name not in contacts and np.abs(gap).max() > MAX_JOINT_GAP * kinematics.travel:
            return RunVerdict.of_size(Outcome.OPENED, f"{name}: gap up to", np.abs(gap).max())
    return None


def _find_branch_flip(kinematics: Kinematics, bodies: BodyTracks, speed: float) -> RunVerdict | None:
    """FLIPPED if the linkage has changed its assembly branch, away from change points."""
    at = bodies.position.instants.angle
    other = kinematics.branch(bodies.position.poses) != kinematics.branch_at(at)
    other &= ~kinematics.near_change(at, CHANGE_POINT_DISTANCE)
    if other.any():
        angle = float(np.degrees(bodies.position.instants.angle[int(np.argmax(other))]))
        return RunVerdict(Outcome.FLIPPED, f"on the other branch from {angle:.1f} deg on")
    return None


def joint_gaps(mechanism: Mechanism, derivatives: list[Array]) -> dict[str, Array]:
    """Gap of every joint, or its rate or acceleration: the highest derivative given.

    Args:
        derivatives: stacked poses, their rates, their accelerations (T, 3 n), the first one, two or three.

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
