"""A study of a part of a scene's limits put into an earlier one: what was looked at again replaces what was known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from conrod.studies.limits.axes import AXES
from conrod.studies.limits.results import Walk
from conrod.studies.limits.study import LimitStudy

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
    return replace(new, **{**parts, "engines": engines, "walks": _in_order(parts["walks"], list(engines))})


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


def _in_order(walks: Sequence[Walk], engines: Sequence[str]) -> tuple[Walk, ...]:
    """By axes, as a study of all of them has it, and by engines."""
    names = list(AXES)
    return tuple(sorted(walks, key=lambda walk: (names.index(walk.axis), engines.index(walk.engine))))
