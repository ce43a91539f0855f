"""Words that a shell completes with names of the model, or of the scene, that the line names: joints, parameters."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.shell_completion import CompletionItem

from conrod.cli.completion import matching_names, words_given
from conrod.errors import InvalidInput
from conrod.user_files import FILES, MODELS

if TYPE_CHECKING:
    from conrod.scenes import Scene

PLACES = ("site", "body", "geom")


def names(
    context: click.Context,
    parameter: click.Parameter,
    typed: str,
    kinds: Iterable[str],
    ending: str = "",
    more: Iterable[str] = (),
) -> list[CompletionItem]:
    """Names in the model.

    Args:
        kinds: as in `names_in_model`.
        ending: what stands behind each name, such as the equals sign before a value.
        more: names that every model has.
    """
    known = dict.fromkeys((*_names(context, kinds), *more))
    return matching_names((f"{name}{ending}" for name in known), typed)


def points(context: click.Context, parameter: click.Parameter, typed: str) -> list[CompletionItem]:
    """Observed points of the scene, then the kind of element, then its names in the model."""
    point, equals, place = typed.partition("=")
    if not equals:
        observed = [one.name for scene in _scenes(context) for one in scene.mechanism().observed]
        return matching_names((f"{name}=" for name in observed), typed)
    kind, colon, _ = place.partition(":")
    if not colon:
        return matching_names((f"{point}={one}:" for one in PLACES), typed)
    known = _names(context, (kind,)) if kind in PLACES else ()
    return matching_names((f"{point}={kind}:{name}" for name in known), typed)


def parameters(context: click.Context, parameter: click.Parameter, typed: str) -> list[CompletionItem]:
    """Complete names of parameters: of the scenes on the line, or of all scenes with a closed form."""
    known = dict.fromkeys(name for scene in _scenes(context) for name in scene.parameter_facts())
    return matching_names((f"{name}=" for name in known), typed)


def _names(context: click.Context, kinds: Iterable[str]) -> Iterator[str]:
    """Yield the names of some kinds in the model that the line names."""
    from conrod.user_files.names_in_model import names_in_model

    model = next((word for word in words_given(context) if word.lower().endswith(MODELS)), None)
    if model is not None:
        found = names_in_model(Path(model))
        for kind in kinds:
            yield from found.get(kind, ())


def _scenes(context: click.Context) -> list[Scene]:
    """Scenes that the line names, by --scene or as they are; those in closed form where it names none."""
    from conrod.execution.resolve_arguments import select_scenes
    from conrod.scenes import CATALOGUE

    named = context.params.get("scene") or [one for one in words_given(context) if not one.lower().endswith(FILES)]
    asked = [named] if isinstance(named, str) else named
    with suppress(InvalidInput, OSError):
        return [*select_scenes([one for one in asked if one != CATALOGUE], ()).values()]
    return []
