"""Commands with a new spelling: a command line of an earlier version is answered with that of today."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path

# Options of `conrod validate` that belong to another verb now
VERB_OF_OPTION = {
    "--invariances": "invariances", "--motion": "free", "--quantity": "forces", "--step": "free", "--drive": "check",
    "--scene": "check", "--crank": "check", "--point": "check", "--plane": "check", "--rotation": "check",
    "--crank-zero": "check", "--keyframe": "check", "--ctrl": "check", "--seconds": "free",
}  # fmt: skip
# Options that take a value, which is no file that is judged.
WITH_VALUE = (
    "--scene", "--drive", "--crank", "--point", "--plane", "--rotation", "--crank-zero", "--keyframe", "--ctrl",
    "--column", "--unit", "--estimate", "--motion", "--quantity", "--seconds", "--step", "--out", "--json", "--html",
    "--engine", "--preset", "--set", "--steps-per-rev", "--revolutions", "--tolerance", "--baseline", "--report",
    "--verification", "--measured", "--limits", "--uncertainty", "--ledger", "--jobs", "--cluster",
    "--cell-timeout", "--cell-memory",
)  # fmt: skip


def new_spelling(arguments: Sequence[str]) -> str | None:
    """Command line to type in place of one of an earlier version; None if it is valid today.

    Args:
        arguments: the verb and all that follows it.
    """
    if not arguments or arguments[0] not in ("validate", "check"):
        return None
    verb, words = arguments[0], _split_equals(arguments[1:])
    given = [word for word in words if word.startswith("--")]
    moved = next((VERB_OF_OPTION[one] for one in VERB_OF_OPTION if one in given), None) if verb == "validate" else None
    if moved is None and verb == "validate" and any(_is_file(name) for name in _subjects(words)):
        moved = "check"
    if moved == "free" and _names_machine_in_space(words):
        moved = "check"
    if moved is None and "--report" not in given:
        return None
    if verb == "validate" and moved == "check" and (refusal := _for_files_alone(words, given)):
        return refusal
    new = ["conrod", moved or verb, *_respell_options(words, moved)]
    return f"`{_shell_text(['conrod', *arguments])}` is now `{_shell_text(new)}`"


def _split_equals(words: Sequence[str]) -> list[str]:
    """Words, with `--option=value` as two."""
    found = list[str]()
    for word in words:
        name, equals, value = word.partition("=")
        found += [name, value] if equals and name in WITH_VALUE else [word]
    return found


def _subjects(words: Sequence[str]) -> list[str]:
    """Words that are no option and no option's value."""
    values = {k + 1 for k, word in enumerate(words) if word in WITH_VALUE}
    return [word for k, word in enumerate(words) if k not in values and not word.startswith("-")]


def _for_files_alone(words: Sequence[str], given: Sequence[str]) -> str | None:
    """Say that an option is for files, if the command line names scenes only; else None."""
    names = _subjects(words)
    if _names_machine_in_space(words) or any(_is_file(name) or Path(name).exists() for name in names):
        return None
    if any(Path(name).suffix not in ("", ".toml") for name in names):
        return None
    option = next(one for one in VERB_OF_OPTION if one in given)
    return f"{option} does not go with a scene: it is for a file, in `conrod check`"


def _names_machine_in_space(words: Sequence[str]) -> bool:
    from conrod.scenes.space import MACHINES, SPATIAL

    return any(name in (*MACHINES, SPATIAL) for name in _subjects(words))


def _is_file(name: str) -> bool:
    from conrod.user_files import FILES

    return name.lower().endswith(FILES)


def _respell_options(words: Sequence[str], verb: str | None) -> list[str]:
    """The words with options in their new spelling."""
    found, skip = list[str](), False
    for word, following in zip(words, [*words[1:], ""], strict=True):
        if skip:
            skip = False
        elif word == "--invariances":
            continue
        elif word == "--motion":
            found += ["--torque"] if following == "torque" else []
            skip = True
        else:
            found.append("--verification" if word == "--report" else word)
    return found


def _shell_text(words: Sequence[str]) -> str:
    return " ".join(shlex.quote(word) for word in words)
