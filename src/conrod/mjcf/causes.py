"""What a model's closures show, as causes of what goes wrong with it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import mujoco
from numpy.linalg import LinAlgError

from conrod.errors import InvalidInput
from conrod.exact.space.motion import NO_FURTHER
from conrod.mjcf.anchors import apart_words
from conrod.mjcf.equalities import handle_indices, handle_words, inactive_words
from conrod.mjcf.loading import check_finite
from conrod.mjcf.missing_files import load_with_notes


def describe_closures(model: mujoco.MjModel) -> str:
    """Describe closures that are inactive, are handles, or hold parts that do not meet; empty if none."""
    return "; ".join(
        filter(None, (inactive_words(model), handle_words(model, handle_indices(model)), apart_words(model)))
    )


def append_causes(error: str, *causes: str) -> str:
    """Append causes to an error message, in place of the guess that it may end with."""
    known = [cause for cause in causes if cause and cause not in error]
    if not known:
        return error
    begins, guess, ends = error.partition(f": {NO_FURTHER}")
    return f"{begins}{': ' if guess else '; '}{'; '.join(known)}{ends}"


@contextmanager
def add_causes_to_errors(
    path: Path, more: Callable[[mujoco.MjModel], Iterable[str]] = lambda _: (), unit: float = 1.0
) -> Iterator[None]:
    """Add the causes that a model's closures show, and further ones, to any InvalidInput raised within.

    Args:
        unit: unit of the file's lengths [m].
    """
    try:
        yield
    except InvalidInput as error:
        try:
            model, _ = load_with_notes(path, unit)
            check_finite(model)
            causes = [describe_closures(model), *more(model)]
        # What cannot be loaded, or has numbers that are none or too large to compute with, says so itself.
        except (InvalidInput, LinAlgError):
            raise error from None
        raise InvalidInput(append_causes(str(error), *causes)) from None
