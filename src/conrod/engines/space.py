"""Runs of machines in space, as every engine takes and gives them: tree, drives, exact start; motion of points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from conrod.exact.motion import Array
from conrod.exact.space import SpatialPoint, SpatialTree
from conrod.exact.space.motion import DrivenTree, SpatialMotion


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
        reset: whether the engine put the state back by itself.
    """

    times: Array
    points: Mapping[str, Array]
    failure: str = ""
    reset: bool = False
