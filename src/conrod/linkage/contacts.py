"""The points in which links roll on each other, in velocity and acceleration polygons."""

from __future__ import annotations

from conrod.linkage.accelerations import rolling_acceleration
from conrod.linkage.centres import joint_centre
from conrod.linkage.points import POLE, Carrier, NamedPoint, RollingContact, guided, place_name
from conrod.linkage.state import LinkageState, link_numbers
from conrod.mechanism import GROUND
from conrod.motion import Array


def shared_point(state: LinkageState, contact: RollingContact) -> NamedPoint:
    """The point of both links: they have one velocity there."""
    carriers = _carriers(state, contact)
    carriers.sort(key=lambda carrier: not guided(state.mechanism, carrier.link))
    return NamedPoint(contact.name, tuple(carriers))


def parted_points(state: LinkageState, contact: RollingContact) -> list[NamedPoint]:
    """The point of each moving link, with that link's number: their accelerations differ."""
    numbers = link_numbers(state.mechanism)
    return [
        NamedPoint(f"{contact.name}{numbers[carrier.link]}", (carrier,), fixed=contact.on_ground)
        for carrier in _carriers(state, contact)
    ]


def contact_vector(state: LinkageState, contact: RollingContact) -> tuple[str, tuple[str, str], Array]:
    """Name, places and value [m/s^2] of the acceleration of the one link's point against the other's."""
    numbers = link_numbers(state.mechanism)
    joint, value = contact.joint, rolling_acceleration(state, contact.joint)
    first, second = joint.a, joint.b
    if second == GROUND:
        first, second, value = second, first, -value
    one, other = (f"{contact.name}{numbers[link]}" for link in (first, second))
    if first == GROUND:
        return f"A_{other}", (POLE, place_name(other)), value
    return f"A_{other}/{one}", (place_name(one), place_name(other)), value


def _carriers(state: LinkageState, contact: RollingContact) -> list[Carrier]:
    centre = joint_centre(state, contact.joint)
    assert centre is not None
    moving = [link for link in (contact.joint.a, contact.joint.b) if link != GROUND]
    return [Carrier(link, state.links[link].own(centre[:2])) for link in moving]
