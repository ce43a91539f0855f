"""Words that a shell completes: scenes, engines, presets, axes, and files by their endings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TypeAlias

import click
from click.shell_completion import CompletionItem

from conrod.user_files import MODELS

TYPED = "conrod.typed"  # words of the command line, in the context of a verb
Completer: TypeAlias = Callable[[click.Context, click.Parameter, str], "list[CompletionItem]"]


def scenes(context: click.Context, parameter: click.Parameter, typed: str) -> list[CompletionItem]:
    """Names of scenes, `catalogue` and `spatial`, and mechanism files."""
    from conrod.scenes import CATALOGUE, SCENES, catalogue_names, dynamics_names
    from conrod.scenes.space import MACHINES, SPATIAL

    names = [*SCENES, *catalogue_names(), *dynamics_names(), CATALOGUE]
    if context.info_name in ("validate", "export", "check"):
        names += [*MACHINES, SPATIAL] if context.info_name == "validate" else MACHINES
    return [*matching_names(names, typed), *_files(typed, (".toml",))]


def engines(context: click.Context, parameter: click.Parameter, typed: str) -> list[CompletionItem]:
    """Names of engines that can take part, and the word for all."""
    from conrod.engines import OPTIONAL_ENGINES, engine_names
    from conrod.execution.resolve_arguments import ALL_ENGINES

    return matching_names([*engine_names(), *OPTIONAL_ENGINES, ALL_ENGINES], typed)


def presets(context: click.Context, parameter: click.Parameter, typed: str) -> list[CompletionItem]:
    """Presets of the engines that were named before, or of all that ship."""
    from conrod.engines import engine_names, presets_of

    asked = context.params.get("engine") or engine_names()
    return matching_names(dict.fromkeys(name for engine in asked for name in presets_of(engine)), typed)


def models_or_scenes(context: click.Context, parameter: click.Parameter, typed: str) -> list[CompletionItem]:
    """Model files, and what `scenes` has."""
    return [*scenes(context, parameter, typed), *_files(typed, MODELS)]


def files_with(endings: Sequence[str]) -> Completer:
    """Make a completer of folders, and of files with some endings."""

    def files(context: click.Context, parameter: click.Parameter, typed: str) -> list[CompletionItem]:
        return _files(typed, endings)

    return files


def words_given(context: click.Context) -> list[str]:
    """Words before the one that is completed which are no option, and no value of one."""
    options = [one for one in context.command.params if isinstance(one, click.Option) and not one.is_flag]
    with_value, words, before = {name for one in options for name in one.opts}, list[str](), ""
    for word in context.meta.get(TYPED, ()):
        if before not in with_value and not word.startswith("-"):
            words.append(word)
        before = word
    return words


def matching_names(names: Iterable[str], typed: str) -> list[CompletionItem]:
    """Return the names that begin as typed."""
    return [CompletionItem(name) for name in names if name.startswith(typed)]


def _files(typed: str, endings: Sequence[str]) -> list[CompletionItem]:
    """Files and folders whose path begins as typed; none where the folder cannot be read."""
    folder, _, name = typed.rpartition("/")
    place = Path(folder or ("/" if typed.startswith("/") else "."))
    try:
        found = sorted(one for one in place.iterdir() if one.name.startswith(name))
    except OSError:
        return []
    prefix = f"{folder}/" if "/" in typed else ""
    folders = [f"{prefix}{one.name}/" for one in found if one.is_dir() and not one.name.startswith(".")]
    return [
        *(CompletionItem(f"{prefix}{one.name}") for one in found if one.name.lower().endswith(tuple(endings))),
        *map(CompletionItem, folders),
    ]
