"""Laws of driven joints: a joint's coordinate as a function of time, with three derivatives."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.mechanism.units import REVOLUTION, check_number, parse_quantity

FORMS = "`60rpm`, `sine:20deg,1.5Hz`, `move:0deg,90deg,2s`, `table:FILE.csv` or `hold`"
RATES = {"rad": "rad/s", "m": "m/s"}
# Range of amplitudes, displacements, frequencies and times in SI: beyond it a slip of the unit is likelier.
SIZES = (1e-6, 1e6)
# Coefficients of t^3, t^4, t^5 of the quintic from 0 to 1 whose velocity and acceleration vanish at both ends.
QUINTIC = np.array([10.0, -15.0, 6.0])


@dataclass(frozen=True)
class DriveLaw:
    """A prescribed joint coordinate as a function of time.

    Attributes:
        text: the law as the user wrote it.
        duration: length of the movement, or of one period if it repeats [s]; infinite for a law that holds.
        derivatives: coordinate, rate, acceleration and jerk (4, T) at times (T,) [s], in rad or m. A function of this
            module with its numbers, which can be pickled: laws are sent to the processes that engines run in.
    """

    text: str
    duration: float
    derivatives: Callable[[Array], Array]


def parse_drive_law(text: str, unit: str, start: float, name: str) -> DriveLaw:
    """Parse a drive law in one of `FORMS`; it starts from the coordinate `start` if the text names none.

    Args:
        unit: unit of the coordinate: rad or m.
        name: name of the joint, for the error.

    Raises:
        InvalidInput: the text is no law, a value is out of range, or its table cannot be read.
    """
    kind, colon, rest = text.partition(":")
    parts = [part.strip() for part in rest.split(",")]
    if text == "hold":
        return DriveLaw(text, math.inf, partial(_constant_rate, start, 0.0))
    if not colon:
        rate = parse_quantity(name, text, RATES[unit])
        check_number(name, abs(rate), 1e-9, 1e9, RATES[unit])
        return DriveLaw(text, (REVOLUTION if unit == "rad" else 1.0) / abs(rate), partial(_constant_rate, start, rate))
    if kind == "sine" and len(parts) == 2:
        amplitude, frequency = parse_quantity(name, parts[0], unit), parse_quantity(name, parts[1], "Hz")
        check_number(f"amplitude of {name}", abs(amplitude), *SIZES, unit)
        check_number(f"frequency of {name}", frequency, *SIZES, "Hz")
        return DriveLaw(text, 1.0 / frequency, partial(_sine, start, amplitude, REVOLUTION * frequency))
    if kind == "move" and len(parts) == 3:
        begin, end = (parse_quantity(name, part, unit) for part in parts[:2])
        check_number(f"way of {name}", abs(end - begin), *SIZES, unit)
        duration = parse_quantity(name, parts[2], "s")
        check_number(f"duration of {name}", duration, *SIZES, "s")
        return DriveLaw(text, duration, quintic(begin, end, duration))
    if kind == "table" and rest:
        return _table_law(text, Path(rest), name)
    raise InvalidInput(f"{name} = {text!r} is no drive law: give {FORMS}")


def _stack_derivatives(times: Array, *values: Array | float) -> Array:
    """Stack a coordinate and its first derivatives (4, T); missing derivatives are 0."""
    made = np.zeros((4, len(times)))
    for row, value in enumerate(values):
        made[row] = value
    return made


def _constant_rate(start: float, rate: float, times: Array) -> Array:
    """Derivatives (4, T) of a coordinate that grows at a constant rate."""
    return _stack_derivatives(times, start + rate * times, rate)


def _sine(start: float, amplitude: float, omega: float, times: Array) -> Array:
    """Derivatives (4, T) of a sine about the start, with its angular frequency [rad/s]."""
    sine, cosine = amplitude * np.sin(omega * times), amplitude * np.cos(omega * times)
    return _stack_derivatives(times, start + sine, omega * cosine, -(omega**2) * sine, -(omega**3) * cosine)


def quintic(begin: float, end: float, duration: float) -> Callable[[Array], Array]:
    """Derivatives (4, T) of a quintic from one coordinate to another, at rest before and after."""
    polynomial = np.polynomial.Polynomial([0.0, 0.0, 0.0, *QUINTIC])
    forms = [(end - begin) / duration**k * np.array(polynomial.deriv(k).coef, dtype=float) for k in range(4)]
    return partial(_quintic, begin, duration, forms)


def _quintic(begin: float, duration: float, forms: Sequence[Array], times: Array) -> Array:
    """Derivatives (4, T) of a quintic from its start.

    Args:
        forms: coefficients of the displacement and of its derivatives, in powers of the share of the duration.
    """
    share = np.clip(times / duration, 0.0, 1.0)
    value, *rows = (np.asarray(np.polynomial.polynomial.polyval(share, form), dtype=float) for form in forms)
    return _at_rest_after(duration, times, _stack_derivatives(times, begin + value, *rows))


def _at_rest_after(end: float, times: Array, derivatives: Array) -> Array:
    """Derivatives (4, T) set to zero after the end [s] of a movement."""
    derivatives[1:, times > end] = 0.0
    return derivatives


def _table_law(text: str, path: Path, name: str) -> DriveLaw:
    """A quintic spline through a file's two columns, time [s] and coordinate [rad or m]."""
    from scipy.interpolate import make_interp_spline

    try:
        with warnings.catch_warnings(action="ignore"):  # of a file without a row
            times, values = np.loadtxt(path, delimiter=",", unpack=True, ndmin=2, comments=("#", "t", "T"))
    except (OSError, ValueError) as error:
        raise InvalidInput(f"{name} = {text!r}: a table has two columns, time [s] and coordinate: {error}") from None
    if len(times) < 6 or not np.all(np.diff(times) > 0.0) or not np.all(np.isfinite([times, values])):
        raise InvalidInput(f"{name} = {text!r}: give at least six rows of numbers, with rising times")
    spline, first = make_interp_spline(times, values, k=5), float(times[0])
    length = float(times[-1]) - first
    return DriveLaw(text, length, partial(_spline, spline, first, length))


def _spline(spline: Callable[..., Array], first: float, length: float, times: Array) -> Array:
    """Derivatives (4, T) of a spline over a length of time [s] from its first instant [s], at rest after it."""
    inside = first + np.clip(times, 0.0, length)
    return _at_rest_after(length, times, np.array([spline(inside, nu=k) for k in range(4)]))
