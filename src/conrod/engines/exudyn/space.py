"""Exudyn on machines in space: a kinematic tree, closed by spherical and generic joints, driven by laws.

Exudyn's tree has joints about the z axis of their own frames, so a link's frame has its origin at the joint and z along
its axis. A body with several joints is a chain of links, of which the last has its mass; a ball is a chain of three
hinges, singular where the middle one has turned by a right angle from the start. Loops may have redundant equations:
Exudyn's dense solver for singular matrices leaves out those that depend on the others.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import count
from typing import Any

import exudyn
import numpy as np
from exudyn.itemInterface import (
    MarkerBodyRigid,
    MarkerKinematicTreeRigid,
    MarkerNodeCoordinate,
    NodeGenericODE2,
    NodePointGround,
    ObjectConnectorCoordinate,
    ObjectGround,
    ObjectJointGeneric,
    ObjectJointSpherical,
    ObjectKinematicTree,
    SensorKinematicTree,
)

from conrod.engines.capabilities import TIMED_REFERENCE
from conrod.engines.exudyn import EXUDYN_PRESETS
from conrod.engines.exudyn.stepping import BLOCK_STEPS, ExudynSystem, SolverStepper, silence_output
from conrod.engines.space import SpatialRun, SpatialStart, constant_rate
from conrod.exact.motion import Array
from conrod.exact.space import SpatialBody, SpatialClosure, SpatialJoint, SpatialPoint, SpatialTree
from conrod.exact.space.drive_laws import DriveLaw
from conrod.exact.space.forward_kinematics import rotation_matrices
from conrod.exact.space.motion import SpatialMotion

LISTS = {
    "jointTransformations": exudyn.Matrix3DList, "linkInertiasCOM": exudyn.Matrix3DList,
    "jointOffsets": exudyn.Vector3DList, "linkCOMs": exudyn.Vector3DList,
}  # fmt: skip
JOINT_TYPES = {"hinge": exudyn.JointType.RevoluteZ, "slide": exudyn.JointType.PrismaticZ}
CLOSURES = ("connect", "weld", "joint")
MOTION = ("Position", "Velocity", "Acceleration")  # of a sensor
SINGULAR_BALL = math.cos(math.radians(70.0))  # of a ball's second angle: beyond it its hinges are nearly singular


def refusal_in_space(start: SpatialStart, preset: str) -> str | None:
    """Return the reason why Exudyn is not given a machine in space, or None."""
    tree = start.tree
    if other := sorted({joint.kind for joint in tree.joints} - {*JOINT_TYPES, "ball"}):
        return f"exudyn in space is given hinges, slides and balls, no {' or '.join(other)} joints"
    if other := sorted({closure.kind for closure in tree.closures} - {*CLOSURES}):
        return f"exudyn in space is given loops closed by connects, welds and couplings, no {' or '.join(other)}"
    if any(any(one.polynomial[2:]) or (not one.points and not all(one.sums)) for one in tree.closures):
        return "exudyn in space is given couplings that are linear, of two joints that both move"
    if any(not body.joints and body.mass > 0.0 for body in tree.bodies[1:]):
        return "exudyn in space is given no body without a joint"
    return None


@dataclass(frozen=True)
class LinkFrame:
    """A link's frame in the frame of its body: number of the link (-1: ground), origin (3,) [m], rotation (3, 3)."""

    link: int
    origin: Array
    turn: Array

    def place_of(self, point: SpatialPoint) -> list[float]:
        """Place [m] of a point of the body in this frame."""
        place: list[float] = (self.turn.T @ (point.offset - self.origin)).tolist()
        return place


@dataclass
class KinematicChain:
    """Links of Exudyn's tree, and the state that each begins in.

    Attributes:
        lists: arguments of `ObjectKinematicTree`, by name.
        frames: of each body the frame of its last link.
        state: coordinates, rates and accelerations (3, n) of the links' joints.
        of_joint: number of the link of each hinge or slide, by the joint's name; of the middle one of a ball.
    """

    lists: dict[str, list[Any]]
    frames: list[LinkFrame]
    state: list[tuple[float, float, float]]
    of_joint: dict[str, int]


