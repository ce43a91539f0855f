"""MJX, as one of conrod's engines, and bounds on its errors before any run.

Its closures lack dJ/dt v: MJX sets J a = aref, where MuJoCo sets J a + dJ/dt v = aref. So each gap g follows g'' =
-2/c g' - g/c^2 + dJ/dt v, with c the time constant: it opens to c^2 dJ/dt v, after a first step in which nothing has
opened yet and all of dJ/dt v is an error of the acceleration. Steps h along tangents take h/c of that away: each
leaves h^2/2 dJ/dt v less of a gap than the rate h dJ/dt v at its end says. Time is the way of the crank [rad].
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from importlib.metadata import version

import numpy as np

from conrod.engines.capabilities import ExpectedError
from conrod.engines.engine import PIECE, Engine, Machine
from conrod.engines.mjx import rollout
from conrod.engines.mjx.settings import PRESETS, MJXSettings
from conrod.engines.mujoco import dynamics
from conrod.engines.mujoco.closure_errors import Course, followed, largest_point_errors, yielding
from conrod.engines.mujoco.engine import ENGINE as MUJOCO
from conrod.engines.mujoco.law import LEFT_OUT, SECOND_ORDER, ripple
from conrod.engines.mujoco.model import Build, build
from conrod.engines.mujoco.settings import LEAST_STEPS
from conrod.engines.numerics import UNDETERMINED, largest_derivatives
from conrod.exact.motion import Array
from conrod.runs.trajectory import Piece

DIFFERENCE = 1e-5  # [rad], over which rates are differenced: of order two, so to 1e-10
# The largest rate of a gap that opens: h dJ/dt v after a step of two to a time constant, 2/e of that without steps.
STEPPED = math.e / 2.0
LAW = "predicted: gaps of closures that lack dJ/dt v, and Euler's velocity, half a step old; 5 % more"


def expected_error(machine: Machine, settings: MJXSettings, start_angle: float = 0.0) -> ExpectedError:
    """Bounds for Euler in double precision with a constant impedance, for links as bodies that have their weight."""
    if machine.kinematics.change_angles.size:
        return ExpectedError(law=UNDETERMINED)
    if settings.dressing or not settings.gravity or settings.precision == "single":
        return ExpectedError()
    if settings.integrator not in ("Euler", "implicitfast") or settings.solref[0] < LEAST_STEPS * settings.timestep:
        return ExpectedError()
    if settings.solimp[0] != settings.solimp[1] or settings.solref[1] != 1.0:
        return ExpectedError()
    made, step = build(machine, settings), 2.0 * math.pi / settings.steps_per_revolution
    constant = abs(machine.speed) * settings.solref[0]
    course = Course.of(machine, start_angle, step, constant)
    lacking, giving = missing(made, course), yielding(machine, settings, made, course)
    still = np.zeros_like(giving)
    (position, *_), (_, velocity, acceleration) = (
        largest_point_errors(course, followed(course.steps, (still, still), share * lacking + giving, constant))
        for share in (1.0 - step / constant, 1.0)
    )
    stale = 0.5 * step * np.array(largest_derivatives(machine.kinematics, 3)[2:])
    errors = np.array([position, STEPPED * velocity + stale[0], acceleration + stale[1]])
    position, velocity, acceleration = (errors * (1.0 + LEFT_OUT + SECOND_ORDER * errors[0])).tolist()
    varying = ripple(machine, settings.armature)
    return ExpectedError(position, velocity, acceleration, law=LAW, ripple=varying)


def missing(made: Build, course: Course) -> Array:
    """dJ/dt v of all joints (T, 3 n), by the way: how their gaps would accelerate if no joint coordinate did."""
    poses, speeds, _ = course.states
    q, v = made.tree.coordinates(poses), made.tree.rates(poses, speeds)
    before, after = (made.tree.forward(q + side * DIFFERENCE * v, v)[1] for side in (-1.0, 1.0))
    return course.opening([poses, speeds, (after - before) / (2.0 * DIFFERENCE)])


class MJX(Engine[MJXSettings]):
    """MuJoCo's algorithms in JAX, on models that MuJoCo has compiled."""

    name = "mjx"
    version = version("mujoco-mjx")
    presets = PRESETS
    expected_error = staticmethod(expected_error)
    stepper = staticmethod(rollout.stepper)
    reference_loop = staticmethod(rollout.reference_loop)

    def refusal(self, machine: Machine, settings: MJXSettings) -> str | None:
        if machine.kinematics.mechanism.cam_contacts:
            return "mjx looks at every face of a mesh in every step: no cams, which have thousands"
        if settings.autoreset:
            return "mjx does not reset its state"
        if reason := MUJOCO.refusal(machine, settings):
            return reason
        made = build(machine, settings)
        try:
            rollout.put(made, *made.start_state(machine, 0.0), settings.precision == "double")
        except NotImplementedError as lacking:
            return f"mjx lacks what the model has: {lacking}"
        return None

    def run(
        self, machine: Machine, settings: MJXSettings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE
    ) -> Iterator[Piece]:
        made = build(machine, settings)
        recorder = rollout.Recorder(made, settings, *made.start_state(machine, start_angle))
        yield from dynamics.recorded(made, recorder, machine, settings, revolutions, start_angle, steps, self.version)


ENGINE = MJX()
