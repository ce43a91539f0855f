"""Models that were not written for conrod: closed loops of MuJoCo Menagerie's robots are linted and hardened.

The package `mujoco-menagerie` downloads a robot when it is asked for.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import conrod

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("robot", "start", "seconds", "closures"),
    [("agility_cassie", ("--keyframe", "home"), 0.1, 4), ("robotiq_2f85", (), 0.2, 3)],
)
def test_the_loops_of_a_robot_are_closed_and_its_model_is_linted_and_left_alone(
    robot: str, start: tuple[str, ...], seconds: float, closures: int, tmp_path: Path
) -> None:
    menagerie = pytest.importorskip("mujoco_menagerie")
    try:
        model = Path(menagerie.get(robot).xml())
    except (menagerie.MenagerieError, OSError) as error:
        pytest.skip(f"the models of mujoco-menagerie cannot be downloaded here: {error}")
    text, given = model.read_bytes(), (str(model), "--seconds", str(seconds), "--json", "found.json")
    done = conrod("harden", *given, *start, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    before, after = json.loads((tmp_path / "found.json").read_text())["variants"]
    assert max(after["openings"]) < 1e-3 * max(before["openings"])
    assert len(before["openings"]) == closures
    done = conrod("lint", *given, cwd=tmp_path)
    assert done.returncode == 1, done.stderr
    findings = json.loads((tmp_path / "found.json").read_text())["findings"]
    assert "silent-reset" in {finding["rule"] for finding in findings}  # MuJoCo's default, which neither switches off
    assert model.read_bytes() == text