def link_chain(start: SpatialStart) -> KinematicChain:
    """Cut the tree of a machine into links of one hinge or slide each."""
    names = (
        "jointTypes", "linkParents", "jointTransformations", "jointOffsets", "linkInertiasCOM", "linkCOMs",
        "linkMasses",
    )  # fmt: skip
    made = KinematicChain({name: [] for name in names}, [LinkFrame(-1, np.zeros(3), np.eye(3))], [], {})
    lists = made.lists
    for body in start.tree.bodies[1:]:
        above = made.frames[body.parent]
        # The link's frame above, seen from the body's own frame at its reference pose.
        place, turn = above.turn.T @ (body.place - above.origin), above.turn.T @ body.turn
        frame = LinkFrame(above.link, -(turn.T @ place), turn.T)
        for joint in body.joints:
            if joint.kind == "ball":
                # Its hinges are along the body's axes as it starts, turned there about the anchor.
                back = rotation_matrices(start.exact.coordinates[joint.coordinates, :1])[:, :, 0].T
                frame = LinkFrame(frame.link, joint.anchor + back @ (frame.origin - joint.anchor), back @ frame.turn)
            for kind, along, state in single_joints(joint, body, start.exact):
                lists["jointTypes"].append(kind)
                lists["linkParents"].append(frame.link)
                lists["jointTransformations"].append(frame.turn.T @ along)
                lists["jointOffsets"].append(frame.turn.T @ (joint.anchor - frame.origin))
                frame = LinkFrame(len(made.state), joint.anchor, along)
                made.state.append(state)
                lists["linkMasses"].append(0.0)
                lists["linkCOMs"].append(np.zeros(3))
                lists["linkInertiasCOM"].append(np.zeros((3, 3)))
            made.of_joint[joint.name] = frame.link - (joint.kind == "ball")
        if body.joints:
            lists["linkMasses"][-1] = body.mass
            lists["linkCOMs"][-1] = frame.turn.T @ (body.centre - frame.origin)
            lists["linkInertiasCOM"][-1] = frame.turn.T @ body.inertia @ frame.turn
        made.frames.append(frame)
    return made


def single_joints(
    joint: SpatialJoint, body: SpatialBody, exact: SpatialMotion
) -> list[tuple[Any, Array, tuple[float, float, float]]]:
    """Exudyn's joints of a joint: type, frame (3, 3) with its axis third, and coordinate, rate and acceleration."""
    rate, acceleration = exact.rates[:2, joint.rates, 0]
    if joint.kind != "ball":
        coordinate = float(exact.coordinates[joint.coordinate, 0]) - joint.reference
        state = (coordinate, float(rate[0]), float(acceleration[0]))
        return [(JOINT_TYPES[joint.kind], frame_along(joint.axis), state)]
    # The last hinge is along the axis of least inertia, about which a rod may spin freely: no spin makes it singular.
    axes = np.linalg.eigh(body.inertia)[1][:, ::-1]
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    # Angles a, b, c about these axes are 0 at the start. Of w = Rc' Rb' (1, 0, 0) a' + Rc' (0, 1, 0) b' + (0, 0, 1) c'
    # along them, w' = (a'' + b' c', b'' - a' c', c'' + a' b') there.
    x, y, z = turning = axes.T @ rate
    bent = axes.T @ acceleration + np.array([-y * z, x * z, -x * y])
    return [
        (JOINT_TYPES["hinge"], frame_along(axis), (0.0, float(w), float(a)))
        for axis, w, a in zip(axes.T, turning, bent, strict=True)
    ]


def frame_along(axis: Array) -> Array:
    """A rotation (3, 3) whose third column is along an axis."""
    along = axis / np.linalg.norm(axis)
    aside = np.cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    aside /= np.linalg.norm(aside)
    return np.column_stack([aside, np.cross(along, aside), along])


