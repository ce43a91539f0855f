"""`conrod init`: a project that runs as it is written, and nothing of the user's overwritten."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

import conrod
from conrod.cli import cli
from conrod.errors import InvalidInput
from conrod.guide.init.api import PLACES


def test_init_writes_a_machine_that_is_within_tolerance(tmp_path: Path) -> None:
    said = CliRunner().invoke(cli, ["init", str(tmp_path / "new")])
    assert said.exit_code == 0, said.output
    assert sorted(p.relative_to(tmp_path / "new") for p in (tmp_path / "new").rglob("*.*") if p.is_file()) == sorted(
        PLACES.values()
    )
    found = conrod.check(tmp_path / "new" / "mechanism.toml", preset="tuned", revolutions=1, steps_per_rev=500)
    assert found.passed is True, found.verdict
    assert "conrod validate" in said.output


@pytest.mark.parametrize("there", PLACES.values())
def test_init_overwrites_nothing_when_a_file_is_there(there: Path, tmp_path: Path) -> None:
    mine = tmp_path / there
    mine.parent.mkdir(parents=True, exist_ok=True)
    mine.write_text("mine", "utf-8")
    said = CliRunner().invoke(cli, ["init", str(tmp_path)])
    assert isinstance(said.exception, InvalidInput)
    assert str(said.exception).startswith(f"{mine}: there already")
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == [mine]
    assert mine.read_text("utf-8") == "mine"


def test_init_refuses_a_folder_that_is_a_file(tmp_path: Path) -> None:
    (tmp_path / "x").write_text("", "utf-8")
    with pytest.raises(InvalidInput, match="it is a file"):
        conrod.begin_project(tmp_path / "x")


def test_init_quotes_a_folder_with_a_space(tmp_path: Path) -> None:
    place = tmp_path / "my machine"
    said = CliRunner().invoke(cli, ["init", str(place)])
    assert f"next: conrod validate '{place / 'mechanism.toml'}'" in said.output
    assert f"next: pip install pytest; python -m pytest '{place / 'test_mechanism.py'}'," in said.output


def test_init_that_fails_leaves_no_empty_folder(tmp_path: Path) -> None:
    (tmp_path / "new").mkdir()
    (tmp_path / "new" / ".github").write_text("", "utf-8")
    with pytest.raises(OSError, match="Not a directory"):
        conrod.begin_project(tmp_path / "new")
    assert [path.name for path in tmp_path.rglob("*")] == ["new", ".github"]


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root can make another's link")
def test_init_writes_through_no_link_of_another_user(tmp_path: Path) -> None:
    private, place = tmp_path / "private", tmp_path / "shared"
    private.mkdir()
    place.mkdir()
    link = place / ".github"
    link.symlink_to(private)
    os.lchown(link, 1002, 1002)
    with pytest.raises(InvalidInput, match=r"\.github is a link of another user \(uid 1002\)"):
        conrod.begin_project(place)
    assert [*private.iterdir()] == []
    assert [*place.iterdir()] == [link]
    # Negative control: one's own link is followed.
    os.lchown(link, os.geteuid(), os.getegid())
    conrod.begin_project(place)
    assert (private / "workflows" / "physics.yml").is_file()


@pytest.mark.slow  # two runs of pytest, in a project of its own
def test_begun_project_passes_its_tests_when_baselines_are_there(tmp_path: Path) -> None:
    conrod.begin_project(tmp_path)
    pytest_here = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path)]
    first = subprocess.run(pytest_here, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert first.returncode == 1, first.stdout
    assert "baseline" in first.stdout
    second = subprocess.run(pytest_here, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (second.returncode, "3 passed" in second.stdout) == (0, True), second.stdout
    # Negative control: another machine is not the one that the baselines are of.
    machine = tmp_path / "mechanism.toml"
    machine.write_text(machine.read_text("utf-8").replace('crank = "80 mm"', 'crank = "81 mm"'), "utf-8")
    third = subprocess.run(pytest_here, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert third.returncode == 1, third.stdout
