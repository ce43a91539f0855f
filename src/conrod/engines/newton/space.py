"""Newton on machines in space: its solvers stepped, driven joints written at each step, points read from its bodies.

Newton keeps its state in single precision. A driven coordinate that Newton sums up itself drifts (by 1e-4 rad in two
turns of 1000 steps), so the law's coordinate and rate are written before each step, without whole turns. SolverMuJoCo
carries a driven joint through the step by a flywheel; for SolverXPBD, which knows no armature, its body is kinematic
and has the pose of the step's end.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import newton
import numpy as np
import warp

from conrod.comparison.outcome import MAX_JOINT_GAP
from conrod.engines.body_readings import BodyReadings, joint_openings, motion_of_points
from conrod.engines.capabilities import TIMED_REFERENCE
from conrod.engines.newton import MUJOCO, MUJOCO_WARP, NEWTON_PRESETS, STIFF_SOLIMP, XPBD, NewtonSettings
from conrod.engines.newton.translation import translate, translation_refusal
from conrod.engines.space import SpatialRun, SpatialStart
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.mechanism.units import REVOLUTION

BLOCK_STEPS = 1024  # for which laws are evaluated at once
# MuJoCo's tolerance is scaled by the mean inertia, flywheels included: with its default no iteration would be made.
MUJOCO_TOLERANCE = 0.0


def refusal_in_space(start: SpatialStart, preset: str) -> str | None:
    """Return the reason why a preset of Newton is not given a machine in space, or None."""
    if reason := translation_refusal(start.tree):
        return reason
    driven = {joint.name for joint in start.machine.driven}
    if NEWTON_PRESETS[preset](TIMED_REFERENCE, 1000).solver != XPBD:
        return None
    for body in start.tree.bodies[1:]:
        names = {joint.name for joint in body.joints}
        if names & driven and (body.parent or names - driven):
            return f"newton {preset} drives bodies whose joints to the ground are all driven, not {body.name}"
    return None


def solving_device(solver: str) -> str:
    """Name of Warp's device of a solver: a GPU where one is found, and the CPU for MuJoCo's C code."""
    return "cuda:0" if solver != MUJOCO and warp.get_cuda_devices() else "cpu"


class NewtonStepper:
    """A machine in space in Newton that starts in its exact state; a call advances it by some steps.

    Attributes:
        done: number of steps made.
        failure: why the run broke off; empty while it goes on.

    Raises:
        InvalidInput: Newton cannot build the machine, or compile its kernels.
    """

    def __init__(self, start: SpatialStart, preset: str) -> None:
        rule = NEWTON_PRESETS[preset](TIMED_REFERENCE, 1000)  # of a machine in the plane, whose step is another
        settings = NewtonSettings(preset, 2, start.step, rule.solver, rule.stiff, rule.iterations)
        self.start, self.settings = start, settings
        self.done, self.failure = 0, ""
        with explain_failure("build the machine"), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of releases of MuJoCo that Newton was not released with
            self._made = translate(start, settings, solving_device(settings.solver))
            model = self._made.model
            self._solver = make_solver(model, settings)
            self.state, self._next, self._control = model.state(), model.state(), model.control()
            self._law_state = model.state()
            newton.eval_fk(model, model.joint_q, model.joint_qd, self.state)
        self._observed = None
        if settings.solver != XPBD:
            self._observed = self._solver.observables({self._solver.ObservableKind.BODY_QDD})
        self._armatures = model.joint_armature.numpy().copy()

    def __call__(self, steps: int) -> None:
        """Advance by some steps, or until the run breaks off."""
        for first in range(0, steps, BLOCK_STEPS):
            count = min(BLOCK_STEPS, steps - first)
            times = self.start.step * (self.done + np.arange(count + 1.0))
            laws = np.array([law.derivatives(times)[:2] for law in self.start.machine.laws.values()])
            for k in range(count):
                if self.failure:
                    return
                self._drive(laws[:, :, k], laws[:, :, k + 1])
                self._step()

    def readings(self) -> BodyReadings:
        """Poses, rates and accelerations of all bodies; accelerations are of the state before the last step."""
        accelerations = None if self._observed is None else self._observed.body_qdd.numpy().copy()
        return BodyReadings(self.state.body_q.numpy().copy(), self.state.body_qd.numpy().copy(), accelerations)

    def _drive(self, begin: Array, end: Array) -> None:
        """Write the laws' values (D, 2) at a step's begin and end into the driven joints."""
        xpbd = self.settings.solver == XPBD
        target = self._made.model if xpbd else self.state
        coordinates, rates, forces = (one.numpy() for one in (target.joint_q, target.joint_qd, self._control.joint_f))
        joints = self.start.machine.driven
        # A flywheel is given the mean acceleration of the step, by which it arrives at the law's rate.
        mean = (end[:, 1] - begin[:, 1]) / self.start.step
        for (q, v), joint, law, acceleration in zip(
            self._made.driven, joints, end if xpbd else begin, mean, strict=True
        ):
            coordinate = float(law[0]) - joint.reference
            # Whole turns would cost digits.
            coordinates[q] = math.remainder(coordinate, REVOLUTION) if joint.kind == "hinge" else coordinate
            rates[v] = law[1]
            forces[v] = self._armatures[v] * acceleration
        target.joint_q.assign(coordinates)
        target.joint_qd.assign(rates)
        if not xpbd:
            self._control.joint_f.assign(forces)
            return
        newton.eval_fk(target, target.joint_q, target.joint_qd, self._law_state)
        for name in ("body_q", "body_qd"):
            own, prescribed = getattr(self.state, name), getattr(self._law_state, name).numpy()
            values = own.numpy()
            for body in self._made.kinematic:
                values[body] = prescribed[body]
            own.assign(values)

    def _step(self) -> None:
        """Make a step; its first one compiles what is not compiled yet."""
        self.state.clear_forces()
        arguments = (self.state, self._next, self._control, None, self.start.step)
        options = {} if self._observed is None else {"observables": self._observed}
        with explain_failure("make a step"):
            self._solver.step(*arguments, **options)
        self.state, self._next = self._next, self.state
        self.done += 1
        if not np.isfinite(self.state.body_q.numpy()).all():
            self.failure = f"not finite from {self.done * self.start.step:.6g} s on"


@contextmanager
def explain_failure(what: str) -> Iterator[None]:
    """Make one line of whatever Newton or Warp raises inside: kernels that cannot be compiled, say.

    Raises:
        InvalidInput: Newton or Warp has raised an error.
    """
    try:
        yield
    except Exception as error:
        said = (str(error).strip() or type(error).__name__).splitlines()[0]
        raise InvalidInput(f"newton cannot {what}: {said}") from error


def make_solver(model: Any, settings: NewtonSettings) -> Any:
    """Newton's solver of a model with the settings."""
    if settings.solver == XPBD:
        return newton.solvers.SolverXPBD(model, iterations=settings.iterations)
    options: dict[str, Any] = {"integrator": "rk4"} if settings.stiff else {}
    solver = newton.solvers.SolverMuJoCo(
        model, use_mujoco_cpu=settings.solver == MUJOCO, tolerance=MUJOCO_TOLERANCE, disable_contacts=True, **options
    )
    if settings.stiff:
        softness = {"eq_solref": (settings.time_constant(False), 1.0), "eq_solimp": STIFF_SOLIMP}
        for name, values in softness.items():
            if settings.solver == MUJOCO_WARP:
                own = getattr(solver.mjw_model, name)
                own.assign(np.broadcast_to(values, own.numpy().shape))
            else:
                getattr(solver.mj_model, name)[:] = values
    return solver


