"""The models of a scene, one for each order in which its joints may be declared, and their invariances.

Another order is another tree with other cuts, so another model of the same machine, whose matrices are of another
pattern. What a solver does with a pattern must not matter in any of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import mujoco
import numpy as np

from conrod.engines.engine import default_steps, run_of
from conrod.engines.massless_rod import ModelForm
from conrod.engines.mujoco.mjcf import mjcf
from conrod.engines.mujoco.model import Build, compiled
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.tree import spanning_tree, tree_refusal
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.mjcf.invariances.changes import SETTINGS, Bench, settings_changed
from conrod.mjcf.invariances.results import Invariance, Kept
from conrod.mjcf.runs import state_of
from conrod.scenes import Scene

MOST_ORDERS = 64
ANGLES = 4  # of the crank, at which states are compared


def declared_otherwise(scene: Scene) -> tuple[Invariance, ...]:
    """The invariances to settings of the solver over the orders of declaration, the worst model for each."""
    found: dict[str, list[Invariance]] = {change: [] for change in SETTINGS}
    for case, bench in _benches(scene):
        for one in settings_changed(bench, SETTINGS):
            found[one.change].append(replace(one, case=case))
    return tuple(_worst(ones) for ones in found.values() if ones)


def _worst(ones: list[Invariance]) -> Invariance:
    broken = [one for one in ones if one.outcome is Kept.BROKEN]
    worst = max(broken or ones, key=lambda one: one.over_bound or 0.0)
    return replace(worst, broken=len(broken), cases=len(ones))


def _benches(scene: Scene) -> Iterator[tuple[str, Bench]]:
    """Models of different text, with states on the exact motion at constant crank speed."""
    kinematics, mechanism = scene.kinematics, scene.kinematics.mechanism
    settings = MuJoCoSettings.tuned(scene, default_steps(scene))
    begin, turns = run_of(scene, default_steps(scene), 1.0)
    angles = begin + math.copysign(2.0 * math.pi * turns, scene.speed) * np.arange(ANGLES) / ANGLES
    poses, by_angle = kinematics.derivatives(angles, 1)
    random, seen = np.random.default_rng(1), set[str]()
    for number in range(MOST_ORDERS):
        joints = list(mechanism.joints)
        if number:
            random.shuffle(joints)
        declared = replace(mechanism, joints=tuple(joints))
        try:
            tree = spanning_tree(declared, kinematics.start[0])
        except InvalidInput:
            continue  # an order in which the tree of these joints does not grow from the ground is no model
        text = mjcf(tree, settings, mechanism.name, sensors=False)
        if tree_refusal(tree) or text in seen:
            continue
        seen.add(text)
        made = Build(ModelForm(declared, declared), tree, compiled(text))
        coordinates, rates = made.coordinates(poses), made.rates(poses, scene.speed * by_angle)
        states = np.array([_state(made.model, *one) for one in zip(coordinates, rates, strict=True)])
        yield (
            f"joints declared {', '.join(joint.name for joint in joints)}",
            Bench.of(made.model, (angles - begin) / scene.speed, states),
        )


def _state(model: mujoco.MjModel, coordinates: Array, rates: Array) -> Array:
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = coordinates, rates
    return state_of(model, data)
