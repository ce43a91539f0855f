"""A shell completes what there is, and files of the endings that a verb takes."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.shell_completion import ShellComplete

from conrod.cli import cli


def completions(*words: str, begun: str = "") -> list[str]:
    """Words that a shell offers after those typed."""
    shell = ShellComplete(cli, {}, "conrod", "_CONROD_COMPLETE")
    return [item.value for item in shell.get_completions(list(words), begun)]


@pytest.mark.parametrize(
    ("words", "begun", "found"),
    [
        (("validate",), "saw-5", ["saw-500rpm"]),
        (("validate", "--fresh", "saw-40rpm"), "benn", ["bennett"]),
        (("forces",), "benn", []),  # a machine in space has no planar forces
        (("sweep",), "catal", ["catalogue"]),
        (("validate", "--engine"), "pym", ["pymunk"]),
        (("versions",), "muj", ["mujoco"]),
        (("validate", "--preset"), "hard", ["hardened"]),
        (("validate", "--engine", "pymunk", "--preset"), "", ["stock", "tuned"]),
        (("limits", "--axis"), "speed", ["speed"]),
        ((), "inv", ["invariances"]),
    ],
)
def test_names_are_completed_where_they_may_stand(words: tuple[str, ...], begun: str, found: list[str]) -> None:
    assert completions(*words, begun=begun) == found


def test_files_are_completed_by_the_endings_of_a_verb(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("saw.xml", "saw.toml", "saw.csv", "saw.png", ".saw.xml"):
        (tmp_path / name).touch()
    (tmp_path / "saws").mkdir()
    assert completions("check", begun="s") == ["saw.csv", "saw.xml", "saws/"]
    assert completions("lint", begun="s") == ["saw.xml", "saws/"]
    assert completions("validate", begun="saw.") == ["saw.toml"]
    assert completions("audit", begun=f"{tmp_path}/s") == [f"{tmp_path}/saw.csv", f"{tmp_path}/saws/"]
    assert completions("check", begun="missing/") == []
