"""Checks of single values that a plugin's engine returns: numbers, texts, arrays, settings.

A value that conrod cannot use raises an `EngineFault`, which ends the engine's own case with the reason, and nothing
else.
"""

from __future__ import annotations

import json
import math
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np

from conrod.engines.engine import STEP_TOLERANCE, Machine, step_length
from conrod.errors import InvalidInput
from conrod.exact.motion import Array

Checked = TypeVar("Checked")

MAX_LINE_LENGTH = 300  # characters


class EngineFault(RuntimeError):
    """A failure of a plugin's engine, which ends the case that it runs; its text is one line."""


@contextmanager
def catch_faults(refusals: bool = False) -> Iterator[None]:
    """Turn every exception that a plugin's code raises into an `EngineFault`.

    Args:
        refusals: whether InvalidInput is a valid answer, which is raised again with its text alone.
    """
    try:
        yield
    except (EngineFault, MemoryError):
        raise
    except BaseException as error:  # SystemExit, GeneratorExit and classes of its own among them
        # Ctrl-C is the user's where Python answers it; a worker does not.
        if isinstance(error, KeyboardInterrupt) and signal.getsignal(signal.SIGINT) is not signal.SIG_DFL:
            raise
        text = error_line(error)
        if refusals and isinstance(error, InvalidInput):
            raise InvalidInput(text) from None
        raise EngineFault(f"{type(error).__name__}: {text}" if text else type(error).__name__) from None


def error_line(error: BaseException) -> str:
    """The text of an error in one line; empty if the error cannot be printed."""
    try:
        return one_line(str(error))
    except BaseException:  # __str__ is the engine's code, too
        return ""


def one_line(text: str) -> str:
    """The text on one line of at most 300 characters, without control characters."""
    line = "".join(letter if letter.isprintable() else " " for letter in " ".join(text.split()))
    return line if len(line) <= MAX_LINE_LENGTH else line[: MAX_LINE_LENGTH - 3] + "..."


def refuse_unless(holds: object, what: str) -> None:
    """Raise EngineFault ("it handed over ...") unless a condition holds."""
    if not holds:
        raise EngineFault(f"it handed over {what}")


def check_type(value: Any, kind: type[Checked], what: str) -> Checked:
    """Return a value if it is of a class; a bool is no number."""
    right = isinstance(value, kind) and not (isinstance(value, bool) and kind is not bool)
    refuse_unless(right, f"{what} that is of {type(value).__name__}, not of {kind.__name__}")
    return value  # type: ignore[no-any-return]


def check_text(value: Any, what: str) -> str:
    """Return a text on one line, without control characters."""
    return one_line(str.__str__(check_type(value, str, what)))


def check_finite_number(value: Any, what: str, lowest: float = -math.inf) -> float:
    """Return a value as a float if it is a finite number, not below `lowest`."""
    plain = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
    refuse_unless(plain, f"{what} that is of {type(value).__name__}, not a number")
    number = float(value)
    refuse_unless(math.isfinite(number) and number >= lowest, f"{what} = {number:g}")
    return number


def check_whole_number(value: Any, what: str) -> int:
    """Return a value as an int if it is a whole number, not negative."""
    whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool) and value >= 0
    refuse_unless(whole, f"{what} that is no count")
    return int(value)


# -- settings ----------------------------------------------------------------------------------------------------------


def check_settings(settings: Any, engine: str, preset: str, machine: Machine | None, steps: int) -> dict[str, Any]:
    """Check settings against the preset, machine (None for any) and steps they were made for; return plain values."""
    own = settings.engine, settings.preset
    refuse_unless(own == (engine, preset), f"settings of {one_line(repr(own))} for {(engine, preset)!r}")
    refuse_unless(
        check_whole_number(settings.steps_per_revolution, "steps per revolution") == steps, "settings for another step"
    )
    length = check_finite_number(settings.timestep, "a time step [s]")
    right = length if machine is None else step_length(machine, steps)
    same = length > 0.0 and abs(length / right - 1.0) <= STEP_TOLERANCE
    refuse_unless(same, f"a time step of {length:g} s where {steps} a turn are {right:g} s")
    found = settings.as_dict()
    refuse_unless(isinstance(found, dict), "settings whose fields are no table")
    try:
        plain = json.loads(json.dumps(found, allow_nan=False))
    except (TypeError, ValueError) as error:
        raise EngineFault(f"it handed over settings that are no plain values: {error_line(error)}") from None
    return {**plain, "preset": preset}


# -- arrays ------------------------------------------------------------------------------------------------------------


def check_array(value: Any, what: str, columns: int | None = None, finite: bool = True) -> Array:
    """Return a copy of a float64 array of shape (T,) or (T, columns)."""
    refuse_unless(type(value) is np.ndarray, f"{what} as {type(value).__name__}, not as a numpy array")
    refuse_unless(value.dtype == np.float64, f"{what} as {value.dtype}, not as float64")
    shape = "(T,)" if columns is None else f"(T, {columns})"
    right = value.ndim == (1 if columns is None else 2) and (columns is None or value.shape[1] == columns)
    refuse_unless(right, f"{what} of shape {value.shape}, not {shape}")
    copy = np.array(value)
    if finite and not np.isfinite(copy).all():
        bad = int(np.argmin(np.isfinite(copy).reshape(len(copy), -1).all(axis=1)))
        raise EngineFault(f"it handed over {what} with {copy[bad].ravel()[~np.isfinite(copy[bad].ravel())][0]}")
    return copy


def check_finite_arrays(found: Checked, kind: type[Checked], what: str) -> Checked:
    """Return a dataclass whose arrays, nested ones included, hold finite numbers alone."""
    check_type(found, kind, what)
    for name, value in ((one.name, getattr(found, one.name)) for one in fields(kind)):  # type: ignore[arg-type]
        if isinstance(value, np.ndarray):
            check_array(value, f"{what}: {name}", None if value.ndim == 1 else value.shape[-1])
        elif is_dataclass(value) and not isinstance(value, type):
            check_finite_arrays(value, type(value), what)
    return found


# -- laws and tables ---------------------------------------------------------------------------------------------------


def check_error_bounds(found: Any, kind: type[Checked]) -> Checked:
    """Return a dataclass of error bounds: texts, and numbers that are not negative or None."""
    check_type(found, kind, "a law of its errors")
    values = {}
    for one in fields(kind):  # type: ignore[arg-type]
        value = getattr(found, one.name)
        if isinstance(value, str):
            values[one.name] = check_text(value, "a law")
        else:
            values[one.name] = None if value is None else check_finite_number(value, f"a bound of {one.name}", 0.0)  # type: ignore[assignment]
    return kind(**values)


def check_number_table(found: Any, what: str) -> dict[str, float]:
    """Return a table of finite numbers by name."""
    return {check_text(name, what): check_finite_number(value, what) for name, value in dict(found).items()}
