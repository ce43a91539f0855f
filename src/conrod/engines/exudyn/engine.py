"""Exudyn, as one of conrod's engines: a mechanism becomes a `MainSystem`, its solvers take it on by so many steps.

Nothing is written into the engine after the start; a constraint holds the crank's rate."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import exudyn
import numpy as np
from exudyn.itemInterface import (
    LoadForceVector,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    NodePointGround,
    NodeRigidBody2D,
    ObjectConnectorCoordinate,
    ObjectGround,
    ObjectJointPrismatic2D,
    ObjectJointRevolute2D,
    ObjectRigidBody2D,
)

from conrod.engines.capabilities import TIMED_REFERENCE, KinematicResult
from conrod.engines.engine import PIECE_STEPS, Engine, Machine, run_extent
from conrod.engines.exudyn import EXUDYN_PRESETS, TRAPEZOIDAL, ExudynSettings
from conrod.engines.numerics import place_at_angles
from conrod.engines.run import RecordedStretch, observed_tracks, record_pieces, stamped_states
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Body, Joint, Mechanism, Point, Prismatic, Revolute
from conrod.runs.outcome import RunVerdict
from conrod.runs.trajectory import BodyTracks, Outcome, Piece

GIVEN = (Revolute, Prismatic)


@dataclass(frozen=True)
class Build:
    """A system of planar bodies, whose coordinates are the poses (3 n,) of `Mechanism.bodies`.

    Attributes:
        container: of the system, which must outlive it.
        drive: number of the constraint on the crank's turn.
    """

    container: Any
    system: Any
    drive: int


def refusal(machine: Machine, settings: ExudynSettings) -> str | None:
    """None, or the reason why these settings cannot be used on this machine."""
    mechanism = machine.kinematics.mechanism
    if mechanism.loads:
        return "exudyn is given gravity and constant forces, no loads that follow a law"
    if not all(isinstance(joint, GIVEN) for joint in mechanism.joints):
        return "exudyn is given pins and slides, no cams that act by contact and no wheels that roll"
    return None


@contextmanager
def silent() -> Iterator[None]:
    """Nothing is printed by Exudyn, which explains at length why a solver has failed."""
    printing = exudyn.config.printToConsole
    exudyn.config.printToConsole = False
    try:
        yield
    finally:
        exudyn.config.printToConsole = printing


def build(mechanism: Mechanism, poses: Array, rates: Array, rate: float | None) -> Build:
    """Translate, with the bodies in poses (3 n,) at rates (3 n,).

    Args:
        rate: that a constraint holds the crank's turn at [rad/s]. Exudyn needs no user function for it, of which its
            initial accelerations would take no account. None for a constraint on the turn itself, which is set later.
    """
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    numbers, nodes = {GROUND: system.AddObject(ObjectGround())}, {}
    for body, pose, start in zip(mechanism.bodies, poses.reshape(-1, 3), rates.reshape(-1, 3), strict=True):
        # Reference coordinates are left at 0: displacements from them, which are what is integrated, are the pose.
        node = NodeRigidBody2D(initialCoordinates=pose.tolist(), initialVelocities=start.tolist())
        nodes[body.name] = system.AddNode(node)
        numbers[body.name] = _add_body(system, mechanism, body, nodes[body.name])
    for joint in mechanism.joints:
        _add_joint(system, numbers, joint)
    still = system.AddNode(NodePointGround())
    turns = [
        system.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=k))
        for node, k in ((still, 0), (nodes[mechanism.crank], 2))
    ]
    held = {"offset": float(poses[3 * mechanism.body_index[mechanism.crank] + 2])}
    if rate is not None:
        held = {"offset": rate, "velocityLevel": True}
    drive = system.AddObject(ObjectConnectorCoordinate(markerNumbers=turns, **held))
    system.Assemble()
    return Build(container, system, drive)


def _add_body(system: Any, mechanism: Mechanism, body: Body, node: int) -> int:
    x, y = body.centre_of_gravity
    inertia = body.inertia + body.mass * (x * x + y * y)  # about the reference point
    rigid = ObjectRigidBody2D(nodeNumber=node, mass=body.mass, inertia=inertia, centerOfMass=[x, y])
    number: int = system.AddObject(rigid)
    push, (along, up) = mechanism.push_on(body.name), mechanism.gravity
    force = [push[0] + body.mass * along, push[1] + body.mass * up, 0.0]
    system.AddLoad(LoadForceVector(markerNumber=_marker(system, number, (x, y)), loadVector=force))
    return number


def _marker(system: Any, number: int, point: Point) -> Any:
    return system.AddMarker(MarkerBodyRigid(bodyNumber=number, localPosition=[*point, 0.0]))


def _add_joint(system: Any, numbers: Mapping[str, int], joint: Joint) -> None:
    assert isinstance(joint, GIVEN)  # or the machine is refused
    ends = ((joint.a, joint.point_a), (joint.b, joint.point_b))
    markers = [_marker(system, numbers[name], point) for name, point in ends]
    if isinstance(joint, Revolute):
        system.AddObject(ObjectJointRevolute2D(markerNumbers=markers))
        return
    across = joint.direction - joint.angle + 0.5 * math.pi
    slide = ObjectJointPrismatic2D(
        markerNumbers=markers,
        axisMarker0=[math.cos(joint.direction), math.sin(joint.direction), 0.0],
        normalMarker1=[math.cos(across), math.sin(across), 0.0],
    )
    system.AddObject(slide)


# -- runs --------------------------------------------------------------------------------------------------------------


# The solver begins again after so many steps, with a new Jacobian: always the same ones, however a run is cut. A power
# of two, by which a step's length is divided without rounding.
BLOCK = 1024
TOLERANCE = 1e-13  # of Newton's iteration; where it stalls on rounding before, the pose is that of its last step


class Stepper:
    """A machine in the exact state of its start, or a crank angle [rad]; calling it advances it by so many steps.

    What is left of a call of the solver, accelerations included, begins the next one. Its time begins at 0 each time:
    with the crank's rate held constant, nothing depends on it.

    Attributes:
        failure: why the solver goes no further; empty while it does.
    """

    def __init__(self, machine: Machine, settings: ExudynSettings, angle: float | None = None) -> None:
        angle = run_extent(machine, 1, 1.0)[0] if angle is None else angle
        poses, slopes = machine.kinematics.derivatives(np.array([angle]), 1)
        mechanism, speed = machine.kinematics.mechanism, machine.speed
        self.failure, self._step = "", settings.timestep
        self._settings = _simulation(settings)
        self._solver = exudyn.MainSolverImplicitSecondOrder()
        with silent():
            self._made = build(mechanism, poses[0], slopes[0] * speed, mechanism.driver.sense * speed)
            self._try("the initial accelerations", self._solver.InitializeSolver)

    def __call__(self, steps: int) -> None:
        self._solver.it.endTime = steps * self._step
        if not self.failure:
            with silent():
                self._try("a step", self._solver.SolveSteps)

    def states(self, steps: int) -> Iterator[Array]:
        """Poses, rates and accelerations (3, 3 n) of one instant each, at the start and after each of so many steps.

        Both solvers fulfil constraints and equations of motion at the end of a step, so all that is read there belongs
        to it: the accelerations are not those, at other instants, that generalised alpha carries along beside them.
        """
        steps = max(steps, 1)
        for done in range(0, steps, BLOCK):
            yield from self._recorded(min(BLOCK, steps - done))[1 if done else 0 :]

    def _recorded(self, steps: int) -> Array:
        """States (steps + 1, 3, 3 n) before so many steps and after each; no numbers where it does not get to."""
        data, found = self._made.system.systemData, list[list[Array]]()

        def record(*_: object) -> bool:
            found.append([data.GetODE2Coordinates(), data.GetODE2Coordinates_t(), data.GetODE2Coordinates_tt()])
            return True

        self._made.system.SetPostStepUserFunction(record)
        self(steps)
        states = np.full((steps + 1, 3, data.ODE2Size()), math.nan)
        if found:
            states[: len(found)] = found
        return states

    def _try(self, what: str, call: Callable[[Any, Any], bool]) -> None:
        try:
            done = call(self._made.system, self._settings)
        except (RuntimeError, ValueError):  # a singular Jacobian, and the like
            done = False
        if not done:
            singular = self._solver.conv.linearSolverFailed
            why = "its Jacobian is singular" if singular else "Newton's iteration did not converge"
            self.failure = f"Exudyn could not solve for {what}: {why}"


def _simulation(settings: ExudynSettings) -> Any:
    """Exudyn's settings: its defaults but for ours, in steps of one length, with no files written."""
    made = exudyn.SimulationSettings()
    made.solution.file.write = False
    integration = made.timeIntegration
    integration.adaptiveStep = False
    integration.numberOfSteps, integration.endTime = BLOCK, BLOCK * settings.timestep
    integration.newton.relativeTolerance = settings.relative_tolerance
    integration.newton.absoluteTolerance = settings.absolute_tolerance
    alpha = integration.generalizedAlpha
    alpha.spectralRadius = settings.spectral_radius
    # As Exudyn's SolveDynamic does it for this solver, which is the same one with other settings.
    alpha.useIndex2Constraints = alpha.useNewmark = settings.solver == TRAPEZOIDAL
    return made


