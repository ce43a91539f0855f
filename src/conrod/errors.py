"""Errors of a user's input, stated in one line; errors that name a file, or pass to another process."""

from __future__ import annotations

import difflib
import os
import pickle
import traceback
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from itertools import islice
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")
Value = TypeVar("Value")

# Of two names, by the share of letters in the same order: below the first they are not alike. Others than the nearest
# are named where they are nearly as near; a name that was begun counts a little less than one typed to its end.
MIN_LIKENESS, NEARLY_AS_LIKE, BEGUN_NAME_FACTOR = 0.49, 0.95, 0.75
MAX_CHOICES = 12  # names that an error lists where one is near
MAX_LISTED_CHARACTERS = 500  # of all names, where none is near
MAX_FILES_LOOKED_AT, MIN_LIKENESS_OF_FILES = 1000, 0.65  # in a folder, for the nearest name
MAX_ECHO = 80  # letters of a name that was typed, in an error


# Characters that command a terminal or a reader, each as what is shown in its place: control characters but tab and
# line end, those that turn the direction of what follows, other ends of lines, letters that are seen nowhere, and
# halves of characters.
COMMANDING_CHARACTERS = dict.fromkeys(
    [
        *range(0x09), *range(0x0B, 0x20), *range(0x7F, 0xA0), 0x61C, 0x200E, 0x200F, *range(0x2028, 0x202F),
        *range(0x2066, 0x206A), *range(0xFFF9, 0xFFFC), *range(0xD800, 0xE000), *range(0xE0000, 0xE0080),
    ],
    "?",
)  # fmt: skip


class InvalidInput(ValueError):
    """A value that cannot be used; the message names the value, the allowed ones and the nearest."""


class OutsideLoopsError(InvalidInput):
    """A drive that closed loops do not answer: of an actuator's control, or of a model without loops."""


class UnknownName(InvalidInput, KeyError):
    """A name that a table lacks; also a KeyError, as mapping lookups raise."""

    __str__ = Exception.__str__  # KeyError quotes its message


class ConrodWarning(UserWarning):
    """Warning of conrod: something was left out, or did not come out as it was asked for."""


class Named(dict[str, T]):
    """A dict whose error for an unknown name suggests the nearest name and lists all.

    Attributes:
        kind: what is named, such as "scene", for the message.
    """

    def __init__(self, entries: Mapping[str, T] | Iterable[tuple[str, T]] = (), kind: str = "name") -> None:
        super().__init__(entries)
        self.kind = kind

    def __missing__(self, name: object) -> T:
        raise UnknownName(str(unknown_choice(self.kind, str(name), self)))


def unknown_choice(kind: str, given: str, choices: Iterable[str], listing: str = "") -> InvalidInput:
    """The error for a name that is not in a list of names.

    A long list is cut where a name is near: to those that are nearest, or to the command that lists all. Where none is
    near, it is cut to what a line bears.

    Args:
        listing: command that prints the names, such as `conrod show`; empty if there is none.
    """
    names, shown = sorted(choices), repr(given if len(given) <= MAX_ECHO else f"{given[:MAX_ECHO]}..")
    if not names:
        return InvalidInput(f"unknown {kind} {shown}: there is none with a name")
    near = " or ".join(repr(name) for name in nearest(given, names))
    hint, more = f"did you mean {near}? " if near else "", ""
    if near and len(names) > MAX_CHOICES:
        if listing:
            return InvalidInput(f"unknown {kind} {shown}: {hint}all: {listing}")
        more = f" and {len(names) - MAX_CHOICES} more"
        names = sorted(sorted(names, key=lambda name: -_likeness(given.casefold(), name))[:MAX_CHOICES])
    elif listing and len(", ".join(names)) > MAX_LISTED_CHARACTERS:
        more, names = f" and {len(names) - MAX_CHOICES} more; all: {listing}", names[:MAX_CHOICES]
    return InvalidInput(f"unknown {kind} {shown}: {hint}choose from {', '.join(names)}{more}")


