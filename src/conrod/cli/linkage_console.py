"""What `conrod show` prints of the classic quantities of a linkage."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from rich.table import Table

from conrod.exact.kinematics import Kinematics
from conrod.exact.linkage.centres import InstantCentre, centre_count
from conrod.exact.linkage.course import CrankRange
from conrod.exact.linkage.outputs import DeadCentre, Output
from conrod.exact.linkage.polygon import Polygon
from conrod.exact.linkage.quantities import InstantQuantities, PointQuantities, TurnQuantities
from conrod.exact.linkage.transmission import Extreme, TransmissionAngle
from conrod.exact.motion import Array
from conrod.report import numbers
from conrod.report.terminal import console

# Below this share of the largest value a digit is rounding, different from machine to machine.
ROUNDING = 1e-9
MM = 1e3
NUMBERS = {"stroke", "time ratio", "normal", "tangential"}  # columns of numbers that name no unit


# -- of a turn -------------------------------------------------------------------------------------------------------


def show_turn(kinematics: Kinematics, turn: TurnQuantities) -> None:
    """What a linkage does in a turn, or in its driver's span."""
    out = console()
    links = ", ".join(f"{number} {name}" for name, number in turn.numbers.items())
    count = centre_count(kinematics.mechanism)
    out.print(f"\nlinks: {links}")
    out.print(f"instant centres: {count}, n (n - 1) / 2 of n = {len(turn.numbers)} links")
    out.print(f"crank: {_reach(turn.crank_range)}")
    span = kinematics.mechanism.driver.span
    if span is not None:
        out.print(f"what follows is of the pass from {degrees(span[0])} to {degrees(span[1])} deg")
    elif turn.crank_range.full and not kinematics.repeats:
        out.print("after a turn the links do not stand as before it: strokes and angles are those of the first turn")
    if turn.outputs:
        rows = [_output_row(output) for output in turn.outputs]
        heading = ("driven link", "guided by", "stroke", "turns back at [deg]", "there and back [deg]", "time ratio")
        _show_table("strokes, dead centres and time ratios", heading, rows)
    if turn.transmission:
        rows = [_transmission_row(angle) for angle in turn.transmission]
        heading = ("driven link", "pushed by", "least", "greatest", "worst", "greatest pressure angle")
        _show_table("transmission angles [deg], and the crank angles where they are taken", heading, rows)


def _reach(reach: CrankRange) -> str:
    if reach.full:
        passed = ", ".join(degrees(angle) for angle in reach.change_points)
        return f"turns fully, through change points at {passed} deg" if passed else "turns fully"
    ends = {"limit": "where it has to turn back", "change point": "a change point", "none": "no end"}
    start, stop = (f"{degrees(angle)} deg" for angle in (reach.start, reach.stop))
    if reach.start_end == reach.stop_end:
        both = "both where it has to turn back" if reach.stop_end == "limit" else f"both {ends[reach.stop_end]}s"
        return f"reaches from {start} to {stop}, {both}"
    return f"reaches from {start} ({ends[reach.start_end]}) to {stop} ({ends[reach.stop_end]})"


def _output_row(output: Output) -> tuple[str, ...]:
    if output.stroke is None:
        stroke = f"goes on, {_way(output.gain, output.unit)} a turn"
    else:
        stroke = _way(output.stroke, output.unit)
    there_and_back = ""
    if output.forward is not None and output.backward is not None:
        there_and_back = f"{degrees(output.forward)}, {degrees(output.backward)}"
    ratio = "" if output.time_ratio is None else f"{output.time_ratio:.6g}"
    centres = ", ".join(_dead_centre(centre) for centre in output.dead_centres)
    return (output.link, output.joint, stroke, centres or "nowhere", there_and_back, ratio)


def _way(value: float, unit: str) -> str:
    return f"{MM * value:.6g} mm" if unit == "m" else f"{math.degrees(value):.6g} deg"


def _dead_centre(centre: DeadCentre) -> str:
    if centre.until == centre.angle:
        return degrees(centre.angle)
    return f"{degrees(centre.angle)} to {degrees(centre.until)}"


