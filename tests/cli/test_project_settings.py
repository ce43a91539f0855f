"""`[tool.conrod]` of pyproject.toml: what it sets is taken, options win, and a slip in it is named."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from conrod.cli import cli
from conrod.cli.options import project_file
from conrod.cli.project import ProjectSettings, read_project_settings
from conrod.errors import InvalidInput
from conrod.studies.validation.verb import ValidateOptions, with_project_settings

SAW = Path(__file__).parents[2] / "mjcf" / "saw-500rpm.xml"
SETTINGS = """
[tool.conrod]
engines = ["mujoco"]
preset = "tuned"
tolerance = { position = "0.1mm", velocity = 1e-3 }
"""


def project(folder: Path, text: str) -> Path:
    (folder / "pyproject.toml").write_text(text, "utf-8")
    return folder


def test_settings_are_those_of_the_nearest_project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a" / "b").mkdir(parents=True)
    project(tmp_path, SETTINGS)
    monkeypatch.chdir(tmp_path / "a" / "b")
    found = read_project_settings(project_file())
    tolerance = {"position": "0.1mm", "velocity": 1e-3}
    assert found == ProjectSettings(tmp_path / "pyproject.toml", ("mujoco",), "tuned", tolerance)
    assert found.tolerance_text == "position=0.1mm,velocity=0.001"
    project(tmp_path / "a", "[project]\nname = 'other'\n")
    assert project_file() is None
    assert read_project_settings(tmp_path / "a" / "pyproject.toml") is None


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[tool.conrod]\npre-set = 'tuned'", "unknown setting 'pre-set': did you mean 'preset'"),
        ("[tool]\nconrod = 1", "it is a table"),
        ("[tool.conrod]\nengines = 'mujoco'", "it is a list of names"),
        ("[tool.conrod]\npreset = 1", "it is a name"),
        ("[tool.conrod]\ntolerance = 1e-4", "it is a table, such as { position"),
        ("[tool.conrod]\ntolerance = { position = true }", "it is a table, such as { position"),
        ("[tool.conrod]\nmodels = ['a.xml']", "it is a list of tables"),
        ("[[tool.conrod.models]]\nscene = 'saw-40rpm'", "has no file"),
        ("[tool.conrod", "it cannot be read"),
    ],
)
def test_a_slip_in_the_settings_is_named_with_what_is_allowed(text: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidInput) as raised:
        read_project_settings(project(tmp_path, text) / "pyproject.toml")
    assert str(raised.value).startswith(str(tmp_path / "pyproject.toml"))
    assert said in str(raised.value)


def test_validate_takes_settings_where_no_option_is_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(project(tmp_path, SETTINGS))
    filled = with_project_settings(ValidateOptions(preset="hardened"))
    assert (filled.engine, filled.preset, filled.tolerance) == (
        ("mujoco",), "hardened", "position=0.1mm,velocity=0.001",
    )  # fmt: skip
    said = capsys.readouterr().err
    assert "engine mujoco; tolerance position=0.1mm" in said
    assert "preset" not in said


def test_check_without_a_file_judges_the_models_of_the_project(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, at_once: None
) -> None:
    shutil.copy(SAW, tmp_path / "saw.xml")
    model = (
        '[[tool.conrod.models]]\nfile = "saw.xml"\nscene = "saw-500rpm"\ncrank = "crank"\npoints = { C = "site:C" }\n'
    )
    monkeypatch.chdir(project(tmp_path, f"{model}revolutions = 1\ntolerance = {{ position = 1e-3 }}\n"))
    judged = CliRunner().invoke(cli, ["check"])
    assert (judged.exit_code, "within tolerance" in judged.output) == (0, True), judged.output
    # Negative control: a tolerance that the model's own settings do not hold.
    project(tmp_path, f"{model}revolutions = 1\ntolerance = {{ position = 1e-9 }}\n")
    assert CliRunner().invoke(cli, ["check"]).exit_code == 1
    beside = CliRunner().invoke(cli, ["check", "--seconds", "1"])
    assert isinstance(beside.exception, InvalidInput)
    project(tmp_path, "[tool.conrod]\n")
    none = CliRunner().invoke(cli, ["check"])
    assert "[[tool.conrod.models]]" in str(none.exception)
