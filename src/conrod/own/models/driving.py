"""Steps of a model that can be looked at where each of them starts, as `mj_step` makes them to the last bit.

Dynamic mode of a user's own model: driven by a flywheel on its crank, from the exact state, as the file has it.
"""

from __future__ import annotations

import copy
import math
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.mujoco.hardening import harden
from conrod.engines.mujoco.recorder import WARNINGS, warnings_kept_quiet
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.models.assembly import Assembly
from conrod.own.models.own_settings import needed_armature
from conrod.own.models.points import FoundPoint
from conrod.own.models.request import Drive, DrivenRun, Order, Question, Scan
from conrod.own.models.scanning import Prepared, prepare
from conrod.runs.trajectory import Outcome

STATE = mujoco.mjtState.mjSTATE_INTEGRATION
EULER, RK4 = mujoco.mjtIntegrator.mjINT_EULER, mujoco.mjtIntegrator.mjINT_RK4
IMPLICIT = (mujoco.mjtIntegrator.mjINT_IMPLICIT, mujoco.mjtIntegrator.mjINT_IMPLICITFAST)


class Stepper:
    """A model that is stepped; `data` holds the state of now.

    A step is the accelerations of now, then the integrator. To look in between costs nothing, and gives position,
    velocity and acceleration of one instant: what `mj_step` leaves of them does not belong together, under RK4 least
    of all. Where the integrator is not one that can be called by itself, another data object is looked at.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model, self._data = model, data
        self._kind = mujoco.mjtIntegrator(int(model.opt.integrator))
        self._aside = None if self._kind in (EULER, RK4, *IMPLICIT) else mujoco.MjData(model)
        self._state = np.empty(mujoco.mj_stateSize(model, STATE))

    def look(self) -> mujoco.MjData:
        """Data with all of now in it, up to the accelerations of bodies; to be read only."""
        data = self._data if self._aside is None else self._aside
        if self._aside is None:
            mujoco.mj_checkPos(self._model, data)
            mujoco.mj_checkVel(self._model, data)
        else:
            mujoco.mj_getState(self._model, self._data, self._state, STATE)
            mujoco.mj_setState(self._model, data, self._state, STATE)
        mujoco.mj_forward(self._model, data)
        if self._aside is None:
            mujoco.mj_checkAcc(self._model, data)
        mujoco.mj_rnePostConstraint(self._model, data)
        return data

    def step(self) -> None:
        """On by a step, after a look."""
        if self._aside is not None:
            mujoco.mj_step(self._model, self._data)
        elif self._kind == RK4:
            mujoco.mj_RungeKutta(self._model, self._data, 4)
        elif self._kind == EULER:
            mujoco.mj_Euler(self._model, self._data)
        else:
            mujoco.mj_implicit(self._model, self._data)


# A flywheel that turns out too light is made heavier by what is missing and a little more, at most so often.
ATTEMPTS, SPARE = 3, 1.25
# Half of the way between two places of a follower, to take its rate from [rad of the crank].
BESIDE = 1e-4


def drive_model(
    path: Path, question: Question, scan: Scan, drive: Drive, orders: tuple[Order, ...]
) -> tuple[DrivenRun, ...]:
    """Runs of a model; to be called in a process of its own, see `conrod.studies.execution.confined`.

    Raises:
        InvalidInput: its time step needs more samples than can be kept.
    """
    prepared = prepare(path, question)
    _check_samples(path, prepared.model, drive)
    _turn_to_start(prepared.assembly, drive)
    start = prepared.assembly.data.qpos.copy()
    rates = drive.rate * _start_rates(prepared)
    own = float(prepared.model.dof_armature[prepared.crank.rate])
    least = needed_armature(prepared.model, scan, drive)
    runs = []
    for order in orders:
        model = ordered(prepared.model, order)
        armature = max(own, least)
        for _ in range(ATTEMPTS):
            model.dof_armature[prepared.crank.rate] = armature
            run = _run(prepared, model, start, rates, drive, armature)
            missing = run.ripple / drive.ripple
            if missing <= 1.0 or run.outcome is not Outcome.COMPLETED or not math.isfinite(missing):
                break
            armature *= SPARE * missing
        runs.append(run)
    return tuple(runs)


def _check_samples(path: Path, model: mujoco.MjModel, drive: Drive) -> None:
    samples = _steps(model, drive) + 1
    if samples > drive.most_samples:
        raise InvalidInput(
            f"{path}: its timestep of {model.opt.timestep:g} s makes {samples} samples of {drive.turns:g} turns: "
            f"at most {drive.most_samples} are kept; fewer --revolutions"
        )


def _steps(model: mujoco.MjModel, drive: Drive) -> int:
    """Of the model's own timestep, which need not divide a turn."""
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


