"""Free and torque-driven motion of a mechanism, exactly: an ordinary differential equation in one coordinate.

The coordinate is the arc length of the curve of configurations (`conrod.exact.dynamics.configurations`), in which
nothing is singular at a crank's dead centres. Integrated by the Runge-Kutta method of order 8 of Dormand and Prince in
SciPy. The energy that loads take or give is integrated beside the motion, so that the balance audits both.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.dynamics import coordinate_jet
from conrod.exact.dynamics.integration import Course, kinks
from conrod.exact.dynamics.line import At, Line
from conrod.exact.joint_equations import pose_jets
from conrod.exact.motion import Array
from conrod.mechanism.loads import TimePulse
from conrod.mechanism.mechanism import Mechanism

STANDS = 1e-9  # of a body's turn by the arc length: below it, it does not turn
# Of what weight and loads would push with together if none held against another, nor a dead centre against them.
BALANCED = 1e-12
# Of a radian that every body turns, in one step of the integrator. Drift of energy with it, and without: a cam of law
# 3-4-5 in 10 s 1e-13, 1.4e-11; a saw at 500 rpm in 3 s 2e-13, 5e-12; in about the same time.
FARTHEST = 0.02
FITS = 1e-6  # of the largest rate, what given rates of several bodies may leave


@dataclass(frozen=True)
class FreeMotion:
    """An exact motion at given times.

    Attributes:
        poses, rates, accelerations: of all bodies, (T, 3 n).
        crossings: times [s] at which configurations were passed where branches cross, on the smooth continuation.
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
        """Largest error of the balance of energy, against the largest kinetic energy or change of the potential one."""
        balance = self.energy - self.work
        return float(np.abs(balance - balance[0]).max()) / self.scale

    @property
    def continuation(self) -> str:
        """In words, that the motion went on smoothly where it had a choice; empty where it had none."""
        if not self.crossings:
            return ""
        shown = ", ".join(f"{time:.6g}" for time in self.crossings[:4]) + (", ..." if self.crossings[4:] else "")
        return (
            f"branches of the motion cross where the linkage is at t = {shown} s; the motion is the smooth continuation"
        )


