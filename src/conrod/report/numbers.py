"""Numbers as they are printed: two significant digits for what was measured; mm, degrees and rpm at the edges."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, TypeAlias

# Below this every normalised error is rounding noise, different on another machine: its digits mean nothing.
ROUNDING = 1e-12
BELOW_ROUNDING = "< 1e-12"
NOISE_DECIMALS = 14  # keep three digits of an error of that size; digits beyond may differ the next time
MISSING = "n/a"
SUPERSCRIPTS = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
QUANTITIES_OVER_L = ("position", "total")  # quantities whose errors are over L
IN_MM = "position [mm]"
PLAIN_RANGE = (1e-3, 1e4)  # sizes printed without an exponent

# SI unit of a parameter -> the unit people use, and the factor to it.
SHOWN_UNITS: Mapping[str, tuple[str, float]] = {
    "m": ("mm", 1e3),
    "rad/s": ("rpm", 60.0 / (2.0 * math.pi)),
    "kg*m^2": ("kg m²", 1.0),
    "m/s^2": ("m/s²", 1.0),
    "m/s": ("mm/s", 1e3),
    "rad": ("deg", 180.0 / math.pi),
}


def measured_text(value: float | None) -> str:
    """Return a measured value in two significant digits; 'n/a' for None."""
    if value is None:
        return MISSING
    if not math.isfinite(value):
        return "not finite"
    if abs(value) < ROUNDING:
        return BELOW_ROUNDING
    if PLAIN_RANGE[0] <= abs(value) < PLAIN_RANGE[1]:
        return _fixed_text(round_to_digits(value, 2), 2)
    return _exponent_text(value)


def scaled_text(value: float | None, factor: float) -> str:
    """Return a normalised error or an angle in another unit; below rounding only its bound."""
    if value is not None and abs(value) < ROUNDING:
        return f"< {quantity(ROUNDING * factor, 1)}"
    return measured_text(None if value is None else factor * value)


# Errors over L by point; or the largest of them, where only that was kept.
ErrorsOverL: TypeAlias = float | Mapping[str, float | None] | None


def in_mm(errors: ErrorsOverL, lengths: Mapping[str, float]) -> str:
    """Return the largest of errors over L in mm; `<= 7.9` where its point is not known.

    Args:
        lengths: L of each point [m].
    """
    of_points = errors if isinstance(errors, Mapping) else dict.fromkeys(lengths, errors)
    known = {point: error for point, error in of_points.items() if error is not None}
    worst = max(known, key=lambda point: known[point] * lengths[point], default=None)
    if worst is None:
        return MISSING
    shown = scaled_text(known[worst], 1e3 * lengths[worst])
    at_most = errors is not of_points and len(set(lengths.values())) > 1 and shown[0].isdigit()
    return f"<= {shown}" if at_most else shown


def with_mm(errors: ErrorsOverL, lengths: Mapping[str, float], of: str = "") -> str:
    """Return the largest of errors over L, and the same in mm: `0.038 (7.9 mm)`.

    Args:
        errors: over L.
        lengths: L of each point [m].
        of: words to add to the share, such as ` of its travel`."""
    known = errors.values() if isinstance(errors, Mapping) else (errors,)
    over = measured_text(max((error for error in known if error is not None), default=None))
    shown = in_mm(errors, lengths)
    return over + of if shown in (MISSING, over) else f"{over}{of} ({shown} mm)"


def error(name: str, size: ErrorsOverL, lengths: Mapping[str, float] = MappingProxyType({})) -> str:
    """Return the largest error of a quantity: positions also in mm if L is given, phase in deg."""
    if name in QUANTITIES_OVER_L:
        return with_mm(size, lengths)
    assert not isinstance(size, Mapping)
    return f"{in_degrees(size)} deg" if name == "phase" and size is not None else measured_text(size)


def allowed_text(name: str, size: float | None, lengths: Mapping[str, float] = MappingProxyType({})) -> str:
    """Return a tolerance as `error` would print it, without hiding a phase below rounding."""
    if name == "phase" and size is not None:
        return f"{quantity(math.degrees(size), 2)} deg"
    return error(name, size, lengths)


def given_tolerance_text(name: str, limit: float) -> str:
    """Return a tolerance that a user gave as text, the phase's in deg."""
    return allowed_text(name, limit) if name == "phase" else quantity(limit)


# SI unit -> unit and factor of errors and tolerances that are printed beside their shares.
SIZES_BESIDE_SHARES = {
    "position": ("mm", 1e3), "closure": ("mm", 1e3), "total": ("mm", 1e3), "velocity": ("mm/s", 1e3),
    "velocity_rms": ("mm/s", 1e3), "acceleration": ("m/s²", 1.0), "rotation": ("deg", 180.0 / math.pi),
    "torque": ("N m", 1.0), "contact": ("N", 1.0), "speed": ("rpm", 60.0 / (2.0 * math.pi)),
}  # fmt: skip