def _transmission_row(angle: TransmissionAngle) -> tuple[str, ...]:
    extremes = (angle.least, angle.greatest, angle.worst, angle.greatest_pressure_angle)
    return (angle.driven, angle.through, *(_extreme(extreme) for extreme in extremes))


def _extreme(extreme: Extreme) -> str:
    return f"{math.degrees(extreme.value):.4f} at {math.degrees(extreme.angle):.2f}"


# -- at a crank angle ------------------------------------------------------------------------------------------------


def show_instant(instant: InstantQuantities, numbering: dict[str, int]) -> None:
    """What a linkage does at a crank angle."""
    out = console()
    state = instant.state
    out.print(f"\nat crank angle {degrees(state.angle)} deg, crank speed {numbers.quantity(state.speed, 6)} rad/s")
    links = {name: state.links[name] for name in numbering}
    turning = [link.angular_velocity for link in links.values()]
    changing = [link.angular_acceleration for link in links.values()]
    rows = [
        (
            str(numbering[name]),
            name,
            *(_length(value) for value in link.pose[:2]),
            degrees(link.pose[2]),
            _clean(link.angular_velocity, turning),
            _clean(link.angular_acceleration, changing),
        )
        for name, link in links.items()
        if name in state.mechanism.body_index
    ]
    heading = (
        "",
        "link",
        "x [mm]",
        "y [mm]",
        "turn [deg]",
        "angular velocity [rad/s]",
        "angular acceleration [rad/s²]",
    )
    _show_table("links", heading, rows)
    for push in instant.pushes:
        angle = float(push.angle[0])
        pressure = abs(0.5 * math.pi - angle)
        out.print(
            f"transmission angle of {push.driven}, pushed by {push.through}: {math.degrees(angle):.4f} deg; "
            f"pressure angle {math.degrees(pressure):.4f} deg"
        )
    rows = [(centre.name, " and ".join(centre.links), centre.kind, *_centre(centre)) for centre in instant.centres]
    _show_table("instant centres", ("", "of", "kind", "x [mm]", "y [mm]"), rows)
    _show_points(instant)
    for polygon, unit in ((instant.velocities, "m/s"), (instant.accelerations, "m/s²")):
        _show_vectors(polygon, unit)


def _show_points(instant: InstantQuantities) -> None:
    points = instant.points
    if not points:
        return
    speeds = [_size(point.velocity) for point in points]
    parts = [_size(part) for p in points for part in (p.parts.normal, p.parts.tangential)]
    rows = [
        (
            point.name,
            ", ".join(point.links),
            *(_length(float(value)) for value in point.place),
            _clean(_size(point.velocity), speeds),
            _clean(_size(point.parts.normal + point.parts.tangential), parts),
            _clean(_size(point.parts.normal), parts),
            _clean(_size(point.parts.tangential), parts),
            _radius(point),
        )
        for point in points
    ]
    motion = ("velocity [m/s]", "acceleration [m/s²]", "normal", "tangential", "radius of path [mm]")
    _show_table("points", ("", "of", "x [mm]", "y [mm]", *motion), rows)


def _show_vectors(polygon: Polygon, unit: str) -> None:
    sizes = [_size(vector.value) for vector in polygon.vectors]
    rows = []
    for vector, size in zip(polygon.vectors, sizes, strict=True):
        there = size > ROUNDING * max(sizes)
        turn = degrees(math.atan2(vector.value[1], vector.value[0]) % (2.0 * math.pi)) if there else ""
        rows.append((vector.name, _clean(size, sizes), turn, vector.kind, vector.link or ""))
    heading = ("", f"size [{unit}]", "direction [deg]", "kind", "link")
    title = "velocities" if polygon.quantity == "velocity" else "accelerations, in their parts"
    _show_table(title, heading, rows)


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


def _show_table(title: str, heading: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> None:
    console().print(f"\n{title}", markup=False)
    table = Table(box=None, pad_edge=False)
    for name in heading:
        number = "[" in name or name in NUMBERS
        table.add_column(name.replace("[", r"\["), justify="right" if number else "left")
    for row in rows:
        table.add_row(*(cell.replace("[", r"\[") for cell in row))
    console().print(table)
