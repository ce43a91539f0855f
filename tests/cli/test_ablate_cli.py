"""`conrod ablate` as a user types it, mistakes among them."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from conrod.cli import main
from conrod.engines.ingredients import Ingredient
from conrod.engines.pymunk.engine import Pymunk
from conrod.report.saved import restore
from conrod.studies.ablate.findings import AblationStudy

PLANTED: tuple[Ingredient[Any], ...] = (
    Ingredient(
        "more-iterations",
        "more iterations",
        "fifty more",
        lambda s: replace(s, preset="custom", iterations=s.iterations + 50),
        lambda s: replace(s, preset="custom", iterations=s.iterations - 50),
    ),
)
QUICK = ("saw-500rpm", "--engine", "pymunk", "--steps-per-rev", "100", "--rounds", "2", "--jobs", "1")


def typed(*arguments: str, monkeypatch: pytest.MonkeyPatch) -> int:
    monkeypatch.setattr(sys, "argv", ["conrod", "ablate", *arguments, "--ledger", "l.sqlite"])
    try:
        main()
    except SystemExit as ended:
        return int(ended.code or 0)
    return 0


def test_a_study_is_printed_written_and_not_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(Pymunk, "ingredients", lambda self, machine, minimal: PLANTED)
    assert typed(*QUICK, "--out", "report", "--json", "a.json", monkeypatch=monkeypatch) == 0
    first = capsys.readouterr()
    assert "more-iterations" in first.out
    assert "times as fast as the full one" in first.out
    study = findings(tmp_path / "a.json")
    # The one ingredient is all of the dressed model: with it and without it are the two models that there are.
    assert [(v.role.value, v.outcome) for v in study.engines[0].variants] == [
        (role, "completed") for role in ("minimal", "added", "full", "taken")
    ]
    assert all(v.cost is not None and v.cost.rounds == 2 for v in study.engines[0].variants)
    page = (tmp_path / "report" / "saw-500rpm.md").read_text()
    assert "`conrod ablate saw-500rpm --engine pymunk --steps-per-rev 100 --rounds 2 --out report`" in page
    assert typed(*QUICK, "--json", "b.json", monkeypatch=monkeypatch) == 0
    assert "to do, 0 in the ledger" not in capsys.readouterr().err
    assert findings(tmp_path / "b.json") == study


def findings(file: Path) -> AblationStudy:
    return restore(AblationStudy, json.loads(file.read_text())["parts"]["saw-500rpm"]["findings"])


MISTAKES = {
    "no scene": ((), ("Missing argument",)),
    "unknown scene": (("saw",), ("unknown scene 'saw'",)),
    "unknown engine": (("saw-500rpm", "--engine", "bullet"), ("unknown engine 'bullet'",)),
    "no steps": (("saw-500rpm", "--steps-per-rev", "1"), ("--steps-per-rev = 1 is out of range",)),
    "too many steps": (("saw-500rpm", "--steps-per-rev", "1000000"), ("samples are too many",)),
    "no rounds": (("saw-500rpm", "--rounds", "1"), ("--rounds = 1 is out of range",)),
    "unknown parameter": (("saw-500rpm", "--set", "lift=1mm"), ("unknown parameter 'lift'",)),
    "jobs of a cluster": (("saw-500rpm", "--cluster", "tcp://x:1", "--jobs", "2"), ("--jobs does not go with",)),
    "file of the report": (("saw-500rpm", "--out", "r", "--json", "r/README.md"), ("has a file of that name",)),
    "folder of something else": (("saw-500rpm", "--out", "."), ("README.md that is not of this report",)),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_told_in_one_line_and_nothing_is_written(
    mistake: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments, words = MISTAKES[mistake]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "README.md").write_text("mine")
    (tmp_path / "r").mkdir()
    assert typed(*arguments, monkeypatch=monkeypatch) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert len(printed.err.splitlines()) == 1, printed.err
    for word in words:
        assert word in printed.err
    assert {path.name for path in tmp_path.iterdir()} == {"README.md", "r"}
