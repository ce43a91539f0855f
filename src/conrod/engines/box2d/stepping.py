"""Steps of a Box2D world whose crank is turned by its step's index."""

from __future__ import annotations

import math

import numpy as np

from conrod.engines.box2d.model import build
from conrod.engines.box2d.settings import Box2DSettings
from conrod.engines.engine import Machine, run_of
from conrod.engines.reference_loop import REFERENCE
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Prismatic

TURN = 2.0 * math.pi


class Stepper:
    """A machine in the exact state of a crank angle [rad]; calling it advances it by so many steps.

    The engine sums speed x step, in single precision; counted steps keep the crank where it belongs. Its angle is
    written without whole turns, which would take digits from it, unless a slide holds another link's turn to it.
    """

    def __init__(self, machine: Machine, settings: Box2DSettings, angle: float) -> None:
        poses, slopes = machine.kinematics.derivatives(np.array([angle]), 1)
        self.made = build(machine.kinematics.mechanism, settings, poses[0], slopes[0] * machine.speed)
        mechanism = self.made.mechanism
        self._start, self._spin = mechanism.crank_turn(angle), mechanism.driver.sense * machine.speed
        self._settings, self._steps, self._whole = settings, 0, 0.0
        self._counted = not any(isinstance(joint, Prismatic) for joint in mechanism.joints_on(mechanism.crank))
        self._crank = mechanism.body_index[mechanism.crank]

    def __call__(self, steps: int) -> None:
        crank, step, settings = self.made.crank, self.made.world.Step, self._settings
        length, iterations = settings.timestep, (settings.velocity_iterations, settings.position_iterations)
        for _ in range(steps):
            turn = self._start + self._spin * length * self._steps
            self._whole = TURN * round(turn / TURN) if self._counted else 0.0
            crank.angle = turn - self._whole
            self._steps += 1
            step(length, *iterations)

    def recorded(self, steps: int) -> tuple[Array, Array]:
        """Centres of gravity with turns [m, rad], and their rates, after each of so many steps; each (steps, 3 n).

        They are not numbers where the engine did not get to.
        """
        centres, rates = np.full((2, steps, 3 * len(self.made.bodies)), math.nan)
        for k in range(steps):
            try:
                self(1)
            except AssertionError:  # which Box2D's own checks are raised as
                break
            centres[k], rates[k] = self.state()
        return centres, rates

    def state(self) -> tuple[Array, Array]:
        """Centres of gravity with turns (3 n,), and their rates, as they are now."""
        scale, states = self.made.scale, list[tuple[float, ...]]()
        for body in self.made.bodies:
            place, rate = body.worldCenter, body.linearVelocity
            states.append(
                (place[0] / scale, place[1] / scale, body.angle, rate[0] / scale, rate[1] / scale, body.angularVelocity)
            )
        found = np.array(states)
        found[self._crank, 2] += self._whole
        return found[:, :3].ravel(), found[:, 3:].ravel()


def stepper(machine: Machine, settings: Box2DSettings) -> Stepper:
    """A machine in the exact state of its start, with nothing recorded."""
    return Stepper(machine, settings, run_of(machine, 1, 1.0)[0])


def reference_loop() -> Stepper:
    """The slider-crank at its start, 1000 steps a turn."""
    return Stepper(REFERENCE, Box2DSettings.stock(REFERENCE, 1000), 0.0)
