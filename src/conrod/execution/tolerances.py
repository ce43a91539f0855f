"""Tolerances as users give them: a share of a quantity's scale, as 1e-4L, or a size with a unit, as 0.1mm."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.kinematics import ExactReference
from conrod.exact.link_rotations import ROTATIONS, rotation_scales
from conrod.mechanism.units import NUMBER, check_number, parse_quantity, unit_in_prose

TOLERANCE_NAMES = ("position", "velocity", "acceleration", "total", "velocity_rms", "phase")
ALL_TOLERANCE_NAMES = (*TOLERANCE_NAMES, *ROTATIONS)  # where links are compared as well as points
MIN_TOLERANCE, MAX_TOLERANCE = 1e-300, 1e6
# Units of the errors that may be given with one. An energy, and reactions (forces and moments), are shares alone.
SIZE_UNITS = {
    "position": "m", "velocity": "m/s", "acceleration": "m/s^2", "total": "m", "velocity_rms": "m/s", "phase": "rad",
    "speed": "rad/s", "rotation": "rad", "angular_velocity": "rad/s", "angular_acceleration": "rad/s^2",
    "torque": "N*m", "contact": "N",
}  # fmt: skip
PHASE = "phase"  # an angle, which has no scale
SHARE = re.compile(rf"({NUMBER.pattern})\s*L")


@dataclass(frozen=True)
class UnscaledLimit:
    """An allowed error as a size or share; its quantity's scale converts it to a study's numbers.

    Attributes:
        size: in SI, or as a share of the quantity's scale.
        is_share: which of the two.
    """

    size: float
    is_share: bool


# A number is what the study judges by: a share in studies of scenes, SI in those of closed loops.
Limit: TypeAlias = float | UnscaledLimit
Scales: TypeAlias = Mapping[str, Mapping[str, float]]  # SI size of a share of 1, by quantity and point (or link)


def check_tolerance(
    tolerance: Mapping[str, float | str], known: Collection[str] = TOLERANCE_NAMES, option: str = "--tolerance "
) -> dict[str, Limit]:
    """Check allowed errors by quantity and return them; texts may be sizes with a unit, or shares, as `1e-4L`.

    Args:
        known: quantities that may be judged, normalised; or with their units, in SI.
        option: words before the quantity's name in an error.

    Raises:
        InvalidInput: an unknown quantity, a value that is not a positive number, or a plain text where it has no unit
            and sizes are judged.
    """
    if not isinstance(tolerance, Mapping):
        raise InvalidInput(f"--tolerance {tolerance!r}: give numbers by quantity, such as {{'position': 1e-4}}")
    found = dict[str, Limit]()
    for name, given in tolerance.items():
        if name not in known:
            raise unknown_choice("quantity", name, known)
        in_si = isinstance(known, Mapping)
        found[name] = limit = _parse_limit(f"{option}{name}", name, given, in_si) if isinstance(given, str) else given
        is_size = limit.is_share is False if isinstance(limit, UnscaledLimit) else in_si
        size = limit.size if isinstance(limit, UnscaledLimit) else limit
        unit = unit_in_prose(SIZE_UNITS[name]) if is_size else ""
        check_number(f"{option}{name}", size, MIN_TOLERANCE, MAX_TOLERANCE, unit)
    return found


def _parse_limit(label: str, name: str, text: str, in_si: bool) -> Limit:
    """Parse a tolerance: a share with L, a size with a unit, or a plain number where it is unambiguous."""
    stripped, unit = text.strip(), SIZE_UNITS.get(name, "")
    example = EXAMPLES.get(unit, "")
    if NUMBER.match(stripped) is None:
        sizes = f", or a size, as in {name}={example}" if example else ""
        raise InvalidInput(f"{label} = {text!r} is not a number; give a share, as in {name}=1e-4L{sizes}")
    if share := SHARE.fullmatch(stripped):
        if name == PHASE:
            raise InvalidInput(f"{label} = {text!r}: an angle has no range of motion: give {name}={example}")
        size = float(share.group(1))
        return UnscaledLimit(size, is_share=True) if in_si else size
    plain = NUMBER.fullmatch(stripped) is not None
    if plain and in_si:
        raise InvalidInput(
            f"{label}={stripped} may be {stripped} {unit_in_prose(unit)} or a share of the range of motion: give a "
            f"size, as in {name}={example}, or a share, as in {name}={stripped}L"
        )
    if not unit and not plain:
        raise InvalidInput(f"{label} = {text!r}: give a share, as in {name}=1e-4L: {name} has no single unit")
    size = parse_quantity(label, stripped, unit)
    return size if plain or in_si or name == PHASE else UnscaledLimit(size, is_share=False)


EXAMPLES = {
    "m": "0.1mm", "m/s": "1mm/s", "m/s^2": "0.1m/s^2", "rad": "0.1deg", "rad/s": "1rpm", "rad/s^2": "1deg/s^2",
    "N*m": "0.1Nm", "N": "1N",
}  # fmt: skip


def point_scales(lengths: Mapping[str, float], speed: float) -> dict[str, dict[str, float]]:
    """SI size of a share of 1, by quantity and point: L, omega L and omega^2 L.

    Args:
        lengths: travel L of each point [m].
        speed: omega [rad/s].
    """
    orders = {"position": 0, "total": 0, "velocity": 1, "velocity_rms": 1, "acceleration": 2}
    return {name: {one: size * abs(speed) ** k for one, size in lengths.items()} for name, k in orders.items()}


def scene_scales(scene: ExactReference) -> dict[str, dict[str, float]]:
    """SI size of a share of 1 of all errors of a scene's motion, by quantity and point or link."""
    links, speed = rotation_scales(scene.kinematics), abs(scene.speed)
    turns = {name: {link: size * speed**k for link, size in links.items()} for k, name in enumerate(ROTATIONS)}
    return {**point_scales(scene.lengths, speed), **turns}


