"""The action and the hooks that build servers and pre-commit read: each command in them runs, and can fail."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from conrod.cli import VERBS
from conrod.models.lint.findings import Finding, Report, Severity, sarif

ROOT = Path(__file__).parents[2]
BIN = Path(sys.executable).parent


def run_step(text: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run a step of the action as a build server does, in a shell that stops at the first error."""
    env = {**os.environ, **variables, "PATH": f"{BIN}:{os.environ['PATH']}"}
    words = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", text]
    return subprocess.run(words, env=env, cwd=ROOT, capture_output=True, text=True, check=False, timeout=300)


def action_step(name: str) -> str:
    """The `run:` line of a step of action.yml."""
    text = (ROOT / "action.yml").read_text("utf-8")
    return re.findall(rf"- name: {name}\n.*?^ +run: (.+?)$", text, re.DOTALL | re.MULTILINE)[0]


def test_action_runs_its_command_and_hands_on_its_status() -> None:
    well = run_step(action_step("Run conrod"), COMMAND="lint mjcf/saw-500rpm.xml")
    assert (well.returncode, "saw-500rpm.xml" in well.stdout) == (0, True), well.stderr
    # Negative control: what fails fails the step, and what is in the words is not executed.
    assert run_step(action_step("Run conrod"), COMMAND="lint mjcf/none.xml").returncode == 2
    planted = run_step(action_step("Run conrod"), COMMAND="--version; echo $(id -u) > planted")
    assert planted.returncode == 2
    assert not (ROOT / "planted").exists()


def test_action_installs_itself_with_the_extras_asked_for() -> None:
    shown = action_step("Install conrod").replace("python -m pip install --quiet", "printf '%s'")
    assert run_step(shown, ACTION_PATH="/a b", EXTRAS="").stdout == "/a b"
    assert run_step(shown, ACTION_PATH="/a b", EXTRAS="exudyn,mjx").stdout == "/a b[exudyn,mjx]"


def test_hooks_call_verbs_that_exist_for_files_that_they_take() -> None:
    text = (ROOT / ".pre-commit-hooks.yaml").read_text("utf-8")
    entries = re.findall(r"entry: conrod (\w+)$", text, re.MULTILINE)
    assert entries == ["lint", "check", "validate"]
    assert set(entries) <= set(VERBS)
    patterns = re.findall(r"files: (.+)$", text, re.MULTILINE)
    taken = [[name for name in ("a.xml", "b.mjcf", "c.mechanism.toml", "d.py") if re.search(p, name)] for p in patterns]
    assert taken == [["a.xml", "b.mjcf"], ["a.xml", "b.mjcf"], ["c.mechanism.toml"]]


@pytest.mark.slow  # three commands on files
def test_hooks_run_on_files_of_this_repository(tmp_path: Path) -> None:
    own = tmp_path / "own.mechanism.toml"
    own.write_bytes((ROOT / "src/conrod/guide/init/project/mechanism.toml").read_bytes())
    for words in ("lint mjcf/saw-500rpm.xml mjcf/saw-40rpm.xml", "check mjcf/saw-500rpm.xml", f"validate {own}"):
        ended = run_step(f"conrod {words}")
        assert ended.returncode == 0, ended.stdout + ended.stderr


def test_sarif_has_a_run_for_each_model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("a.xml", "b.xml"):
        Path(name).write_text("<mujoco/>", "utf-8")
    found = Finding(rule="r", what="w", severity=Severity.ERROR, evidence={}, why="y", fix="f")
    log = json.loads(sarif([Report("a.xml", "", (found,)), Report("b.xml", "", ())]))
    assert [(len(run["results"]), run["automationDetails"]["id"]) for run in log["runs"]] == [
        (1, "conrod lint/a.xml"),
        (0, "conrod lint/b.xml"),
    ]
