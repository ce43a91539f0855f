"""Errors of a user's input, stated in one line; and errors that pass to another process."""

from __future__ import annotations

import difflib
import pickle
import traceback
from collections.abc import Iterable


class InvalidInput(ValueError):
    """A value that cannot be used; the message names it, what is allowed and the nearest valid choice."""


def unknown_choice(kind: str, given: str, choices: Iterable[str]) -> InvalidInput:
    """The error for a name that is not in a list of names."""
    names = sorted(choices)
    if not names:
        return InvalidInput(f"unknown {kind} {given!r}: there is none with a name")
    near = difflib.get_close_matches(given, names, n=1, cutoff=0.4)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    return InvalidInput(f"unknown {kind} {given!r}: choose from {', '.join(names)}{hint}")


def portable(error: Exception) -> Exception:
    """An error that arrives in another process: one that cannot be pickled is replaced by its text."""
    if not isinstance(error, InvalidInput):
        error.add_note("".join(traceback.format_exception(error)))
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error
