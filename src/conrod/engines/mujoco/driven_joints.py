"""MuJoCo models whose joints are driven by laws: flywheels, and the settings of the presets at a given step."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from conrod.engines.engine import DeferredLibrary
from conrod.engines.mujoco import HARDENING_FACTOR, MuJoCoSettings, compat
from conrod.engines.mujoco.compiled_edits import harden, set_armature, set_step
from conrod.exact.motion import Array
from conrod.exact.space.motion import DrivenTree

if TYPE_CHECKING:
    import mujoco
else:
    mujoco = DeferredLibrary("mujoco")

# Armature of a driven joint over the inertia that all bodies together could have about it: what the machine asks of its
# drive changes the joint's acceleration by one part in so many.
FLYWHEEL_RATIO = 1e12
STEPS_TOGETHER = 256  # whose forces are computed at once: a law costs as much at one time as at a hundred
# Hardening of a machine with an idle spin: an RSSR linkage whose rod has 1/500 of its inertia about itself is off by
# 1 mm at 1e-9 and by 1e-7 mm at 1e-7 (1 m, 1 ms).
IDLE_SPIN_HARDENING = 1e-7
# Solver tolerance: at 0 Newton's method goes on where nothing is gained any more, to its last iteration in most steps
# (of Agility's Cassie 100 in place of 2, at 12 times the cost).
SOLVER_TOLERANCE = 1e-30


class Drives:
    """Drives of a model: prescribed coordinates and rates at each step, flywheels accelerated by the laws."""

    def __init__(self, machine: DrivenTree, model: mujoco.MjModel) -> None:
        self.machine, self.model = machine, model
        self.joints = list(zip(machine.driven, machine.laws.values(), strict=True))
        self.held = [joint for joint in machine.tree.joints if joint.name in machine.held]
        inertia = float(model.body_mass.sum()) * (machine.tree.extent**2)
        self.armature = FLYWHEEL_RATIO * max(inertia, float(model.dof_M0.max(initial=1e-9)))
        driven = [np.arange(model.nv)[joint.rates] for joint in (*machine.driven, *self.held)]
        set_armature(model, np.concatenate(driven).tolist(), self.armature)

    def writer(self, times: Array) -> Callable[[mujoco.MjData, int], None]:
        """Return a function that writes the driven coordinates and rates at the k-th of the times (N,) [s]."""
        # All at once: a law is a few array operations, which cost as much for one time as for a hundred.
        laws = np.reshape([law.derivatives(times)[:2] for _, law in self.joints], (len(self.joints), 2, len(times)))
        driven, turning = (np.ascontiguousarray(laws[:, k].T) for k in (0, 1))
        at = np.array([joint.coordinate for joint, _ in self.joints], dtype=int)
        speeds = np.array([joint.rate for joint, _ in self.joints], dtype=int)
        held = [
            (joint.rates, joint.coordinates, self.machine.knots[0].coordinates[joint.coordinates, 0])
            for joint in self.held
        ]

        def write(data: mujoco.MjData, k: int) -> None:
            coordinates, rates = data.qpos, data.qvel
            coordinates[at], rates[speeds] = driven[k], turning[k]
            for stopped, places, still in held:
                rates[stopped], coordinates[places] = 0.0, still

        return write

    @contextmanager
    def pushing_flywheels(self) -> Iterator[None]:
        """Make MuJoCo push the flywheels along their laws at each stage of a step, inside the context.

        Where the model switches actuation off MuJoCo asks for no control, but for passive forces all the same.
        """
        off = self.model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_ACTUATION
        kind = "passive" if off else "control"
        callback, set_callback = (getattr(mujoco, f"{verb}_mjcb_{kind}") for verb in ("get", "set"))

        rates, known = [joint.rate for joint, _ in self.joints], dict[float, tuple[float, ...]]()

        def push(_: mujoco.MjModel, data: mujoco.MjData) -> None:
            if (forces := known.get(time := data.time)) is None:
                known.clear()
                known.update(self._forces_from(time))
                forces = known[time]
            applied = data.qfrc_applied
            for rate, force in zip(rates, forces, strict=True):
                applied[rate] = force

        before = callback()
        set_callback(push)
        try:
            yield
        finally:
            set_callback(before)

    def _forces_from(self, time: float) -> dict[float, tuple[float, ...]]:
        """Forces on the flywheels at the stages of the next `STEPS_TOGETHER` steps from a time [s], by time."""
        step = float(self.model.opt.timestep)
        # MuJoCo adds up steps one by one. Stages of RK4 are at a step's beginning, twice at its middle, and at its end.
        begins = np.add.accumulate([time, *[step] * STEPS_TOGETHER])
        times = np.concatenate([begins, begins + 0.5 * step])
        forces = [(self.armature * law.derivatives(times)[2]).tolist() for _, law in self.joints]
        return dict(zip(times.tolist(), zip(*forces, strict=True), strict=True))


# -- settings ----------------------------------------------------------------------------------------------------------


def model_with_settings(model: mujoco.MjModel, step: float, settings: MuJoCoSettings | None) -> mujoco.MjModel:
    """Copy a model with a step [s], settings, and a converging solver; contacts and closures alike get the settings.

    Args:
        settings: of a preset; None for those that the model has.
    """
    made = copy.copy(model)
    option = made.opt
    set_step(made, step)
    option.disableflags |= compat.disable_bit("AUTORESET")
    if settings is not None:
        option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{settings.integrator.upper()}")
        option.solver = getattr(mujoco.mjtSolver, f"mjSOL_{settings.solver.upper()}")
        option.iterations = settings.iterations
        made.eq_solref[:], made.eq_solimp[:] = settings.solref, settings.solimp
        made.geom_solref[:], made.geom_solimp[:] = settings.contact_solref, settings.contact_solimp
        made.pair_solref[:], made.pair_solimp[:] = settings.contact_solref, settings.contact_solimp
        option.o_solref[:], option.o_solimp[:] = settings.contact_solref, settings.contact_solimp  # under `override`
        if settings.hardening is not None:
            harden(made, settings.hardening)
    option.tolerance = SOLVER_TOLERANCE
    return made


def preset_settings(label: str, step: float, period: float, idle: bool, contact: bool = False) -> MuJoCoSettings:
    """Return a preset's settings at a step [s], for a machine whose slowest drive has a period [s].

    Args:
        idle: whether the drives leave a freedom; closures that are too hard would hide its inertia in rounding.
        contact: whether a contact places what the closures leave free.
    """
    tuned = MuJoCoSettings("stock", 2, step).with_tuned_solver(contact)
    if label != "hardened":
        return tuned
    return replace(
        tuned,
        preset=label,
        solref=(max(0.1 * period, tuned.solref[0]), 1.0),
        hardening=IDLE_SPIN_HARDENING if idle else HARDENING_FACTOR,
    )