def scale_tolerance(
    tolerance: Mapping[str, Limit], scales: Scales
) -> tuple[dict[str, float], dict[str, dict[str, float]]]:
    """Convert limits in units (such as mm) to shares, and compute the weights of their points.

    A size s is a share s / S of the largest scale S of its points; an error over a point's own scale S_p is then
    weighed by S_p / S, so that no point may be off by more than s, and none need be off by less.

    Returns:
        Allowed shares by quantity; weights by quantity and point where they are not all 1.
    """
    limits, weights = dict[str, float](), dict[str, dict[str, float]]()
    for name, limit in tolerance.items():
        if isinstance(limit, UnscaledLimit):
            own = scales.get(name, {})
            largest = max(own.values(), default=0.0)
            # Without a scale there is no motion that could be within it.
            limits[name] = limit.size / largest if largest else 0.0
            if any(one != largest for one in own.values()):
                weights[name] = {point: one / largest for point, one in own.items()}
        else:
            limits[name] = limit
    return limits, weights


def exceeded_limits(
    limits: Mapping[str, float], error: Callable[[str], float | None]
) -> dict[str, tuple[float, float]]:
    """Return found and allowed error by quantity out of tolerance; a quantity without an error exceeds nothing.

    Args:
        error: gives the error of a quantity by its name.
    """
    errors = {name: found for name in limits if (found := error(name)) is not None}
    return {name: (found, limits[name]) for name, found in errors.items() if not found <= limits[name]}


def judged_scale(errors: Mapping[str, float], scales: Mapping[str, float], *, weighed: bool) -> float | None:
    """SI size of a share of 1 at the point with the largest judged error; None if it is unknown.

    Args:
        errors: judged errors by point.
        scales: SI size of a share of 1 by point.
        weighed: whether the tolerance was given in units, and shares are of the largest scale.
    """
    if weighed:
        return max(scales.values(), default=None)
    known = {point: error for point, error in errors.items() if point in scales}
    return scales[max(known, key=known.__getitem__)] if known else None
