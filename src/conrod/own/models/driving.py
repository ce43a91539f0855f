"""Dynamic mode of a user's own model: driven by a flywheel on its crank, from the exact state, as the file has it."""

from __future__ import annotations

import copy
import math
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.mujoco.recorder import WARNINGS, warnings_kept_quiet
from conrod.engines.mujoco.settings import MuJoCoSettings, harden
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.models.assembly import Assembly
from conrod.own.models.own_settings import required_armature
from conrod.own.models.request import Drive, DrivenRun, Order, Question, Scan
from conrod.own.models.scanning import Prepared, prepare
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
    prepared = prepare(path, question)
    _check_samples(path, prepared.model, drive)
    _turn_to_start(prepared.assembly, drive)
    start = prepared.assembly.data.qpos.copy()
    rates = drive.rate * _start_rates(prepared)
    own = float(prepared.model.dof_armature[prepared.crank.rate])
    least = max(own, required_armature(prepared.model, scan, drive))
    return tuple(_driven(prepared, ordered(prepared.model, order), start, rates, drive, least) for order in orders)


def _check_samples(path: Path, model: mujoco.MjModel, drive: Drive) -> None:
    samples = _steps(model, drive) + 1
    if samples > drive.most_samples:
        raise InvalidInput(
            f"{path}: its timestep of {model.opt.timestep:g} s makes {samples} samples of {drive.turns:g} turns: "
            f"at most {drive.most_samples} are kept; fewer --revolutions"
        )


def _steps(model: mujoco.MjModel, drive: Drive) -> int:
    """Number of the model's own timesteps, which need not divide a turn."""
    return max(2, math.ceil(drive.turns * 2.0 * math.pi / abs(drive.rate) / float(model.opt.timestep) - 1e-9))


def _turn_to_start(assembly: Assembly, drive: Drive) -> None:
    assembly.data.qpos[:] = drive.near
    assembly.close()
    assembly.go(drive.start)
    if assembly.place_rest is not None:
        assembly.place_rest()


def _start_rates(prepared: Prepared) -> Array:
    """Joint rates (nv,) at a crank rate of one; where a contact places the rest, by a central difference."""
    assembly = prepared.assembly
    if prepared.gap is None:
        return assembly.rates()
    here, state = assembly.coordinate(), assembly.data.qpos.copy()
    around = []
    for by in (-BESIDE, BESIDE):
        assembly.go(here + by)
        around.append(assembly.data.qpos.copy())
    assembly.data.qpos[:] = state
    rates = np.empty(assembly.model.nv)
    mujoco.mj_differentiatePos(assembly.model, rates, 2.0 * BESIDE, *around)
    return rates


def ordered(model: mujoco.MjModel, order: Order) -> mujoco.MjModel:
    """A copy of a model with the settings of an order; contacts and closures alike get a preset's."""
    changed = copy.copy(model)
    changed.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    if order.settings is not None:
        assert isinstance(order.settings, MuJoCoSettings)
        _give(changed, order.settings)
    if order.tolerance is not None:
        changed.opt.tolerance = order.tolerance
    return changed


def _give(model: mujoco.MjModel, settings: MuJoCoSettings) -> None:
    option = model.opt
    option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{settings.integrator.upper()}")
    option.solver = getattr(mujoco.mjtSolver, f"mjSOL_{settings.solver.upper()}")
    option.iterations, option.tolerance = settings.iterations, settings.tolerance
    model.eq_solref[:], model.eq_solimp[:] = settings.solref, settings.solimp
    for softness in (model.geom_solref, model.pair_solref):
        softness[:] = settings.contact_solref
    for softness in (model.geom_solimp, model.pair_solimp):
        softness[:] = settings.contact_solimp
    if settings.hardening is not None:
        harden(model, settings.hardening)


def _driven(
    prepared: Prepared, model: mujoco.MjModel, start: Array, rates: Array, drive: Drive, armature: float
) -> DrivenRun:
    """A run with an armature that is heavy enough, or as heavy as the last attempt had it."""
    for _ in range(ATTEMPTS):
        model.dof_armature[prepared.crank.rate] = armature
        run = _run(prepared, model, start, rates, drive)
        missing = run.ripple / drive.ripple
        if missing <= 1.0 or run.outcome is not Outcome.COMPLETED or not math.isfinite(missing):
            break
        armature *= SPARE * missing
    return run


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


def _run(prepared: Prepared, model: mujoco.MjModel, start: Array, rates: Array, drive: Drive) -> DrivenRun:
    """Steps from the exact state; each sample is read before its step."""
    data, aside = mujoco.MjData(model), mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = start, rates
    steps, step, points = _steps(model, drive), float(model.opt.timestep), prepared.points
    rows = np.full((steps + 1, 4 + 9 * len(points)), np.nan)
    with warnings_kept_quiet():
        for k, row in enumerate(rows):
            if k:
                mujoco.mj_step(model, data)
            look_at(model, data, aside)
            _read(prepared, model, aside, row)
            if not math.isfinite(row.sum()):
                break
    finite = np.all(np.isfinite(rows), axis=1)
    whole = bool(finite.all())
    rows = rows if whole else rows[: int(np.argmin(finite))]
    motion = rows[:, 4:].reshape(len(rows), len(points), 3, 3)
    named = [{point.name: motion[:, k, part] for k, point in enumerate(points)} for part in range(3)]
    # A run that is not finite may have been ended before the engine itself looks at its numbers.
    warned = {name: int(data.warning[kind].number) for name, kind in WARNINGS.items()}
    return DrivenRun(
        armature=float(model.dof_armature[prepared.crank.rate]),
        timestep=step,
        times=np.asarray(step * np.arange(len(rows)), dtype=float),
        coordinate=rows[:, 0],
        rate=rows[:, 1],
        acceleration=rows[:, 2],
        positions=named[0],
        velocities=named[1],
        accelerations=named[2],
        gap=rows[:, 3],
        warnings={name: number for name, number in warned.items() if number},
        ripple=float(np.abs(rows[:, 1] / drive.rate - 1.0).max()) if len(rows) else math.inf,
        outcome=Outcome.COMPLETED if whole else Outcome.DIVERGED,
        reason="" if whole else f"not finite from {step * len(rows):.6g} s on",
    )


def _read(prepared: Prepared, model: mujoco.MjModel, data: mujoco.MjData, row: Array) -> None:
    """Fill a row: the crank's coordinate, rate and acceleration, the largest gap, and each point's motion (3, 3)."""
    crank = prepared.crank
    row[:3] = data.qpos[crank.coordinate], data.qvel[crank.rate], data.qacc[crank.rate]
    # Equalities come first among the constraints.
    row[3] = np.abs(data.efc_pos[: data.ne]).max(initial=0.0)
    fall = 0.0 if model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY else np.array(model.opt.gravity)
    for point, motion in zip(prepared.points, row[4:].reshape(-1, 3, 3), strict=True):
        motion[:] = point.position(data), point.velocity(model, data), point.acceleration(model, data) + fall
