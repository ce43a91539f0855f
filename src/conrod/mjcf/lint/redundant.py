"""Rules on coordinates and closures that are too many: closures that repeat others, bodies that float and are tied."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from conrod.engines.mobility import jacobian_rank
from conrod.exact.motion import Array
from conrod.mjcf.equalities import Rows, bodies_of, closure_name, ties_bodies
from conrod.mjcf.lint.bench import Bench
from conrod.mjcf.lint.edits import Remove
from conrod.mjcf.lint.findings import Finding, Harm
from conrod.own.models.loading import listed, name_or_number

# Two closures in the place of one are twice as stiff; what they close is then closed a little less tightly by one. A
# change of the motion by a millionth is that, and no other machine.
SAME_MOTION = 1e-6
# Motion between two bodies in another direction than the largest that is below this share of it is what soft closures
# give way by; a second joint would move in the order of the first.
SAME_DIRECTION = 1e-2


def redundant_closures(bench: Bench) -> Iterator[Finding]:
    """Equalities without which the rank of all is the same at every pose, and rows that depend on others."""
    looks = bench.poses.rows
    redundant = min((int(rows.effective.sum()) - rows.rank for rows in looks), default=0)
    if redundant <= 0:
        return
    whole = _removable(looks)
    if whole:
        yield _repeated_closures(bench, whole, redundant)
    else:
        yield _repeated_rows(bench, looks[0], redundant)


def _removable(looks: Sequence[Rows]) -> list[int]:
    """Equalities that can go together without anything becoming free, the later ones first."""
    gone: list[int] = []
    for index in sorted(set(looks[0].ids.tolist()), reverse=True):
        trial = [*gone, index]
        if all(_rank_without(rows, trial) == rows.rank for rows in looks) and any(
            rows.effective[rows.ids == index].any() for rows in looks
        ):
            gone = trial
    return gone


def _rank_without(rows: Rows, gone: list[int]) -> int:
    return jacobian_rank(rows.jacobian[~np.isin(rows.ids, gone)])


def _repeated_closures(bench: Bench, gone: list[int], redundant: int) -> Finding:
    rows = bench.poses.rows[0]
    names = [closure_name(bench.model, index) for index in gone]
    trial = bench.trial([Remove("equality", index, name) for index, name in zip(gone, names, strict=True)])
    return Finding(
        subjects=tuple(names),
        what=f"without {listed(names)} the closures hold what they hold",
        harm=Harm.WASTE,
        evidence=_counts(rows, redundant)
        | {"rank without": _rank_without(rows, gone), "change of motion without": trial.told_change},
        why="forces are shared between closures that say the same: their reactions mean nothing, and where they do not "
        "agree to the last digit they fight",
        fix=f"leave out {listed(names)}",
        edits=trial.edits,
        safe=trial.changes_at_most(SAME_MOTION),
        change=trial.change,
        cost=trial.cost,
    )


def _repeated_rows(bench: Bench, rows: Rows, redundant: int) -> Finding:
    """No equality as a whole is one too many, but some of their rows are."""
    dependent: list[str] = []
    kept: list[int] = []
    for row in (int(index) for index in np.flatnonzero(rows.effective)):
        if jacobian_rank(rows.jacobian[[*kept, row]]) == len(kept) + 1:
            kept.append(row)
        else:
            first = int(np.flatnonzero(rows.ids == rows.ids[row])[0])
            dependent.append(f"row {row - first + 1} of {closure_name(bench.model, int(rows.ids[row]))}")
    return Finding(
        subjects=tuple(dependent),
        what=f"{redundant} rows of the closures say what others say: {listed(dependent)}",
        harm=Harm.WASTE,
        evidence=_counts(rows, redundant),
        why="forces are shared between rows that say the same: the reactions mean nothing, and a body that is made a "
        "little off fights itself",
        fix="let the bodies move in the plane of the machine only (hinges and slides), or tie each pin at one point",
    )


def _counts(rows: Rows, redundant: int) -> dict[str, float | int | str]:
    effective = int(rows.effective.sum())
    return {"constraint rows that say anything": effective, "rank": rows.rank, "redundant": redundant}


# -- bodies that float -----------------------------------------------------------------------------------------------


def floating_bodies(bench: Bench) -> Iterator[Finding]:
    """Bodies with freedom of their own that move past what they are tied to by a single joint's motion."""
    model = bench.model
    taken: set[int] = set()
    for body in range(1, model.nbody):
        own = int(model.body_dofnum[body])
        if own < 2 or body in taken:
            continue
        for partner, ties in _partners(model, body).items():
            rank = max(jacobian_rank(rows.jacobian[np.isin(rows.ids, ties)]) for rows in bench.poses.rows)
            moved = _directions(bench, body, partner)
            # Joints and ties must leave at least the joint that is to be in their place; otherwise the joints hold too.
            if moved == 1 and own - rank >= moved and own - moved > 0:
                yield _floating(bench, body, partner, ties)
                taken.add(body)
                break


def _floating(bench: Bench, body: int, partner: int, ties: list[int]) -> Finding:
    model, looks = bench.model, bench.poses.rows
    own, rank = int(model.body_dofnum[body]), max(rows.rank for rows in looks)
    name, to = name_or_number(model, "body", body), name_or_number(model, "body", partner)
    lines = int(np.isin(looks[0].ids, ties).sum())
    names = [closure_name(model, index) for index in ties]
    return Finding(
        subjects=(name, *names),
        what=f"{name} has {own} degrees of freedom of its own, and against {to}, to which {listed(names)} ties it, "
        "it moves in one",
        harm=Harm.WASTE,
        evidence={
            "degrees of freedom": model.nv,
            "rank of the closures": rank,
            "degrees of freedom left": model.nv - rank,
            "degrees of freedom if it hung there": model.nv - own + 1,
            "constraint rows": len(looks[0].ids),
            "constraint rows if it hung there": len(looks[0].ids) - lines,
        },
        fix=f"make {name} a child of {to} with one hinge or slide, and leave out {listed(names)}",
    )


def _partners(model: mujoco.MjModel, body: int) -> dict[int, list[int]]:
    """Bodies that a body is tied to by active closures, and by which."""
    found: dict[int, list[int]] = {}
    for index in range(model.neq):
        if not ties_bodies(model, index) or not model.eq_active0[index]:
            continue
        ends = [int(model.body_weldid[end]) for end in bodies_of(model, index)]
        if body in ends and ends[0] != ends[1]:
            found.setdefault(ends[0] if ends[1] == body else ends[1], []).append(index)
    return found


def _directions(bench: Bench, body: int, partner: int) -> int:
    """Number of directions in which a body moves as seen from another, over the run."""
    seen = np.array([_relative_velocity(bench, data, body, partner) for data in bench.poses.each()])
    singular = np.linalg.svd(seen, compute_uv=False)
    return int(np.sum(singular > SAME_DIRECTION * singular[0])) if singular[0] > 0.0 else 0


def _relative_velocity(bench: Bench, data: mujoco.MjData, body: int, partner: int) -> Array:
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
