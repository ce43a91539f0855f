"""Defects of the machine that a run is compared with, and the machine put together in another way.

A run of a right model against a machine with a longer rod is as far off as one of a wrong model against the right
machine, and needs no run of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Self

import numpy as np

from conrod.engines.capabilities import Lacking, Varied, capability
from conrod.engines.engine import Engine
from conrod.errors import InvalidInput
from conrod.exact import ExactReference, GenericReference
from conrod.exact.kinematics import Kinematics
from conrod.mechanism.mechanism import Mechanism, Point, Revolute
from conrod.runs.trajectory import Piece, concatenate_pieces
from conrod.scenes import Scene

ASSEMBLIES, APART = 40, 0.01  # starts from which another assembly is looked for; of the size, how far it is off


@dataclass(frozen=True)
class Recording:
    """A run as it was recorded, and the machine that it is compared with.

    Attributes:
        made_by: the engine, to make the run again; None where that cannot be.
        start_angle: of the run [rad].
    """

    run: Piece
    reference: ExactReference
    made_by: Engine[Any] | None
    start_angle: float = 0.0

    @classmethod
    def of(cls, engine: Engine[Any], scene: ExactReference, settings: Any, turns: float, start_angle: float) -> Self:
        """The run of an engine, as one piece."""
        steps = max(round(settings.steps_per_revolution * turns), 1)
        run = concatenate_pieces(list(engine.run(scene, settings, turns, start_angle, steps)))
        return cls(run, scene, engine, start_angle)


Plant = Callable[[Recording, float], Recording]
Plants = Callable[[Recording], Iterator[tuple[str, Plant]]]  # by where they are planted; none where there is no place


def softness(given: Recording) -> Iterator[tuple[str, Plant]]:
    """The run made again, with joints or contacts that take so many steps longer to mend an error."""
    engine = given.made_by
    if engine is None or isinstance(varied := capability(engine, Varied), Lacking):
        return
    settings: Any = given.run.trajectory.settings
    contact = bool(given.reference.mechanism().cam_contacts)
    own = settings.time_constant(contact) / settings.timestep

    def softer(now: Recording, steps: float) -> Recording:
        if steps == 0.0:
            return now
        changed = varied.stabilised(now.reference, settings, own + abs(steps))
        turns = now.run.trajectory.revolutions
        return Recording.of(engine, now.reference, changed, turns, now.start_angle)

    yield "", softer


def _machines(places: Callable[[Mechanism], Iterator[tuple[str, Callable[[float], Mechanism]]]]) -> Plants:
    """Plants of changed mechanisms, by the generic solver."""

    def plant(changed: Callable[[float], Mechanism], given: Recording, size: float) -> Recording:
        return replace(given, reference=GenericReference(changed(size), given.reference.speed))

    return lambda given: ((where, partial(plant, one)) for where, one in places(given.reference.mechanism()))


def _with_place(mechanism: Mechanism, name: str, end: str, at: Any, by: Any, size: float) -> Mechanism:
    """The mechanism with the point at one end of a joint moved from a place by so many times a way."""
    change: Any = {end: tuple((np.asarray(at) + size * np.asarray(by)).tolist())}
    joints = tuple(replace(joint, **change) if joint.name == name else joint for joint in mechanism.joints)
    return replace(mechanism, joints=joints)


def _links(mechanism: Mechanism) -> Iterator[tuple[str, Callable[[float], Mechanism]]]:
    """Distances of the pins of each link, the crank too, from its first one."""
    for body in mechanism.bodies:
        ends = [(j, "point_a" if j.a == body.name else "point_b") for j in mechanism.joints_on(body.name)]
        pins: list[tuple[str, str, Point]] = [
            (joint.name, end, getattr(joint, end)) for joint, end in ends if isinstance(joint, Revolute)
        ]
        for name, end, place in pins[1:]:
            way = np.subtract(place, pins[0][2])
            if way.any():
                yield body.name, partial(_with_place, mechanism, name, end, place, way)


def lengths(given: Recording) -> Iterator[tuple[str, Plant]]:
    """Lengths of links, and of a machine with a cam all lengths that the scene names."""

    def scaled(name: str, now: Recording, share: float) -> Recording:
        scene: Any = now.reference
        return replace(now, reference=scene.with_parameters(**{name: (1.0 + share) * scene.parameters[name]}))

    yield from _machines(_links)(given)
    scene = given.reference
    if isinstance(scene, Scene) and scene.mechanism().cam_contacts:
        for name, fact in scene.parameter_facts().items():
            if fact.unit == "m" and scene.parameters[name]:
                yield name, partial(scaled, name)


def masses(given: Recording) -> Iterator[tuple[str, Plant]]:
    """The mass of each body."""

    def changed(mechanism: Mechanism, name: str, share: float) -> Mechanism:
        bodies = [replace(b, mass=(1.0 + share) * b.mass) if b.name == name else b for b in mechanism.bodies]
        return replace(mechanism, bodies=tuple(bodies))

    places = _machines(lambda machine: ((body.name, partial(changed, machine, body.name)) for body in machine.bodies))
    yield from places(given)


def another_assembly(reference: ExactReference) -> Kinematics | None:
    """The machine put together so that an observed point stands elsewhere all along, if that can be; else None."""
    healthy, mechanism = reference.kinematics, reference.mechanism()
    chance, angles = np.random.default_rng(1), healthy.angles(36)
    shown = healthy.point_derivatives([healthy.poses(angles)])
    places = np.arange(healthy.start.size).reshape(-1, 3)[:, :2].ravel()
    for _ in range(ASSEMBLIES):
        poses = healthy.start.copy()
        poses[0, 2::3] += chance.uniform(-math.pi, math.pi, len(mechanism.bodies))
        # With the turns given, places follow from the joints: what does not fit is left to Newton's iteration.
        left = healthy.residual([poses], np.zeros(1))[0]
        poses[0, places] -= np.linalg.lstsq(healthy.jacobian(poses)[0][:, places], left)[0]
        rows = poses.reshape(-1, 3).tolist()
        guess: Any = {body.name: tuple(row) for body, row in zip(mechanism.bodies, rows, strict=True)}
        try:
            other = Kinematics(replace(mechanism, poses=guess))
            # Where it stands at the start is known without its whole turn.
            if all(
                _apart(other.point_derivatives([other.poses(at)]), shown, healthy.size) for at in (angles[:1], angles)
            ):
                return other
        except (InvalidInput, np.linalg.LinAlgError):
            continue
    return None


def _apart(points: Any, shown: Any, size: float) -> bool:
    """True if a point keeps away from where it was shown."""
    apart = [np.linalg.norm(at[0] - shown[name][0][: len(at[0])], axis=1).min() for name, at in points.items()]
    return bool(max(apart) >= APART * size)