class LawOffset:
    """Coordinate and rate that a drive's law prescribes, as Exudyn asks for them: by the time in a block of steps.

    Exudyn asks several times in a step, always at its end: laws are evaluated for a block of steps at once.

    Attributes:
        before: steps before the present block.
    """

    def __init__(self, law: DriveLaw, reference: float, step: float) -> None:
        self.before, self._law, self._reference, self._step = 0, law, reference, step
        self._known: dict[int, tuple[float, float]] = {}

    def evaluate(self, time: float) -> tuple[float, float]:
        """Coordinate and rate at a time [s] after the block's beginning, a whole number of steps."""
        k = self.before + round(time / self._step)
        if k not in self._known:
            steps = np.arange(k, k + BLOCK_STEPS)
            values = self._law.derivatives(np.asarray(self._step * steps, dtype=float))[:2]
            values[0] -= self._reference
            self._known = dict(zip(steps.tolist(), map(tuple, values.T.tolist()), strict=True))
        return self._known[k]


@dataclass(frozen=True)
class SpatialSystem(ExudynSystem):
    """A machine in space in Exudyn.

    Attributes:
        sensors: numbers of three sensors by observed point: position, velocity and acceleration.
        offsets: laws that are asked for by time.
    """

    sensors: Mapping[str, tuple[int, ...]]
    offsets: tuple[LawOffset, ...]


def build_in_space(start: SpatialStart, chain: KinematicChain) -> SpatialSystem:
    """Build the system of a machine in its exact state, with its drives and sensors."""
    container = exudyn.SystemContainer()
    system, tree, joints = container.AddSystem(), start.tree, len(chain.state)
    coordinates, rates, _ = (list(row) for row in zip(*chain.state, strict=True))
    node = system.AddNode(
        NodeGenericODE2(
            referenceCoordinates=[0.0] * joints, initialCoordinates=coordinates, initialCoordinates_t=rates,
            numberOfODE2Coordinates=joints,
        )
    )  # fmt: skip
    links = dict(chain.lists)
    for name, kind in LISTS.items():
        links[name] = kind(links[name])
    number = system.AddObject(ObjectKinematicTree(nodeNumber=node, gravity=tree.gravity.tolist(), **links))
    ground = system.AddObject(ObjectGround())

    def marker(point: SpatialPoint, turn: Array) -> int:
        """Add a marker at a point, along the axes of a frame (3, 3) in its body's; return its number."""
        frame, local = chain.frames[point.body], np.eye(4)
        local[:3, :3], local[:3, 3] = frame.turn.T @ turn, frame.place_of(point)
        if frame.link < 0:
            return int(system.AddMarker(MarkerBodyRigid(bodyNumber=ground, localHT=local.tolist())))
        at = {"linkNumber": frame.link, "localHT": local.tolist()}
        return int(system.AddMarker(MarkerKinematicTreeRigid(objectNumber=number, **at)))

    for closure in tree.closures:
        if not closure.points:
            _add_coupling(system, closure, tree, node, chain)
            continue
        turns = (np.eye(3) if closure.turn is None else closure.turn, np.eye(3))
        ends = [marker(point, turn) for point, turn in zip(closure.points, turns, strict=True)]
        joint = ObjectJointSpherical if closure.kind == "connect" else ObjectJointGeneric
        system.AddObject(joint(markerNumbers=ends))
    offsets = _add_drives(system, start, node, chain)
    sensors = {
        name: tuple(
            int(system.AddSensor(SensorKinematicTree(
                objectNumber=number, linkNumber=chain.frames[point.body].link, writeToFile=False,
                localPosition=chain.frames[point.body].place_of(point),
                outputVariableType=getattr(exudyn.OutputVariableType, quantity),
            )))
            for quantity in MOTION
        )
        for name, point in start.points.items()
    }  # fmt: skip
    system.Assemble()
    return SpatialSystem(container, system, -1, sensors, offsets)


def _add_coupling(system: Any, closure: SpatialClosure, tree: SpatialTree, node: int, chain: KinematicChain) -> None:
    """Constrain a joint's coordinate to a linear function of another's, both from their references."""
    names = {joint.rate: joint.name for joint in tree.joints}
    ends = [
        system.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=chain.of_joint[names[rate]]))
        for terms in closure.sums
        for rate in terms
    ]
    constant, factor = closure.polynomial[:2]
    # Exudyn holds factor1 times the second coordinate, less the first, to the offset.
    system.AddObject(ObjectConnectorCoordinate(markerNumbers=ends, factor1=factor, offset=-constant))


