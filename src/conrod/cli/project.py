"""Settings of a project: the table `[tool.conrod]` of its pyproject.toml."""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from conrod.cli import FAILED, waiting
from conrod.cli.options import PROJECT_FILE, project_file
from conrod.errors import InvalidInput, unknown_choice

KEYS = ("engines", "preset", "tolerance", "models")


@dataclass(frozen=True)
class ProjectSettings:
    """Settings of `[tool.conrod]` in a pyproject.toml, for `conrod validate` and `conrod check`.

    Attributes:
        file: the pyproject.toml, whose folder the models' paths start from.
        tolerance: largest error by quantity, as numbers or with a unit.
        models: for each model, table or FMU to check `file`, and keywords of `conrod.check`.
    """

    file: Path
    engines: tuple[str, ...] = ()
    preset: str | None = None
    tolerance: Mapping[str, float | str] = field(default_factory=dict)
    models: tuple[Mapping[str, Any], ...] = ()

    @property
    def tolerance_text(self) -> str | None:
        """The tolerance in the syntax of `--tolerance`; None if the project sets no tolerance."""
        return ",".join(f"{name}={value}" for name, value in self.tolerance.items()) or None


def read_project_settings(file: Path | None) -> ProjectSettings | None:
    """Read `[tool.conrod]` of a pyproject.toml; None without that file or table.

    Raises:
        InvalidInput: the file is no TOML, or a setting is unknown or of the wrong kind.
    """
    if file is None:
        return None
    try:
        tables = tomllib.loads(file.read_text("utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InvalidInput(f"{file}: it cannot be read: {error}") from None
    given = tables.get("tool", {}).get("conrod")
    return None if given is None else _parse_settings(file, given)


def _parse_settings(file: Path, given: Any) -> ProjectSettings:
    """Check the types of a project's settings."""
    place = f"{file}: tool.conrod"
    if not isinstance(given, dict):
        raise InvalidInput(f"{place} = {given!r}: it is a table, [tool.conrod]")
    for key in given:
        if key not in KEYS:
            raise InvalidInput(f"{place}: {unknown_choice('setting', key, KEYS)}")
    engines, preset = given.get("engines", []), given.get("preset")
    tolerance, models = given.get("tolerance", {}), given.get("models", [])
    if not isinstance(engines, list) or not all(isinstance(one, str) for one in engines):
        raise InvalidInput(f'{place}.engines = {engines!r}: it is a list of names, such as ["mujoco"]')
    if not isinstance(preset, str | None):
        raise InvalidInput(f"{place}.preset = {preset!r}: it is a name, such as 'tuned'")
    sizes = tolerance.values() if isinstance(tolerance, dict) else [None]
    if not all(isinstance(one, int | float | str) and not isinstance(one, bool) for one in sizes):
        raise InvalidInput(f'{place}.tolerance = {tolerance!r}: it is a table, such as {{ position = "0.1 mm" }}')
    if not isinstance(models, list) or not all(isinstance(one, dict) for one in models):
        raise InvalidInput(f"{place}.models = {models!r}: it is a list of tables, [[tool.conrod.models]]")
    for one in models:
        if not isinstance(one.get("file"), str):
            raise InvalidInput(f'{place}.models: {one!r} has no file: give file = "model.xml"')
    return ProjectSettings(file, tuple(engines), preset, tolerance, tuple(models))


def check_project_models(*, given_options: bool) -> None:
    """Judge each model named in the project's pyproject.toml; exit with status 1 if any fails.

    Args:
        given_options: whether options were typed, which go with a file alone.

    Raises:
        InvalidInput: no model is named, options were typed, or a model or its keywords cannot be used.
    """
    import conrod
    from conrod.execution.local import FILE_TIMEOUT
    from conrod.report.terminal import print_parts

    file = project_file()
    settings = read_project_settings(file)
    if settings is None or not settings.models:
        raise InvalidInput(f"give a FILE to judge, or name models in {file or PROJECT_FILE}: [[tool.conrod.models]]")
    if given_options:
        raise InvalidInput(f"options go with a FILE; of the models in {settings.file} they stand there")
    passed = list[bool | None]()
    for model in settings.models:
        given = {"tolerance": settings.tolerance or None, **model}
        name, scene = str(settings.file.parent / given.pop("file")), given.pop("scene", None)
        with waiting(name, FILE_TIMEOUT):
            found = conrod.check(name, scene, **{key: value for key, value in given.items() if value is not None})
        print_parts(found.kind.printed(list(found.values())))
        print_parts(found.baseline.text.splitlines() if found.baseline else ())
        passed.append(found.passed)
    if False in passed:
        sys.exit(FAILED)
