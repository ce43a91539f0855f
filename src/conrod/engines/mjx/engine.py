"""The MJX engine, and bounds on its errors before any run.

MJX's closures lack dJ/dt v: MJX sets J a = aref, where MuJoCo sets J a + dJ/dt v = aref. So each gap g obeys

    g'' + (2/c) g' + g/c^2 = dJ/dt v,    c = solref[0] |omega|

with the crank's travel [rad] as independent variable (`mujoco.error_bound`): it opens to c^2 dJ/dt v, after a first
step in which nothing has opened yet and all of dJ/dt v is an error of the acceleration. Steps h along tangents reduce
that by the share h/c: each leaves a gap that is h^2/2 dJ/dt v smaller than its end rate h dJ/dt v implies.

Compiled functions serve all machines of one layout, whatever their sizes. As in MuJoCo, the sensors after a step belong
to the state before it; but under RK4 to the last of its stages.
"""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import redirect_stdout
from importlib.metadata import version
from typing import Any

import jax
import jax.numpy as jnp
import mujoco
import numpy as np

from conrod.comparison.trajectory import Piece
from conrod.engines.capabilities import ExpectedError
from conrod.engines.engine import PIECE_STEPS, Engine, Machine, run_extent
from conrod.engines.mjx import MJX_PRESETS, MJXSettings
from conrod.engines.mjx.compiled_functions import keep_compiled_functions
from conrod.engines.mujoco import MIN_TIME_CONSTANT_STEPS, dynamics
from conrod.engines.mujoco.engine import MUJOCO_ENGINE as MUJOCO
from conrod.engines.mujoco.error_bound import (
    PREDICTION_MARGIN,
    SECOND_ORDER_MARGIN,
    DrivenCourse,
    compliance_acceleration,
    integrate_gaps,
    largest_point_errors,
    largest_rotation_errors,
    speed_ripple_bound,
    states_with_gaps,
)
from conrod.engines.mujoco.model import MuJoCoModel, build
from conrod.engines.numerics import CRANK_SAMPLES, NO_BOUND_AT_CHANGE_POINT, largest_derivatives
from conrod.exact.link_rotations import ROTATIONS, largest_rotation
from conrod.exact.motion import Array

with redirect_stdout(io.StringIO()):  # it prints that it has no Warp
    from mujoco import mjx

keep_compiled_functions(jax.config)
BLOCK_SAMPLES = 512  # recorded at a time: length of the arrays of the compiled functions


def take_step(model: Any, data: Any) -> Any:
    """Data after a step, with their types kept: in double precision MJX also widens some of its integers."""
    return jax.tree.map(lambda after, before: after.astype(before.dtype), mjx.step(model, data), data)


def _record_block(model: Any, data: Any, samples: Any) -> tuple[Any, Any, Any]:
    """Data after some steps, with states (BLOCK_SAMPLES, nq + nv) and sensors (BLOCK_SAMPLES, ..) before each."""

    def step(k: Any, carried: tuple[Any, Any, Any]) -> tuple[Any, Any, Any]:
        now, states, sensors = carried
        states = states.at[k].set(jnp.concatenate([now.qpos, now.qvel]))
        after = take_step(model, now)
        read = mjx.forward(model, now) if model.opt.integrator == mjx.IntegratorType.RK4 else after
        return after, states, sensors.at[k].set(read.sensordata)

    kept = (jnp.zeros((BLOCK_SAMPLES, model.nq + model.nv)), jnp.zeros((BLOCK_SAMPLES, model.nsensordata)))
    found: tuple[Any, Any, Any] = jax.lax.fori_loop(0, samples, step, (data, *kept))
    return found


def _advance_data(model: Any, data: Any, steps: Any) -> Any:
    """Data after some steps, with nothing recorded."""
    return jax.lax.fori_loop(0, steps, lambda _, now: take_step(model, now), data)


record_block, advance = jax.jit(_record_block), jax.jit(_advance_data)


