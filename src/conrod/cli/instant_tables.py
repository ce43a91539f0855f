"""Output of `conrod show --angle`: motion of links and points, instant centres, parts of accelerations."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np

from conrod.cli.console import degrees, separated_by_lines
from conrod.exact.linkage import InstantQuantities
from conrod.exact.linkage.centres import InstantCentre
from conrod.exact.motion import Array
from conrod.mechanism.units import MM, REVOLUTION
from conrod.report import numbers
from conrod.report.table import Table, table
from conrod.report.terminal import PrintedPart

# Below this share of the largest value a digit is rounding, different from machine to machine.
NEGLIGIBLE_SHARE = 1e-9


def instant_parts(instant: InstantQuantities) -> Iterator[PrintedPart]:
    """Yield tables of the motion of links and points at a crank angle."""
    speed = " ".join(numbers.in_shown_unit(instant.speed, "rad/s"))
    yield from ("", f"at crank angle {degrees(instant.angle)} deg, crank speed {speed}")
    yield from separated_by_lines(
        links_table(instant),
        points_table(instant),
        centres_table(instant),
        velocities_table(instant),
        accelerations_table(instant),
        sliding_table(instant),
    )


def links_table(instant: InstantQuantities) -> Table:
    """Poses, rates and angular accelerations of the moving links."""
    turning, changing = [link.rate[2] for link in instant.links], [link.acceleration[2] for link in instant.links]
    rows = []
    for link in instant.links:
        moved = _text_or_zero(link.rate[2], turning), _text_or_zero(link.acceleration[2], changing)
        rows.append((link.link, *_millimetres(link.pose[:2]), degrees(link.pose[2]), *moved))
    right = ("x [mm]", "y [mm]", "turn [deg]", "angular velocity [rad/s]", "angular acceleration [rad/s²]")
    return table(("link", *right), rows, right, "links")


def points_table(instant: InstantQuantities) -> Table:
    """Places, velocities and accelerations of the observed points."""
    rows = []
    for name, point in instant.points.points.items():
        vectors = [moved[0].tolist() for moved in (point.velocity, point.acceleration)]
        components = (_text_or_zero(value, [math.hypot(*vector)]) for vector in vectors for value in vector)
        rows.append((name, *_millimetres(point.position[0]), *components))
    moved = ("velocity x [m/s]", "velocity y [m/s]", "acceleration x [m/s²]", "acceleration y [m/s²]")
    right = ("x [mm]", "y [mm]", *moved)
    return table(("point", *right), rows, right, "points")


def centres_table(instant: InstantQuantities) -> Table:
    """Instant centres of every pair of links."""
    title = f"instant centres of {len(instant.links) + 1} links: {len(instant.centres)}"
    right = ("x [mm]", "y [mm]")
    rows = [(*centre.links, *_centre_place(centre)) for centre in instant.centres]
    return table(("link", "and link", *right), rows, right, title, names=2)


def _centre_place(centre: InstantCentre) -> tuple[str, str]:
    if centre.place is not None:
        x, y = _millimetres(centre.place)
        return x, y
    if centre.direction is None:
        return "at rest to each other", ""
    return "at infinity", f"at {degrees(centre.direction)} deg"


def velocities_table(instant: InstantQuantities) -> Table:
    """Velocities of points about others of the same link."""
    sizes = [_size(one.velocity) for one in instant.relative]
    rows = []
    for one, size in zip(instant.relative, sizes, strict=True):
        components = (_text_or_zero(value, [size]) for value in one.velocity.tolist())
        rows.append((f"V_{one.point}/{one.about}", one.link, *components, *_size_and_direction(one.velocity, sizes)))
    right = ("x [m/s]", "y [m/s]", "size [m/s]", "direction [deg]")
    return table(("velocity", "link", *right), rows, right, "relative velocities of points on one link", names=2)


def accelerations_table(instant: InstantQuantities) -> Table:
    """Normal and tangential parts of the accelerations of points about others of the same link."""
    sizes = [_size(part) for one in instant.relative for part in (one.normal, one.tangential)]
    rows = []
    for one in instant.relative:
        parts = (*_size_and_direction(one.normal, sizes), *_size_and_direction(one.tangential, sizes))
        rows.append((f"A_{one.point}/{one.about}", one.link, *parts))
    right = ("normal [m/s²]", "its direction [deg]", "tangential [m/s²]", "direction of it [deg]")
    title = "relative accelerations of points on one link, in their parts"
    return table(("acceleration", "link", *right), rows, right, title, names=2)


def sliding_table(instant: InstantQuantities) -> Table:
    """Velocities and parts of the accelerations of points that slide along a moving link."""
    speeds = [_size(one.velocity) for one in instant.sliding]
    sizes = [_size(part) for one in instant.sliding for part in (one.coriolis, one.normal, one.tangential)]
    rows = []
    for one in instant.sliding:
        parts = (_text_or_zero(_size(part), sizes) for part in (one.normal, one.tangential))
        moved = (*_size_and_direction(one.velocity, speeds), *_size_and_direction(one.coriolis, sizes))
        rows.append((one.point, one.guide, *moved, *parts))
    parts_shown = ("across the path [m/s²]", "along it [m/s²]")
    right = ("velocity [m/s]", "direction [deg]", "Coriolis [m/s²]", "its direction [deg]", *parts_shown)
    title = "points that slide along a moving link, against its point under them"
    return table(("point", "on link", *right), rows, right, title, names=2)


def _size(vector: Array) -> float:
    return float(np.linalg.norm(vector))


def _size_and_direction(vector: Array, sizes: list[float]) -> tuple[str, str]:
    """Size of a vector and its direction [deg] in [0, 360), as texts; a size of 0 has no direction.

    Args:
        sizes: sizes of all vectors of the table; a vector below their rounding counts as 0.
    """
    size = _text_or_zero(_size(vector), sizes)
    direction = degrees(math.atan2(vector[1], vector[0]) % REVOLUTION)
    return size, "" if size == "0" else "0" if direction == "360" else direction


def _millimetres(lengths: Iterable[float]) -> list[str]:
    return [f"{MM * length:z.3f}" for length in lengths]


def _text_or_zero(value: float, values: list[float]) -> str:
    """Text of a value; "0" if it is below rounding of the largest of some values of its unit."""
    if abs(value) <= NEGLIGIBLE_SHARE * max(map(abs, values)):
        return "0"
    return numbers.quantity(value, 6)
