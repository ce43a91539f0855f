"""Rules on geoms: links that collide where a joint holds them together, geoms that never meet, or cannot."""

from __future__ import annotations

import math
from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.mjcf.equalities import bodies_of, closure_name, ties_bodies
from conrod.mjcf.lint.bench import UNCHANGED, Bench
from conrod.mjcf.lint.edits import Exclude, SetAttribute
from conrod.mjcf.lint.findings import Finding, Harm, Note
from conrod.own.models.loading import listed, name_or_number

# Links that a pin holds together and that touch in nearly every step overlap whatever the pin does: a mechanical stop,
# or a foot on the ground, lets go.
ALWAYS = 0.9
TURNING = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_BALL))


def joined_links(bench: Bench) -> Iterator[Finding]:
    """Pairs of links that overlap where they are joined, and collide there."""
    model, run = bench.model, bench.run
    declared = {tuple(sorted(pair)) for pair in zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True)}
    steps: dict[tuple[int, int], int] = {}
    for (one, other), count in run.touched.items():
        if min(one, other) < 0 or (one, other) in declared:
            continue
        first, second = sorted((int(model.geom_bodyid[one]), int(model.geom_bodyid[other])))
        steps[first, second] = max(steps.get((first, second), 0), count)
    for (one, other), count in steps.items():
        joint = _joint_between(model, one, other)
        if joint and count >= ALWAYS * run.steps:
            yield _overlap(bench, (one, other), joint, count)


def _overlap(bench: Bench, bodies: tuple[int, int], joint: str, count: int) -> Finding:
    model = bench.model
    names = (name_or_number(model, "body", bodies[0]), name_or_number(model, "body", bodies[1]))
    trial = bench.trial([Exclude(bodies, names)])
    wrong = trial.change is not None and trial.change > UNCHANGED
    return Finding(
        subjects=names,
        what=f"{names[0]} and {names[1]} collide where {joint} joins them",
        harm=Harm.WRONG if wrong else Harm.WASTE,
        evidence={
            "steps in contact": count,
            "steps": bench.run.steps,
            "change of motion without": trial.told_change,
        },
        fix="exclude the pair",
        edits=trial.edits,
        # Where the motion changes, somebody has to say which of the two was meant.
        safe=bool(trial.edits) and not wrong,
        change=trial.change,
        cost=trial.cost,
    )


def _joint_between(model: mujoco.MjModel, one: int, other: int) -> str:
    """Name of what holds two bodies together so that they cannot part: a joint that only turns, a connect or a weld."""
    for child, parent in ((one, other), (other, one)):
        # Bodies without a joint are one with those that they hang on.
        links = int(model.body_weldid[child])
        if links and model.body_weldid[model.body_parentid[links]] == model.body_weldid[parent]:
            joints = range(model.body_jntadr[links], model.body_jntadr[links] + model.body_jntnum[links])
            if joints and all(int(model.jnt_type[joint]) in TURNING for joint in joints):
                return f"joint {name_or_number(model, 'joint', joints[0])}"
    for index in range(model.neq):
        if ties_bodies(model, index) and model.eq_active0[index]:
            pair = {int(model.body_weldid[body]) for body in bodies_of(model, index)}
            if pair == {int(model.body_weldid[one]), int(model.body_weldid[other])}:
                return closure_name(model, index)
    return ""


# -- those that never meet -------------------------------------------------------------------------------------------


def idle_geoms(bench: Bench) -> Iterator[Finding | Note]:
    """Geoms that may collide and do not, in a run that comes through all poses of the machine."""
    model, run = bench.model, bench.run
    met = {geom for pair in run.touched for geom in pair}
    idle = [geom for geom in sorted(may_collide(model)) if geom not in met]
    if not idle:
        return
    names = tuple(name_or_number(model, "geom", geom) for geom in idle)
    turned = whole_turn(bench)
    if not turned:
        yield Note(
            f"{len(idle)} geoms may collide and did not in {run.steps} steps: {listed(names)}. "
            "The run does not come through all poses, so whether they ever should is unknown",
        )
        return
    trial = bench.trial(
        [
            SetAttribute("geom", geom, name, attribute, "0")
            for geom, name in zip(idle, names, strict=True)
            for attribute in ("contype", "conaffinity")
        ]
    )
    yield Finding(
        subjects=names,
        what=f"{len(idle)} geoms may collide and never do: {listed(names)}",
        harm=Harm.WASTE,
        evidence={
            "contacts": 0,
            "steps": run.steps,
            "degrees of freedom": bench.poses.freedom,
            "turns": round(turned, 3),
        },
        fix='contype="0" conaffinity="0"',
        edits=trial.edits,
        safe=trial.changes_at_most(UNCHANGED),
        change=trial.change,
        cost=trial.cost,
    )


def visual_geoms(bench: Bench) -> Iterator[Note]:
    """Geoms that no other can collide with, and their cost."""
    model = bench.model
    named = set(model.pair_geom1.tolist()) | set(model.pair_geom2.tolist())
    if int(model.opt.disableflags) & mujoco.mjtDisableBit.mjDSBL_CONTACT:
        named = set()
    seen = sorted(set(range(model.ngeom)) - may_collide(model) - named)
    if seen:
        yield Note(f"{len(seen)} of {model.ngeom} geoms cannot collide with anything", bench.cost_of("geom", seen))


def whole_turn(bench: Bench) -> float:
    """Turns that a machine with one degree of freedom makes in the run; 0 where it does not come round once."""
    model = bench.model
    if bench.poses.freedom != 1 or any(kind == mujoco.mjtJoint.mjJNT_FREE for kind in model.jnt_type):
        return 0.0
    hinges = model.jnt_qposadr[model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE]
    angles = np.array([state.qpos[hinges] for state in bench.run.states])
    if not angles.size:
        return 0.0
    turns = float(np.ptp(angles, axis=0).max()) / (2.0 * math.pi)
    # The samples end a little before the run does.
    return turns if turns >= 1.0 - 1.0 / len(angles) else 0.0


def may_collide(model: mujoco.MjModel) -> set[int]:
    """Geoms that MuJoCo would look for contacts of: those that some other geom passes all its filters with."""
    flags = int(model.opt.disableflags)
    if flags & (mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT):
        return set()
    weld, own, others = model.body_weldid[model.geom_bodyid], model.geom_contype, model.geom_conaffinity
    masks = (own[:, None] & others[None, :]) | (own[None, :] & others[:, None])
    apart = weld[:, None] != weld[None, :]
    if not flags & mujoco.mjtDisableBit.mjDSBL_FILTERPARENT:
        parent = model.body_weldid[model.body_parentid[weld]]
        # The world is everybody's parent, and filters nothing.
        family = ((parent[:, None] == weld[None, :]) & (weld[None, :] > 0)) | (
            (parent[None, :] == weld[:, None]) & (weld[:, None] > 0)
        )
        apart &= ~family
    bodies = model.geom_bodyid
    for signature in model.exclude_signature.tolist():
        one, other = signature >> 16, signature & 0xFFFF
        both = (bodies[:, None] == one) & (bodies[None, :] == other)
        apart &= ~(both | both.T)
    pairs = (masks != 0) & apart
    named = set(model.pair_geom1.tolist()) | set(model.pair_geom2.tolist())
    return set(np.flatnonzero(pairs.any(axis=1)).tolist()) - named