def _run(
    prepared: Prepared, model: mujoco.MjModel, start: Array, rates: Array, drive: Drive, armature: float
) -> DrivenRun:
    """Steps from the exact state; each sample is read before its step."""
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = start, rates
    steps, taken = _steps(model, drive), 0
    stepper, reader = Stepper(model, data), _Reader(prepared, model, data)
    rows = np.empty((steps + 1, reader.width))
    with warnings_kept_quiet():
        for k in range(steps + 1):
            seen = stepper.look()
            reader.read(seen, rows[k])
            if not math.isfinite(rows[k].sum()):
                break
            taken = k + 1
            if k < steps:
                stepper.step()
    return _told(model, data, rows[:taken], steps, prepared.points, drive, armature)


class _Reader:
    """Reads a sample: the crank's coordinate, rate and acceleration, the largest gap, and each point's motion."""

    def __init__(self, prepared: Prepared, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._crank, self._points, self._model = prepared.crank, prepared.points, model
        self.width = 4 + 9 * len(prepared.points)
        off = bool(model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY)
        self._fall = np.zeros(3) if off else np.array(model.opt.gravity)

    def read(self, data: mujoco.MjData, row: Array) -> None:
        """Fill a row (width,) from data that are made up to the accelerations of bodies."""
        model, crank = self._model, self._crank
        row[0], row[1], row[2] = data.qpos[crank.coordinate], data.qvel[crank.rate], data.qacc[crank.rate]
        # Equalities come first among the constraints.
        row[3] = np.abs(data.efc_pos[: data.ne]).max() if data.ne else 0.0
        for k, point in enumerate(self._points):
            at = 4 + 9 * k
            row[at : at + 3] = point.position(data)
            row[at + 3 : at + 6] = point.velocity(model, data)
            row[at + 6 : at + 9] = point.acceleration(model, data) + self._fall


def _told(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    rows: Array,
    steps: int,
    points: tuple[FoundPoint, ...],
    drive: Drive,
    armature: float,
) -> DrivenRun:
    step = float(model.opt.timestep)
    finite = np.all(np.isfinite(rows), axis=1)
    whole = len(rows) == steps + 1 and bool(finite.all())
    if not finite.all():
        rows = rows[: int(np.argmin(finite))]
    read = {
        point.name: [rows[:, 4 + 9 * i + 3 * j : 7 + 9 * i + 3 * j] for j in range(3)] for i, point in enumerate(points)
    }
    # A run that is not finite may have been ended before the engine itself looks at its numbers.
    warned = {name: int(data.warning[kind].number) for name, kind in WARNINGS.items()}
    ripple = np.abs(rows[:, 1] / drive.rate - 1.0).max() if len(rows) else math.inf
    return DrivenRun(
        armature=armature,
        timestep=step,
        times=np.asarray(step * np.arange(len(rows)), dtype=float),
        coordinate=rows[:, 0],
        rate=rows[:, 1],
        acceleration=rows[:, 2],
        positions={name: parts[0] for name, parts in read.items()},
        velocities={name: parts[1] for name, parts in read.items()},
        accelerations={name: parts[2] for name, parts in read.items()},
        gap=rows[:, 3],
        warnings={name: number for name, number in warned.items() if number},
        ripple=float(ripple),
        outcome=Outcome.COMPLETED if whole else Outcome.DIVERGED,
        reason="" if whole else f"not finite from {step * len(rows):.6g} s on",
    )
