"""A study of a part of a scene's limits put into an earlier one: what was looked at again replaces what was known.

The report of limits for machines: `results.json`, from which all its pages are made, and it is known by.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

from conrod.errors import InvalidInput
from conrod.report import numbers
from conrod.report.folder import check_beside, check_own_folder, document_in, holds_document
from conrod.report.names import FIGURES, FILE, INDEX, page_file
from conrod.runs.plain import plain, restore
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.results import LimitStudy, Walk

Part = TypeVar("Part")
Sameness = Callable[[Any], tuple[str, ...]]

# Of each part of a study: what it is about, besides the scene.
PARTS: dict[str, Sameness] = {
    "walks": lambda walk: (walk.engine, walk.preset, walk.axis),
    "long_runs": lambda run: (run.engine, run.preset),
    "maps": lambda found: (found.engine, found.preset, found.x_axis, found.y_axis),
    "needs": lambda need: (need.engine, need.preset, str(need.iterations)),
    "determinism": lambda found: (found.engine, found.preset),
    "floats": lambda found: (found.engine, found.preset),
}


def merged(earlier: LimitStudy, new: LimitStudy) -> LimitStudy:
    """The earlier study with all that the new one looked at again replaced, and with what it adds.

    Nothing is kept of another machine, or of another version of an engine: figures that no run would give again.
    """
    if (earlier.kind, dict(earlier.parameters)) != (new.kind, dict(new.parameters)):
        return new
    changed = {name for name, version in new.engines.items() if earlier.engines.get(name, version) != version}
    kept = {name: [part for part in getattr(earlier, name) if part.engine not in changed] for name in PARTS}
    engines = {**earlier.engines, **new.engines}
    parts: dict[str, Any] = {name: _replaced(kept[name], getattr(new, name), same) for name, same in PARTS.items()}
    return replace(new, **{**parts, "engines": engines, "walks": _merged_in_order(parts["walks"], list(engines))})


def _replaced(earlier: Sequence[Part], new: Sequence[Part], same: Sameness) -> tuple[Part, ...]:
    """New parts stand where the first earlier one about the same stood; those about something else at the end."""
    ahead: dict[tuple[str, ...], list[Part]] = {}
    for part in new:
        ahead.setdefault(same(part), []).append(part)
    about = set(ahead)
    found: list[Part] = []
    for part in earlier:
        found += ahead.pop(same(part), []) if same(part) in about else [part]
    return (*found, *(part for parts in ahead.values() for part in parts))


def _merged_in_order(walks: Sequence[Walk], engines: Sequence[str]) -> tuple[Walk, ...]:
    """By axes, as a study of all of them has it, and by engines."""
    names = list(AXES)
    return tuple(sorted(walks, key=lambda walk: (names.index(walk.axis), engines.index(walk.engine))))


SCHEMA = 2
# Inputs, written as they are; everything else that is a fraction was measured.
INPUTS = {"parameters", "value", "last_good", "first_bad", "good_again", "x", "y", "revolutions"}
INPUTS |= {"speed", "held", "flown"}
# Flights are compared with exact ones: what counts is a small difference of the two.
COMPARED = {"exact", "measured"}
MEASURED_DIGITS, COMPARED_DIGITS = 4, 8
SCENE_KEYS = {"conrod", "environment", "commands", "study"}
NESTED = 5  # levels that are written on lines of their own

Entry = dict[str, Any]  # of a scene: SCENE_KEYS


def scene_entry(study: LimitStudy, earlier: Entry | None, made_with: Mapping[str, str], command: str) -> Entry:
    """What the document says of a scene.

    Args:
        earlier: what it said before, if anything; parts of it that the study did not look at stay.
        made_with: the environment of the new runs.
        command: what reproduces them.
    """
    found = plain(study)
    commands = [command]
    if earlier is not None:
        before = restore(LimitStudy, earlier["study"])
        whole = merged(before, study)
        found = plain(whole)
        if whole != study:
            commands = list(dict.fromkeys([*earlier["commands"], command]))
    return {
        "conrod": version("conrod"),
        "environment": dict(made_with),
        "commands": commands,
        "study": rounded(found),
    }


def document_text(scenes: Mapping[str, Entry]) -> str:
    """The JSON document: a run a line."""
    return _lines({"schema": SCHEMA, "limits": scenes}, 0) + "\n"


def rounded(value: Any, digits: int | None = MEASURED_DIGITS) -> Any:
    """What was measured in few significant digits, inputs as they are; what is not finite as the tables print it."""
    match value:
        case float() if not math.isfinite(value):
            return numbers.measured(value)
        case float():
            return value if digits is None else numbers.rounded(value, digits)
        case Mapping():
            return {str(key): rounded(part, _digits(key, digits)) for key, part in value.items()}
        case list() | tuple():
            return [rounded(part, digits) for part in value]
        case _:
            return value


def _digits(key: object, digits: int | None) -> int | None:
    return None if digits is None or key in INPUTS else COMPARED_DIGITS if key in COMPARED else digits


def _lines(value: Any, level: int) -> str:
    """JSON with a line for each part of the first levels, and for each of a list of many below them."""
    many = isinstance(value, list) and any(isinstance(part, Mapping) for part in value)
    if (level >= NESTED and not many) or not isinstance(value, Mapping | list) or not value:
        return json.dumps(value, ensure_ascii=False, allow_nan=False)
    margin = " " * (level + 1)
    if isinstance(value, Mapping):
        parts = [f"{json.dumps(str(k), ensure_ascii=False)}: {_lines(v, level + 1)}" for k, v in value.items()]
        opening, closing = "{", "}"
    else:
        parts = [_lines(part, level + 1) for part in value]
        opening, closing = "[", "]"
    inside = ",\n".join(margin + part for part in parts)
    return f"{opening}\n{inside}\n{' ' * level}{closing}"


# -- the report that a folder holds ----------------------------------------------------------------------------------


def earlier_limits(directory: Path) -> dict[str, Entry]:
    """Scenes of the report of limits that a folder already holds; none where it holds no report of this kind."""
    try:
        document = document_in(directory / FILE)
        scenes = document["limits"] if document["schema"] == SCHEMA else {}
        return {name: scene for name, scene in scenes.items() if _is_whole(scene)}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


def _is_whole(scene: Mapping[str, Any]) -> bool:
    """Whether an entry can be read back; one of another version of conrod may not."""
    try:
        restore(LimitStudy, scene["study"])
    except (InvalidInput, KeyError, TypeError, AttributeError):
        return False
    return scene.keys() >= SCENE_KEYS


def check_limits_folder(directory: Path, scenes: Collection[str]) -> None:
    """Refuse a folder in which a report of the limits of some scenes would replace what is not such a report's.

    Raises:
        InvalidInput: names the file that is in the way.
    """
    pages = [INDEX, FILE, *(page_file(scene) for scene in scenes)]
    found = (path for scene in scenes for path in (directory / FIGURES).glob(f"{scene}-*.svg"))
    drawn = [path.relative_to(directory).as_posix() for path in found]
    own = holds_document(directory / FILE, {"schema", "limits"})
    check_own_folder(directory, pages, drawn, FIGURES, own, "a report of limits")


def check_limits_apart(document: Path, directory: Path, scenes: Iterable[str]) -> None:
    """Refuse a file that is one of those that a report of the limits of some scenes consists of, or is in its way.

    Raises:
        InvalidInput: names the file.
    """
    pages = [page_file(scene) for scene in (*scenes, *earlier_limits(directory))]
    # Its folder of figures is the report's own.
    check_beside(document, directory, [INDEX, FILE, *pages, f"{FIGURES}/{document.name}"])
