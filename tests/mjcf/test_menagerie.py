"""Models that were not written for conrod: closed loops of MuJoCo Menagerie's robots are linted and hardened.

The package `mujoco-menagerie` downloads a robot when it is asked for.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.support.command_line import conrod

ROBOTS = [("agility_cassie", "home", 0.1, 4), ("robotiq_2f85", None, 0.2, 3)]

pytestmark = pytest.mark.slow


def model_of(robot: str) -> Path:
    menagerie = pytest.importorskip("mujoco_menagerie")
    try:
        return Path(menagerie.get(robot).xml())
    except (menagerie.MenagerieError, OSError) as error:
        pytest.skip(f"the models of mujoco-menagerie cannot be downloaded here: {error}")


@pytest.mark.parametrize(("robot", "keyframe", "seconds", "closures"), ROBOTS)
def test_hardening_closes_the_loops_of_a_robot(
    robot: str, keyframe: str | None, seconds: float, closures: int, tmp_path: Path
) -> None:
    given = [] if keyframe is None else ["--keyframe", keyframe]
    found = tmp_path / "found.json"
    done = conrod("harden", str(model_of(robot)), *given, "--seconds", str(seconds), "--json", str(found), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    before, _, after = json.loads(found.read_text())["variants"]
    assert after["opening_over_size"] < 1e-3 * before["opening_over_size"]
    assert len(before["openings"]) == closures


@pytest.mark.parametrize(("robot", "keyframe", "seconds", "closures"), ROBOTS)
def test_a_robot_is_linted_and_its_safe_fixes_made(
    robot: str, keyframe: str | None, seconds: float, closures: int, tmp_path: Path
) -> None:
    model, found = model_of(robot), tmp_path / "found.json"
    before = model.read_bytes()
    done = conrod("lint", str(model), "--seconds", str(seconds), "--json", str(found), cwd=tmp_path)
    assert done.returncode == 1, done.stderr
    rules = {finding["rule"] for finding in json.loads(found.read_text())["findings"]}
    assert "silent-reset" in rules  # MuJoCo's default, which neither switches off
    assert model.read_bytes() == before
