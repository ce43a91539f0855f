"""The Exudyn engine: translates a mechanism to a `MainSystem`, steps it by Exudyn's solvers and records.

Nothing is written into the engine after the start; a constraint holds the crank's rate.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
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

from conrod.comparison.outcome import RunVerdict
from conrod.comparison.trajectory import BodyTracks, Outcome, Piece
from conrod.engines.capabilities import TIMED_REFERENCE, KinematicResult
from conrod.engines.engine import PIECE_STEPS, Engine, Machine, run_extent
from conrod.engines.exudyn import EXUDYN_PRESETS, ExudynSettings, space
from conrod.engines.exudyn.stepping import BLOCK_STEPS, ExudynSystem, SolverStepper, silence_output
from conrod.engines.numerics import place_at_angles
from conrod.engines.run import RecordedPiece, observed_tracks, record_pieces, stamped_states
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Body, Joint, Mechanism, Point, Prismatic, Revolute

SUPPORTED_JOINTS = (Revolute, Prismatic)


def refusal(machine: Machine, settings: ExudynSettings) -> str | None:
    """Return the reason why these settings cannot be used on this machine, or None."""
    mechanism = machine.kinematics.mechanism
    if mechanism.loads:
        return "exudyn is given gravity and constant forces, no loads that follow a law"
    if not all(isinstance(joint, SUPPORTED_JOINTS) for joint in mechanism.joints):
        return "exudyn is given pins and slides, no cams that act by contact and no wheels that roll"
    return None


def build(mechanism: Mechanism, poses: Array, rates: Array, rate: float | None) -> ExudynSystem:
    """Build the system with the bodies in poses (3 n,) at rates (3 n,).

    Args:
        rate: crank rate [rad/s] that a constraint holds; None for a constraint on the crank's angle, which is set
            later. This takes no user function, which Exudyn ignores in its initial accelerations.
    """
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    numbers, nodes = {GROUND: system.AddObject(ObjectGround())}, {}
    for body, pose, start in zip(mechanism.bodies, poses.reshape(-1, 3), rates.reshape(-1, 3), strict=True):
        # Reference coordinates stay 0, so the displacements from them, which Exudyn integrates, are the pose.
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
    return ExudynSystem(container, system, drive)


def _add_body(system: Any, mechanism: Mechanism, body: Body, node: int) -> int:
    """Add a body with its weight and constant force; return its object number."""
    x, y = body.centre_of_gravity
    inertia = body.inertia + body.mass * (x * x + y * y)  # about the reference point
    rigid = ObjectRigidBody2D(nodeNumber=node, mass=body.mass, inertia=inertia, centerOfMass=[x, y])
    number: int = system.AddObject(rigid)
    push, (along, up) = mechanism.constant_force_on(body.name), mechanism.gravity
    force = [push[0] + body.mass * along, push[1] + body.mass * up, 0.0]
    system.AddLoad(LoadForceVector(markerNumber=_add_marker(system, number, (x, y)), loadVector=force))
    return number


def _add_marker(system: Any, number: int, point: Point) -> Any:
    """Add a marker at a point of a body."""
    return system.AddMarker(MarkerBodyRigid(bodyNumber=number, localPosition=[*point, 0.0]))


def _add_joint(system: Any, numbers: Mapping[str, int], joint: Joint) -> None:
    """Add a pin or a slide."""
    assert isinstance(joint, SUPPORTED_JOINTS)  # or the machine is refused
    ends = ((joint.a, joint.point_a), (joint.b, joint.point_b))
    markers = [_add_marker(system, numbers[name], point) for name, point in ends]
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


KINEMATIC_TOLERANCE = 1e-13  # of Newton's iteration; if rounding stalls it before, its last pose is taken


class ExudynStepper(SolverStepper):
    """A machine in Exudyn that starts in an exact state; with the crank's rate held constant, nothing depends on time.

    Args:
        angle: crank angle at the start [rad]; None for 0, or for the start of a pass.
    """

    def __init__(self, machine: Machine, settings: ExudynSettings, angle: float | None = None) -> None:
        angle = run_extent(machine, 1, 1.0)[0] if angle is None else angle
        poses, derivative = machine.kinematics.derivatives(np.array([angle]), 1)
        mechanism, speed = machine.kinematics.mechanism, machine.speed
        super().__init__(settings)
        with silence_output():
            self._made = build(mechanism, poses[0], derivative[0] * speed, mechanism.driver.sense * speed)
            self._call_solver("the initial accelerations", self._solver.InitializeSolver)

    def states(self, steps: int) -> Iterator[Array]:
        """Yield poses, rates and accelerations (3, 3 n) of one instant each, at the start and after each step.

        Both solvers fulfil constraints and equations of motion at the end of a step, so all that is read there belongs
        to it: the accelerations read are not the algorithmic ones of generalised alpha, which belong to other instants.
        """
        steps = max(steps, 1)
        for done in range(0, steps, BLOCK_STEPS):
            yield from self._record_block(min(BLOCK_STEPS, steps - done))[1 if done else 0 :]

    def _record_block(self, steps: int) -> Array:
        """States (steps + 1, 3, 3 n) before and after each step; NaN after the solver has failed."""
        data, found = self._made.system.systemData, list[list[Array]]()

        def record(*_: object) -> bool:
            """Record coordinates and their rates after a step; return True, which lets the solver continue."""
            found.append([data.GetODE2Coordinates(), data.GetODE2Coordinates_t(), data.GetODE2Coordinates_tt()])
            return True

        self._made.system.SetPostStepUserFunction(record)
        self(steps)
        states = np.full((steps + 1, 3, data.ODE2Size()), math.nan)
        if found:
            states[: len(found)] = found
        return states


def solve_kinematics(machine: Machine, angle: Array) -> KinematicResult:
    """Hold the crank at each angle (T,) [rad] while Exudyn's static solver places the bodies."""
    mechanism = machine.kinematics.mechanism
    start = machine.kinematics.start[0]
    made = build(mechanism, start, np.zeros_like(start), rate=None)
    data, solver, settings = made.system.systemData, exudyn.MainSolverStatic(), exudyn.SimulationSettings()
    settings.solution.file.write, settings.staticSolver.verboseMode = False, 0
    newton = settings.staticSolver.newton
    newton.relativeTolerance = newton.absoluteTolerance = KINEMATIC_TOLERANCE
    poses, rates = list[Array](), list[Array]()

    def place(theta: float, ahead: Array | None) -> Array:
        """Place the machine by the engine's joints at a crank angle [rad], from a guess if one is given."""
        if ahead is not None:
            data.SetODE2Coordinates(ahead, exudyn.ConfigurationType.Initial)
        made.system.SetObjectParameter(made.drive, "offset", mechanism.crank_turn(theta))
        with silence_output():
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
    """Rates (3 n,) that fulfil the engine's own constraints at a crank speed [rad/s].

    They solve C q' = (0, .., 0, c omega), with the constraints' Jacobian C, as the static solver has no rates.

    Args:
        jacobian: [[K, C'], [C, 0]] of the static equations (6 n, 6 n), with the constraint on the crank's angle last.
    """
    count = 3 * len(mechanism.bodies)
    constraints, asked = jacobian[count:, :count], np.zeros(count)
    asked[-1] = constraints[-1, 3 * mechanism.body_index[mechanism.crank] + 2] * mechanism.driver.sense * speed
    # At a pose with dependent constraints there are many solutions, of which this takes the smallest.
    return np.asarray(np.linalg.lstsq(constraints, asked)[0])