def record_samples(of: Any, model: Any, data: Any, samples: int, double: bool) -> tuple[Any, Array, Array]:
    """Data after T samples, with states (.., T, nq + nv) and sensor data (.., T, ..) of each, in double precision.

    Args:
        of: `record_block` for one machine, or its `vmap` over several.
    """
    found = []
    for done in range(0, samples, BLOCK_SAMPLES):
        count = min(BLOCK_SAMPLES, samples - done)
        with jax.enable_x64(double):
            data, *values = of(model, data, count)
        found.append([np.asarray(value[..., :count, :], dtype=float) for value in values])
    states, sensors = (np.concatenate(values, axis=-2) for values in zip(*found, strict=True))
    return data, states, sensors


class MJXRecorder(dynamics.MuJoCoRecorder):
    """Steps a machine from a state of its model and returns its samples; the engine has no warnings."""

    warnings: Mapping[str, int] = {}

    def __init__(self, made: MuJoCoModel, settings: MJXSettings, coordinates: Array, rates: Array) -> None:
        self._timestep, self._double, self._steps = settings.timestep, settings.precision == "double", 0
        self._model, self._data = put_on_device(made, coordinates, rates, self._double)

    def next_samples(self, samples: int) -> tuple[Array, Array]:
        """The next T samples: states (T, 1 + nq + nv), clock first, and sensor data (T, ..), in double precision."""
        self._data, states, sensors = record_samples(record_block, self._model, self._data, samples, self._double)
        # From the step index: a sum of steps in single precision stands still.
        clock = self._timestep * np.arange(self._steps, self._steps + samples)
        self._steps += samples
        return np.column_stack([clock, states]), sensors


def put_on_device(made: MuJoCoModel, coordinates: Array, rates: Array, double: bool) -> tuple[Any, Any]:
    """Model and data as MJX's objects, in a state (nq,), (nv,).

    Raises:
        NotImplementedError: MJX says what it lacks of the model.
    """
    data = mujoco.MjData(made.model)
    data.qpos[:], data.qvel[:] = coordinates, rates
    with jax.enable_x64(double):
        return mjx.put_model(made.model), mjx.put_data(made.model, data)


def stepper(machine: Machine, settings: MJXSettings) -> Callable[[int], None]:
    """A machine in the exact state of its start; a call advances it by a number of steps."""
    made = build(machine, settings, sensors=False)
    double = settings.precision == "double"
    return _compiled_stepper(
        *put_on_device(made, *made.start_state(machine, run_extent(machine, 1, 1.0)[0]), double), double
    )


def reference_loop() -> Callable[[int], None]:
    """Stepper of MuJoCo's fixed slider-crank, the unit of timings, in single precision."""
    loop = MUJOCO.reference_loop()
    return _compiled_stepper(mjx.put_model(loop.model), mjx.put_data(loop.model, loop.data), double=False)


def _compiled_stepper(model: Any, data: Any, double: bool) -> Callable[[int], None]:
    """Return a compiled function that advances the data by a number of steps at each call."""

    def call(steps: int) -> None:
        nonlocal data
        with jax.enable_x64(double):
            data = jax.block_until_ready(advance(model, data, steps))

    call(0)
    return call


# -- the engine, and its law -------------------------------------------------------------------------------------------


RATE_DIFFERENCE_STEP = 1e-5  # [rad], of the central difference of rates: order two, so exact to 1e-10
# Largest rate of an opening gap with two steps per time constant, h dJ/dt v, over that of the equation, 2/e of it.
STEPPED_RATE_RATIO = math.e / 2.0
LAW = (
    "predicted: gaps of closures that lack dJ/dt v, and Euler's velocity, half a step old; "
    "5 % and ten times the error itself more"
)