def with_size(text: str, name: str, share: float, scale: float | None) -> str:
    """Return the text of a share with its size behind it: `1e-4 (0.021 mm)`.

    Args:
        name: what the error or tolerance is of.
        scale: SI size of a share of 1; None where it is not known.
    """
    size = size_text(name, share, scale)
    return f"{text} ({size})" if size else text


def size_text(name: str, share: float, scale: float | None) -> str:
    """Return the size of a share in its unit, `0.021 mm`; empty where it has none, see `with_size`."""
    if scale is None or name not in SIZES_BESIDE_SHARES:
        return ""
    unit, factor = SIZES_BESIDE_SHARES[name]
    return f"{scaled_text(share, factor * scale)} {unit}"


def lengths(travels: Mapping[str, float]) -> str:
    """Return the travels L [m] of points as the end of a sentence, at least a full stop."""
    known = ", ".join(f"{point} {quantity(1e3 * length, 6)} mm" for point, length in travels.items())
    return f", which is of {known}." if known else "."


def in_degrees(angle: float | None) -> str:
    """Return an error of an angle [rad] in degrees."""
    return scaled_text(angle, 180.0 / math.pi)


def quantity(value: float, digits: int = 4) -> str:
    """Return an exact value, such as a parameter, without needless digits."""
    if value == 0.0:
        return "0"
    if PLAIN_RANGE[0] <= abs(value) < 10.0 ** max(digits, 4):
        return f"{value:.{digits}g}"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    short = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
    return f"{short}e{int(exponent)}"


def unequal_quantities(one: float, other: float, digits: int = 4) -> tuple[str, str]:
    """Return two values that differ, in the fewest digits from `digits` on that show it."""
    for more in range(digits, 17):
        texts = quantity(one, more), quantity(other, more)
        if texts[0] != texts[1]:
            break
    return texts


def defect_size_text(size: float, unit: str) -> str:
    """Return the size of a planted defect in its unit, in two digits; empty if it has no unit."""
    factor = 100.0 if unit.startswith("%") else 180.0 / math.pi if unit == "deg" else 1.0
    return f"{quantity(size * factor, 3 if size * factor >= 99.5 else 2)} {unit}" if unit else ""


def order(value: float | None) -> str:
    """Return an observed order of convergence in two digits; 'n/a' for None."""
    return MISSING if value is None else _fixed_text(round_to_digits(value, 2), 2)


def duration(seconds: float | None) -> str:
    """Return a measured time [s] in two significant digits, in µs, ms or s; 'n/a' for None."""
    if seconds is None:
        return MISSING
    value = round_to_digits(seconds, 2)
    unit, factor = ("µs", 1e6) if value < 1e-3 else ("ms", 1e3) if value < 1.0 else ("s", 1.0)
    return f"{_fixed_text(round_to_digits(value * factor, 2), 2)} {unit}"


def magnification(power: int) -> str:
    """Say by which power of ten something is magnified: `magnified 100 times`, `not magnified`."""
    if power == 0:
        return "not magnified"
    return f"magnified {power_of_ten(power)} times"


def power_of_ten(power: int) -> str:
    """Return a power of ten as people write it: `100`, `10⁷`."""
    return str(10**power) if power <= 3 else f"10{str(power).translate(SUPERSCRIPTS)}"


def three_digits(value: float, plain: bool) -> str:
    """Return a value in three significant digits: `0.0320` if plain, else `3.20e-2`."""
    if plain:
        return _fixed_text(round_to_digits(value, 3), 3)
    mantissa, exponent = f"{value:.2e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def percent(share: float | None) -> str:
    """Return a share as a whole percentage, or as `< 1 %` or `> 99 %`."""
    if share is None:
        return MISSING
    whole = round(100.0 * share)
    if whole == 0 and share > 0.0:
        return "< 1 %"
    return "> 99 %" if whole == 100 and share < 1.0 else f"{whole} %"


def in_shown_unit(value: float, unit: str, digits: int = 6) -> tuple[str, str]:
    """Return a parameter's value and unit as engineers write them: ('32.5', 'mm') for 0.0325 m."""
    shown, factor = SHOWN_UNITS.get(unit, (unit, 1.0))
    return quantity(value * factor, digits), shown or "-"


def setting(value: Any) -> str:
    """Return a setting's value as short text."""
    match value:
        case None:
            return "none"
        case bool():
            return "yes" if value else "no"
        case float():
            return quantity(value)
        case list() | tuple():
            return "(" + ", ".join(map(setting, value)) + ")"
        case _:
            return str(value)


def round_reproducibly(value: float, digits: int) -> float:
    """Round a measured number to significant digits, and rounding noise to 0."""
    return 0.0 if abs(value) < ROUNDING else round(round_to_digits(value, digits), NOISE_DECIMALS)


def round_to_digits(value: float, digits: int) -> float:
    """Round a number to significant digits."""
    return float(f"{value:.{digits - 1}e}")


def _fixed_text(value: float, digits: int) -> str:
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value)))) if value else 0
    return f"{value:.{decimals}f}"


def _exponent_text(value: float) -> str:
    mantissa, exponent = f"{value:.1e}".split("e")
    return f"{mantissa}e{int(exponent)}"