class ForwardDynamics:
    """One mechanism under its weight, its constant forces and its loads."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.loads = mechanism, mechanism.loads
        self.line = Line(mechanism)
        self._driven = [load.law for load in self.loads if not load.conservative]

    def motion(self, times: Array, rates: Mapping[str, float]) -> FreeMotion:
        """The motion from the start poses.

        Args:
            times: (T,) [s], growing from 0.
            rates: turn rates of bodies at time 0 [rad/s], counter-clockwise; one determines all, none is a rest.

        Raises:
            InvalidInput: the joints do not allow the rates, the mechanism rests where its loads cannot move it, a
                force is not finite, or what moves has no inertia.
        """
        mechanism = self.mechanism
        times = np.asarray(times, dtype=float)
        if not (len(times) and np.isfinite(times).all() and times[0] >= 0.0 and (np.diff(times) > 0.0).all()):
            raise InvalidInput(f"{mechanism.name}: times must be finite and grow from 0 on")
        start = np.array([0.0, self.start_rate(rates), 0.0])
        if start[1] == 0.0:
            self._check_rest()
        pulses = [load.law for load in self.loads if isinstance(load.law, TimePulse)]
        course = Course(
            self._rates, self._measures(start[1], float(times[-1])), kinks(self.line, self.loads),
            {time for pulse in pulses for time in (pulse.start, pulse.stop)},
            FARTHEST * self.line.configurations.curve.unit,
        )  # fmt: skip
        states = course.run(times, start, self.line.crossings)
        return self._motion(times, states, tuple(sorted(course.passed)))

    def start_rate(self, given: Mapping[str, float]) -> float:
        """Rate of the arc length at the start [1/s], of given turn rates of bodies [rad/s]; 0 where none is given.

        Raises:
            InvalidInput: a body is unknown, cannot turn at the start, or the joints give it another rate.
        """
        tangent = self.line.configurations.start.tangent[0]
        slopes = {}
        for body, rate in given.items():
            if body not in self.mechanism.body_index:
                raise unknown_choice("body with a rate at the start", body, self.mechanism.body_index)
            if not math.isfinite(rate):
                raise InvalidInput(f"rate of {body} at the start = {rate!r} is not a finite number")
            slopes[body] = float(tangent[3 * self.mechanism.body_index[body] + 2])
            if abs(slopes[body]) < STANDS and rate != 0.0:
                stands = "stands at a dead centre and cannot turn" if body == self.mechanism.crank else "does not turn"
                raise InvalidInput(f"rate of {body} at the start = {rate:g} rad/s: there it {stands}")
        if not slopes:
            return 0.0
        teller = max(slopes, key=lambda body: abs(slopes[body]))
        along = given[teller] / slopes[teller] if given[teller] else 0.0
        for body, rate in given.items():
            fitting = along * slopes[body]
            if abs(rate - fitting) > FITS * max(abs(along), abs(rate)):
                raise InvalidInput(
                    f"rate of {body} at the start = {rate:g} rad/s contradicts the joints: with {teller} at "
                    f"{given[teller]:g} rad/s it is {fitting:g} rad/s"
                )
        return along

    # -- the differential equation -----------------------------------------------------------------------------------

    def _rates(self, time: float, state: Array) -> Array:
        rate = float(state[1])
        at = self.line.at(float(state[0]))
        force = self._force(at, rate, time)
        return np.array([rate, (at.descent + force - 0.5 * at.slope * rate * rate) / at.inertia, force * rate])

    def _force(self, at: At, rate: float, time: float) -> float:
        """The force along the arc length of loads that are no potential."""
        total = 0.0
        for law, value, slope in zip(self._driven, at.values, at.rates, strict=True):
            total += float(law.force(np.asarray(value), np.asarray(slope * rate), np.asarray(time))) * float(slope)
        if not math.isfinite(total):
            raise InvalidInput(f"{self.mechanism.name}: a force is not finite at t = {time:g} s")
        return total

    def _check_rest(self) -> None:
        """Refuse a rest that only an exact balance keeps: rounding would decide which way it goes, and how soon."""
        if any(isinstance(load.law, TimePulse) for load in self.loads):
            return
        at, mechanism, total = self.line.at(0.0), self.mechanism, 0.0
        point, tangent, _ = self.line.point(0.0)
        bodies = pose_jets(mechanism, [point[None], tangent[None]])
        # Weights and constant forces, times how far their bodies go by the arc length.
        for body in mechanism.bodies:
            x, y = (float(np.ravel(j.coefficients[1])[0]) for j in bodies[body.name].point(body.centre_of_gravity))
            force = body.mass * math.hypot(*mechanism.gravity) + math.hypot(*mechanism.push_on(body.name))
            total += force * math.hypot(x, y)
        # Forces of the loads at rest, times a body's size; torques as they are.
        for load in self.loads:
            value, slope = (np.ravel(c) for c in coordinate_jet(load.along, bodies).coefficients)
            size = 1.0 if load.unit == "rad" else float(self.line.configurations.curve.scale[0])
            total += size * abs(float(load.law.force(value, 0.0 * slope, np.zeros(1))[0]))
        if abs(at.descent + self._force(at, 0.0, 0.0)) < BALANCED * total:
            raise InvalidInput(
                f"{mechanism.name}: at rest in a dead centre, or where its weight and loads are in balance, which "
                "nothing ends; start beside it, or in motion"
            )

    def _measures(self, rate: float, time: float) -> Array:
        """Sizes that arc length, its rate and work are measured by where they are 0."""
        at, ahead = self.line.at(0.0), self.line.configurations.ahead[0].stop
        push = abs(at.descent) + abs(self._force(at, rate, 0.0))
        energy = max(at.inertia * rate * rate, push * min(ahead, push * time * time / at.inertia), 1e-20)
        return np.array([self.line.configurations.curve.unit, math.sqrt(energy / at.inertia), energy])

    # -- the motion --------------------------------------------------------------------------------------------------

    def _motion(self, times: Array, states: Array, crossings: tuple[float, ...]) -> FreeMotion:
        along, rate, work = states.T
        shape = (len(times), 3 * len(self.mechanism.bodies))
        poses, rates, accelerations = (np.empty(shape) for _ in range(3))
        kinetic, potential = np.empty(len(times)), np.empty(len(times))
        for k, (s, v, t) in enumerate(zip(along, rate, times, strict=True)):
            at = self.line.at(float(s))
            kinetic[k], potential[k] = 0.5 * at.inertia * v * v, at.potential
            acceleration = self._rates(float(t), np.array([s, v, 0.0]))[1]
            poses[k], tangent, curvature = self.line.point(float(s))
            rates[k], accelerations[k] = tangent * v, tangent * acceleration + curvature * v * v
        scale = float(max(kinetic.max(), np.ptp(potential))) or 1.0
        return FreeMotion(times, poses, rates, accelerations, kinetic + potential, work, along, crossings, scale)
