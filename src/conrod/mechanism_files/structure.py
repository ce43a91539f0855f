"""How bodies and joints hang together: the order in which they are taken, whatever the order of the file."""

from __future__ import annotations

from dataclasses import dataclass, replace

from conrod.errors import InvalidInput
from conrod.mechanism import GROUND, Body, Driver, HigherPair, Joint, Revolute


@dataclass(frozen=True)
class Structure:
    """Bodies and joints in the order in which motion reaches them from the crank."""

    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]


def ordered(bodies: tuple[Body, ...], joints: tuple[Joint, ...], driver: Driver) -> Structure:
    """Bodies as a search in breadth from the crank finds them, and each body's joints with it; ties by name.

    Engines solve joints one after the other, and results depend on the order where they stop early: so that of a file
    must not count, and this one follows the motion. A pin's body `a` is the one that is reached first.

    Raises:
        InvalidInput: a body has no joint, or its mobility is not one.
    """
    _check_joined(bodies, joints)
    _check_mobility(bodies, joints)
    by_name = sorted(joints, key=lambda joint: (joint.name != driver.joint, joint.name))
    crank = next(body for joint in by_name[:1] for body in (joint.a, joint.b) if body != GROUND)
    reached, taken = [crank], []
    for body in reached:
        here = [joint for joint in by_name if body in (joint.a, joint.b) and joint not in taken]
        taken += here
        reached += _new(here, reached)
    loose = sorted({body.name for body in bodies} - set(reached))
    if loose:
        raise InvalidInput(
            f"bodies.{loose[0]}: no chain of joints leads to it from the crank {crank!r}: it would not move"
        )
    known = {body.name: body for body in bodies}
    place = {name: k for k, name in enumerate([GROUND, *reached])}
    return Structure(tuple(known[name] for name in reached), tuple(_turned(joint, place) for joint in taken))


def _new(joints: list[Joint], reached: list[str]) -> list[str]:
    found = {body: None for joint in joints for body in (joint.a, joint.b) if body != GROUND and body not in reached}
    return list(found)


def _turned(joint: Joint, place: dict[str, int]) -> Joint:
    if isinstance(joint, Revolute) and place[joint.a] > place[joint.b]:
        return replace(joint, a=joint.b, b=joint.a, point_a=joint.point_b, point_b=joint.point_a)
    return joint


def _check_joined(bodies: tuple[Body, ...], joints: tuple[Joint, ...]) -> None:
    joined = {body for joint in joints for body in (joint.a, joint.b)}
    for body in bodies:
        if body.name not in joined:
            raise InvalidInput(f"bodies.{body.name}: no joint holds it")


def _check_mobility(bodies: tuple[Body, ...], joints: tuple[Joint, ...]) -> None:
    higher = sum(isinstance(joint, HigherPair) for joint in joints)
    lower = len(joints) - higher
    mobility = 3 * len(bodies) - 2 * lower - higher
    if mobility == 1:
        return
    count = f"mobility {mobility}: 3 x {len(bodies)} moving bodies - 2 x {lower} lower - {higher} higher pairs"
    if mobility > 1:
        raise InvalidInput(f"{count}; one driven crank needs exactly 1: more joints, or fewer bodies, are wanted")
    raise InvalidInput(
        f"{count}; it cannot move, or only because of special lengths, which is not supported: exactly 1 is needed"
    )
