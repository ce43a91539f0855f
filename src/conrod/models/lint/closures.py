"""Rules on closures that give way, that the start leaves open, that are too many; and on links that collide there."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from dataclasses import replace
from xml.sax.saxutils import quoteattr

import mujoco
import numpy as np
from numpy.typing import NDArray

from conrod.engines.mujoco import STIFF_SOLIMP, compat
from conrod.engines.mujoco.model import equality_jacobian
from conrod.errors import list_names
from conrod.exact.motion import Array
from conrod.exact.space.assembly import RANK_TOLERANCE
from conrod.mjcf.anchors import parts_apart
from conrod.mjcf.equalities import (
    close_loops,
    closure_name,
    constraint_violations,
    handle_indices,
    row_equalities,
    ties_bodies,
)
from conrod.mjcf.loading import name_or_number
from conrod.mjcf.request import MIN_NAMED_OPENING
from conrod.mjcf.runs import data_at_state, run, state_of
from conrod.mjcf.unit_of_length import WIDTH, coordinate_powers, violation_power
from conrod.models.lint.bench import UNCHANGED_SHARE, LintBench
from conrod.models.lint.findings import Finding, Severity

# -- softness --------------------------------------------------------------------------------------------------------

# Of the machine's size. A bearing's play is a ten-thousandth of a small machine (30 micrometres in 0.3 m): closures
# that give way by more are worse than a real joint.
MAX_BEARING_PLAY = 1e-4
# A closure that opens ten times less when it is made stiff opens because it was soft, and for no other reason.
MAX_STIFF_RATIO = 0.1
REFINEMENTS = 3  # halvings of the step; where a stiff closure still opens then, it is not the softness that is seen
# Time constants [steps] at which conrod's preset `tuned` closes loops: RK4 loses its order below.
STIFF_STEPS = {int(mujoco.mjtIntegrator.mjINT_RK4): 8.0}
MIN_TIME_CONSTANT_STEPS = 2.0  # MuJoCo admits no less


def soft_closure(bench: LintBench) -> Iterator[Finding]:
    """Closures that yield under load, above all those with MuJoCo's default softness."""
    opened, finer = _largest_violations(bench), bench
    dragged = handle_indices(bench.model)  # by hand, and meant to give way
    wide = [k for k in range(bench.model.neq) if opened[k] > MAX_BEARING_PLAY * bench.size and k not in dragged]
    # With few steps a turn a stiff closure opens as well, by what the step leaves: looked at again with finer ones.
    for _ in range(REFINEMENTS + 1):
        stiffened = _stiffen(finer, wide)
        if not wide or stiffened.run.broke:
            return
        before, after = _largest_violations(finer), _largest_violations(stiffened)
        soft = [index for index in wide if after[index] <= MAX_STIFF_RATIO * before[index]]
        if soft:
            yield _compliance_finding(bench, finer, soft, before, after)
            return
        wide = [index for index in wide if before[index] > MAX_BEARING_PLAY * bench.size]
        finer = finer.finer


def _compliance_finding(bench: LintBench, finer: LintBench, soft: list[int], before: Array, after: Array) -> Finding:
    """Finding on soft closures, with violations [m] before and after they are made stiff at a finer step."""
    model, worst = bench.model, max(soft, key=lambda index: before[index])
    stiff = _stiffen(bench, soft)
    softness = stiff.model.eq_solref[worst].copy(), stiff.model.eq_solimp[worst].copy()
    softness[1][WIDTH] *= bench.document.unit ** -violation_power(model, worst)
    solref, solimp = (" ".join(f"{v:.6g}" for v in values) for values in softness)
    return Finding(
        subjects=tuple(closure_name(model, index) for index in soft),
        what=f"closures give way: {closure_name(model, worst)} opens by {1e3 * before[worst]:.3g} mm",
        severity=Severity.ERROR,
        evidence={
            "opening [m]": float(before[worst]),
            "opening when stiff [m]": float(after[worst]),
            "with a step of [s]": finer.step,
            "closures": len(soft),
        },
        why="the loop is not closed: positions are off by the opening, accelerations by far more, and no smaller step "
        "helps",
        fix=f'solref="{solref}" solimp="{solimp}", unless they are meant to give way; `conrod harden` takes out '
        "what no file can",
        change=bench.change_to(stiff.run),
    )