def run(
    machine: Machine, settings: ExudynSettings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE_STEPS
) -> Iterator[Piece]:
    """Run a machine at constant crank speed, and yield its pieces of `steps` steps."""
    kinematics, stepper = machine.kinematics, ExudynStepper(machine, settings, start_angle)
    states = stepper.states(round(settings.steps_per_revolution * revolutions))

    def explain_failure(judged: RunVerdict) -> RunVerdict:
        """Add the solver's own message to the reason of a run that diverged."""
        failed = judged.outcome is Outcome.DIVERGED and stepper.failure
        return replace(judged, reason=f"{stepper.failure}; {judged.reason}") if failed else judged

    def record(first: int, times: Array) -> RecordedPiece:
        """Read the next samples at times (T,) [s]; `first` is the index of the first."""
        read = np.array(list(islice(states, len(times)))).swapaxes(0, 1)
        bodies = stamped_states(kinematics.mechanism, times, *read)
        # As in Exudyn, the clock is step index times step.
        clock = settings.timestep * np.arange(first, first + len(times), dtype=float)
        tracks = BodyTracks(bodies, bodies, bodies)
        return RecordedPiece(tracks, observed_tracks(kinematics, bodies), clock, finish_verdict=explain_failure)

    return record_pieces(machine, settings, exudyn.__version__, revolutions, start_angle, steps, record)


class Exudyn(Engine[ExudynSettings]):
    """Exudyn through its `MainSystem` of planar bodies, with hard constraints and implicit integrators."""

    name = "exudyn"
    version = exudyn.__version__
    presets = EXUDYN_PRESETS
    refusal = staticmethod(refusal)
    solve_kinematics = staticmethod(solve_kinematics)
    run = staticmethod(run)
    stepper = ExudynStepper
    refusal_in_space = staticmethod(space.refusal_in_space)
    run_in_space = staticmethod(space.run_in_space)
    stepper_in_space = space.ExudynSpatialStepper

    def reference_loop(self) -> ExudynStepper:
        """Stepper of the fixed slider-crank, the unit of timings, at 1000 steps per revolution."""
        return ExudynStepper(TIMED_REFERENCE, ExudynSettings.stock(TIMED_REFERENCE, 1000))


EXUDYN_ENGINE = Exudyn()
