"""`conrod limits` as a user types it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from command_line import conrod

from conrod.runs.plain import restore
from conrod.studies.frame.ledger import Ledger
from conrod.studies.limits.results import LimitStudy

# Two dozen runs of a second or two in all.
QUICK = ("saw-500rpm", "--axis", "steps", "--engine", "pymunk", "--preset", "stock", "--range", "400..2")


def studied(folder: Path) -> tuple[str, LimitStudy, int]:
    """What a quick study prints, what it finds, and the number of runs that are kept."""
    done = conrod("limits", *QUICK, "--json", "limits.json", "--ledger", "ledger.sqlite", cwd=folder)
    assert done.returncode == 0, done.stderr
    document: dict[str, Any] = json.loads((folder / "limits.json").read_text())
    (part,) = document["parts"].values()
    with Ledger.open(folder / "ledger.sqlite") as ledger:
        return done.stdout, restore(LimitStudy, part["findings"]), len(list(ledger.rows()))


def test_boundaries_are_told_and_the_same_command_runs_nothing_again_and_finds_the_same(tmp_path: Path) -> None:
    printed, study, runs = studied(tmp_path)
    (walk,) = study.walks
    boundary = {b.criterion: b for b in walk.boundaries}["wrong"]
    # Saw at 500 rpm, stock pymunk: a joint gapes by a twentieth of the travel between 30 and 100 steps.
    assert boundary.last_good is not None
    assert boundary.first_bad is not None
    assert 20 < boundary.first_bad < boundary.last_good < 100
    assert boundary.last_good <= 1.02 * boundary.first_bad + 1.0
    assert (boundary.outcome, boundary.undetected) == ("opened", True)
    for words in ("opened (undetected)", "within 1 %", "within 10 %"):
        assert words in printed
    assert studied(tmp_path)[1:] == (study, runs)
