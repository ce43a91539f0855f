"""Dynamic mode of a user's own model: as its file has it, and from the exact state with a flywheel on its crank."""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.mujoco import older
from conrod.engines.mujoco.recorder import bad_numbers, warnings_kept_quiet, warnings_of
from conrod.engines.mujoco.settings import MuJoCoSettings, harden
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.models.assembly import Assembly, prepare
from conrod.own.models.loading import data_at_start
from conrod.own.models.request import Drive, DrivenRun, Order, Question, Scan
from conrod.runs.trajectory import Outcome

STATE = mujoco.mjtState.mjSTATE_INTEGRATION
# A flywheel that turns out too light is made heavier by what is missing and a little more, at most so often.
ATTEMPTS, SPARE = 3, 1.25
# Half of the way between two places of a follower, to take its rate from [rad of the crank].
BESIDE = 1e-4


def drive_model(
    path: Path, question: Question, scan: Scan, drive: Drive, orders: tuple[Order, ...]
) -> tuple[DrivenRun, ...]:
    """Runs of a model; to be called in a process of its own, see `conrod.studies.execution.isolation`.

    Raises:
        InvalidInput: its time step needs more samples than can be kept.
    """
    assembly = prepare(path, question)
    model, samples = assembly.original, _steps(assembly.original, drive) + 1
    if samples > drive.most_samples:
        raise InvalidInput(
            f"{path}: its timestep of {model.opt.timestep:g} s makes {samples} samples of {drive.turns:g} turns: "
            f"at most {drive.most_samples} are kept; fewer --revolutions"
        )
    assembly.data.qpos[:] = drive.near
    assembly.close()
    assembly.go(drive.start)
    assembly.touch()
    start = assembly.data.qpos.copy(), drive.rate * _start_rates(assembly)
    least = max(float(model.dof_armature[assembly.crank.rate]), _required_armature(model, scan, drive))
    return tuple(
        _as_given(assembly, question, drive)
        if order.as_given
        else _driven(assembly, ordered(model, order), start, drive, least)
        for order in orders
    )


def _steps(model: mujoco.MjModel, drive: Drive) -> int:
    """Number of the model's own timesteps, which need not divide a turn."""
    return max(2, math.ceil(drive.turns * 2.0 * math.pi / abs(drive.rate) / float(model.opt.timestep) - 1e-9))


def _start_rates(assembly: Assembly) -> Array:
    """Joint rates (nv,) at a crank rate of one; where a contact places the rest, by a central difference."""
    if assembly.touching is None:
        return assembly.rates()
    here, around, rates = assembly.coordinate(), [], np.empty(assembly.model.nv)
    for by in (-BESIDE, BESIDE):
        assembly.go(here + by)
        around.append(assembly.data.qpos.copy())
    mujoco.mj_differentiatePos(assembly.model, rates, 2.0 * BESIDE, *around)
    return rates


def _required_armature(model: mujoco.MjModel, scan: Scan, drive: Drive) -> float:
    """Armature with which the energy that the crank exchanges changes its speed by no more than the ripple.

    Along the exact motion the machine's energy, less the work that dampers, friction and actuators have done, is what
    the flywheel has given: a change of the speed by d takes I w^2 d.
    """
    data = mujoco.MjData(model)
    energy, power = [], []
    with warnings_kept_quiet():
        for state, rates in zip(scan.states, scan.rates, strict=True):
            data.qpos[:], data.qvel[:] = state, drive.rate * rates
            for stage in (mujoco.mj_fwdPosition, mujoco.mj_fwdVelocity, mujoco.mj_fwdActuation, mujoco.mj_energyPos):
                stage(model, data)
            mujoco.mj_energyVel(model, data)
            energy.append(float(data.energy.sum()))
            # Of all that acts along the joints and has no energy [W].
            acting = data.qfrc_passive - data.qfrc_spring + data.qfrc_actuator
            power.append(float(acting @ data.qvel - model.dof_frictionloss @ np.abs(data.qvel)))
    # Turn after turn the same work is done once more.
    turns, step = max(1, math.ceil(drive.turns)), 2.0 * np.pi / abs(drive.rate) / len(power)
    given = np.tile(energy, turns) - np.cumsum(np.tile(power, turns)) * step
    return float(np.ptp(given)) / (drive.rate**2 * drive.ripple)


