"""Runs of machines in space, as every engine takes and gives them: tree, drives, exact start; motion of points."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from conrod.exact.motion import Array
from conrod.exact.space import SpatialPoint, SpatialTree
from conrod.exact.space.drive_laws import DriveLaw
from conrod.exact.space.mobility import count_mobility
from conrod.exact.space.motion import DrivenTree, SpatialMotion

START_SHARE = 1e-3  # of a law, over which the branch is tracked to find the exact state at the start
RATE_ROUNDING = 1e-12  # of the largest rate, by which a constant one may change


@dataclass(frozen=True, eq=False)
class SpatialStart:
    """A machine in space, ready to be run: its drives' laws, its exact state at time 0, and its step.

    Attributes:
        machine: tree and laws; its motion is tracked from time 0 on.
        exact: exact coordinates, rates and accelerations at time 0, one sample.
        points: observed points by name, to be recorded.
        period: time [s] that the slowest drive takes for its law.
        step: time step [s].
        idle: whether the drives leave a joint free to spin.
    """

    machine: DrivenTree
    exact: SpatialMotion
    points: Mapping[str, SpatialPoint]
    period: float
    step: float
    idle: bool = False

    @property
    def tree(self) -> SpatialTree:
        """The machine's bodies, joints and closures."""
        return self.machine.tree


@dataclass(frozen=True, eq=False)
class SpatialRun:
    """Motion of a machine in space, as an engine reports it; all quantities of a sample belong to one instant.

    Attributes:
        times: (T,) [s]; fewer than were asked for where the run broke off.
        points: position, velocity and acceleration (3, T, 3) of each observed point, by name.
        failure: why the run broke off, in the engine's words; empty if it came to its end.
    """

    times: Array
    points: Mapping[str, Array]
    failure: str = ""


def exact_start(tree: SpatialTree, laws: Mapping[str, DriveLaw], names: Iterable[str]) -> SpatialStart:
    """Find the exact state of a machine at time 0, with the duration of a law as step until one is set.

    Args:
        laws: of the driven joints by name, the coordinates in the tree's start pose at time 0.
        names: observed points of the tree to be recorded; the ends of all closures are, too.
    """
    period = max(law.duration for law in laws.values() if law.duration < math.inf)
    driven = DrivenTree(tree, {joint.name: laws[joint.name] for joint in tree.joints if joint.name in laws})
    driven.track_branch(driven.assemble_start(), START_SHARE * period)
    points = {name: tree.points[name] for name in names}
    points |= {name: end for ends in _closure_ends(tree).values() for pair in ends for name, end in pair}
    return SpatialStart(driven, driven.motion(np.zeros(1)), points, period, period, bool(count_mobility(driven).idle))


def constant_rate(law: DriveLaw) -> float | None:
    """Rate [rad/s, m/s] of a drive that keeps it, or None; a law that holds has the rate 0."""
    if math.isinf(law.duration):
        return 0.0
    rates = law.derivatives(np.linspace(0.0, 2.5 * law.duration, 21))[1]  # beyond its end, where some laws stop
    return float(rates[0]) if np.ptp(rates) <= RATE_ROUNDING * np.abs(rates).max() else None


def widest_gaps(tree: SpatialTree, run: SpatialRun) -> dict[str, float]:
    """Largest distance [m] between the two ends of each closure, by its name; they coincide in a closed loop.

    A weld has further ends at arms as long as the tree's extent, which show its rotation. A coupling of joints has no
    ends.
    """
    return {
        closure: max(
            float(np.linalg.norm(run.points[one][0] - run.points[other][0], axis=1).max(initial=0.0))
            for (one, _), (other, _) in ends
        )
        for closure, ends in _closure_ends(tree).items()
    }


def _closure_ends(tree: SpatialTree) -> dict[str, list[tuple[tuple[str, SpatialPoint], tuple[str, SpatialPoint]]]]:
    """Pairs of points that coincide while a closure is closed, each with a name, by the closure's name."""
    found = {}
    for k, closure in enumerate(tree.closures):
        if not closure.points:
            continue
        turns = (np.eye(3) if closure.turn is None else closure.turn, np.eye(3))
        arms = np.zeros((1, 3)) if closure.turn is None else tree.extent * np.vstack([np.zeros(3), np.eye(3)])
        ends = [
            [
                (f"closure {k} arm {j} end {m}", replace(point, offset=point.offset + turn @ arm))
                for j, arm in enumerate(arms)
            ]
            for m, (point, turn) in enumerate(zip(closure.points, turns, strict=True), 1)
        ]
        found[closure.name] = list(zip(*ends, strict=True))
    return found
