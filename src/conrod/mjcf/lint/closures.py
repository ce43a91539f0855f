"""Rules on closures: those that give way, and those that the start leaves open."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from dataclasses import replace

import mujoco
import numpy as np

from conrod.engines.mujoco.settings import STIFF_SOLIMP
from conrod.exact.motion import Array
from conrod.mjcf.equalities import close_loops, closure_name, openings
from conrod.mjcf.lint.bench import Bench
from conrod.mjcf.lint.findings import Finding, Severity
from conrod.mjcf.runs import data_at, run, state_of
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


def soft_closure(bench: Bench) -> Iterator[Finding]:
    """Closures that give way, stock softness above all."""
    opened, finer = _worst(bench), bench
    wide = [index for index in range(bench.model.neq) if opened[index] > PLAY * bench.size]
    # With few steps a turn a stiff closure opens as well, by what the step leaves: looked at again with finer ones.
    for _ in range(REFINEMENTS + 1):
        stiffened = _stiffened(finer, wide)
        if not wide or stiffened.run.broke:
            return
        before, after = _worst(finer), _worst(stiffened)
        soft = [index for index in wide if after[index] <= TENFOLD * before[index]]
        if soft:
            yield _give(bench, finer, soft, before, after)
            return
        wide = [index for index in wide if before[index] > PLAY * bench.size]
        finer = finer.finer


def _give(bench: Bench, finer: Bench, soft: list[int], before: Array, after: Array) -> Finding:
    """Closures that give way, as a finer step shows it: openings [m] before and after they are made stiff."""
    model, worst = bench.model, max(soft, key=lambda index: before[index])
    stiff = _stiffened(bench, soft)
    solref, solimp = (
        " ".join(f"{v:.6g}" for v in values[worst]) for values in (stiff.model.eq_solref, stiff.model.eq_solimp)
    )
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


def _stiffened(bench: Bench, closures: list[int]) -> Bench:
    """The model with closures as stiff as a file can make them."""
    model = copy.copy(bench.model)
    steps = STIFF_STEPS.get(int(model.opt.integrator), LEAST_STEPS)
    for index in closures:
        model.eq_solref[index], model.eq_solimp[index] = (steps * bench.step, 1.0), STIFF_SOLIMP
    return replace(bench, model=model)


def _worst(bench: Bench) -> Array:
    """The widest opening (neq,) [m] of each; where one is open at the start, after the first quarter of the run."""
    found = bench.openings
    settled = found[len(found) // 4 :].max(axis=0)
    return np.asarray(np.where(found[0] <= PLAY * bench.size, found.max(axis=0), settled))


# -- the start -------------------------------------------------------------------------------------------------------

# Of the machine's size; numbers that were written with six digits leave a loop open by 1e-6 of it.
AJAR = 1e-5
CLOSED = 1e-13  # of the machine's size


def open_start(bench: Bench) -> Iterator[Finding]:
    """A start pose that leaves a loop open."""
    model, data = bench.model, data_at(bench.model, bench.start)
    mujoco.mj_forward(model, data)
    opened = openings(model, data, bench.size)
    ajar = [index for index in range(model.neq) if opened[index] > AJAR * bench.size]
    if not ajar:
        return
    closed = data_at(model, bench.start)
    change, fix = None, "lengths or places of the closures: no pose closes them"
    if close_loops(model, closed, CLOSED * bench.size):
        change = bench.change_to(run(model, state_of(model, closed), bench.steps))
        fix = f'qpos="{" ".join(f"{value:.15g}" for value in closed.qpos)}"'
    names = tuple(closure_name(model, index) for index in ajar)
    yield Finding(
        subjects=names,
        what=f"the start pose leaves loops open: {listed(names)} by up to {1e3 * opened.max():.3g} mm",
        severity=Severity.ERROR,
        evidence={
            "opening [m]": float(opened.max()),
            "start": "qpos0" if bench.keyframe is None else f"keyframe {bench.keyframe}",
        },
        why="the closures pull it shut in the first steps: a blow that no machine gets, and speeds that stay",
        fix=fix,
        change=change,
    )
