"""The classic quantities of a linkage as tables, and in SI units and radians as `conrod show --json` writes them."""

from __future__ import annotations

import math
from importlib.metadata import version
from typing import Any

import numpy as np

from conrod.exact.linkage import InstantQuantities, PointQuantities, TurnQuantities
from conrod.exact.linkage.centres import InstantCentre, centre_count
from conrod.exact.linkage.course import CrankRange
from conrod.exact.linkage.outputs import Output
from conrod.exact.linkage.polygon import Polygon
from conrod.exact.motion import Array
from conrod.report import numbers
from conrod.report.saved import json_text
from conrod.report.table import Table, table
from conrod.runs.plain import plain
from conrod.scenes import Scene

# Below this share of the largest value a digit is rounding, different from machine to machine.
ROUNDING = 1e-9
MM = 1e3
SCHEMA = 2  # of the JSON


# -- of a turn -------------------------------------------------------------------------------------------------------


def reach_words(reach: CrankRange) -> str:
    """Range of the crank in words."""
    if reach.full:
        passed = ", ".join(degrees(angle) for angle in reach.change_points)
        return f"turns fully, through change points at {passed} deg" if passed else "turns fully"
    ends = {"limit": "where it has to turn back", "change point": "a change point", "none": "no end"}
    start, stop = (f"{degrees(angle)} deg" for angle in (reach.start, reach.stop))
    if reach.start_end == reach.stop_end:
        both = "both where it has to turn back" if reach.stop_end == "limit" else f"both {ends[reach.stop_end]}s"
        return f"reaches from {start} to {stop}, {both}"
    return f"reaches from {start} ({ends[reach.start_end]}) to {stop} ({ends[reach.stop_end]})"


def outputs_table(turn: TurnQuantities) -> Table:
    """Strokes, dead centres and time ratios of the driven links."""
    right = ("stroke", "turns back at [deg]", "there and back [deg]", "time ratio")
    title = "strokes, dead centres and time ratios"
    return table(("driven link", "guided by", *right), [_output_row(output) for output in turn.outputs], right, title)


def _output_row(output: Output) -> tuple[str, ...]:
    if output.stroke is None:
        stroke = f"goes on, {_way(output.gain, output.unit)} a turn"
    else:
        stroke = _way(output.stroke, output.unit)
    there_and_back = ""
    if output.forward is not None and output.backward is not None:
        there_and_back = f"{degrees(output.forward)}, {degrees(output.backward)}"
    ratio = "" if output.time_ratio is None else f"{output.time_ratio:.6g}"
    ends = [dict.fromkeys((degrees(centre.angle), degrees(centre.until))) for centre in output.dead_centres]
    centres = ", ".join(" to ".join(end) for end in ends)
    return (output.link, output.joint, stroke, centres or "nowhere", there_and_back, ratio)


def _way(value: float, unit: str) -> str:
    return f"{MM * value:.6g} mm" if unit == "m" else f"{math.degrees(value):.6g} deg"


def transmission_table(turn: TurnQuantities) -> Table:
    """Transmission angles of the driven links, with the crank angles where they are taken."""
    head = ("driven link", "pushed by", "least", "greatest", "worst", "greatest pressure angle")
    title = "transmission angles [deg], and the crank angles where they are taken"
    rows = []
    for angle in turn.transmission:
        extremes = (angle.least, angle.greatest, angle.worst, angle.greatest_pressure_angle)
        values = [f"{math.degrees(one.value):.4f} at {math.degrees(one.angle):.2f}" for one in extremes]
        rows.append((angle.driven, angle.through, *values))
    return table(head, rows, title=title)


# -- at a crank angle ------------------------------------------------------------------------------------------------


def instant_tables(instant: InstantQuantities) -> tuple[Table, ...]:
    """Links, centres, points and polygons; those of them that there are."""
    rows = [(centre.name, " and ".join(centre.links), centre.kind, *_centre(centre)) for centre in instant.centres]
    coordinates = ("x [mm]", "y [mm]")
    centres = table(("", "of", "kind", *coordinates), rows, coordinates, "instant centres")
    vectors = (_vectors_table(instant.velocities, "m/s"), _vectors_table(instant.accelerations, "m/s²"))
    return (centres, *([_points_table(instant)] if instant.points else []), *vectors)


def links_table(instant: InstantQuantities, numbering: dict[str, int]) -> Table:
    """Poses, rates and angular accelerations of the moving links."""
    links = {name: instant.state.links[name] for name in numbering}
    turning = [link.angular_velocity for link in links.values()]
    changing = [link.angular_acceleration for link in links.values()]
    rows = [
        (
            *(str(numbering[name]), name, *(_length(value) for value in link.pose[:2]), degrees(link.pose[2])),
            _clean(link.angular_velocity, turning),
            _clean(link.angular_acceleration, changing),
        )
        for name, link in links.items()
        if name in instant.state.mechanism.body_index
    ]
    right = ("x [mm]", "y [mm]", "turn [deg]", "angular velocity [rad/s]", "angular acceleration [rad/s²]")
    return table(("", "link", *right), rows, right, "links")