def _stiffen(bench: LintBench, closures: list[int]) -> LintBench:
    """The model with closures as stiff as a file can make them."""
    model = copy.copy(bench.model)
    steps = STIFF_STEPS.get(int(model.opt.integrator), MIN_TIME_CONSTANT_STEPS)
    for index in closures:
        model.eq_solref[index], model.eq_solimp[index] = (steps * bench.step, 1.0), STIFF_SOLIMP
    return replace(bench, model=model)


def _largest_violations(bench: LintBench) -> Array:
    """Largest violation (neq,) [m] of each equality; of one that starts open, after a quarter of the run."""
    found = bench.constraint_violations
    settled = found[len(found) // 4 :].max(axis=0)
    return np.asarray(np.where(found[0] <= MAX_BEARING_PLAY * bench.size, found.max(axis=0), settled))


# -- the start -------------------------------------------------------------------------------------------------------

CLOSING_TOLERANCE = 1e-13  # of the machine's size


def open_start(bench: LintBench) -> Iterator[Finding]:
    """A start pose that leaves a loop open."""
    model, data = bench.model, data_at_state(bench.model, bench.start)
    mujoco.mj_forward(model, data)
    opened = constraint_violations(model, data, bench.size)
    dragged = handle_indices(model)  # what drags by hand may begin where the hand is
    opened[list(dragged)] = 0.0
    ajar = [index for index in range(model.neq) if opened[index] > MIN_NAMED_OPENING * bench.size]
    if not ajar:
        return
    closed = data_at_state(model, bench.start)
    change, fix = None, "lengths or places of the closures: no pose closes them"
    if close_loops(model, closed, CLOSING_TOLERANCE * bench.size):
        change = bench.change_to(run(model, state_of(model, closed), bench.steps))
        pose = bench.document.unit ** -coordinate_powers(model) * closed.qpos
        fix = f'qpos="{" ".join(f"{value:.15g}" for value in pose)}"'
    names = tuple(closure_name(model, index) for index in ajar)
    yield Finding(
        subjects=names,
        what=f"the start pose leaves loops open: {list_names(names)} by up to {1e3 * opened.max():.3g} mm",
        severity=Severity.ERROR,
        evidence={
            "opening [m]": float(opened.max()),
            "start": "qpos0" if bench.keyframe is None else f"keyframe {bench.keyframe}",
        },
        why="the closures pull it shut in the first steps: a blow that no machine gets, and speeds that stay",
        fix=fix,
        change=change,
    )


# -- parts that do not meet ------------------------------------------------------------------------------------------


def parts_do_not_meet(bench: LintBench) -> Iterator[Finding]:
    """A connect or weld between bodies that holds parts which do not meet."""
    for one in parts_apart(bench.model):
        made = "the anchor on the second body" if one.kind == "connect" else "the relative pose"
        yield Finding(
            subjects=(one.closure, one.body),
            what=one.words,
            # A weld may hold what does not touch.
            severity=Severity.NOTE if one.kind == "weld" else Severity.ERROR,
            evidence={"distance [m]": one.distance, "extent of the model [m]": float(bench.model.stat.extent)},
            why=f"a {one.kind} by bodies takes {made} from the reference pose: where that does not assemble the "
            "machine, it is another machine, closed at the start and of other lengths",
            fix=one.cure if one.kind == "connect" else "give its relpose, or connect sites where the parts meet",
        )


# -- closures that are too many --------------------------------------------------------------------------------------

CHECKED_POSES = 5  # of the run


def redundant_closure(bench: LintBench) -> Iterator[Finding]:
    """Closures that say what others say."""
    states, model, looks = bench.run.states, bench.model, list[tuple[NDArray[np.int_], Array]]()
    for state in states[:: max(1, len(states) // CHECKED_POSES)]:
        data = data_at_state(model, state)
        close_loops(
            model, data, CLOSING_TOLERANCE * bench.size
        )  # or as nearly as loops that contradict each other can be
        if not np.isfinite(data.qpos).all():
            continue
        if np.isfinite(rows := equality_jacobian(model, data)).all():
            looks.append((row_equalities(data), rows))
    # Rows of one closure may repeat each other, as across the plane in which all moves: they are counted once.
    spare = [sum(_rank(rows, ids == k) for k in {*ids.tolist()}) - _rank(rows) for ids, rows in looks]
    if (redundant := min(spare, default=0)) <= 0:
        return
    gone, every = list[int](), sorted({*looks[0][0].tolist()})
    for index in reversed(every):
        if all(_rank(rows, ~np.isin(ids, [*gone, index])) == _rank(rows) for ids, rows in looks):
            gone.append(index)
    names = tuple(closure_name(model, index) for index in gone or every)
    finding = Finding(
        subjects=names,
        what=f"{redundant} rows of the closures ({list_names(names)}) say what others say",
        severity=Severity.NOTE,
        evidence={"redundant": redundant, "rank": _rank(looks[0][1])},
        why="forces are shared between rows that say the same: their reactions mean nothing, and where they do not "
        "agree to the last digit they fight",
        fix="tie each pin at one point, or let the bodies move in the plane of the machine only",
    )
    what, fix = f"without {list_names(names)} the closures hold what they hold", f"leave out {list_names(names)}"
    yield replace(finding, what=what, fix=fix) if gone else finding


def _rank(rows: Array, some: NDArray[np.bool_] | slice = slice(None)) -> int:
    """Rank of some rows of a Jacobian, with singular values judged by the size of all rows."""
    return int(np.linalg.matrix_rank(rows[some], RANK_TOLERANCE * np.linalg.norm(rows, 2))) if rows.size else 0


# -- links that collide at their joint -------------------------------------------------------------------------------

# Links that a pin holds together and that touch in nearly every step overlap whatever the pin does: a mechanical stop,
# or a foot on the ground, lets go.
MIN_CONTACT_SHARE = 0.9
TURNING = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_BALL))


def joined_links_collide(bench: LintBench) -> Iterator[Finding]:
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
        if joint and count >= MIN_CONTACT_SHARE * bench.run.steps:
            yield _overlap_finding(bench, bodies, joint, count)


def _overlap_finding(bench: LintBench, bodies: tuple[int, int], joint: str, count: int) -> Finding:
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
    if change <= UNCHANGED_SHARE:
        return replace(finding, edits=(edit,), safe=True, change=change)
    # Where the motion changes, somebody has to say which of the two was meant.
    return replace(finding, edits=(edit,), severity=Severity.ERROR, change=change)


def _joint_between(model: mujoco.MjModel, one: int, other: int) -> str:
    """Name of the joint, connect or weld that keeps two bodies together; empty if none."""
    for child, parent in ((one, other), (other, one)):
        # Bodies without a joint are one with those that they hang on.
        links = int(model.body_weldid[child])
        if links and model.body_weldid[model.body_parentid[links]] == model.body_weldid[parent]:
            joints = range(model.body_jntadr[links], model.body_jntadr[links] + model.body_jntnum[links])
            if joints and all(int(model.jnt_type[joint]) in TURNING for joint in joints):
                return f"joint {name_or_number(model, 'joint', joints[0])}"
    parts = sorted(model.body_weldid[[one, other]])
    ties = (index for index in np.flatnonzero(model.eq_active0).tolist() if ties_bodies(model, index))
    tied = (index for index in ties if sorted(model.body_weldid[compat.equality_bodies(model, index)]) == parts)
    return next((closure_name(model, index) for index in tied), "")
