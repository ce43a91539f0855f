"""Exact free and torque-driven motion of a mechanism: an ordinary differential equation in one coordinate.

The coordinate is the arc length s of the configuration curve (`conrod.exact.dynamics.configuration_series`), which is
regular at a crank's dead centres. With the reduced inertia I(s) and potential V(s), and Q(s, s', t) the force along s
of loads without a potential,

    I s'' + I' s'^2 / 2 = -V' + Q.

Integrated by the Runge-Kutta method of order 8 of Dormand and Prince in SciPy. The work of Q is integrated beside the
motion, so that the energy balance checks both.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.dynamics import coordinate_jet
from conrod.exact.dynamics.configuration_series import ConfigurationSeries
from conrod.exact.dynamics.integration import EventIntegrator, kink_events
from conrod.exact.dynamics.reduced_dynamics import ReducedDynamics, ReducedState
from conrod.exact.joint_equations import pose_jets
from conrod.exact.motion import Array
from conrod.mechanism.loads import Sampled, TimePulse
from conrod.mechanism.mechanism import Mechanism

MIN_TURN_DERIVATIVE = 1e-9  # rotation of a body by arc length; below it the body does not turn
BALANCE_TOLERANCE = 1e-12  # net force over the sum of the sizes of all forces, below which a rest is an exact balance
# Largest rotation [rad] of every body in one step. Drift of energy with and without this limit, in about the same time:
# a cam of law 3-4-5 in 10 s 1e-13, 1.4e-11; a saw at 500 rpm in 3 s 2e-13, 5e-12.
MAX_STEP_TURN = 0.02
# Of `crank_start`: Newton steps, and the largest of them [rad].
MAX_NEWTON_STEPS, MAX_NEWTON_TURN = 200, 0.2
RATE_TOLERANCE = 1e-6  # of the largest rate, for given rates of several bodies that the joints couple


@dataclass(frozen=True)
class FreeMotion:
    """An exact motion without a prescribed drive, at given times.

    Attributes:
        poses, rates, accelerations: of all bodies, (T, 3 n).
        crossings: times [s] at which the motion passed a crossing of branches, on its smooth continuation.
    """

    times: Array  # (T,) [s]
    poses: Array
    rates: Array
    accelerations: Array
    energy: Array  # kinetic and potential (T,) [J]
    work: Array  # of the loads that are no potential (T,) [J]
    along: Array  # arc length (T,), without unit
    crossings: tuple[float, ...]
    scale: float  # largest energy that took part [J]

    @property
    def drift(self) -> float:
        """Largest error of the energy balance over the largest kinetic energy or change of potential energy."""
        balance = self.energy - self.work
        return float(np.abs(balance - balance[0]).max()) / self.scale

    @property
    def continuation(self) -> str:
        """Sentence that the motion continues smoothly where branches cross; empty if none cross."""
        if not self.crossings:
            return ""
        shown = ", ".join(f"{time:.6g}" for time in self.crossings[:4]) + (", ..." if self.crossings[4:] else "")
        return (
            f"branches of the motion cross where the linkage is at t = {shown} s; the motion is the smooth continuation"
        )


class ForwardDynamics:
    """Motion of one mechanism under its weight, its constant forces and its loads.

    Args:
        configurations: as in `ReducedDynamics`.
    """

    def __init__(self, mechanism: Mechanism, configurations: ConfigurationSeries | None = None) -> None:
        self.mechanism, self.loads = mechanism, mechanism.loads
        self.reduced = ReducedDynamics(mechanism, configurations)
        self._driven = [load.law for load in self.loads if not load.conservative]
        self._piece: float | None = None  # [s], an instant between the same two jumps of held forces as now

    def motion(self, times: Array, rates: Mapping[str, float], start: tuple[float, float] | None = None) -> FreeMotion:
        """Integrate the motion from the start poses.

        Args:
            times: (T,) [s], growing from 0.
            rates: turn rates of bodies at time 0 [rad/s], counter-clockwise; one determines all, none means rest.
            start: arc length and its rate at time 0, of `crank_start`; None for the start poses, at those rates.

        Raises:
            InvalidInput: the joints do not allow the rates, the mechanism rests where its loads cannot move it, a
                force is not finite, or moving parts have no inertia.
        """
        mechanism = self.mechanism
        times = np.asarray(times, dtype=float)
        if not (len(times) and np.isfinite(times).all() and times[0] >= 0.0 and (np.diff(times) > 0.0).all()):
            raise InvalidInput(f"{mechanism.name}: times must be finite and grow from 0 on")
        along, rate = (0.0, self.start_rate(rates)) if start is None else start
        if rate == 0.0:
            self._check_rest(along)
        pulses = [load.law for load in self.loads if isinstance(load.law, TimePulse)]
        sampled = [load.law for load in self.loads if isinstance(load.law, Sampled)]
        course = EventIntegrator(
            self.state_derivative, self._state_scales(rate, float(times[-1])), kink_events(self.reduced, self.loads),
            {time for pulse in pulses for time in (pulse.start, pulse.stop)}.union(*(law.kinks for law in sampled)),
            MAX_STEP_TURN * self.reduced.configurations.curve.unit, self.enter_piece,
        )  # fmt: skip
        states = course.integrate(times, np.array([along, rate, 0.0]), self.reduced.crossings)
        self.enter_piece(None)
        return self._motion(times, states, tuple(sorted(course.crossing_times)))

    def start_rate(self, given: Mapping[str, float]) -> float:
        """Rate of the arc length at the start [1/s] for given turn rates of bodies [rad/s]; 0 if none is given.

        Raises:
            InvalidInput: a body is unknown, cannot turn at the start, or the joints require another rate.
        """
        tangent = self.reduced.configurations.start.tangent[0]
        derivatives = {}
        for body, rate in given.items():
            if body not in self.mechanism.body_index:
                raise unknown_choice("body with a rate at the start", body, self.mechanism.body_index)
            if not math.isfinite(rate):
                raise InvalidInput(f"rate of {body} at the start = {rate!r} is not a finite number")
            derivatives[body] = float(tangent[3 * self.mechanism.body_index[body] + 2])
            if abs(derivatives[body]) < MIN_TURN_DERIVATIVE and rate != 0.0:
                stands = "stands at a dead centre and cannot turn" if body == self.mechanism.crank else "does not turn"
                raise InvalidInput(f"rate of {body} at the start = {rate:g} rad/s: there it {stands}")
        if not derivatives:
            return 0.0
        teller = max(derivatives, key=lambda body: abs(derivatives[body]))
        along = given[teller] / derivatives[teller] if given[teller] else 0.0
        for body, rate in given.items():
            fitting = along * derivatives[body]
            if abs(rate - fitting) > RATE_TOLERANCE * max(abs(along), abs(rate)):
                raise InvalidInput(
                    f"rate of {body} at the start = {rate:g} rad/s contradicts the joints: with {teller} at "
                    f"{given[teller]:g} rad/s it is {fitting:g} rad/s"
                )
        return along

    def crank_start(self, angle: float, speed: float) -> tuple[float, float]:
        """Arc length and its rate where the crank is at an angle [rad] and a speed [rad/s] in the driver's sense.

        Raises:
            InvalidInput: the crank does not come to the angle, or cannot turn there.
        """
        mechanism = self.mechanism
        sense, turning = mechanism.driver.sense, 3 * mechanism.body_index[mechanism.crank] + 2
        first, along = float(self.reduced.poses_with_derivatives(0.0)[0][turning]), 0.0
        for _ in range(MAX_NEWTON_STEPS):
            poses, tangent, _ = self.reduced.poses_with_derivatives(along)
            slope = sense * float(tangent[turning])
            if abs(slope) < MIN_TURN_DERIVATIVE:
                raise InvalidInput(
                    f"{mechanism.name}: the crank cannot start at {math.degrees(angle):.6g} deg: on the way there it "
                    "stands in a dead centre"
                )
            off = angle - sense * (float(poses[turning]) - first)
            along += off / slope if abs(off) < MAX_NEWTON_TURN else math.copysign(MAX_NEWTON_TURN, off) / slope
            if abs(off) < 1e-14 * max(1.0, abs(angle)):
                break
        return along, speed / slope

    # -- the differential equation -----------------------------------------------------------------------------------

    def enter_piece(self, middle: float | None) -> None:
        """Note an instant [s] within the piece between two jumps of forces that is integrated next; None for none."""
        self._piece = middle

    def state_derivative(self, time: float, state: Array) -> Array:
        """Time derivative of the state (arc length, its rate, work of loads without a potential)."""
        along, rate = state[0].item(), state[1].item()
        acceleration, force = self._acceleration(self.reduced.evaluate(along), rate, time)
        return np.array([rate, acceleration, force * rate])

    def _acceleration(self, at: ReducedState, rate: float, time: float) -> tuple[float, float]:
        """Second derivative of the arc length, and the force along it of the loads without a potential."""
        force = self._force(at, rate, time) if self._driven else 0.0
        return (at.conservative_force + force - 0.5 * at.inertia_derivative * rate * rate) / at.inertia, force

    def _force(self, at: ReducedState, rate: float, time: float) -> float:
        """Force along the arc length of the loads without a potential."""
        total = 0.0
        for law, value, derivative in zip(self._driven, at.load_coordinates, at.load_derivatives, strict=True):
            held = isinstance(law, Sampled) and law.between != "linear" and self._piece is not None
            instant = np.asarray(self._piece if held else time)
            total += float(law.force(np.asarray(value), np.asarray(derivative * rate), instant)) * float(derivative)
        if not math.isfinite(total):
            raise InvalidInput(f"{self.mechanism.name}: a force is not finite at t = {time:g} s")
        return total

    def _check_rest(self, along: float) -> None:
        """Refuse a start at rest in exact balance: rounding would decide when and which way it moves."""
        if any(isinstance(load.law, TimePulse | Sampled) for load in self.loads):
            return
        at, mechanism, total = self.reduced.evaluate(along), self.mechanism, 0.0
        point, tangent, _ = self.reduced.poses_with_derivatives(along)
        bodies = pose_jets(mechanism, [point[None], tangent[None]])
        # Weights and constant forces, times how far their bodies go by the arc length.
        for body in mechanism.bodies:
            x, y = (float(np.ravel(j.coefficients[1])[0]) for j in bodies[body.name].point(body.centre_of_gravity))
            force = body.mass * math.hypot(*mechanism.gravity) + math.hypot(*mechanism.constant_force_on(body.name))
            total += force * math.hypot(x, y)
        # Forces of the loads at rest, times a body's size; torques as they are.
        for load in self.loads:
            value, derivative = (np.ravel(c) for c in coordinate_jet(load.along, bodies).coefficients)
            size = 1.0 if load.unit == "rad" else float(self.reduced.configurations.curve.scale[0])
            total += size * abs(float(load.law.force(value, 0.0 * derivative, np.zeros(1))[0]))
        if abs(at.conservative_force + self._force(at, 0.0, 0.0)) < BALANCE_TOLERANCE * total:
            raise InvalidInput(
                f"{mechanism.name}: at rest in a dead centre, or where its weight and loads are in balance, which "
                "nothing ends; start beside it, or in motion"
            )

    def _state_scales(self, rate: float, time: float) -> Array:
        """Sizes of arc length, its rate and work, which absolute tolerances refer to."""
        at, ahead = self.reduced.evaluate(0.0), self.reduced.configurations.ahead[0].stop
        push = abs(at.conservative_force) + abs(self._force(at, rate, 0.0))
        # A sampled force may be 0 at first.
        push += sum(
            float(np.abs(law.sizes).max()) * abs(float(derivative))
            for law, derivative in zip(self._driven, at.load_derivatives, strict=True)
            if isinstance(law, Sampled)
        )
        energy = max(at.inertia * rate * rate, push * min(ahead, push * time * time / at.inertia), 1e-20)
        return np.array([self.reduced.configurations.curve.unit, math.sqrt(energy / at.inertia), energy])

    # -- the motion --------------------------------------------------------------------------------------------------

    def _motion(self, times: Array, states: Array, crossings: tuple[float, ...]) -> FreeMotion:
        """Poses, rates, accelerations and energies at times from integrated states (T, 3)."""
        along, rate, work = states.T
        shape = (len(times), 3 * len(self.mechanism.bodies))
        poses, rates, accelerations = (np.empty(shape) for _ in range(3))
        kinetic, potential = np.empty(len(times)), np.empty(len(times))
        for k, (s, v, t) in enumerate(zip(along, rate, times, strict=True)):
            at = self.reduced.evaluate(float(s))
            kinetic[k], potential[k] = 0.5 * at.inertia * v * v, at.potential
            acceleration, _ = self._acceleration(at, float(v), float(t))
            poses[k], tangent, curvature = self.reduced.poses_with_derivatives(float(s))
            rates[k], accelerations[k] = tangent * v, tangent * acceleration + curvature * v * v
        scale = float(max(kinetic.max(), np.ptp(potential))) or 1.0
        return FreeMotion(times, poses, rates, accelerations, kinetic + potential, work, along, crossings, scale)
