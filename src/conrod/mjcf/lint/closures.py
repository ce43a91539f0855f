"""Rules on closures: those that give way, that the start leaves open or tears, and those that are too many."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.engines.mujoco.settings import STIFF_SOLIMP, STOCK_SOLIMP, STOCK_SOLREF
from conrod.exact.motion import Array
from conrod.mjcf.equalities import Rows, close_loops, closure_name, lengths, openings, rows_at, ties_bodies
from conrod.mjcf.lint.bench import Bench, rule
from conrod.mjcf.lint.findings import Change, Edit, Finding, Harm
from conrod.mjcf.runs import data_at, state_of, velocity
from conrod.own.models.loading import listed

# -- softness --------------------------------------------------------------------------------------------------------

# Of the machine's size. A bearing's play is a ten-thousandth of a small machine (30 micrometres in 0.3 m): closures
# that give way by more are worse than a real joint.
PLAY = 1e-4
# A closure that opens ten times less when it is made stiff opens because it was soft, and for no other reason.
TENFOLD = 0.1
REFINEMENTS = 3  # halvings of the step; where a stiff closure still opens then, it is not the softness that is seen
# Time constants [steps] at which conrod's preset `tuned` closes loops: RK4 loses its order below.
STIFF_STEPS = {int(mujoco.mjtIntegrator.mjINT_RK4): 8.0}
LEAST_STEPS = 2.0  # MuJoCo admits no less


@rule(
    "the loop is not closed: positions are off by the opening, accelerations by far more, and no smaller step helps",
)
def soft_closure(bench: Bench) -> Iterator[Finding]:
    """Connects and welds that give way, stock softness above all."""
    model, opened = bench.model, _worst(bench)
    wide = [i for i in range(model.neq) if opened[i] > PLAY * bench.size and bench.document.can_edit("equality", i)]
    finer = bench
    # With few steps a turn a stiff closure opens as well, by what the step leaves: looked at again with finer ones.
    for _ in range(REFINEMENTS + 1):
        stiffened = finer.edited(_stiff(finer, wide))
        if not wide or stiffened.run.broke:
            return
        before, after = _worst(finer), _worst(stiffened)
        soft = [index for index in wide if after[index] <= TENFOLD * before[index]]
        if soft:
            yield _give(bench, finer, soft)
            return
        wide = [index for index in wide if before[index] > PLAY * bench.size]
        finer = bench.with_step(0.5 * finer.step)


def _give(bench: Bench, finer: Bench, soft: list[int]) -> Finding:
    """Closures that give way, as a finer step shows it."""
    model, edits = bench.model, _stiff(bench, soft)
    change, opened = bench.change(edits), _worst(finer)
    worst = max(soft, key=lambda index: opened[index])
    stock = sum(
        ties_bodies(model, index)
        and np.array_equal(model.eq_solref[index], STOCK_SOLREF)
        and np.array_equal(model.eq_solimp[index], STOCK_SOLIMP)
        for index in soft
    )
    return Finding(
        subjects=tuple(closure_name(model, index) for index in soft),
        what=f"closures give way: {closure_name(model, worst)} opens by {1e3 * opened[worst]:.3g} mm",
        harm=Harm.WRONG,
        evidence={
            "opening [m]": float(opened[worst]),
            "opening when stiff [m]": float(_worst(finer.edited(_stiff(finer, soft)))[worst]),
            "with a step of [s]": finer.step,
            "closures with the stock solref and solimp": f"{stock} of {len(soft)}",
        },
        fix="stiffer closures, as here, unless they are meant to give way; `conrod harden` takes out what no file can",
        edits=edits,
        change=change,
    )


def _stiff(bench: Bench, closures: list[int]) -> tuple[Edit, ...]:
    """Closures as stiff as a model file can make them."""
    steps = STIFF_STEPS.get(int(bench.model.opt.integrator), LEAST_STEPS)
    values = {"solref": f"{steps * bench.step:.6g} 1", "solimp": " ".join(f"{value:g}" for value in STIFF_SOLIMP)}
    return tuple(
        Change("equality", index, closure_name(bench.model, index), attribute, value)
        for index in closures
        for attribute, value in values.items()
    )


def _worst(bench: Bench) -> Array:
    """The widest opening (neq,) [m] of each; where one is open at the start, after the first quarter of the run."""
    found = bench.openings
    settled = found[len(found) // 4 :].max(axis=0)
    return np.asarray(np.where(found[0] <= PLAY * bench.size, found.max(axis=0), settled))


# -- the start -------------------------------------------------------------------------------------------------------

# Of the machine's size; numbers that were written with six digits leave a loop open by 1e-6 of it.
AJAR = 1e-5
TORN = 1e-4  # of the fastest point: the same for speeds, which are differences of larger numbers
CLOSED = 1e-13  # of the machine's size


@rule(
    "the closures pull it shut in the first steps: a blow that no machine gets, and speeds that stay",
    needs_motion=False,
)
def open_start(bench: Bench) -> Iterator[Finding]:
    """A start pose that leaves a loop open."""
    model, data = bench.model, data_at(bench.model, bench.start)
    mujoco.mj_forward(model, data)
    opened = openings(model, data)
    ajar = [index for index in range(model.neq) if opened[index] > AJAR * bench.size]
    if not ajar:
        return
    closed = data_at(model, bench.start)
    change, fix = None, "lengths or places of the closures: no pose closes them"
    if close_loops(model, closed, CLOSED * bench.size):
        change, fix = bench.change_from(state_of(model, closed)), f'qpos="{_all_digits(closed.qpos)}"'
    names = tuple(closure_name(model, index) for index in ajar)
    yield Finding(
        subjects=names,
        what=f"the start pose leaves loops open: {listed(names)} by up to {1e3 * opened.max():.3g} mm",
        harm=Harm.WRONG,
        evidence={
            "opening [m]": float(opened.max()),
            "start": "qpos0" if bench.keyframe is None else f"keyframe {bench.keyframe}",
        },
        fix=fix,
        change=change,
    )


@rule(
    "the closures stop it with a blow in the first steps, and energy that the machine was given is gone",
    needs_motion=False,
)
def torn_start(bench: Bench) -> Iterator[Finding]:
    """Start speeds that tear a loop."""
    model, data = bench.model, data_at(bench.model, bench.start)
    mujoco.mj_forward(model, data)
    moving = np.flatnonzero(model.body_weldid > 0).tolist()
    fastest = max((float(np.linalg.norm(velocity(model, data, body)[3:])) for body in moving), default=0.0)
    rows = rows_at(model, data)
    parting = lengths(model, rows.ids, rows.rates)
    torn = [index for index in range(model.neq) if parting[index] > TORN * fastest]
    if not torn or fastest == 0.0:
        return
    names = tuple(closure_name(model, index) for index in torn)
    joined = data_at(model, bench.start)
    joined.qvel[:] = _consistent_speeds(model, data, rows)
    change = bench.change_from(state_of(model, joined))
    yield Finding(
        subjects=names,
        what=f"the start speeds tear loops: the ends of {listed(names)} part at up to {parting.max():.3g} m/s",
        harm=Harm.WRONG,
        evidence={
            "speed of parting [m/s]": float(parting.max()),
            "speed of the fastest body [m/s]": fastest,
        },
        fix=f'qvel="{_all_digits(joined.qvel)}"',
        change=change,
    )


def _all_digits(values: Array) -> str:
    return " ".join(f"{value:.15g}" for value in values)


def _consistent_speeds(model: mujoco.MjModel, data: mujoco.MjData, rows: Rows) -> Array:
    """Speeds (nv,) that part no closure, and that a blow of the closures would leave of those of the data.

    The change has the least energy, whatever the units of the coordinates are: a heavy crank keeps its speed.
    """
    mass = np.empty((model.nv, model.nv))
    for k, direction in enumerate(np.eye(model.nv)):
        mujoco.mj_mulM(model, data, mass[k], direction)
    root = np.linalg.cholesky(mass)
    # By coordinates in which the energy is half the square of the speeds.
    jacobian = np.linalg.solve(root, rows.jacobian.T).T
    change = np.linalg.pinv(jacobian, rcond=1e-9) @ (jacobian @ (root.T @ data.qvel))
    return np.asarray(data.qvel - np.linalg.solve(root.T, change))


# -- closures that are too many --------------------------------------------------------------------------------------

# Two closures in the place of one are twice as stiff; what they close is then closed a little less tightly by one. A
# change of the motion by a millionth is that, and no other machine.
SAME_MOTION = 1e-6


@rule(
    "forces are shared between rows that say the same: their reactions mean nothing, and where they do not agree to "
    "the last digit they fight",
)
def redundant_closure(bench: Bench) -> Iterator[Finding]:
    """Closures that say what others say."""
    looks = bench.rows
    redundant = min((int(rows.effective.sum()) - rows.rank for rows in looks), default=0)
    if redundant <= 0:
        return
    rows, gone = looks[0], _removable(looks)
    names = tuple(closure_name(bench.model, index) for index in gone or dict.fromkeys(rows.ids.tolist()))
    what, fix = f"without {listed(names)} the closures hold what they hold", f"leave out {listed(names)}"
    if not gone:
        what = f"{redundant} rows of the closures ({listed(names)}) say what others say"
        fix = "let the bodies move in the plane of the machine only (hinges and slides), or tie each pin at one point"
    finding = Finding(
        subjects=names,
        what=what,
        harm=Harm.WASTE,
        evidence={
            "constraint rows that say anything": int(rows.effective.sum()),
            "rank": rows.rank,
            "rank without": rows.rank_without(gone),
            "redundant": redundant,
        },
        fix=fix,
    )
    edits = [Change("equality", index, closure_name(bench.model, index)) for index in gone]
    yield bench.tried(finding, edits, SAME_MOTION) if gone else finding


def _removable(looks: list[Rows]) -> list[int]:
    """Equalities that can go together without anything becoming free, the later ones first."""
    gone: list[int] = []
    for index in sorted(set(looks[0].ids.tolist()), reverse=True):
        trial = [*gone, index]
        says_anything = any(rows.effective[rows.ids == index].any() for rows in looks)
        if says_anything and all(rows.rank_without(trial) == rows.rank for rows in looks):
            gone = trial
    return gone
