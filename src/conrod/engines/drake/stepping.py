"""Drake's simulator on a plant that is built: steps of one length, drives that follow laws, failures as data."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from conrod.engines.drake import DISCRETE, DrakeSettings
from conrod.engines.drake.plant import DrakePlant
from conrod.exact.motion import Array
from conrod.exact.space.drive_laws import DriveLaw

MOST_PARTS = 1024  # that a step may be cut into
STEPS_TOGETHER = 256  # whose forces are computed at once: a law costs as much at one time as at a hundred


def explain_error(message: str) -> str:
    """Say in one line why Drake's simulator gave up."""
    if "smaller than minimum" in message:
        return f"Newton's iteration of Drake's integrator fails even in 1/{MOST_PARTS} of a step"
    words = " ".join(message.split())
    if "gimbal-lock" in words:
        return "Drake refuses roll, pitch and yaw of a loop's bushing next to a pitch of a right angle (gimbal lock)"
    if "BallRpyJoint" in words:
        return (
            "Drake refuses a ball joint (BallRpyJoint) next to a pitch of a right angle, where its angles are singular"
        )
    return f"Drake: {words}"


class LawForces(LeafSystem):  # type: ignore[misc] # pydrake is untyped here
    """Forces on the flywheels, of inertia J each, that take the driven joints along their laws s(t)."""

    def __init__(self, laws: Mapping[str, DriveLaw], made: DrakePlant, step: float) -> None:
        super().__init__()
        self._laws, self._step = list(laws.values()), step
        self._inertias = np.array([made.flywheels[name] for name in laws])
        self._known: dict[float, Array] = {}
        self.DeclareVectorOutputPort("forces", len(laws), self._write, {self.time_ticket()})

    def forces_at(self, time: float) -> Array:
        """Forces (n,) at a time [s]."""
        raise NotImplementedError

    def _write(self, context: Any, output: Any) -> None:
        """Write the forces at the context's time."""
        output.SetFromVector(self.forces_at(context.get_time()))

    def _derivatives(self, times: Array) -> Array:
        """Coordinates, rates and accelerations (3, n, T) by the laws at times (T,) [s]."""
        return np.array([law.derivatives(times)[:3] for law in self._laws]).swapaxes(0, 1)


class DiscreteForces(LawForces):
    """Forces for the discrete update, which makes v_1 = v_0 + h f / J and q_1 = q_0 + h v_1 of a step.

    The joints are on their laws after each step with f = J (s_1 - 2 s_0 + s_-1) / h^2, and in the first step with
    f = J ((s_1 - s_0) / h - s'_0) / h.
    """

    def forces_at(self, time: float) -> Array:
        step = round(time / self._step)
        if step not in self._known:
            steps = np.arange(step, step + STEPS_TOGETHER)
            times = self._step * np.maximum(np.arange(step - 1, step + STEPS_TOGETHER + 1), 0)
            rates = np.diff(self._derivatives(times)[0]) / self._step
            if step == 0:
                rates[:, 0] = self._derivatives(np.zeros(1))[1, :, 0]
            forces = self._inertias * (np.diff(rates) / self._step).T
            self._known = dict(zip(steps.tolist(), forces, strict=True))
        return self._known[step]


class ContinuousForces(LawForces):
    """Forces for an integrator, f = J (s'' + c + d (t - t_0)) in the step from t_0 on.

    The integrator takes the joints along their laws but for its own error. What is left, e of a coordinate and e' of
    its rate, is gone after the next step with c h + d h^2 / 2 = -e' and e' h + c h^2 / 2 + d h^3 / 6 = -e.
    """

    def __init__(self, laws: Mapping[str, DriveLaw], made: DrakePlant, step: float) -> None:
        super().__init__(laws, made, step)
        self._joints = [made.joints[name] for name in laws]
        self._begin, self._constant, self._linear = 0.0, np.zeros(len(laws)), np.zeros(len(laws))

    def forces_at(self, time: float) -> Array:
        if time not in self._known:  # stages are asked for many times
            own = self._derivatives(np.array([time]))[2, :, 0]
            self._known[time] = self._inertias * (own + self._constant + self._linear * (time - self._begin))
        return self._known[time]

    def correct(self, time: float, coordinates: Array, rates: Array) -> None:
        """Let the next step, from a time [s] on, lead from Drake's coordinates (nq,) and rates (nv,) to the laws."""
        (places, speeds), h = self._derivatives(np.array([time]))[:2, :, 0], self._step
        off = coordinates[[one.joint.position_start() for one in self._joints]]
        off = off + [one.reference for one in self._joints] - places
        slip = rates[[one.joint.velocity_start() for one in self._joints]] - speeds
        self._begin, self._known = time, {}
        self._constant, self._linear = -6.0 * off / h**2 - 4.0 * slip / h, 12.0 * off / h**3 + 6.0 * slip / h**2


class DrakeSimulation:
    """A plant in Drake's simulator, in its state at the start; a call advances it by some steps.

    Attributes:
        made: the plant.
        context: the plant's context.
        done: number of steps made.
        failure: why the run broke off, in Drake's words; empty while it goes on.
    """

    def __init__(
        self, made: DrakePlant, step: float, settings: DrakeSettings, laws: Mapping[str, DriveLaw] | None = None
    ) -> None:
        """Prepare the simulator.

        Args:
            laws: laws of the driven joints by name; without them their flywheels keep their rates.
        """
        self.made, self.done, self.failure, self._step = made, 0, "", step
        self._forces: ContinuousForces | None = None
        plant, system, discrete = made.plant, made.plant, settings.integrator == DISCRETE
        if laws:
            builder = DiagramBuilder()
            builder.AddSystem(plant)
            forces = builder.AddSystem((DiscreteForces if discrete else ContinuousForces)(laws, made, step))
            self._forces = None if discrete else forces
            builder.Connect(forces.get_output_port(), plant.get_actuation_input_port())
            system = builder.Build()
        self._simulator = Simulator(system)
        if not discrete:
            integrator = ResetIntegratorFromFlags(self._simulator, settings.integrator, step)
            integrator.set_maximum_step_size(step)
            integrator.set_target_accuracy(settings.accuracy)
            integrator.set_fixed_step_mode(True)
            # Where Newton's iteration fails Drake halves the step, and again; not without an end.
            integrator.set_requested_minimum_step_size(step / MOST_PARTS)
        self.context = plant.GetMyMutableContextFromRoot(self._simulator.get_mutable_context())

    @property
    def time(self) -> float:
        """The simulator's clock [s]."""
        return float(self._simulator.get_context().get_time())

    def __call__(self, steps: int) -> None:
        for _ in range(1 if self._forces is None else steps):
            if not self.failure:
                self.done += steps if self._forces is None else 1
                self._advance()

    def _advance(self) -> None:
        """Advance to the number of steps done, and keep the reason where that fails."""
        plant, time = self.made.plant, self.time
        if self._forces is not None:
            self._forces.correct(time, plant.GetPositions(self.context), plant.GetVelocities(self.context))
        try:
            self._simulator.AdvanceTo(self.done * self._step)
        except RuntimeError as error:
            self.failure = explain_error(str(error))
            return
        if not np.isfinite(plant.GetPositionsAndVelocities(self.context)).all():
            self.failure = f"not finite at {self.time:.4g} s"
