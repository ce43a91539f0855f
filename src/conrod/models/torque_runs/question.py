"""A run that differs from the exact motion, and what a changed machine would do instead, in coarse steps."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from conrod.exact.dynamics.configuration_series import ConfigurationSeries
from conrod.exact.dynamics.forward import ForwardDynamics
from conrod.exact.motion import Array
from conrod.mechanism.loads import Load, Sampled
from conrod.mechanism.mechanism import Mechanism
from conrod.models.tables.columns import CRANK_ANGLE
from conrod.models.torque_runs.comparison import RunComparison
from conrod.models.torque_runs.exact import CrankStart, Values, quantities_of, start_state
from conrod.models.torque_runs.torque import Torque
from conrod.scenes import Scene

MAX_FIT_TURNS, MAX_FIT_ROWS = 10.0, 150  # turns of the crank, and rows of the table, that causes are fitted to
MAX_FIT_PHASE = 1.5  # [rad], difference of the crank angle beyond which a fit may go astray
MIN_FIT_ROWS = 20
STEP_TURN = 0.05  # largest rotation [rad] of a body in a step of the coarse integration


@dataclass(frozen=True)
class RunQuestion:
    """A run that differs from the exact motion, with all that the exact motion was made of.

    Attributes:
        row_distance: time [s] between two rows of the table.
    """

    run: RunComparison
    scene: Scene
    torque: Torque
    start: CrankStart
    row_distance: float

    @cached_property
    def configurations(self) -> ConfigurationSeries:
        """Configurations of the machine, the same for all masses and loads."""
        return ConfigurationSeries(self.scene.kinematics.mechanism)

    @cached_property
    def first_turns(self) -> RunQuestion:
        """The question on evenly spread rows of the first turns, before the crank is far off."""
        turned = np.abs(self.run.exact[CRANK_ANGLE] - self.run.exact[CRANK_ANGLE][0])
        within = turned <= 2.0 * math.pi * MAX_FIT_TURNS
        if CRANK_ANGLE in self.run.values:
            within &= np.maximum.accumulate(np.abs(self.run.difference(CRANK_ANGLE))) <= MAX_FIT_PHASE
        last = max(int(within.sum()), min(MIN_FIT_ROWS, len(turned)))
        keep = np.unique(np.rint(np.linspace(0, last - 1, min(last, MAX_FIT_ROWS))).astype(int))
        return replace(self, run=self.run.keep_rows(keep))

    def predict(
        self, mechanism: Mechanism | None = None, torque: Torque | None = None, start: CrankStart | None = None,
        later: float = 0.0, extra: Sequence[Load] = (),
    ) -> Values:  # fmt: skip
        """Quantities at the rows, or later [s] but not before the start, by coarse integration of a changed machine."""
        machine = mechanism or self.scene.kinematics.mechanism
        load = (torque or self.torque).acts_on(machine)
        dynamics = ForwardDynamics(replace(machine, loads=(*machine.loads, load, *extra)), self.configurations)
        states = _coarse_states(
            dynamics, start_state(self.scene, dynamics, start or self.start), np.maximum(self.run.times + later, 0.0)
        )
        poses, rates, accelerations = (np.array(part) for part in zip(*states, strict=True))
        return quantities_of(self.scene, poses, rates, accelerations)


def _coarse_states(
    dynamics: ForwardDynamics, start: tuple[float, float], times: Array
) -> Iterator[tuple[Array, Array, Array]]:
    """Yield poses, rates and accelerations at times (T,) [s], by Runge and Kutta's method of order 4."""
    now, state = 0.0, np.array([*start, 0.0])
    kinks = np.array([t for load in dynamics.loads if isinstance(load.law, Sampled) for t in load.law.kinks])
    for time in times:
        for stop in (*kinks[(kinks > now) & (kinks < time)], time):
            state = _step_to(dynamics, now, state, float(stop))
            now = float(stop)
        dynamics.enter_piece(None)
        poses, tangent, curvature = dynamics.reduced.poses_with_derivatives(float(state[0]))
        rate, acceleration = float(state[1]), float(dynamics.state_derivative(now, state)[1])
        yield poses, tangent * rate, tangent * acceleration + curvature * rate * rate


def _step_to(dynamics: ForwardDynamics, now: float, state: Array, stop: float) -> Array:
    """Integrate a state up to a time [s] without a jump of forces before it, in steps of at most `STEP_TURN`."""
    slope, scale = dynamics.state_derivative, STEP_TURN * dynamics.reduced.configurations.curve.unit
    dynamics.enter_piece(0.5 * (now + stop))
    while now < stop:
        first = slope(now, state)
        fastest = abs(float(first[0])) + math.sqrt(2.0 * scale * abs(float(first[1])))
        steps = max(1, math.ceil((stop - now) * fastest / scale))
        step = (stop - now) / steps
        half = slope(now + 0.5 * step, state + 0.5 * step * first)
        again = slope(now + 0.5 * step, state + 0.5 * step * half)
        last = slope(now + step, state + step * again)
        state = state + step / 6.0 * (first + 2.0 * half + 2.0 * again + last)
        now = stop if steps == 1 else now + step
    return state