def expected_error(machine: Machine, settings: MJXSettings, start_angle: float = 0.0) -> ExpectedError:
    """Bounds on the errors of a run: of Euler in double precision, with constant impedance.

    There are none for other settings, for machines without weight, or for models with edits.
    """
    if machine.kinematics.change_angles.size:
        return ExpectedError(law=NO_BOUND_AT_CHANGE_POINT)
    if settings.dressing or not settings.gravity or settings.precision == "single":
        return ExpectedError()
    if (
        settings.integrator not in ("Euler", "implicitfast")
        or settings.solref[0] < MIN_TIME_CONSTANT_STEPS * settings.timestep
    ):
        return ExpectedError()
    if settings.solimp[0] != settings.solimp[1] or settings.solref[1] != 1.0:
        return ExpectedError()
    made, step = build(machine, settings), 2.0 * math.pi / settings.steps_per_revolution
    constant = abs(machine.speed) * settings.solref[0]
    course = DrivenCourse.sample_course(machine, start_angle, step, constant)
    lacking, giving = missing_acceleration(made, course), compliance_acceleration(machine, settings, made, course)
    still = np.zeros_like(giving)
    lagging, exact = (
        integrate_gaps(course.steps, (still, still), share * lacking + giving, constant)
        for share in (1.0 - step / constant, 1.0)
    )
    derivatives = machine.kinematics.derivatives(machine.kinematics.angles(CRANK_SAMPLES), 3)
    turned = [largest_rotation(machine.kinematics, derivative[:, 2::3]) for derivative in derivatives]
    moved = [states_with_gaps(course, gaps) for gaps in (lagging, exact)]
    points = (largest_point_errors(course, gaps) for gaps in (lagging, exact))
    links = (largest_rotation_errors(course, states) for states in moved)
    bounds = []
    for (first, rest), sizes in ((points, largest_derivatives(machine.kinematics, 3)), (links, turned)):
        stale = 0.5 * step * np.array(sizes[2:])
        errors = np.array([first[0], STEPPED_RATE_RATIO * rest[1] + stale[0], rest[2] + stale[1]])
        bounds.append((errors * (1.0 + PREDICTION_MARGIN + SECOND_ORDER_MARGIN * errors[0])).tolist())
    (position, velocity, acceleration), of_links = bounds
    varying = speed_ripple_bound(machine, settings.armature)
    by_name = dict(zip(ROTATIONS, of_links, strict=True))
    return ExpectedError(position, velocity, acceleration, law=LAW, ripple=varying, **by_name)


def missing_acceleration(made: MuJoCoModel, course: DrivenCourse) -> Array:
    """The term dJ/dt v of all joints (T, 3 n) per unit of travel squared, by central difference.

    It is how the joints' gaps would accelerate with constant joint rates.
    """
    poses, speeds, _ = course.states
    q, v = made.tree.coordinates(poses), made.tree.rates(poses, speeds)
    before, after = (made.tree.forward_kinematics(q + side * RATE_DIFFERENCE_STEP * v, v)[1] for side in (-1.0, 1.0))
    return course.joint_gaps([poses, speeds, (after - before) / (2.0 * RATE_DIFFERENCE_STEP)])


class MJX(Engine[MJXSettings]):
    """MuJoCo's algorithms in JAX, on models that MuJoCo has compiled."""

    name = "mjx"
    version = version("mujoco-mjx")
    presets = MJX_PRESETS
    expected_error = staticmethod(expected_error)
    stepper = staticmethod(stepper)
    reference_loop = staticmethod(reference_loop)

    def refusal(self, machine: Machine, settings: MJXSettings) -> str | None:
        if machine.kinematics.mechanism.cam_contacts:
            return "mjx looks at every face of a mesh in every step: no cams, which have thousands"
        if settings.rounded_state or settings.autoreset:
            return "mjx neither rounds its state nor resets it"
        if reason := MUJOCO.refusal(machine, settings):
            return reason
        made = build(machine, settings)
        try:
            put_on_device(made, *made.start_state(machine, 0.0), settings.precision == "double")
        except NotImplementedError as lacking:
            return f"mjx lacks what the model has: {lacking}"
        return None

    def run(
        self,
        machine: Machine,
        settings: MJXSettings,
        revolutions: float,
        start_angle: float = 0.0,
        steps: int = PIECE_STEPS,
    ) -> Iterator[Piece]:
        made = build(machine, settings)
        recorder = MJXRecorder(made, settings, *made.start_state(machine, start_angle))
        yield from dynamics.record_run(made, recorder, machine, settings, revolutions, start_angle, steps, self.version)


MJX_ENGINE = MJX()
