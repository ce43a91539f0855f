"""The rule on links that collide where they are joined."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from xml.sax.saxutils import quoteattr

import mujoco

from conrod.mjcf.equalities import closure_name, ties
from conrod.mjcf.lint.bench import UNCHANGED, Bench
from conrod.mjcf.lint.findings import Finding, Severity
from conrod.own.models.loading import name_or_number

# Links that a pin holds together and that touch in nearly every step overlap whatever the pin does: a mechanical stop,
# or a foot on the ground, lets go.
ALWAYS = 0.9
TURNING = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_BALL))


def joined_links_collide(bench: Bench) -> Iterator[Finding]:
    """Geoms of links that collide where a hinge, connect or weld joins them."""
    model = bench.model
    declared = {tuple(sorted(pair)) for pair in zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True)}
    steps: dict[tuple[int, int], int] = {}
    for (one, other), count in bench.run.touched.items():
        if one >= 0 and (one, other) not in declared:
            first, second = sorted((int(model.geom_bodyid[one]), int(model.geom_bodyid[other])))
            steps[first, second] = max(steps.get((first, second), 0), count)
    for bodies, count in steps.items():
        joint = _joint_between(model, *bodies)
        if joint and count >= ALWAYS * bench.run.steps:
            yield _overlap(bench, bodies, joint, count)


def _overlap(bench: Bench, bodies: tuple[int, int], joint: str, count: int) -> Finding:
    names = (name_or_number(bench.model, "body", bodies[0]), name_or_number(bench.model, "body", bodies[1]))
    finding = Finding(
        subjects=names,
        what=f"{names[0]} and {names[1]} collide where {joint} joins them",
        severity=Severity.NOTE,
        evidence={"steps in contact": count, "steps": bench.run.steps},
        why="the contact pushes against the joint that holds the links together: friction, loads and rows of its own",
        fix="exclude the pair",
    )
    if not all(bench.model.body(body).name for body in bodies):  # MJCF excludes bodies by their names
        return finding
    edit = f"<contact><exclude body1={quoteattr(names[0])} body2={quoteattr(names[1])}/></contact>"
    change = bench.change((edit,))
    if change <= UNCHANGED:
        return replace(finding, edits=(edit,), safe=True, change=change)
    # Where the motion changes, somebody has to say which of the two was meant.
    return replace(finding, edits=(edit,), severity=Severity.ERROR, change=change)


def _joint_between(model: mujoco.MjModel, one: int, other: int) -> str:
    """Name of what holds two bodies together so that they cannot part: a joint that only turns, a connect or a weld."""
    for child, parent in ((one, other), (other, one)):
        # Bodies without a joint are one with those that they hang on.
        links = int(model.body_weldid[child])
        if links and model.body_weldid[model.body_parentid[links]] == model.body_weldid[parent]:
            joints = range(model.body_jntadr[links], model.body_jntadr[links] + model.body_jntnum[links])
            if joints and all(int(model.jnt_type[joint]) in TURNING for joint in joints):
                return f"joint {name_or_number(model, 'joint', joints[0])}"
    parts = {int(model.body_weldid[one]), int(model.body_weldid[other])}
    return next((closure_name(model, index) for index, ends in ties(model) if set(ends) == parts), "")
