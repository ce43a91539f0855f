"""The Drake engine: translates a mechanism to a tree of a `MultibodyPlant`, steps it by Drake's simulator and records.

Nothing is written into the engine after the start: a flywheel keeps the crank's rate.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from importlib.metadata import version
from itertools import islice

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce

from conrod.comparison.outcome import RunVerdict
from conrod.comparison.trajectory import BodyTracks, Outcome, Piece
from conrod.engines.capabilities import TIMED_REFERENCE
from conrod.engines.drake import DRAKE_PRESETS, DrakeSettings, space
from conrod.engines.drake.plant import build_plant
from conrod.engines.drake.stepping import DrakeSimulation
from conrod.engines.engine import PIECE_STEPS, Engine, Machine, run_extent
from conrod.engines.run import RecordedPiece, observed_tracks, record_pieces, stamped_states
from conrod.engines.spanning_tree import SpanningTree, machine_tree, rotation_coefficients
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import SpatialBody, SpatialClosure, SpatialJoint, SpatialPoint, SpatialTree
from conrod.mechanism.mechanism import GROUND, Point, Prismatic, Revolute

SUPPORTED_JOINTS = (Revolute, Prismatic)
DRAKE_VERSION = version("drake")


def refusal(machine: Machine, settings: DrakeSettings) -> str | None:
    """Return the reason why these settings cannot be used on this machine, or None."""
    mechanism = machine.kinematics.mechanism
    if mechanism.loads:
        return "drake is given gravity and constant forces, no loads that follow a law"
    if not all(isinstance(joint, SUPPORTED_JOINTS) for joint in mechanism.joints):
        return "drake is given pins and slides, no cams that act by contact and no wheels that roll"
    try:
        machine_tree(machine)
    except InvalidInput as error:
        return f"drake: {error}"
    return None


def planar_tree(found: SpanningTree) -> SpatialTree:
    """A planar spanning tree as one in space, in the plane z = 0, its cut pins as closures.

    A body in the plane has no inertia but about z; what it is given about x and y makes no difference there.
    """
    mechanism = found.mechanism
    number = {GROUND: 0, **{branch.child: k for k, branch in enumerate(found.branches, 1)}}
    bodies = [SpatialBody(GROUND, 0, np.zeros(3), np.eye(3), (), 0.0, np.zeros(3), np.zeros((3, 3)))]
    for k, branch in enumerate(found.branches):
        parent, child, body = (
            found.start_pose(branch.parent),
            found.start_pose(branch.child),
            mechanism.body(branch.child),
        )
        turn = rotation_about_z(child[2] - parent[2])
        place = rotation_about_z(-parent[2]) @ _in_space(child[:2] - parent[:2])
        if isinstance(branch.joint, Revolute):
            kind, anchor, axis = "hinge", _in_space(found.pin_points(branch)[1]), np.array([0.0, 0.0, branch.sense])
        else:
            along = found.slide_direction(branch)
            kind, anchor = "slide", np.zeros(3)
            axis = branch.sense * turn.T @ np.array([math.cos(along), math.sin(along), 0.0])
        joint = SpatialJoint(branch.joint.name, kind, k + 1, k, k, anchor, axis)
        centre = _in_space(body.centre_of_gravity)
        about = body.inertia * np.eye(3)
        bodies.append(SpatialBody(branch.child, number[branch.parent], place, turn, (joint,), body.mass, centre, about))
    closures = tuple(
        SpatialClosure(
            pin.name, "connect",
            (SpatialPoint(number[pin.a], _in_space(pin.point_a)), SpatialPoint(number[pin.b], _in_space(pin.point_b))),
        )
        for pin in found.cuts
    )  # fmt: skip
    gravity = np.array([*mechanism.gravity, 0.0])
    return SpatialTree(tuple(bodies), closures, {}, gravity, np.zeros(len(found.branches)))


def rotation_about_z(angle: float) -> Array:
    """Rotation (3, 3) about z by an angle [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _in_space(point: Point | Array) -> Array:
    """A point of the plane as one of space."""
    return np.array([point[0], point[1], 0.0])


# -- runs --------------------------------------------------------------------------------------------------------------


class DrakeStepper:
    """A machine in Drake that starts in an exact state; a call advances it by some steps.

    Args:
        angle: crank angle at the start [rad]; None for 0, or for the start of a pass.
    """

    def __init__(self, machine: Machine, settings: DrakeSettings, angle: float | None = None) -> None:
        angle = run_extent(machine, 1, 1.0)[0] if angle is None else angle
        self._tree, mechanism = machine_tree(machine), machine.kinematics.mechanism
        poses, derivative = machine.kinematics.derivatives(np.array([angle]), 1)
        coordinates = self._tree.coordinates(poses)[0]
        rates = self._tree.rates(poses, derivative * machine.speed)[0]
        tree = planar_tree(self._tree)
        made = build_plant(tree, {mechanism.driver.joint}, coordinates, settings.timestep, settings)
        self._simulation = DrakeSimulation(made, settings.timestep, settings)
        made.place(tree, self._simulation.context, coordinates, rates)
        self._numbers = [1 + [branch.child for branch in self._tree.branches].index(b.name) for b in mechanism.bodies]
        self._turns = np.array([rotation_coefficients(self._tree, body.name) for body in mechanism.bodies])
        self._starts = np.array([self._tree.start_pose(body.name)[2] for body in mechanism.bodies])
        self._push()

    @property
    def failure(self) -> str:
        """Why the run broke off; empty while it goes on."""
        return self._simulation.failure

    def __call__(self, steps: int) -> None:
        self._simulation(steps)

    def _push(self) -> None:
        """Apply the constant forces."""
        made, mechanism = self._simulation.made, self._tree.mechanism
        pushes = []
        for number, body in zip(self._numbers, mechanism.bodies, strict=True):
            force = ExternallyAppliedSpatialForce()
            force.body_index = made.bodies[number].index()
            force.p_BoBq_B = _in_space(body.centre_of_gravity)
            force.F_Bq_W = SpatialForce(np.zeros(3), _in_space(mechanism.constant_force_on(body.name)))
            pushes.append(force)
        port = made.plant.get_applied_spatial_force_input_port()
        port.FixValue(self._simulation.context, Value[list[ExternallyAppliedSpatialForce]](pushes))

    def state(self) -> Array:
        """Poses, rates and accelerations (3, 3 n) of all bodies; NaN after a failure."""
        made, mechanism = self._simulation.made, self._tree.mechanism
        if self.failure:
            return np.full((3, 3 * len(mechanism.bodies)), math.nan)
        read = made.body_states(self._simulation.context, self._numbers)
        coordinates = made.plant.GetPositions(self._simulation.context)
        order = [made.joints[branch.joint.name].joint.position_start() for branch in self._tree.branches]
        # Angles are sums of the joints': a rotation matrix does not count whole turns.
        angles = self._starts + self._turns @ coordinates[order]
        rows = ((read[:, 0], angles), (read[:, 4], read[:, 5, 2]), (read[:, 6], read[:, 7, 2]))
        return np.array([np.column_stack([along[:, :2], about]).ravel() for along, about in rows])

    def states(self, steps: int) -> Iterator[tuple[Array, float]]:
        """Yield states (3, 3 n) and the clock [s], at the start and after each of some steps."""
        yield self.state(), self._simulation.time
        for _ in range(steps):
            self(1)
            yield self.state(), self._simulation.time


def run(
    machine: Machine, settings: DrakeSettings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE_STEPS
) -> Iterator[Piece]:
    """Run a machine at constant crank speed, and yield its pieces of `steps` steps."""
    kinematics, stepper = machine.kinematics, DrakeStepper(machine, settings, start_angle)
    states = stepper.states(round(settings.steps_per_revolution * revolutions))

    def explain_failure(judged: RunVerdict) -> RunVerdict:
        """Add the simulator's own message to the reason of a run that diverged."""
        failed = judged.outcome is Outcome.DIVERGED and stepper.failure
        return replace(judged, reason=f"{stepper.failure}; {judged.reason}") if failed else judged

    def record(first: int, times: Array) -> RecordedPiece:
        """Read the next samples at times (T,) [s]; `first` is the index of the first."""
        read, clock = zip(*islice(states, len(times)), strict=True)
        bodies = stamped_states(kinematics.mechanism, times, *np.array(read).swapaxes(0, 1))
        tracks, points = BodyTracks(bodies, bodies, bodies), observed_tracks(kinematics, bodies)
        return RecordedPiece(tracks, points, np.array(clock), finish_verdict=explain_failure)

    return record_pieces(machine, settings, DRAKE_VERSION, revolutions, start_angle, steps, record)


class Drake(Engine[DrakeSettings]):
    """Drake's `MultibodyPlant` in its simulator: minimal coordinates, loops closed by constraints or bushings."""

    name = "drake"
    version = DRAKE_VERSION
    presets = DRAKE_PRESETS
    refusal = staticmethod(refusal)
    run = staticmethod(run)
    stepper = DrakeStepper
    refusal_in_space = staticmethod(space.refusal_in_space)
    run_in_space = staticmethod(space.run_in_space)
    stepper_in_space = staticmethod(space.stepper_in_space)

    def reference_loop(self) -> DrakeStepper:
        """Stepper of the fixed slider-crank, the unit of timings, at 1000 steps per revolution."""
        return DrakeStepper(TIMED_REFERENCE, DrakeSettings.stock(TIMED_REFERENCE, 1000))


DRAKE_ENGINE = Drake()
