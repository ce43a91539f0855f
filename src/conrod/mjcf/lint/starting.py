"""Rules on the start: one that no closed loop can be in, and a model that starts again by itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import mujoco
import numpy as np

from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.mjcf.equalities import closure_name, lengths, openings, rows_at
from conrod.mjcf.lint.bench import Bench, relative
from conrod.mjcf.lint.edits import SetOption
from conrod.mjcf.lint.findings import Finding, Harm
from conrod.mjcf.lint.runs import Start, largest_change, run
from conrod.mjcf.lint.solver import stable
from conrod.own.models.loading import listed

NO_RESET = (SetOption(("option", "flag"), "autoreset", "disable"),)
TOO_FAST = 1e11  # mjMAXVAL is 1e10: what is beyond it counts as divergence


def silent_reset(bench: Bench) -> Iterator[Finding]:
    """A speed that no machine has is put into a copy: it must be there, or an error, after the next step."""
    if not resets(bench):
        return
    model = bench.model
    twice = stable(bench.with_step(2.0 * float(model.opt.timestep)), bench)
    yield Finding(
        subjects=(),
        what="when its numbers go wrong the model starts again by itself, and the run goes on",
        harm=Harm.WRONG if bench.run.broke else Harm.LATENT,
        evidence={
            "speed put in": TOO_FAST,
            "time after the next step [s]": float(model.opt.timestep),
            "runs at twice its step": "yes" if twice else "no",
        },
        fix="autoreset off, and look at the warnings or at the numbers",
        edits=NO_RESET,
        safe=True,
        change=bench.change(NO_RESET) if not bench.run.broke else None,
    )


def resets(bench: Bench) -> bool:
    """Return True where the time starts again after a speed that no machine has."""
    model = bench.model
    if not model.nv:
        return False
    data = bench.start.data(model)
    with warnings_kept_quiet():
        mujoco.mj_step(model, data, 2)
        before = float(data.time)
        data.qvel[:] = TOO_FAST
        mujoco.mj_step(model, data)
    return bool(data.time < before and np.isfinite(data.qpos).all())


# Of the machine's size; numbers that were written with six digits leave a loop open by 1e-6 of it.
AJAR = 1e-5
TORN = 1e-4  # of the fastest point: the same for speeds, which are differences of larger numbers
PASSES = 50
CLOSED = 1e-13  # of the machine's size


def open_pose(bench: Bench) -> Iterator[Finding]:
    """Closures that are open before the first step."""
    model = bench.model
    data = bench.start.data(model)
    mujoco.mj_forward(model, data)
    opened = openings(model, data)
    ajar = [index for index in range(model.neq) if opened[index] > AJAR * bench.size]
    if not ajar:
        return
    names = tuple(closure_name(model, index) for index in ajar)
    closed = closed_pose(bench)
    change = None if closed is None else _change(bench, closed)
    moved = "no closed pose near" if closed is None else " ".join(f"{value:.15g}" for value in closed.qpos)
    yield Finding(
        subjects=names,
        what=f"the start pose leaves loops open: {listed(names)} by up to {1e3 * opened.max():.3g} mm",
        harm=Harm.WRONG,
        evidence={
            "opening [m]": float(opened.max()),
            "opening over size": float(opened.max() / bench.size),
            "start": "qpos0" if bench.keyframe is None else f"keyframe {bench.keyframe}",
            "change of motion when closed": "not run" if change is None else change,
        },
        fix=f'qpos="{moved}"' if closed is not None else "lengths or places of the closures: no pose closes them",
        change=change,
    )


def torn_speeds(bench: Bench) -> Iterator[Finding]:
    """Closures whose ends part in the first instant."""
    model = bench.model
    data = bench.start.data(model)
    mujoco.mj_forward(model, data)
    fastest = _fastest(model, data)
    rows = rows_at(model, data)
    parting = lengths(model, rows.ids, rows.rates)
    torn = [index for index in range(model.neq) if parting[index] > TORN * fastest]
    if not torn or fastest == 0.0:
        return
    names = tuple(closure_name(model, index) for index in torn)
    joined = consistent_speeds(bench)
    change = _change(bench, joined)
    yield Finding(
        subjects=names,
        what=f"the start speeds tear loops: the ends of {listed(names)} part at up to {parting.max():.3g} m/s",
        harm=Harm.WRONG,
        evidence={
            "speed of parting [m/s]": float(parting.max()),
            "speed of the fastest body [m/s]": fastest,
            "change of motion when they fit": change,
        },
        fix=f'qvel="{" ".join(f"{value:.15g}" for value in joined.qvel)}"',
        change=change,
    )


def closed_pose(bench: Bench) -> Start | None:
    """The start with the nearest pose that closes all loops, by Newton's method; None where it finds none."""
    model, data = bench.model, bench.start.data(bench.model)
    for _ in range(PASSES):
        mujoco.mj_forward(model, data)
        rows = rows_at(model, data)
        if not (np.isfinite(data.qpos).all() and np.isfinite(rows.jacobian).all()):
            return None
        if np.abs(rows.gaps).max(initial=0.0) <= CLOSED * bench.size:
            return replace(bench.start, qpos=data.qpos.copy())
        mujoco.mj_integratePos(model, data.qpos, -np.linalg.pinv(rows.jacobian, rcond=1e-9) @ rows.gaps, 1.0)
    return None


def consistent_speeds(bench: Bench) -> Start:
    """The start with the speeds that part no closure, and that a blow of the closures would leave of its own.

    The change has the least energy, whatever the units of the coordinates are: a heavy crank keeps its speed.
    """
    model, data = bench.model, bench.start.data(bench.model)
    mujoco.mj_forward(model, data)
    mass = np.empty((model.nv, model.nv))
    for k, direction in enumerate(np.eye(model.nv)):
        mujoco.mj_mulM(model, data, mass[k], direction)
    root = np.linalg.cholesky(mass)
    # By coordinates in which the energy is half the square of the speeds.
    jacobian = np.linalg.solve(root, rows_at(model, data).jacobian.T).T
    change = np.linalg.pinv(jacobian, rcond=1e-9) @ (jacobian @ (root.T @ data.qvel))
    return replace(bench.start, qvel=np.asarray(data.qvel - np.linalg.solve(root.T, change)))


def _change(bench: Bench, start: Start) -> float:
    other = run(bench.model, start, bench.steps, bench.observed)
    return relative(largest_change(bench.run, other) / bench.scale)


def _fastest(model: mujoco.MjModel, data: mujoco.MjData) -> float:
    speeds = [0.0]
    for body in np.flatnonzero(model.body_weldid > 0):
        velocity = np.empty(6)
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, int(body), velocity, 0)
        speeds.append(float(np.linalg.norm(velocity[3:])))
    return max(speeds)