def _add_drives(system: Any, start: SpatialStart, node: int, chain: KinematicChain) -> tuple[LawOffset, ...]:
    """Constrain the driven joints to their laws: a constant rate, or a coordinate asked for by time."""
    still = system.AddMarker(MarkerNodeCoordinate(nodeNumber=system.AddNode(NodePointGround()), coordinate=0))
    offsets = []
    for joint, law in zip(start.machine.driven, start.machine.laws.values(), strict=True):
        moving = MarkerNodeCoordinate(nodeNumber=node, coordinate=chain.of_joint[joint.name])
        ends = [still, system.AddMarker(moving)]
        if (rate := constant_rate(law)) is not None:
            system.AddObject(ObjectConnectorCoordinate(markerNumbers=ends, offset=rate, velocityLevel=True))
            continue
        offset = LawOffset(law, joint.reference, start.step)
        offsets.append(offset)
        asked = {"offsetUserFunction": _reader(offset, 0), "offsetUserFunction_t": _reader(offset, 1)}
        system.AddObject(ObjectConnectorCoordinate(markerNumbers=ends, **asked))
    return tuple(offsets)


def _reader(offset: LawOffset, which: int) -> Callable[[Any, float, int, float], float]:
    """A user function of Exudyn that reads a law's coordinate (0) or rate (1)."""
    return lambda system, time, item, constant: offset.evaluate(time)[which]


class ExudynSpatialStepper(SolverStepper):
    """A machine in space in Exudyn that starts in an exact state; a call advances it by some steps."""

    def __init__(self, start: SpatialStart, preset: str) -> None:
        # A preset's rule is asked of a machine in the plane, whose step is another.
        settings = replace(EXUDYN_PRESETS[preset](TIMED_REFERENCE, 1000), timestep=start.step)
        super().__init__(settings)
        self._settings.linearSolver.solverType = exudyn.LinearSolverType.EigenDense
        self._settings.linearSolver.ignoreSingularJacobian = True
        alpha = self._settings.timeIntegration.generalizedAlpha
        # Exudyn's own initial accelerations know no user function: the exact ones are given.
        alpha.computeInitialAccelerations = alpha.resetAccelerations = False
        chain = link_chain(start)
        with silence_output():
            self.made = self._made = build_in_space(start, chain)
            accelerations = [state[2] for state in chain.state]
            self.made.system.systemData.SetODE2Coordinates_tt(accelerations, exudyn.ConfigurationType.Initial)
            self._call_solver("the start", self._solver.InitializeSolver)

        self._balls = {j.name: chain.of_joint[j.name] for j in start.tree.joints if j.kind == "ball"}

    def __call__(self, steps: int) -> None:
        before = self.failure
        super().__call__(steps)
        for offset in self.made.offsets:
            offset.before += steps
        if self.failure and not before:
            angles = self.made.system.systemData.GetODE2Coordinates()
            for name, middle in self._balls.items():
                if abs(math.cos(angles[middle])) < SINGULAR_BALL:
                    self.failure += f"; the three hinges that the ball {name} is made of are nearly singular there"


def run_in_space(start: SpatialStart, preset: str, steps: int, every: int = 1) -> SpatialRun:
    """Run a machine from its exact state, and record its points at the start and after each `every` steps."""
    stepper, rows = ExudynSpatialStepper(start, preset), list[Array]()
    made, sample = stepper.made, count(0)

    def record(*_: object) -> bool:
        """Read all sensors at the start and after a step; return True, which lets the solver continue."""
        if next(sample) % every == 0:
            rows.append(np.array([[made.system.GetSensorValues(k) for k in three] for three in made.sensors.values()]))
        return True

    made.system.SetPostStepUserFunction(record)
    for done in range(0, steps, BLOCK_STEPS):
        # Exudyn calls the function before the first step of a block, too: there the state is the last one's.
        if done:
            sample, rows = count(done), rows[: -1 if done % every == 0 else None]
        stepper(min(BLOCK_STEPS, steps - done))
    times = start.step * every * np.arange(len(rows), dtype=float)
    moved = np.reshape(rows, (len(rows), len(start.points), 3, 3)).transpose(1, 2, 0, 3)
    return SpatialRun(times, dict(zip(start.points, moved, strict=True)), stepper.failure)