def nearest(given: str, names: Iterable[str], max_names: int = 2) -> list[str]:
    """The names most similar to a mistyped one, the most similar first; empty if none is similar."""
    if not given.strip():
        return []
    typed = given.casefold()
    likely = sorted(((_likeness(typed, name), name) for name in names), key=lambda pair: -pair[0])
    best = likely[0][0] if likely else 0.0
    return [name for alike, name in likely[:max_names] if alike >= max(MIN_LIKENESS, NEARLY_AS_LIKE * best)]


def _likeness(typed: str, name: str) -> float:
    """Share of letters that a name and the typed text have in the same order, both in lower case."""
    # A name that was only begun ("saw") is as near as one with a wrong letter.
    whole, begun = name.casefold(), name.casefold()[: len(typed)]
    return max(
        difflib.SequenceMatcher(None, typed, whole).ratio(),
        BEGUN_NAME_FACTOR * difflib.SequenceMatcher(None, typed, begun).ratio(),
    )


def list_names(names: Iterable[str], max_names: int = 6) -> str:
    """Join names by commas, cut short after the first `max_names`."""
    every = list(names)
    return ", ".join(every[:max_names]) + (f" and {len(every) - max_names} more" if len(every) > max_names else "")


def no_such_file(path: Path) -> InvalidInput:
    """The error for a missing file: names the nearest file in its folder, or the missing folder."""
    with suppress(OSError):
        if not path.parent.is_dir():
            return InvalidInput(f"{path}: there is no such file: there is no folder {path.parent}")
        names = [Path(one.name) for one in islice(os.scandir(path.parent), MAX_FILES_LOOKED_AT)]
        stems = [name.stem for name in names if name.suffix == path.suffix]
        if near := difflib.get_close_matches(path.stem, stems, n=2, cutoff=MIN_LIKENESS_OF_FILES):
            beside = " or ".join(repr(str(path.with_name(stem + path.suffix))) for stem in near)
            return InvalidInput(f"{path}: there is no such file: did you mean {beside}?")
    return InvalidInput(f"{path}: there is no such file")


def named_values(
    texts: Iterable[str], option: str, form: str = "name=value", kind: str = "name", known: Iterable[str] = ()
) -> dict[str, str]:
    """Parse texts "name=value" to values by name.

    Args:
        form: expected form of a text, for the error message.
        kind: kind of thing that the names stand for, for the error message.
        known: allowed names; empty if any name is allowed.

    Raises:
        InvalidInput: a text has another form, or its name is unknown or given twice.
    """
    values, choices = dict[str, str](), list(known)
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (equals and name and value):
            raise InvalidInput(f"{option} {text!r}: give {form}")
        if choices and name not in choices:
            raise unknown_choice(kind, name, choices)
        if name in values:
            raise InvalidInput(f"{option} {name}: given twice, as {values[name]!r} and {value!r}")
        values[name] = value
    return values


def as_names(given: str | Sequence[str] | None) -> tuple[str, ...]:
    """Names given as one text or as several: one text is one name."""
    return (given,) if isinstance(given, str) else tuple(given or ())


def as_mapping(keyword: str, given: Mapping[str, Value] | None, example: str) -> dict[str, Value]:
    """Check that a keyword's value is a mapping; None is an empty one.

    Raises:
        InvalidInput: the value is no mapping; shows the example.
    """
    if given is not None and not isinstance(given, Mapping):
        raise InvalidInput(f"{keyword} = {given!r}: give a mapping, such as {example}")
    return dict(given or {})


def portable(error: Exception) -> Exception:
    """Make an error that can be pickled: another one is replaced by its text."""
    if not isinstance(error, InvalidInput):
        error.add_note("".join(traceback.format_exception(error)))
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:  # pickling runs code of the error's own class, which may raise anything
        made = RuntimeError(f"{type(error).__name__}: {error}")
        for note in getattr(error, "__notes__", ()):
            made.add_note(note)
        return made
    return error


@contextmanager
def name_file_in_os_errors(place: Path | str) -> Iterator[None]:
    """Make an OSError name the file that the user knows, not the temporary file or none."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(place)) from error
