"""Cam profiles of a file: one of a named shape, arc by arc, or from a motion law."""

from __future__ import annotations

import math
from itertools import pairwise

from conrod.cam import Arc, CamProfile, symmetric_cam
from conrod.cam_shape import Profile
from conrod.errors import InvalidInput
from conrod.mechanism_files.cam_laws import read_law
from conrod.mechanism_files.fields import Fields
from conrod.mechanism_files.numbers import ANGLE, COORDINATE, LENGTH, shown

MOST_ARCS = 2000
# Of the largest radius: what written digits may leave between the end of an arc and the start of the next.
JOINED = 1e-6


def read_profile(fields: Fields, roller_radius: float) -> Profile:
    """The profile of a cam, in the frame of its body.

    Args:
        roller_radius: of the roller that a motion law's profile is made for [m].

    Raises:
        InvalidInput: it is not closed, not convex, or something in it cannot be used.
    """
    profile: Profile
    match fields.choice("kind", ("symmetric", "arcs", "law")):
        case "symmetric":
            profile = _symmetric(fields)
        case "arcs":
            profile = _arcs(fields)
        case _:
            profile = read_law(fields, roller_radius)
    fields.end()
    return profile


def _symmetric(fields: Fields) -> CamProfile:
    base, flank, nose, distance = (
        fields.number(name, LENGTH, f"{name.replace('_', ' ')} of the cam")
        for name in ("base_radius", "flank_radius", "nose_radius", "centre_distance")
    )
    if not abs(base - nose) < distance:
        raise InvalidInput(
            f"{fields.at('centre_distance')} = {distance:g} m must be more than the difference of base_radius and "
            f"nose_radius, {abs(base - nose):g} m: one circle would lie inside the other"
        )
    least = 0.5 * (base + nose + distance)
    if flank < least:
        raise InvalidInput(
            f"{fields.at('flank_radius')} = {flank:g} m must be at least (base_radius + nose_radius + "
            f"centre_distance) / 2 = {least:g} m"
        )
    return symmetric_cam(base, flank, nose, distance)


def _arcs(fields: Fields) -> CamProfile:
    given = fields.raw("arcs")
    if not isinstance(given, list) or not 1 <= len(given) <= MOST_ARCS:
        raise InvalidInput(f"{fields.at('arcs')} = {shown(given)}: a list of 1 to {MOST_ARCS} arcs is wanted")
    arcs = tuple(_arc(Fields(some, f"{fields.at('arcs')}[{k}]", fields.numbers)) for k, some in enumerate(given))
    turn = arcs[-1].stop - arcs[0].start
    if not math.isclose(turn, 2.0 * math.pi, abs_tol=JOINED):
        raise InvalidInput(
            f"{fields.at('arcs')}: their normals turn by {math.degrees(turn):.9g} deg from the first start to the last "
            "stop; a closed profile has 360 deg"
        )
    largest = max(arc.radius for arc in arcs)
    for k, (arc, following) in enumerate(pairwise([*arcs, arcs[0]])):
        after = following.start if k + 1 < len(arcs) else following.start + 2.0 * math.pi
        gap = math.dist(_point(arc, arc.stop), _point(following, following.start))
        if abs(after - arc.stop) > JOINED or gap > JOINED * largest:
            raise InvalidInput(
                f"{fields.at('arcs')}[{k}]: it is not tangent to the next one: a gap of {gap:.3g} m and "
                f"{math.degrees(after - arc.stop):.3g} deg between them"
            )
    return CamProfile(arcs)


def _arc(fields: Fields) -> Arc:
    arc = Arc(
        fields.pair("centre", COORDINATE, "centre of an arc of the cam"),
        fields.number("radius", LENGTH, "radius of an arc of the cam"),
        fields.number("start", ANGLE, "direction of the normal where an arc of the cam begins"),
        fields.number("stop", ANGLE, "direction of the normal where an arc of the cam ends"),
    )
    fields.end()
    if not 0.0 < arc.extent <= 2.0 * math.pi + JOINED:
        raise InvalidInput(f"{fields.place}: stop must be after start, by 360 deg at most: arcs go counter-clockwise")
    return arc


def _point(arc: Arc, normal: float) -> tuple[float, float]:
    return (arc.centre[0] + arc.radius * math.cos(normal), arc.centre[1] + arc.radius * math.sin(normal))
