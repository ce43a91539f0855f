"""Dynamic mode of a user's own model: as its file has it, and from the exact state with a flywheel on its crank."""

from __future__ import annotations

import copy
import math
from dataclasses import replace

import mujoco
import numpy as np

from conrod.engines.mujoco import MuJoCoSettings, harden, older
from conrod.engines.mujoco.dynamics import bad_numbers, warnings_kept_quiet
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.models.assembly import Assembly
from conrod.own.models.loading import data_at_start
from conrod.own.models.request import DrivenRun, Question, Scan
from conrod.own.models.results import RIPPLE
from conrod.runs.trajectory import Outcome
from conrod.studies.frame.resolve_arguments import MOST_SAMPLES

STATE = mujoco.mjtState.mjSTATE_INTEGRATION
# A flywheel that turns out too light is made heavier by what is missing and a little more, at most so often.
ATTEMPTS, SPARE = 3, 1.25
# Half of the way between two places of a follower, to take its rate from [rad of the crank].
BESIDE = 1e-4


def changed(
    model: mujoco.MjModel, settings: MuJoCoSettings | None = None, tolerance: float | None = None, finer: float = 1.0
) -> mujoco.MjModel:
    """A copy of a model with other settings; contacts and closures alike get a preset's.

    Args:
        tolerance: of the solver; None for that of the settings.
        finer: number of steps that take the place of one of the model's own.
    """
    changed = copy.copy(model)
    option = changed.opt
    option.timestep /= finer
    option.disableflags |= older.flag("AUTORESET")
    if settings is not None:
        option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{settings.integrator.upper()}")
        option.solver = getattr(mujoco.mjtSolver, f"mjSOL_{settings.solver.upper()}")
        option.iterations, option.tolerance = settings.iterations, settings.tolerance
        changed.eq_solref[:], changed.eq_solimp[:] = settings.solref, settings.solimp
        changed.geom_solref[:], changed.geom_solimp[:] = settings.contact_solref, settings.contact_solimp
        changed.pair_solref[:], changed.pair_solimp[:] = settings.contact_solref, settings.contact_solimp
        if settings.hardening is not None:
            harden(changed, settings.hardening)
    if tolerance is not None:
        option.tolerance = tolerance
    return changed


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


class CrankDrive:
    """A constant speed that is prescribed to a model's crank, by an armature that is heavy enough.

    Attributes:
        rate: of the crank's hinge [rad/s], of either sign.
        start: exact coordinates (nq,) and rates (nv,) at the beginning.
        armature: with which the speed keeps to `RIPPLE`, as far as the energy that the crank exchanges tells.
    """

    def __init__(self, assembly: Assembly, scan: Scan, rate: float, start: float, turns: float) -> None:
        """Args: start is the crank's coordinate at the beginning [rad].

        Raises:
            InvalidInput: the model's time step needs more samples than can be kept.
        """
        self.assembly, self.rate, self.turns = assembly, rate, turns
        model = assembly.original
        if (samples := self._samples(model)) > MOST_SAMPLES:
            raise InvalidInput(
                f"its timestep of {model.opt.timestep:g} s makes {samples} samples of {turns:g} turns: "
                f"at most {MOST_SAMPLES} are kept; fewer --revolutions"
            )
        assembly.data.qpos[:] = scan.states[int(np.argmin(np.abs(scan.coordinate - start)))]
        assembly.close()
        assembly.go(start)
        assembly.touch()
        self.start = assembly.data.qpos.copy(), rate * self._start_rates()
        self.armature = max(float(model.dof_armature[assembly.crank.rate]), self._required_armature(scan))

    def _samples(self, model: mujoco.MjModel) -> int:
        """One more than the model's own timesteps, which need not divide a turn."""
        duration = self.turns * 2.0 * math.pi / abs(self.rate)
        return max(2, math.ceil(duration / float(model.opt.timestep) - 1e-9)) + 1

    def _start_rates(self) -> Array:
        """Joint rates (nv,) at a crank rate of one; where a contact places the rest, by a central difference."""
        assembly = self.assembly
        if assembly.touching is None:
            return assembly.rates()
        here, around, rates = assembly.coordinate(), [], np.empty(assembly.model.nv)
        for by in (-BESIDE, BESIDE):
            assembly.go(here + by)
            around.append(assembly.data.qpos.copy())
        mujoco.mj_differentiatePos(assembly.model, rates, 2.0 * BESIDE, *around)
        return rates

    def _required_armature(self, scan: Scan) -> float:
        """Armature with which the energy that the crank exchanges changes its speed by no more than the ripple.

        Along the exact motion the machine's energy, less the work that dampers, friction and actuators have done, is
        what the flywheel has given: a change of the speed by d takes I w^2 d.
        """
        model = self.assembly.original
        data = mujoco.MjData(model)
        energy, power = [], []
        with warnings_kept_quiet():
            for state, rates in zip(scan.states, scan.rates, strict=True):
                data.qpos[:], data.qvel[:] = state, self.rate * rates
                for stage in (
                    mujoco.mj_fwdPosition,
                    mujoco.mj_fwdVelocity,
                    mujoco.mj_fwdActuation,
                    mujoco.mj_energyPos,
                ):
                    stage(model, data)
                mujoco.mj_energyVel(model, data)
                energy.append(float(data.energy.sum()))
                # Of all that acts along the joints and has no energy [W].
                acting = data.qfrc_passive - data.qfrc_spring + data.qfrc_actuator
                power.append(float(acting @ data.qvel - model.dof_frictionloss @ np.abs(data.qvel)))
        # Turn after turn the same work is done once more.
        turns, step = max(1, math.ceil(self.turns)), 2.0 * np.pi / abs(self.rate) / len(power)
        given = np.tile(energy, turns) - np.cumsum(np.tile(power, turns)) * step
        return float(np.ptp(given)) / (self.rate**2 * RIPPLE)

    def driven(self, model: mujoco.MjModel) -> DrivenRun:
        """A run with an armature that is heavy enough, or as heavy as the last attempt had it."""
        armature = self.armature
        for _ in range(ATTEMPTS):
            model.dof_armature[self.assembly.crank.rate] = armature
            data = mujoco.MjData(model)
            data.qpos[:], data.qvel[:] = self.start
            run = self._run(model, data)
            missing = run.ripple / RIPPLE
            if missing <= 1.0 or run.outcome is not Outcome.COMPLETED or not math.isfinite(missing):
                break
            armature *= SPARE * missing
        return run

    def as_given(self, question: Question) -> DrivenRun:
        """The run of the file: its own start, actuators and controls, autoreset as it is; nothing is prescribed."""
        model = self.assembly.original
        data, _ = data_at_start(model, question.keyframe, question.controls)
        return replace(self._run(model, data), ripple=0.0)

    def _run(self, model: mujoco.MjModel, data: mujoco.MjData) -> DrivenRun:
        """Steps from a state; each sample is read before its step. It ends where MuJoCo warns of numbers that are none.

        A row has the crank's coordinate, rate and acceleration, the largest gap, and each point's motion (3, 3).
        """
        aside, crank, points, clock = mujoco.MjData(model), self.assembly.crank, self.assembly.points, 0.0
        rows = np.full((self._samples(model), 4 + 9 * len(points)), np.nan)
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
            ripple=float(np.abs(rows[:, 1] / self.rate - 1.0).max()) if len(rows) else math.inf,
            outcome=Outcome.COMPLETED if whole else Outcome.RESET if reset else Outcome.DIVERGED,
            reason="" if whole else ended,
        )
