"""Degrees of freedom that closures take away again: bodies that float, and are tied where they could hang."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.engines.mobility import jacobian_rank
from conrod.exact.motion import Array
from conrod.mjcf.lint.bench import Bench
from conrod.mjcf.lint.finding import Finding, Harm
from conrod.mjcf.lint.poses import closing, closure_name, equality_bodies
from conrod.mjcf.lint.rule import Rule
from conrod.own.models.loading import listed, name_or_number

# Motion between two bodies in another direction than the largest that is below this share of it is what soft closures
# give way by; a second joint would move in the order of the first.
SAME = 1e-2


def judge(bench: Bench) -> Iterator[Finding]:
    """Bodies with freedom of their own that move past what they are tied to by a single joint's motion."""
    model = bench.model
    taken: set[int] = set()
    for body in range(1, model.nbody):
        own = int(model.body_dofnum[body])
        if own < 2 or body in taken:
            continue
        for partner, ties in _partners(model, body).items():
            rows = _rank_of(bench, ties)
            moved = _directions(bench, body, partner)
            # Joints and ties must leave at least the joint that is to be in their place; otherwise the joints hold too.
            if moved == 1 and own - rows >= moved and own - moved > 0:
                yield _finding(bench, body, partner, ties)
                taken.add(body)
                break


def _finding(bench: Bench, body: int, partner: int, ties: list[int]) -> Finding:
    model, looks = bench.model, bench.poses.rows
    own, rank = int(model.body_dofnum[body]), max(rows.rank for rows in looks)
    name, to = name_or_number(model, "body", body), name_or_number(model, "body", partner)
    lines = int(np.isin(looks[0].ids, ties).sum())
    names = [closure_name(model, index) for index in ties]
    return Finding(
        rule=RULE.name,
        subjects=(name, *names),
        what=f"{name} has {own} degrees of freedom of its own, and against {to}, to which {listed(names)} ties it, "
        "it moves in one",
        harm=Harm.WASTE,
        evidence=(
            ("degrees of freedom", model.nv),
            ("rank of the closures", rank),
            ("degrees of freedom left", model.nv - rank),
            ("degrees of freedom if it hung there", model.nv - own + 1),
            ("constraint rows", len(looks[0].ids)),
            ("constraint rows if it hung there", len(looks[0].ids) - lines),
        ),
        why="coordinates that closures take away again are solved for in every step, and are as exact as the closures "
        "are stiff",
        fix=f"make {name} a child of {to} with one hinge or slide, and leave out {listed(names)}",
    )


def _partners(model: mujoco.MjModel, body: int) -> dict[int, list[int]]:
    """What a body is tied to by active closures, and by which."""
    found: dict[int, list[int]] = {}
    for index in range(model.neq):
        if not closing(model, index) or not model.eq_active0[index]:
            continue
        ends = [int(model.body_weldid[end]) for end in equality_bodies(model, index)]
        if body in ends and ends[0] != ends[1]:
            found.setdefault(ends[0] if ends[1] == body else ends[1], []).append(index)
    return found


def _rank_of(bench: Bench, ties: list[int]) -> int:
    return max(jacobian_rank(rows.jacobian[np.isin(rows.ids, ties)]) for rows in bench.poses.rows)


def _directions(bench: Bench, body: int, partner: int) -> int:
    """In how many directions a body moves as seen from another, over the run."""
    seen = np.array([_relative(bench, data, body, partner) for data in bench.poses.each()])
    singular = np.linalg.svd(seen, compute_uv=False)
    return int(np.sum(singular > SAME * singular[0])) if singular[0] > 0.0 else 0


def _relative(bench: Bench, data: mujoco.MjData, body: int, partner: int) -> Array:
    """Velocity (6,) of a body in a frame that moves with another, about its origin: rad/s, and m/s over the size."""
    spatial = []
    origin = data.xpos[partner]
    for index in (body, partner):
        velocity = np.empty(6)
        mujoco.mj_objectVelocity(bench.model, data, mujoco.mjtObj.mjOBJ_XBODY, index, velocity, 0)
        turning, moving = velocity[:3], velocity[3:]
        spatial.append((turning, moving + np.cross(turning, origin - data.xpos[index])))
    frame = data.xmat[partner].reshape(3, 3).T
    turning, moving = (one - other for one, other in zip(*spatial, strict=True))
    return np.concatenate([frame @ turning, frame @ moving / bench.size])


RULE = Rule("freedom-taken-away", judge)
