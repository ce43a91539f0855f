"""The study of a model's invariances: its run, the changes, and the comparison at states of the run."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.engine import default_steps, run_extent
from conrod.engines.mujoco import MuJoCoSettings
from conrod.engines.mujoco.mjcf import mjcf_text
from conrod.engines.mujoco.model import MuJoCoModel, compile_mjcf
from conrod.engines.spanning_tree import grow_spanning_tree, tree_refusal
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.mjcf.loading import check_finite, data_at_start, load_model, start_words
from conrod.mjcf.request import Controls
from conrod.mjcf.runs import MAX_SAMPLES, run, state_of, user_model_errors
from conrod.models.invariances import changes
from conrod.models.invariances.results import Invariance, InvarianceOutcome
from conrod.models.invariances.solvers import other_solvers
from conrod.scenes import Scene

DEFAULT_STEPS = 1000  # of the run, unless it is said how long it is
COMPARED_STATES = 12  # states of it
THREADS = 4


def states_digest(path: Path, seconds: float | None, keyframe: str | None, controls: Controls) -> str:
    """SHA-256 of all states of a model's run; call it in a separate process."""
    model = load_model(path)
    return _digest(model, *_start(model, seconds, keyframe, controls)[:2])


def study_invariances(
    path: Path, seconds: float | None, keyframe: str | None, controls: Controls, elsewhere: str
) -> tuple[str, tuple[Invariance, ...]]:
    """Describe the run of a model file and check its invariances; call it in a separate process.

    Args:
        elsewhere: `states_digest` of another process.

    Raises:
        InvalidInput: the file cannot be loaded, or its run breaks off at once.
    """
    model = load_model(path)
    with user_model_errors(path):
        check_finite(model)
        if not model.nv:
            raise InvalidInput("nothing in it moves: it has no joint")
        start, steps, words = _start(model, seconds, keyframe, controls)
        bench = _bench(model, start, steps)
        own = _digest(model, start, steps)
        with ThreadPoolExecutor(THREADS) as threads:
            together = set(threads.map(lambda _: _digest(model, start, steps), range(THREADS)))
        same = {"run again": {own, _digest(model, start, steps)}, "another process": {own, elsewhere}}
        same[f"{THREADS} threads"] = together | {own}
        found = [
            Invariance(change, "bits", InvarianceOutcome.BITS if len(digests) == 1 else InvarianceOutcome.BROKEN)
            for change, digests in same.items()
        ]
        found += all_invariance_checks(bench, path)
    broke = "; the run breaks off, and states before that are compared" if bench.broke else ""
    run = f"{steps} steps of {model.opt.timestep:g} s; accelerations at {len(bench.times)} states of them"
    return f"{run}, from {words}{broke}", tuple(found)


def all_invariance_checks(bench: changes.InvarianceBench, path: Path) -> Iterator[Invariance]:
    """Yield the result of every change of a model file."""
    yield from (*changes.solver_settings(bench), changes.warm_start(bench), *other_solvers(bench))
    yield from (*changes.similarities(bench), changes.reversed_declaration(bench, path))


def _start(
    model: mujoco.MjModel, seconds: float | None, keyframe: str | None, controls: Controls
) -> tuple[Array, int, str]:
    """The start state, the number of steps, and the start in words."""
    data, index = data_at_start(model, keyframe, controls)
    steps = DEFAULT_STEPS if seconds is None else max(1, round(seconds / model.opt.timestep))
    return state_of(model, data), steps, start_words(model, index)


def _digest(model: mujoco.MjModel, start: Array, steps: int) -> str:
    return hashlib.sha256(run(model, start, steps).states.tobytes()).hexdigest()


def _bench(model: mujoco.MjModel, start: Array, steps: int) -> changes.InvarianceBench:
    """Run a model; return the bench on which some of its states are compared.

    Raises:
        InvalidInput: the run breaks off before its first state.
    """
    made = run(model, start, steps)
    every = max(1, len(made.states) // COMPARED_STATES)
    states = made.states[::every][:COMPARED_STATES]
    if not len(states):
        raise InvalidInput("its run breaks off at the start")
    interval = model.opt.timestep * max(1, -(-steps // MAX_SAMPLES)) * every
    return changes.InvarianceBench.from_states(model, interval * np.arange(len(states)), states, bool(made.broke))


# -- scenes: a model for each order in which joints may be declared ---------------------------------------------------

# Another order is another tree with other cuts, so another model of the same machine, whose matrices are of another
# pattern. What a solver does with a pattern must not matter in any of them.
MAX_ORDERS = 64
COMPARED_ANGLES = 4  # of the crank, at which states are compared


def study_declaration_orders(scene: Scene) -> tuple[Invariance, ...]:
    """Check solver settings over orders of joint declaration; the worst model for each setting."""
    found: dict[str, list[Invariance]] = {change: [] for change in changes.SETTINGS}
    for case, bench in _order_benches(scene):
        for one in changes.solver_settings(bench):
            found[one.change].append(replace(one, case=case))
    return tuple(_worst_case(ones) for ones in found.values() if ones)


def _worst_case(ones: list[Invariance]) -> Invariance:
    broken = [one for one in ones if one.outcome is InvarianceOutcome.BROKEN]
    worst = max(broken or ones, key=lambda one: one.over_bound or 0.0)
    return replace(worst, broken=len(broken), cases=len(ones))


def _order_benches(scene: Scene) -> Iterator[tuple[str, changes.InvarianceBench]]:
    """Yield models that differ by the order of their joints, with states of the exact motion."""
    kinematics, mechanism = scene.kinematics, scene.kinematics.mechanism
    settings = MuJoCoSettings.tuned(scene, default_steps(scene))
    begin, turns = run_extent(scene, default_steps(scene), 1.0)
    angles = begin + math.copysign(2.0 * math.pi * turns, scene.speed) * np.arange(COMPARED_ANGLES) / COMPARED_ANGLES
    poses, by_angle = kinematics.derivatives(angles, 1)
    random, seen = np.random.default_rng(1), set[str]()
    for number in range(MAX_ORDERS):
        joints = list(mechanism.joints)
        if number:
            random.shuffle(joints)
        declared = replace(mechanism, joints=tuple(joints))
        try:
            tree = grow_spanning_tree(declared, kinematics.start[0])
        except InvalidInput:
            continue  # an order in which the tree of these joints does not grow from the ground is no model
        text = mjcf_text(tree, settings, mechanism.name, sensors=False)
        if tree_refusal(tree) or text in seen:
            continue
        seen.add(text)
        made = MuJoCoModel(tree, compile_mjcf(text))
        coordinates, rates = made.coordinates(poses), made.rates(poses, scene.speed * by_angle)
        states = np.array([_state_from(made.model, *one) for one in zip(coordinates, rates, strict=True)])
        yield (
            f"joints declared {', '.join(joint.name for joint in joints)}",
            changes.InvarianceBench.from_states(made.model, (angles - begin) / scene.speed, states),
        )


def _state_from(model: mujoco.MjModel, coordinates: Array, rates: Array) -> Array:
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = coordinates, rates
    return state_of(model, data)
