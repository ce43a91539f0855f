"""The one door through which everything passes that an engine of another package hands over.

What cannot be used there is an `EngineFault`: it ends the engine's own case, with the reason, and nothing else.
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

from conrod.engines.engine import Machine, step_length
from conrod.errors import InvalidInput
from conrod.exact.motion import Array

Kind = TypeVar("Kind")

LONGEST_REASON = 300  # characters
SAME_STEP = 1e-5  # as `check_run` has it


class EngineFault(RuntimeError):
    """What an engine of another package did that ends the case which it was asked for, in one line."""


@contextmanager
def guarded(refusals: bool = False) -> Iterator[None]:
    """Turn whatever an engine's own code raises into an `EngineFault`.

    Args:
        refusals: whether InvalidInput is an answer, which passes as one line without the engine's objects.
    """
    try:
        yield
    except (EngineFault, MemoryError):
        raise
    except BaseException as error:  # SystemExit, GeneratorExit and classes of its own among them
        # Ctrl-C is the user's where Python answers it; a worker does not.
        if isinstance(error, KeyboardInterrupt) and signal.getsignal(signal.SIGINT) is not signal.SIG_DFL:
            raise
        text = words_of(error)
        if refusals and isinstance(error, InvalidInput):
            raise InvalidInput(text) from None
        raise EngineFault(f"{type(error).__name__}: {text}" if text else type(error).__name__) from None


def words_of(error: BaseException) -> str:
    """The words of an error in one line; an error that cannot say what it is has none."""
    try:
        return one_line(str(error))
    except BaseException:  # __str__ is the engine's code, too
        return ""


def one_line(text: str) -> str:
    """A text on one line of bounded length, without characters that command a terminal."""
    line = "".join(letter if letter.isprintable() else " " for letter in " ".join(text.split()))
    return line if len(line) <= LONGEST_REASON else line[: LONGEST_REASON - 3] + "..."


def demand(holds: object, what: str) -> None:
    """Refuse what an engine handed over unless a condition holds."""
    if not holds:
        raise EngineFault(f"it handed over {what}")


def typed(value: Any, kind: type[Kind], what: str) -> Kind:
    """A value that is of a class; a truth value is no number."""
    right = isinstance(value, kind) and not (isinstance(value, bool) and kind is not bool)
    demand(right, f"{what} that is of {type(value).__name__}, not of {kind.__name__}")
    return value  # type: ignore[no-any-return]


def text_of(value: Any, what: str) -> str:
    """A text without characters that command a terminal."""
    return one_line(str.__str__(typed(value, str, what)))


def number_of(value: Any, what: str, least: float = -math.inf) -> float:
    """A finite number, not below `least`."""
    plain = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
    demand(plain, f"{what} that is of {type(value).__name__}, not a number")
    number = float(value)
    demand(math.isfinite(number) and number >= least, f"{what} = {number:g}")
    return number


def count_of(value: Any, what: str) -> int:
    """A whole number, not negative."""
    whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool) and value >= 0
    demand(whole, f"{what} that is no count")
    return int(value)


# -- settings ----------------------------------------------------------------------------------------------------------


def checked_fields(settings: Any, engine: str, preset: str, machine: Machine | None, steps: int) -> dict[str, Any]:
    """The plain values of settings that a preset made for a machine, None for any, and steps per revolution."""
    own = settings.engine, settings.preset
    demand(own == (engine, preset), f"settings of {one_line(repr(own))} for {(engine, preset)!r}")
    demand(count_of(settings.steps_per_revolution, "steps per revolution") == steps, "settings for another step")
    length = number_of(settings.timestep, "a time step [s]")
    right = length if machine is None else step_length(machine, steps)
    same = length > 0.0 and abs(length / right - 1.0) <= SAME_STEP
    demand(same, f"a time step of {length:g} s where {steps} a turn are {right:g} s")
    found = settings.as_dict()
    demand(isinstance(found, dict), "settings whose fields are no table")
    try:
        plain = json.loads(json.dumps(found, allow_nan=False))
    except (TypeError, ValueError) as error:
        raise EngineFault(f"it handed over settings that are no plain values: {words_of(error)}") from None
    return {**plain, "preset": preset}


# -- arrays ------------------------------------------------------------------------------------------------------------


def array_of(value: Any, what: str, columns: int | None = None, finite: bool = True) -> Array:
    """A copy of an array of numbers in double precision, (T,) or (T, columns)."""
    demand(type(value) is np.ndarray, f"{what} as {type(value).__name__}, not as a numpy array")
    demand(value.dtype == np.float64, f"{what} as {value.dtype}, not as float64")
    shape = "(T,)" if columns is None else f"(T, {columns})"
    right = value.ndim == (1 if columns is None else 2) and (columns is None or value.shape[1] == columns)
    demand(right, f"{what} of shape {value.shape}, not {shape}")
    copy = np.array(value)
    if finite and not np.isfinite(copy).all():
        bad = int(np.argmin(np.isfinite(copy).reshape(len(copy), -1).all(axis=1)))
        raise EngineFault(f"it handed over {what} with {copy[bad].ravel()[~np.isfinite(copy[bad].ravel())][0]}")
    return copy


def finite_arrays(found: Kind, kind: type[Kind], what: str) -> Kind:
    """A dataclass of arrays that begin with the same number of samples, all of them finite."""
    typed(found, kind, what)
    for name, value in ((one.name, getattr(found, one.name)) for one in fields(kind)):  # type: ignore[arg-type]
        if isinstance(value, np.ndarray):
            array_of(value, f"{what}: {name}", None if value.ndim == 1 else value.shape[-1])
        elif is_dataclass(value) and not isinstance(value, type):
            finite_arrays(value, type(value), what)
    return found


# -- laws and tables ---------------------------------------------------------------------------------------------------


def checked_law(found: Any, kind: type[Kind]) -> Kind:
    """Bounds on errors: a dataclass of texts and of numbers that are not negative, or None."""
    typed(found, kind, "a law of its errors")
    values = {}
    for one in fields(kind):  # type: ignore[arg-type]
        value = getattr(found, one.name)
        if isinstance(value, str):
            values[one.name] = text_of(value, "a law")
        else:
            values[one.name] = None if value is None else number_of(value, f"a bound of {one.name}", 0.0)  # type: ignore[assignment]
    return kind(**values)


def checked_numbers(found: Any, what: str) -> dict[str, float]:
    """A table of numbers by name."""
    return {text_of(name, what): number_of(value, what) for name, value in dict(found).items()}