def run_in_space(start: SpatialStart, preset: str, steps: int, every: int = 1) -> SpatialRun:
    """Run a machine from its exact state, and record its points at the start and after each `every` steps.

    Accelerations are SolverMuJoCo's own on MuJoCo's C code where drives keep their rates, and else central differences
    of velocities, one-sided at the start. A run of SolverXPBD whose joints come apart is ended.
    """
    stepper = NewtonStepper(start, preset)
    near = sorted({k + d for k in range(0, steps + 1, every) for d in (-1, 0, 1) if k + d >= 0} | {2})
    read = {0: stepper.readings()}
    for k in near[1:]:
        stepper(k - stepper.done)
        if stepper.failure:
            break
        read[k] = stepper.readings()
        if stepper.settings.solver == XPBD and k % every == 0:
            stepper.failure = opened_joint(start, read[k], k)
            if stepper.failure:
                break
    samples = [k for k in range(0, steps + 1, every) if k in read and k + 1 in read]
    times = start.step * np.arange(steps + 1.0)
    steady = not any(law.derivatives(times)[2].any() for law in start.machine.laws.values())
    points = motion_of_points(start, read, samples, own=steady and stepper.settings.solver == MUJOCO)
    return SpatialRun(start.step * np.array(samples, dtype=float), points, stepper.failure)


def opened_joint(start: SpatialStart, read: BodyReadings, done: int) -> str:
    """Say which joint of the tree is open by more than `MAX_JOINT_GAP` of the machine's extent; empty if none is."""
    openings: Mapping[str, float] = joint_openings(start.tree, read)
    name = max(openings, key=openings.__getitem__)
    if openings[name] <= MAX_JOINT_GAP * start.tree.extent:
        return ""
    return f"the joint {name} is open by {1e3 * openings[name]:.3g} mm at {done * start.step:.4g} s"
