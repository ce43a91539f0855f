"""Rules on bodies: geoms that collide or never meet, bodies that float where they could hang, gravity and inertias."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import mujoco
import numpy as np

from conrod.engines.mobility import jacobian_rank
from conrod.exact.motion import Array
from conrod.mjcf.equalities import closure_name, ties
from conrod.mjcf.lint.bench import UNCHANGED, Bench, rule
from conrod.mjcf.lint.findings import Change, Exclude, Finding, Harm, SetOption
from conrod.mjcf.runs import velocity
from conrod.own.models.loading import listed, name_or_number

# -- links that collide ----------------------------------------------------------------------------------------------

# Links that a pin holds together and that touch in nearly every step overlap whatever the pin does: a mechanical stop,
# or a foot on the ground, lets go.
ALWAYS = 0.9
TURNING = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_BALL))


@rule(
    "the contact pushes against the joint that holds the links together: friction, loads and rows of its own",
    needs_motion=False,
)
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
        harm=Harm.WASTE,
        evidence={"steps in contact": count, "steps": bench.run.steps},
        fix="exclude the pair",
    )
    tried = bench.tried(finding, [Exclude(bodies, names)], UNCHANGED)
    # Where the motion changes, somebody has to say which of the two was meant.
    return tried if tried.safe or tried.change is None else replace(tried, harm=Harm.WRONG)


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


# -- geoms that never meet -------------------------------------------------------------------------------------------


@rule("every step looks for contacts between them, in a machine that has come round and has found none")
def never_touch(bench: Bench) -> Iterator[Finding]:
    """Geoms that can collide and never do."""
    model, run = bench.model, bench.run
    met = {geom for pair in run.touched for geom in pair}
    idle = {geom: name_or_number(model, "geom", geom) for geom in sorted(may_collide(model)) if geom not in met}
    number, turned = len(idle), whole_turn(bench)
    if not (idle and turned):  # a run that does not come through all poses says nothing
        return
    masks = ("contype", "conaffinity")
    finding = Finding(
        subjects=tuple(idle.values()),
        what=f"{number} geoms may collide and never do: {listed(idle.values())}",
        harm=Harm.WASTE,
        evidence={"contacts": 0, "steps": run.steps, "degrees of freedom": bench.freedom, "turns": round(turned, 3)},
        fix='contype="0" conaffinity="0"',
    )
    edits = [Change("geom", geom, name, mask, "0") for geom, name in idle.items() for mask in masks]
    yield bench.tried(finding, edits, UNCHANGED)


def whole_turn(bench: Bench) -> float:
    """Turns that a machine with one degree of freedom makes in the run; 0 where it does not come round once."""
    model = bench.model
    if bench.freedom != 1 or any(kind == mujoco.mjtJoint.mjJNT_FREE for kind in model.jnt_type):
        return 0.0
    angles = bench.run.states[:, model.jnt_qposadr[model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE]]
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
        child_of = (parent[:, None] == weld[None, :]) & (weld[None, :] > 0)
        apart &= ~(child_of | child_of.T)
    bodies = model.geom_bodyid
    for signature in model.exclude_signature.tolist():
        both = (bodies[:, None] == signature >> 16) & (bodies[None, :] == signature & 0xFFFF)
        apart &= ~(both | both.T)
    return set(np.flatnonzero(((masks != 0) & apart).any(axis=1)).tolist()) - _paired(model)


def _paired(model: mujoco.MjModel) -> set[int]:
    """Geoms of declared pairs, which collide whatever their masks."""
    return set(model.pair_geom1.tolist()) | set(model.pair_geom2.tolist())


# -- bodies that float -----------------------------------------------------------------------------------------------

# Motion between two bodies in another direction than the largest that is below this share of it is what soft closures
# give way by; a second joint would move in the order of the first.
SAME_DIRECTION = 1e-2


@rule(
    "coordinates that closures take away again are solved for in every step, and are as exact as the closures "
    "are stiff",
)
def freedom_taken_away(bench: Bench) -> Iterator[Finding]:
    """Bodies that float and are tied where they could hang."""
    model = bench.model
    for body in np.flatnonzero(model.body_dofnum >= 2).tolist():
        own = int(model.body_dofnum[body])
        for partner, closures in _partners(model, body).items():
            rank = max(jacobian_rank(rows.jacobian[np.isin(rows.ids, closures)]) for rows in bench.rows)
            # Joints and ties must leave at least the joint that is to be in their place; otherwise the joints hold too.
            if own - rank >= 1 and _directions(bench, body, partner) == 1:
                yield _floating(bench, body, partner, closures)
                break


def _floating(bench: Bench, body: int, partner: int, closures: list[int]) -> Finding:
    model, rows = bench.model, bench.rows[0]
    own, rank = int(model.body_dofnum[body]), max(rows.rank for rows in bench.rows)
    name, to = name_or_number(model, "body", body), name_or_number(model, "body", partner)
    names = [closure_name(model, index) for index in closures]
    return Finding(
        subjects=(name, *names),
        what=f"{name} has {own} degrees of freedom of its own, and against {to}, to which {listed(names)} ties it, "
        "it moves in one",
        harm=Harm.WASTE,
        evidence={
            "degrees of freedom": model.nv,
            "rank of the closures": rank,
            "degrees of freedom if it hung there": model.nv - own + 1,
            "constraint rows": len(rows.ids),
            "constraint rows if it hung there": int((~np.isin(rows.ids, closures)).sum()),
        },
        fix=f"make {name} a child of {to} with one hinge or slide, and leave out {listed(names)}",
    )


def _partners(model: mujoco.MjModel, body: int) -> dict[int, list[int]]:
    """Bodies that a body is tied to by active closures, and by which."""
    found: dict[int, list[int]] = {}
    for index, ends in ties(model):
        if body in ends and ends[0] != ends[1]:
            found.setdefault(ends[0] if ends[1] == body else ends[1], []).append(index)
    return found


def _directions(bench: Bench, body: int, partner: int) -> int:
    """Number of directions in which a body moves as seen from another, over the run."""
    seen = np.array([_relative_velocity(bench, data, body, partner) for data in bench.poses()])
    singular = np.linalg.svd(seen, compute_uv=False)
    return int(np.sum(singular > SAME_DIRECTION * singular[0])) if singular[0] > 0.0 else 0


def _relative_velocity(bench: Bench, data: mujoco.MjData, body: int, partner: int) -> Array:
    """Velocity (6,) of a body in a frame that moves with another, about its origin: rad/s, and m/s over the size."""
    spatial = []
    for index in (body, partner):
        turning, moving = np.split(velocity(bench.model, data, index, mujoco.mjtObj.mjOBJ_XBODY), 2)
        spatial.append((turning, moving + np.cross(turning, data.xpos[partner] - data.xpos[index])))
    frame = data.xmat[partner].reshape(3, 3).T
    turning, moving = (one - other for one, other in zip(*spatial, strict=True))
    return np.concatenate([frame @ turning, frame @ moving / bench.size])


# -- gravity ---------------------------------------------------------------------------------------------------------

# Motion out of a plane below this share of that in it is what soft closures sag by.
PLANAR = 1e-2
# Of gravity. A machine that is a hundredth of a degree out of the vertical has 2e-4; rounding of a vector written with
# six digits, 1e-6.
ACROSS = 1e-5
# Of the travel: what closures sag by must not be taken for motion, and the motion of a driven machine knows of masses
# only by what is soft in it.
SAME_MOTION = 1e-6


@rule(
    "it does no work on the motion: joints and closures carry it, reactions contain it, soft closures sag by it; a "
    "machine that stands upright has its gravity in the plane",
)
def gravity_across(bench: Bench) -> Iterator[Finding]:
    """Gravity across the plane in which everything moves."""
    model, gravity, normal = bench.model, np.array(bench.model.opt.gravity), plane_normal(bench)
    least = ACROSS * np.linalg.norm(gravity)
    if int(model.opt.disableflags) & mujoco.mjtDisableBit.mjDSBL_GRAVITY or normal is None:
        return
    across = float(abs(gravity @ normal))
    if across <= least or bench.run.touched:  # where anything touches, contacts carry it
        return
    rest = gravity - (gravity @ normal) * normal
    rest[np.abs(rest) < least] = 0.0
    edits = (SetOption(("option",), "gravity", " ".join(f"{value:.9g}" for value in rest)),)
    change = bench.change(edits)
    yield Finding(
        what=f"gravity has {across:.4g} m/s² across the plane in which everything moves",
        harm=Harm.WRONG if change > SAME_MOTION else Harm.LATENT,
        evidence={
            "normal of the plane": _digits(np.where(np.abs(normal) < 1e-9, 0.0, normal)),
            "share of gravity": across / float(np.linalg.norm(gravity)),
            "weight that joints carry across [N]": across * float(model.body_mass[model.body_weldid > 0].sum()),
        },
        fix="turn the machine, or the gravity, into the plane; or leave that part of it out",
        # Never safe: loads and free motion would be those of another machine, whatever this motion shows.
        edits=edits,
        change=change,
    )


def plane_normal(bench: Bench) -> Array | None:
    """Normal of the plane that all bodies stay parallel to in the run; None where there is none, or nothing turns."""
    bodies = np.flatnonzero(bench.model.body_weldid > 0).tolist()
    found = [velocity(bench.model, data, body) for data in bench.poses() for body in bodies]
    # With three that do not move, so that there are three singular values.
    turning, moving = np.split(np.vstack([np.zeros((3, 6)), *found]), 2, axis=1)
    _, spins, axes = np.linalg.svd(turning, full_matrices=False)
    if not spins[0] > 0.0 or spins[1] > PLANAR * spins[0]:
        return None
    normal: Array = axes[0]
    return normal if np.abs(moving @ normal).max() <= PLANAR * np.linalg.norm(moving, axis=1).max() else None


# -- inertias --------------------------------------------------------------------------------------------------------

# Everything by which the compiler changes what is written, turned off.
NOT_WRITTEN = {"balanceinertia": "false", "boundmass": "0", "boundinertia": "0", "settotalmass": "-1"}
AS_WRITTEN = tuple(
    SetOption(("compiler",), name, value) for name, value in {**NOT_WRITTEN, "inertiafromgeom": "auto"}.items()
)
SAME = 1e-9  # the sums are the same, their order may not be
WRITE = (
    "write every mass and inertia as it is, and take balanceinertia, boundmass, boundinertia, settotalmass and "
    "inertiafromgeom out of <compiler>"
)


@rule("drive torques, reactions and free motion are those of another machine", needs_motion=False)
def changed_inertia(bench: Bench) -> Iterator[Finding]:
    """Masses or inertias that the compiler made others than those written."""
    model = bench.model
    try:
        written = bench.edited(AS_WRITTEN).model
    except ValueError as error:
        yield Finding(
            what="the compiler makes masses or inertias up, without which the model does not compile",
            harm=Harm.WRONG,
            evidence={"compiled as written": " ".join(str(error).split())},
            fix=WRITE,
        )
        return
    # Principal moments come in an order of their own.
    compiled, meant = (np.column_stack([m.body_mass, np.sort(m.body_inertia, axis=1)]) for m in (model, written))
    changed = np.flatnonzero(~np.isclose(compiled, meant, rtol=SAME, atol=0.0).all(axis=1)).tolist()
    if not changed:
        return
    names = tuple(name_or_number(model, "body", body) for body in changed)
    change = None if bench.run.broke else bench.change(AS_WRITTEN)
    yield Finding(
        subjects=names,
        what=f"masses or inertias of {listed(names)} are not those that are written",
        harm=Harm.LATENT if change is not None and change <= SAME_MOTION else Harm.WRONG,
        evidence={
            "bodies changed": len(changed),
            f"mass [kg] and moments [kg m²] of {names[0]} as written": _digits(meant[changed[0]]),
            "as compiled": _digits(compiled[changed[0]]),
        },
        fix=WRITE,
        edits=AS_WRITTEN,
        change=change,
    )


def _digits(values: Array) -> str:
    return " ".join(f"{value:.6g}" for value in values)
