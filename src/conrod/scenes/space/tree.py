"""A spatial machine as the tree that engines are given, from its links alone: no engine computes its masses."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from conrod.exact.motion import Array
from conrod.exact.space import (
    COORDINATES,
    RATES,
    SpatialBody,
    SpatialClosure,
    SpatialJoint,
    SpatialPoint,
    SpatialTree,
)
from conrod.exact.space.drive_laws import DriveLaw, parse_drive_law
from conrod.scenes.space.machine import (
    ORIGIN,
    ROD_RADIUS,
    STEEL_DENSITY,
    LinkJoint,
    LoopClosure,
    ModelLink,
    SpatialMachine,
)

GRAVITY = np.array([0.0, 0.0, -9.81])  # [m/s^2]


def spatial_tree(machine: SpatialMachine) -> SpatialTree:
    """Build the tree of a machine, in the reference pose, with its links' sites as observed points."""
    links = list(_links_with_parents(machine.links, 0, ORIGIN, 0))
    joints, bodies = (
        _place_joints(links),
        [SpatialBody("world", 0, ORIGIN, np.eye(3), (), 0.0, ORIGIN, np.zeros((3, 3)))],
    )
    for number, (link, parent, parent_origin) in enumerate(links, 1):
        mass, centre, inertia = rod_inertia([end - link.origin for end in link.rods])
        own = tuple(joint for joint in joints if joint.body == number)
        place = link.origin - parent_origin
        bodies.append(SpatialBody(link.name, parent, place, np.eye(3), own, mass, centre, inertia))
    points = {
        name: SpatialPoint(number, place - link.origin)
        for number, (link, _, _) in enumerate(links, 1)
        for name, place in link.sites.items()
    }
    by_name = {link.name: (number, link) for number, (link, _, _) in enumerate(links, 1)}
    closures = tuple(_closure(one, points, by_name) for one in machine.closures)
    start = np.concatenate([[1.0, 0.0, 0.0, 0.0] if joint.kind == "ball" else [0.0] for joint in joints])
    return SpatialTree(tuple(bodies), closures, points, GRAVITY, start)


def _links_with_parents(
    links: Sequence[ModelLink], parent: int, parent_origin: Array, before: int
) -> Iterator[tuple[ModelLink, int, Array]]:
    """Yield links with their parent's number and origin; a link's number follows all links before it, depth first.

    Args:
        before: number of links that have been yielded.
    """
    for link in links:
        before += 1
        yield link, parent, parent_origin
        carried = list(_links_with_parents(link.links, before, link.origin, before))
        yield from carried
        before += len(carried)


def _place_joints(links: Sequence[tuple[ModelLink, int, Array]]) -> list[SpatialJoint]:
    """Number the joints of all links, in the order of their coordinates."""
    made, coordinate, rate = list[SpatialJoint](), 0, 0
    for number, (link, _, _) in enumerate(links, 1):
        for joint in link.joints:
            axis = np.asarray(joint.axis / np.linalg.norm(joint.axis))
            made.append(SpatialJoint(joint.name, joint.kind, number, coordinate, rate, ORIGIN, axis))
            coordinate, rate = coordinate + COORDINATES[joint.kind], rate + RATES[joint.kind]
    return made


def _closure(
    closure: LoopClosure, points: dict[str, SpatialPoint], links: dict[str, tuple[int, ModelLink]]
) -> SpatialClosure:
    """A closure of two sites that coincide, or of two links that are welded as they are in the reference pose."""
    if closure.kind == "connect":
        return SpatialClosure(closure.name, closure.kind, (points[closure.first], points[closure.second]))
    (one, first), (two, second) = links[closure.first], links[closure.second]
    ends = (SpatialPoint(one, second.origin - first.origin), SpatialPoint(two, ORIGIN))
    return SpatialClosure(closure.name, closure.kind, ends, np.eye(3))


def rod_inertia(ends: Sequence[Array]) -> tuple[float, Array, Array]:
    """Mass [kg], centre of gravity (3,) [m] and inertia about it (3, 3) [kg m^2] of steel rods with round ends.

    A rod of length s is a cylinder of mass c and two half balls of mass b in all: along its axis it has
    c r^2 / 2 + 2 b r^2 / 5, across it c (3 r^2 + s^2) / 12 + b (2 r^2 / 5 + s^2 / 4 + 3 s r / 8).

    Args:
        ends: far ends (3,) [m] of the rods, which begin at the origin; a ball at the origin if there are none.
    """
    r, parts = ROD_RADIUS, list[tuple[float, Array, Array]]()
    ball = STEEL_DENSITY * 4.0 / 3.0 * math.pi * r**3
    for end in ends or (ORIGIN,):
        s = float(np.linalg.norm(end))
        cylinder = STEEL_DENSITY * math.pi * r**2 * s
        along = cylinder * r**2 / 2.0 + 0.4 * ball * r**2
        across = cylinder * (3.0 * r**2 + s**2) / 12.0 + ball * (0.4 * r**2 + s**2 / 4.0 + 0.375 * s * r)
        axis = end / s if s else np.array([1.0, 0.0, 0.0])
        parts.append((cylinder + ball, 0.5 * end, across * np.eye(3) + (along - across) * np.outer(axis, axis)))
    mass = sum(part[0] for part in parts)
    centre = np.asarray(sum(part[0] * part[1] for part in parts) / mass)
    inertia = np.zeros((3, 3))
    for own, place, about in parts:
        arm = place - centre
        inertia += about + own * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return mass, centre, inertia


# -- its drives, and its motion ---------------------------------------------------------------------------------------


def machine_laws(machine: SpatialMachine) -> dict[str, DriveLaw]:
    """Laws of the driven joints by name; in the reference pose their coordinates are 0."""
    units = {joint.name: "m" if joint.kind == "slide" else "rad" for joint in _joints(machine.links)}
    return {name: parse_drive_law(text, units[name], 0.0, name) for name, text in machine.drives.items()}


def _joints(links: Sequence[ModelLink]) -> Iterator[LinkJoint]:
    for link in links:
        yield from link.joints
        yield from _joints(link.links)


def law_period(laws: Mapping[str, DriveLaw]) -> float:
    """Time [s] that the slowest drive takes for its law."""
    return max(law.duration for law in laws.values() if law.duration < math.inf)


def exact_points(machine: SpatialMachine, times: Array) -> dict[str, Array]:
    """Position, velocity and acceleration (3, T, 3) of the observed points by the closed form."""
    return machine.points({joint: law.derivatives(times)[:3] for joint, law in machine_laws(machine).items()})