def solve_kinematics(machine: Machine, angle: Array) -> KinematicResult:
    """The crank held at each angle, the rest placed by the joints."""
    mechanism = machine.kinematics.mechanism
    start = machine.kinematics.start[0]
    made = build(mechanism, start, np.zeros_like(start), rate=None)
    data, solver, settings = made.system.systemData, exudyn.MainSolverStatic(), exudyn.SimulationSettings()
    settings.solution.file.write, settings.staticSolver.verboseMode = False, 0
    newton = settings.staticSolver.newton
    newton.relativeTolerance = newton.absoluteTolerance = TOLERANCE
    poses, rates = list[Array](), list[Array]()

    def place(theta: float, ahead: Array | None) -> Array:
        if ahead is not None:
            data.SetODE2Coordinates(ahead, exudyn.ConfigurationType.Initial)
        made.system.SetObjectParameter(made.drive, "offset", mechanism.crank_turn(theta))
        with silent():
            solver.SolveSystem(made.system, settings)
        found: Array = data.GetODE2Coordinates()
        return found

    for _ in place_at_angles(machine.kinematics, angle, place, always=True):
        solver.ComputeNewtonJacobian(made.system, settings)
        poses.append(data.GetODE2Coordinates())
        rates.append(closing_rates(solver.GetSystemJacobian(), mechanism, machine.speed))
    observed = machine.kinematics.point_derivatives([np.array(poses), np.array(rates)])
    return KinematicResult(angle, np.array(poses), {name: (place, rate) for name, (place, rate) in observed.items()})


