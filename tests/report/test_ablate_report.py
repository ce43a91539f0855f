"""The report on ingredients: costs with their verdicts, from a study that is made once."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from command_line import conrod
from committed_studies import SCENE

from conrod.engines.mujoco.engine import MuJoCo
from conrod.engines.variants import Ingredient
from conrod.report.folder import restored
from conrod.studies.ablate_findings import AblationStudy

PLANTED: tuple[Ingredient[Any], ...] = (
    Ingredient(
        "more-iterations",
        "fifty more",
        lambda s: replace(s, preset="custom", iterations=s.iterations + 50),
        lambda s: replace(s, preset="custom", iterations=s.iterations - 50),
    ),
)
QUICK = ("ablate", SCENE, "--engine", "mujoco", "--steps-per-rev", "100", "--rounds", "2", "--jobs", "1")


def test_a_study_is_printed_written_and_not_made_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(MuJoCo, "ingredients", lambda self, machine, minimal: PLANTED)
    first = conrod(*QUICK, "--ledger", "l.sqlite", "--out", "report", "--json", "a.json", cwd=tmp_path)
    assert first.returncode == 0, first.stderr
    assert "times as fast as the full one" in first.stdout
    study = findings(tmp_path / "a.json")
    # The one ingredient is all of the dressed model: with it and without it are the two models that there are.
    assert [(v.role.value, v.outcome) for v in study.engines[0].variants] == [
        (role, "completed") for role in ("minimal", "added", "full", "taken")
    ]
    page = (tmp_path / "report" / f"{SCENE}.md").read_text()
    assert "`conrod ablate saw-500rpm --engine mujoco --steps-per-rev 100 --rounds 2 --out report`" in page
    again = conrod(*QUICK, "--ledger", "l.sqlite", "--json", "b.json", cwd=tmp_path)
    assert re.findall(r"(\d+) done", again.stderr) == ["0", "0"]
    assert findings(tmp_path / "b.json") == study


def findings(file: Path) -> AblationStudy:
    return restored(AblationStudy, json.loads(file.read_text())["parts"][SCENE]["findings"])
