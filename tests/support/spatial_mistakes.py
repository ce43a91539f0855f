"""Mistakes of engines in space: edits of the machine that an engine is given, which it then runs rightly."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from planted_engine import LawfulEngine

from conrod.engines import engine_named
from conrod.engines.space import SpatialStart
from conrod.exact.motion import Array
from conrod.exact.space import SpatialBody, SpatialJoint, SpatialTree
from conrod.exact.space.motion import DrivenTree

Edit = Callable[[SpatialStart], SpatialStart]


class RunsInSpace(LawfulEngine):
    """The planted engine, which has MuJoCo run machines in space: those that it is given, edited."""

    def __init__(self, edit: Edit) -> None:
        super().__init__()
        self.edit, self._runs = edit, engine_named("mujoco")

    def refusal_in_space(self, start: SpatialStart, preset: str) -> str | None:
        return None

    def run_in_space(self, start: SpatialStart, preset: str, steps: int, every: int = 1) -> Any:
        return self._runs.run_in_space(self.edit(start), "hardened", steps, every)  # type: ignore[attr-defined] # it can

    def stepper_in_space(self, start: SpatialStart, preset: str) -> Any:
        return self._runs.stepper_in_space(self.edit(start), "hardened")  # type: ignore[attr-defined] # it can


def with_tree(start: SpatialStart, tree: SpatialTree) -> SpatialStart:
    return replace(start, machine=DrivenTree(tree, start.machine.laws))


def edit_joints(start: SpatialStart, edit: Callable[[SpatialBody], tuple[SpatialJoint, ...]]) -> SpatialStart:
    bodies = tuple(replace(body, joints=edit(body)) for body in start.tree.bodies)
    return with_tree(start, replace(start.tree, bodies=bodies))


def align_axes(start: SpatialStart) -> SpatialStart:
    """Turn each joint's axis to the nearest axis of its body."""

    def aligned(axis: Array) -> Array:
        nearest = int(np.argmax(np.abs(axis)))
        return np.asarray(np.eye(3)[nearest] * np.sign(axis[nearest]))

    return edit_joints(start, lambda body: tuple(replace(joint, axis=aligned(joint.axis)) for joint in body.joints))


def move_first_of_two_hinges(start: SpatialStart) -> SpatialStart:
    """Put the first of two hinges of a body at its parent's origin, as Drake's reader of MJCF does."""

    def moved(body: SpatialBody) -> tuple[SpatialJoint, ...]:
        if len(body.joints) < 2:
            return body.joints
        return (replace(body.joints[0], anchor=-body.turn.T @ body.place), *body.joints[1:])

    return edit_joints(start, moved)


def swap_hinges(start: SpatialStart) -> SpatialStart:
    """Give each of two hinges of a body the other's axis."""

    def swapped(body: SpatialBody) -> tuple[SpatialJoint, ...]:
        if len(body.joints) < 2:
            return body.joints
        first, second = body.joints
        return replace(first, axis=second.axis), replace(second, axis=first.axis)

    return edit_joints(start, swapped)


def ignore_closures(start: SpatialStart) -> SpatialStart:
    return with_tree(start, replace(start.tree, closures=()))


def freeze_spin(start: SpatialStart) -> SpatialStart:
    """Let a ball begin at rest."""
    rates = start.exact.rates.copy()
    for joint in start.tree.joints:
        rates[:, joint.rates] *= joint.kind != "ball"
    return replace(start, exact=replace(start.exact, rates=rates))


def edit_nothing(start: SpatialStart) -> SpatialStart:
    """Give the machine as it is."""
    return start
