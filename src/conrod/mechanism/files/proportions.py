"""Refusal of numbers that are probably slips: lengths, masses and inertias out of proportion."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from conrod.errors import InvalidInput
from conrod.mechanism.files.fields import Numbers
from conrod.mechanism.mechanism import Body, Point

# Largest ratio of a number to its reference: key True for one without unit, where a forgotten unit is likelier, False
# for one with a unit. References are the largest other length or mass, and the machine's size for a centre of gravity's
# distance from its body's points and for a radius of gyration.
MAX_LENGTH = {True: 20.0, False: 300.0}
MAX_DISTANCE = {True: 5.0, False: 20.0}
MAX_GYRATION = {True: 5.0, False: 30.0}
MAX_MASS = {True: 100.0, False: 1e5}
MAX_BARE_LENGTH = 100.0  # [m], of a length without unit
NEGLIGIBLE_MASS = 0.01  # share of the largest mass; a radius of gyration is computed with at least this mass
GROUND_PREFIX = "ground.points."
CENTRE_KEY = "centre_of_gravity"


def check_proportions(
    numbers: Numbers, bodies: Iterable[Body], points: Mapping[str, Mapping[str, Point]], moved_origin: bool = False
) -> None:
    """Refuse lengths, centres of gravity, inertias and masses out of all proportion to the machine.

    Args:
        points: of all bodies and of the ground, by name.
        moved_origin: whether a body's origin is no place on it, as in a file that is drawn.

    Raises:
        InvalidInput: names the place, what the number is compared with, and what is likely to be meant.
    """
    every = tuple(bodies)
    _check_lengths(numbers, len(every))
    _check_masses(numbers, every)
    own = {name: [*some.values(), *([] if moved_origin and some else [(0.0, 0.0)])] for name, some in points.items()}
    size = max((math.dist(a, b) for some in own.values() for a in some for b in some), default=0.0)
    if size > 0.0:
        for body in every:
            _check_centre(numbers, body, own[body.name], size)
            _check_inertia(numbers, body, max(one.mass for one in every), size)


def _check_lengths(numbers: Numbers, bodies: int) -> None:
    """Refuse a length far above all other lengths; ground points may be as far apart as all bodies in line."""
    # Start positions are guesses for the assembly and may be far off.
    lengths = {
        name: abs(value)
        for name, value in numbers.values.items()
        if numbers.facts[name].unit == "m" and value != 0.0 and CENTRE_KEY not in name and not name.startswith("start.")
    }
    stated = max((size for name, size in lengths.items() if name not in numbers.bare), default=0.0)
    for name, size in lengths.items():
        bare = name in numbers.bare
        largest = stated if bare and stated else max((s for n, s in lengths.items() if n != name), default=size)
        if name.startswith(GROUND_PREFIX) and size <= bodies * largest:
            continue
        if size > MAX_LENGTH[bare] * largest:
            raise InvalidInput(
                f"{name} = {size:g} m is {size / largest:.0f} times the largest other length, {largest:g} m: "
                f"{_likely_meaning(numbers, name, size, 'mm', 'm')}"
            )
        if bare and size > MAX_BARE_LENGTH:
            raise InvalidInput(
                f"{name} = {size:g} without unit is in metres, for a machine of that size: "
                f"{_likely_meaning(numbers, name, size, 'mm', 'm')}"
            )


def _check_masses(numbers: Numbers, bodies: tuple[Body, ...]) -> None:
    """Refuse a mass far above all other masses."""
    masses = {body.name: body.mass for body in bodies}
    for name, mass in masses.items():
        place = f"bodies.{name}.mass"
        largest = max((other for one, other in masses.items() if one != name), default=mass)
        if mass > MAX_MASS[place in numbers.bare] * largest:
            raise InvalidInput(
                f"{place} = {mass:g} kg is {mass / largest:.0f} times the largest other mass, {largest:g} kg: "
                f"{_likely_meaning(numbers, place, mass, 'g', 'kg')}"
            )


def _check_centre(numbers: Numbers, body: Body, points: list[Point], size: float) -> None:
    """Refuse a centre of gravity far from all points of its body; `size` is the machine's [m]."""
    place = f"bodies.{body.name}.{CENTRE_KEY}"
    away = min(math.dist(body.centre_of_gravity, point) for point in points)
    if away > MAX_DISTANCE[bool({f"{place}.x", f"{place}.y"} & numbers.bare)] * size:
        x, y = body.centre_of_gravity
        raise InvalidInput(
            f"{place} = [{x:g} m, {y:g} m] is {away:.3g} m from the points of {body.name}, in a machine of "
            f'{size:.3g} m: is mm meant? Write it as in "50 mm"'
        )


def _check_inertia(numbers: Numbers, body: Body, largest_mass: float, size: float) -> None:
    """Refuse an inertia whose radius of gyration far exceeds the machine's size [m]."""
    place, mass = f"bodies.{body.name}.inertia", max(body.mass, NEGLIGIBLE_MASS * largest_mass)
    gyration = math.sqrt(body.inertia / mass)
    if place in numbers.values and gyration > MAX_GYRATION[place in numbers.bare] * size:
        raise InvalidInput(
            f"{place} = {body.inertia:g} kg m² with a mass of {body.mass:g} kg is a radius of gyration of "
            f"{gyration:.3g} m, in a machine of {size:.3g} m: is kg*mm^2 or kg*cm^2 meant?"
        )


def _likely_meaning(numbers: Numbers, name: str, size: float, smaller: str, unit: str) -> str:
    """Clause of an error message: the unit that was probably meant."""
    if name in numbers.bare:
        return f'write "{size:g} {smaller}" if {smaller} is meant, "{size:g} {unit}" if not'
    return f"is {smaller} meant?"