def closing_rates(jacobian: Array, mechanism: Mechanism, speed: float) -> Array:
    """Rates (3 n,) that fit the engine's own constraints at the crank's speed [rad/s]: the static solver has none.

    Args:
        jacobian: [[K, C'], [C, 0]] of the static equations (6 n, 6 n), with the constraint on the crank's turn last.
    """
    count = 3 * len(mechanism.bodies)
    constraints, asked = jacobian[count:, :count], np.zeros(count)
    asked[-1] = constraints[-1, 3 * mechanism.body_index[mechanism.crank] + 2] * mechanism.driver.sense * speed
    # At a pose where the constraints depend on each other there are many, of which this takes the least.
    return np.asarray(np.linalg.lstsq(constraints, asked)[0])


def run(
    machine: Machine, settings: ExudynSettings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE_STEPS
) -> Iterator[Piece]:
    """A run at constant crank speed in pieces of so many steps."""
    kinematics, stepper = machine.kinematics, Stepper(machine, settings, start_angle)
    states = stepper.states(round(settings.steps_per_revolution * revolutions))

    def ended(judged: RunVerdict) -> RunVerdict:
        failed = judged.outcome is Outcome.DIVERGED and stepper.failure
        return replace(judged, reason=f"{stepper.failure}; {judged.reason}") if failed else judged

    def record(first: int, times: Array) -> RecordedStretch:
        read = np.array(list(islice(states, len(times)))).swapaxes(0, 1)
        bodies = stamped_states(kinematics.mechanism, times, *read)
        # Exudyn too has it from the step index.
        clock = settings.timestep * np.arange(first, first + len(times), dtype=float)
        tracks = BodyTracks(bodies, bodies, bodies)
        return RecordedStretch(tracks, observed_tracks(kinematics, bodies), clock, finish_verdict=ended)

    return record_pieces(machine, settings, exudyn.__version__, revolutions, start_angle, steps, record)


class Exudyn(Engine[ExudynSettings]):
    """Exudyn by way of its `MainSystem` of planar bodies, with hard constraints and implicit integrators."""

    name = "exudyn"
    version = exudyn.__version__
    presets = EXUDYN_PRESETS
    refusal = staticmethod(refusal)
    solve_kinematics = staticmethod(solve_kinematics)
    run = staticmethod(run)
    stepper = Stepper

    def reference_loop(self) -> Stepper:
        """The slider-crank at its start, 1000 steps a turn."""
        return Stepper(TIMED_REFERENCE, ExudynSettings.stock(TIMED_REFERENCE, 1000))


EXUDYN_ENGINE = Exudyn()