def _points_table(instant: InstantQuantities) -> Table:
    points = instant.points
    speeds = [_size(point.velocity) for point in points]
    parts = [_size(part) for p in points for part in (p.parts.normal, p.parts.tangential)]
    rows = [
        (
            *(point.name, ", ".join(point.links), *(_length(float(value)) for value in point.place)),
            _clean(_size(point.velocity), speeds),
            *(_clean(_size(a), parts) for a in (p.normal + p.tangential, p.normal, p.tangential)),
            _radius(point),
        )
        for point, p in ((point, point.parts) for point in points)
    ]
    right = ("x [mm]", "y [mm]", "velocity [m/s]", "acceleration [m/s²]", "normal", "tangential", "radius of path [mm]")
    return table(("", "of", *right), rows, right, "points")


def _vectors_table(polygon: Polygon, unit: str) -> Table:
    sizes = [_size(vector.value) for vector in polygon.vectors]
    rows = []
    for vector, size in zip(polygon.vectors, sizes, strict=True):
        there = size > ROUNDING * max(sizes)
        turn = degrees(math.atan2(vector.value[1], vector.value[0]) % (2.0 * math.pi)) if there else ""
        rows.append((vector.name, _clean(size, sizes), turn, vector.kind, vector.link or ""))
    right = (f"size [{unit}]", "direction [deg]")
    title = "velocities" if polygon.quantity == "velocity" else "accelerations, in their parts"
    return table(("", *right, "kind", "link"), rows, right, title)


def _radius(point: PointQuantities) -> str:
    radius = point.parts.radius
    if radius is None:
        return "at rest"
    return "straight" if math.isinf(radius) else _length(radius)


def _centre(centre: InstantCentre) -> tuple[str, str]:
    if centre.place is not None:
        return _length(centre.place[0]), _length(centre.place[1])
    if centre.direction is None:
        return "the two move as one", ""
    x, y = centre.direction
    return "at infinity", f"at {degrees(math.atan2(y, x) % math.pi)} deg"


# -- words -----------------------------------------------------------------------------------------------------------


def degrees(angle: float) -> str:
    """An angle [rad] in degrees, to a ten thousandth, without zeros that carry nothing."""
    text = f"{math.degrees(angle):.4f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _length(value: float) -> str:
    text = f"{MM * value:.3f}"
    return text[1:] if text.strip("-0.") == "" and text.startswith("-") else text


def _size(vector: Array) -> float:
    return float(np.linalg.norm(vector))


def _clean(value: float, beside: list[float]) -> str:
    """A value, 0 where it is rounding of those beside it."""
    if abs(value) <= ROUNDING * max(abs(other) for other in beside):
        return "0"
    return numbers.quantity(value, 6)


# -- JSON --------------------------------------------------------------------------------------------------------------


def linkage_text(name: str, scene: Scene, turn: TurnQuantities, instant: InstantQuantities | None) -> str:
    """The JSON document of a scene."""
    document = {
        "schema": SCHEMA,
        "conrod": version("conrod"),
        "scene": name,
        "parameters": scene.parameters,
        "turn": _turn(scene, turn),
        "instant": None if instant is None else _instant(instant),
    }
    return json_text(document)


def _turn(scene: Scene, turn: TurnQuantities) -> dict[str, Any]:
    """Quantities of a turn, or of the driver's span; angles [rad], lengths [m]."""
    return {
        "links": turn.numbers,
        "mobility": turn.mobility,
        "instant_centres": centre_count(scene.kinematics.mechanism),
        "looked_at": list(scene.kinematics.span),
        "crank": {"turns_fully": turn.crank_range.full, **plain(turn.crank_range)},
        "outputs": [{**plain(output), "time_ratio": output.time_ratio} for output in turn.outputs],
        "transmission": [
            {
                **plain(angle),
                "worst": plain(angle.worst),
                "greatest_pressure_angle": plain(angle.greatest_pressure_angle),
            }
            for angle in turn.transmission
        ],
    }


def _instant(instant: InstantQuantities) -> dict[str, Any]:
    """Quantities at a crank angle; m, m/s, m/s^2, rad, rad/s, rad/s^2."""
    state = instant.state
    return {
        "angle": state.angle,
        "speed": state.speed,
        "acceleration": state.acceleration,
        "links": [{"link": name, **plain(link)} for name, link in state.links.items()],
        "transmission": [
            {"driven": push.driven, "through": push.through, "angle": float(push.angle[0])} for push in instant.pushes
        ],
        "centres": plain(instant.centres),
        "points": [_point(point) for point in instant.points],
        "velocities": plain(instant.velocities.vectors),
        "accelerations": plain(instant.accelerations.vectors),
    }


def _point(point: PointQuantities) -> dict[str, Any]:
    parts = point.parts
    # A straight path has the curvature 0, a point at rest none.
    curvature = None if parts.radius is None else 0.0 if math.isinf(parts.radius) else 1.0 / parts.radius
    acceleration = parts.normal + parts.tangential
    return {
        "name": point.name,
        "links": point.links,
        **plain({"place": point.place, "velocity": point.velocity}),
        **plain({"acceleration": acceleration, "normal": parts.normal, "tangential": parts.tangential}),
        "curvature": curvature,
    }
