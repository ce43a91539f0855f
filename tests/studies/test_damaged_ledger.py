"""A damaged row of the ledger counts as not run: it is reported, made again, and nothing ends in a traceback."""

from __future__ import annotations

import math
import random
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from click.testing import CliRunner
from damaged_ledgers import CELLS, KEYS, kept_whole, overwrite_place, overwrite_value, resumed

from conrod import InvalidInput
from conrod.cli import cli
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.measurement import Measurement


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return kept_whole(tmp_path_factory.mktemp("whole") / "ledger.sqlite")


def test_sixty_overwritten_values_are_made_again(whole: Path, tmp_path: Path) -> None:
    chance, again = random.Random(20), 0
    for k in range(60):
        path = tmp_path / f"{k}.sqlite"
        shutil.copy(whole, path)
        key, column = overwrite_value(path, chance)
        seen = resumed(path)
        assert seen.ran in ([], [key])
        assert seen.ran or column == "outcome", "the damage was not seen"
        again += len(seen.ran)
        assert resumed(path).ran == []
    assert again > 40


def test_sixty_overwritten_places_of_the_file_end_in_no_traceback(whole: Path, tmp_path: Path) -> None:
    chance, refused = random.Random(21), list[str]()
    for k in range(60):
        path = tmp_path / f"{k}.sqlite"
        shutil.copy(whole, path)
        overwrite_place(path, chance)
        try:
            resumed(path)
        except InvalidInput as error:
            refused.append(str(error))
    assert all("the ledger" in message and "\n" not in message for message in refused)
    assert len(refused) < 20  # what holds the rows together is a small part of the file


def test_numbers_that_json_has_not_come_back(tmp_path: Path) -> None:
    odd = Measurement("completed", phase={"max": math.nan, "final": math.inf}, beside={"none": None, "tiny": 5e-324})
    with Ledger.open(tmp_path / "ledger.sqlite") as ledger:
        ledger.keep(CELLS[0], odd)
        kept = ledger.measurements(KEYS).get(KEYS[0])
    assert kept is not None
    assert repr(kept) == repr(odd)


def test_results_leave_out_what_is_damaged_and_say_so(whole: Path, tmp_path: Path) -> None:
    path = tmp_path / "ledger.sqlite"
    shutil.copy(whole, path)
    with closing(sqlite3.connect(path)) as raw, raw:
        # Still JSON, of another run: what would be shown is not what was run.
        raw.execute("UPDATE cells SET identity = replace(identity, '7.', '8.') WHERE key = ?", (KEYS[0],))
        raw.execute("UPDATE runs SET measurement = x'00' WHERE key = ?", (KEYS[1],))
    done = CliRunner().invoke(cli, ["results", "--ledger", str(path)])
    assert done.exit_code == 0
    assert "2 runs in" in done.stderr
    assert len(done.stdout.splitlines()) == 1 + len(CELLS) - 2
    assert done.stderr.count("\n") == 1
    assert resumed(path).lost == 2