def ordered(model: mujoco.MjModel, order: Order) -> mujoco.MjModel:
    """A copy of a model with the settings of an order; contacts and closures alike get a preset's."""
    changed, settings = copy.copy(model), order.settings
    option = changed.opt
    option.timestep /= order.finer
    option.disableflags |= older.flag("AUTORESET")
    if settings is not None:
        assert isinstance(settings, MuJoCoSettings)
        option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{settings.integrator.upper()}")
        option.solver = getattr(mujoco.mjtSolver, f"mjSOL_{settings.solver.upper()}")
        option.iterations, option.tolerance = settings.iterations, settings.tolerance
        changed.eq_solref[:], changed.eq_solimp[:] = settings.solref, settings.solimp
        changed.geom_solref[:], changed.geom_solimp[:] = settings.contact_solref, settings.contact_solimp
        changed.pair_solref[:], changed.pair_solimp[:] = settings.contact_solref, settings.contact_solimp
        if settings.hardening is not None:
            harden(changed, settings.hardening)
    if order.tolerance is not None:
        option.tolerance = order.tolerance
    return changed


def _driven(
    assembly: Assembly, model: mujoco.MjModel, start: tuple[Array, Array], drive: Drive, armature: float
) -> DrivenRun:
    """A run with an armature that is heavy enough, or as heavy as the last attempt had it."""
    for _ in range(ATTEMPTS):
        model.dof_armature[assembly.crank.rate] = armature
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = start
        run = _run(assembly, model, data, drive)
        missing = run.ripple / drive.ripple
        if missing <= 1.0 or run.outcome is not Outcome.COMPLETED or not math.isfinite(missing):
            break
        armature *= SPARE * missing
    return run


def _as_given(assembly: Assembly, question: Question, drive: Drive) -> DrivenRun:
    """The run of the file: its own start, actuators and controls, autoreset as it is; nothing is prescribed."""
    data, _ = data_at_start(assembly.original, question.keyframe, question.controls)
    return replace(_run(assembly, assembly.original, data, drive), ripple=0.0)


def look_at(model: mujoco.MjModel, data: mujoco.MjData, aside: mujoco.MjData) -> None:
    """Make position, velocity and acceleration of the present instant in another data object.

    What `mj_step` leaves of them does not belong together, under RK4 least of all. The run goes on to the last bit as
    if it had not been looked at.
    """
    state = np.empty(mujoco.mj_stateSize(model, STATE))
    mujoco.mj_getState(model, data, state, STATE)
    mujoco.mj_setState(model, aside, state, STATE)
    mujoco.mj_forward(model, aside)
    mujoco.mj_rnePostConstraint(model, aside)


def _run(assembly: Assembly, model: mujoco.MjModel, data: mujoco.MjData, drive: Drive) -> DrivenRun:
    """Steps from a state; each sample is read before its step. It ends where MuJoCo warns of numbers that are none.

    A row has the crank's coordinate, rate and acceleration, the largest gap, and each point's motion (3, 3).
    """
    aside, crank, points, clock = mujoco.MjData(model), assembly.crank, assembly.points, 0.0
    rows = np.full((_steps(model, drive) + 1, 4 + 9 * len(points)), np.nan)
    with warnings_kept_quiet():
        for k, row in enumerate(rows):
            if k:
                clock = float(data.time)
                mujoco.mj_step(model, data)
            if bad_numbers(data):
                break
            look_at(model, data, aside)
            row[:3] = aside.qpos[crank.coordinate], aside.qvel[crank.rate], aside.qacc[crank.rate]
            # Equalities come first among the constraints.
            row[3] = np.abs(aside.efc_pos[: aside.ne]).max(initial=0.0)
            row[4:] = np.ravel([point.motion(model, aside) for point in points])
            if not math.isfinite(row.sum()):
                clock = float(data.time)
                mujoco.mj_step(model, data)  # where MuJoCo looks at its numbers, and resets them if it may
                break
    finite, step = np.all(np.isfinite(rows), axis=1), float(model.opt.timestep)
    whole = bool(finite.all())
    rows = rows if whole else rows[: int(np.argmin(finite))]
    bad = bad_numbers(data)
    reset = bool(bad) and not model.opt.disableflags & older.flag("AUTORESET")
    named = f" ({', '.join(bad)})" if bad else ""
    ended = f"{'MuJoCo reset its state' if reset else 'not finite'} at {clock:.4g} s{named}"
    motion = rows[:, 4:].reshape(len(rows), len(points), 3, 3)
    return DrivenRun(
        armature=float(model.dof_armature[crank.rate]),
        timestep=step,
        times=np.asarray(step * np.arange(len(rows)), dtype=float),
        coordinate=rows[:, 0],
        rate=rows[:, 1],
        acceleration=rows[:, 2],
        motion={point.name: motion[:, k].swapaxes(0, 1) for k, point in enumerate(points)},
        gap=rows[:, 3],
        warnings=warnings_of(data),
        ripple=float(np.abs(rows[:, 1] / drive.rate - 1.0).max()) if len(rows) else math.inf,
        outcome=Outcome.COMPLETED if whole else Outcome.RESET if reset else Outcome.DIVERGED,
        reason="" if whole else ended,
    )
