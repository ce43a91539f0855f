"""A scene, a model, an FMU or a table, judged by the function for its kind."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Mapping
from inspect import signature
from pathlib import Path
from typing import Any

import conrod
from conrod.errors import InvalidInput, OutsideLoopsError, unknown_choice
from conrod.execution.resolve_arguments import OneScene
from conrod.execution.runner import Runs
from conrod.report.findings import Findings
from conrod.scenes import Scene
from conrod.scenes.space import MACHINES
from conrod.user_files import FILES, FMUS, TABLES
from conrod.user_files.in_memory import columns_of

# Keywords of `conrod.check` that are spelled in another way now.
NEW_KEYWORDS = {
    "point": "points", "drive": "drives", "column": "columns", "unit": "units", "ctrl": "controls", "engine": "engines"
}  # fmt: skip


def check(subject: Any, scene: OneScene | None = None, **arguments: Any) -> Findings[Any]:
    """Judge a scene, a model, an FMU or a table, by the function for its kind.

    Args:
        subject: a scene (a name, a mechanism file, or a `Scene`), a model (the path of an MJCF or binary file, or one
            in memory), an FMU (its path), or a table (the path of a file, a data frame, or a mapping of numpy
            arrays (T,), with `C` of shape (T, 2) for `C.x` and `C.y`).
        scene: the machine that a model, an FMU or a table is to be; none for a model whose joints are driven by laws,
            or that is inspected by itself.
        arguments: as in `validate`, `check_model`, `check_fmu`, `check_table`, `check_loops` or `inspect_model`; of a
            table with `torque`, as in `check_torque_run`. A scene's runs are made
            here and now unless `runs` says otherwise: no result of an earlier day answers for it.

    Raises:
        InvalidInput: the subject, the scene or an argument cannot be used.
    """
    refuse_old_keywords(arguments)
    name = str(subject).lower() if isinstance(subject, str | Path) else ""
    if isinstance(subject, str) and subject in MACHINES:
        return conrod.check_loops(subject, **_keywords("check_loops", "a machine in space", arguments, machine=scene))
    if isinstance(subject, Scene) or (name and not name.endswith(FILES)):
        if scene is not None:
            raise InvalidInput(f"scene={scene!r} is for a file: a scene is judged as it is")
        with tempfile.TemporaryDirectory() as folder:
            runs = Runs(ledger=Path(folder, "ledger.sqlite"), fresh=True, jobs=1)
            return conrod.validate(subject, **{"runs": runs, **_keywords("validate", "a scene", arguments)})
    is_table = name.endswith(TABLES) or columns_of(subject) is not None
    driven = "drives" in arguments and not is_table and not name.endswith(FMUS)
    if driven:
        return _check_driven_model(subject, scene, arguments)
    if scene is None:
        if not is_table and not name.endswith(FMUS) and "inspect_model" in conrod.__all__:
            return conrod.inspect_model(subject, **_keywords("inspect_model", "a model without a scene", arguments))
        what = str(subject) if name else f"a {type(subject).__name__}"
        raise InvalidInput(f"{what}: say with scene=... what machine it is")
    if is_table or name.endswith(FMUS):
        under_torque = "torque" in arguments and "check_torque_run" in conrod.__all__
        function, what = ("check_torque_run", "a run under a torque") if under_torque else ("check_table", "a table")
        if not is_table:
            function, what = "check_fmu", "an FMU"
        found: Findings[Any] = getattr(conrod, function)(subject, **_keywords(function, what, arguments, scene=scene))
        return found
    given = _keywords("check_model", "a model", arguments, scene=scene)
    return conrod.check_model(subject, **{"crank": None, "points": {}, **given})


def _check_driven_model(subject: Any, scene: OneScene | None, arguments: Mapping[str, Any]) -> Findings[Any]:
    """Judge a model's loops by its exact motion; inspect the model if its drives are outside loops."""
    given = _keywords("check_loops", "a model with drives", arguments, machine=scene)
    try:
        return conrod.check_loops(subject, **given)
    except OutsideLoopsError:
        if scene is not None or "inspect_model" not in conrod.__all__:
            raise
    return conrod.inspect_model(subject, **_keywords("inspect_model", "a drive outside loops", arguments))


# What each function judges, in words, by its name.
JUDGED = {
    "validate": "scenes", "check_model": "models", "check_fmu": "FMUs", "check_table": "tables",
    "check_loops": "closed loops", "inspect_model": "models by themselves",
    "check_torque_run": "tables of runs under a torque",
}  # fmt: skip


def _keywords(function: str, subject: str, given: Mapping[str, Any], **machine: OneScene | None) -> dict[str, Any]:
    """Return the keywords of a function for its subject, with a given scene or machine added.

    Raises:
        InvalidInput: the function has no such keyword; names the functions that have it.
    """
    known = {name: [*signature(getattr(conrod, name)).parameters][1:] for name in JUDGED if name in conrod.__all__}
    for keyword in given:
        if keyword not in known[function]:
            others = [JUDGED[name] for name, names in known.items() if keyword in names]
            if others:
                raise InvalidInput(f"{keyword} does not go with {subject}: it is for {', '.join(others)}")
            raise unknown_choice(
                "keyword", keyword, [one for one in known[function] if one not in ("scene", "progress")]
            )
    chosen = {name: str(one) if name == "machine" else one for name, one in machine.items() if one is not None}
    return {**chosen, **given}


def refuse_old_keywords(names: Iterable[str]) -> None:
    """Refuse a keyword of an earlier conrod; raises InvalidInput, which gives the new one."""
    for name in names:
        if name in NEW_KEYWORDS:
            raise InvalidInput(f"{name}=... is now {NEW_KEYWORDS[name]}=...")
        if name == "set":
            raise InvalidInput("set=... is gone: make the scene with its parameters, conrod.scene(NAME, crank='80 mm')")
