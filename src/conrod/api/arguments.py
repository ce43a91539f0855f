"""Scenes and engines that a caller names."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from conrod.engines import Engine
from conrod.scenes import Scene
from conrod.studies.frame.resolve_arguments import select_engines, select_scene, select_scenes

OneScene: TypeAlias = str | Path | Scene | tuple[str, Scene]  # of a pair the first is what it is called
Scenes: TypeAlias = OneScene | Sequence[OneScene] | Mapping[str, Scene]
Engines: TypeAlias = str | Sequence[str | Engine[Any]] | None


class EngineLeftOut(UserWarning):
    """An engine that nobody named cannot be loaded, and takes no part."""


def scenes_by_name(scenes: Scenes) -> dict[str, Scene]:
    """Scenes by name: names, mechanism files or objects; the four with a closed form where none is given.

    Raises:
        InvalidInput: there is no such scene or file, or two scenes have one name.
    """
    if isinstance(scenes, Mapping):
        return dict(scenes)
    given = [scenes] if is_one(scenes) else list(scenes)  # type: ignore[arg-type] # is_one tells both apart
    objects, names = dict[str, Scene](), list[str]()
    for one in given:
        if isinstance(one, tuple):
            objects[one[0]] = one[1]
        elif isinstance(one, Scene):
            objects[one.kind] = one
        else:
            names.append(str(one))
    return {**(select_scenes(names, ()) if names or not objects else {}), **objects}


def is_one(scenes: object) -> bool:
    """True of one scene, False of a sequence of scenes."""
    pair = isinstance(scenes, tuple) and len(scenes) == 2 and isinstance(scenes[1], Scene)
    return isinstance(scenes, str | Path | Scene) or pair


def scene_by_name(scene: OneScene) -> tuple[str, Scene]:
    """One scene with its name."""
    if isinstance(scene, tuple):
        return scene
    return select_scene(scene if isinstance(scene, Scene) else str(scene), ())


def choose_engines(engines: Engines) -> list[Engine[Any]]:
    """Engines by name or as objects; of "all" every installed one, of none those that take part by themselves.

    Raises:
        InvalidInput: there is no such engine, or it cannot be loaded.
    """
    given = [engines] if isinstance(engines, str) else list(engines or ())
    objects = [one for one in given if isinstance(one, Engine)]
    names = [one for one in given if isinstance(one, str)]
    if objects and not names:
        return objects
    return [*objects, *select_engines(names, left_out=_warn)]


def engine_names_given(engines: Engines) -> tuple[str, ...]:
    """Names of the engines that a caller named."""
    given = [engines] if isinstance(engines, str) else list(engines or ())
    return tuple(one if isinstance(one, str) else one.name for one in given)


def _warn(reason: str) -> None:
    warnings.warn(f"left out: {reason}", EngineLeftOut, stacklevel=4)


def text_of_call(function: str, subject: object, **arguments: object) -> str:
    """A call of the API as Python text, with the arguments that were given, for reports to print."""
    given = {name: value for name, value in arguments.items() if value not in (None, (), False)}
    return f"conrod.{function}({', '.join([repr(subject), *(f'{name}={value!r}' for name, value in given.items())])})"
