"""`conrod validate`, with `--quantity` and with `--motion`, goes on where it stopped and runs nothing twice."""

from __future__ import annotations

import json
import os
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from command_line import conrod

TUNED = ("--preset", "tuned")
KINDS = {
    "validate": ("saw-40rpm", "--steps-per-rev", "200", "--revolutions", "1", *TUNED),
    "forces": ("saw-40rpm", "--quantity", "torque", "--steps-per-rev", "200", "--revolutions", "1", *TUNED),
    "motion": ("pendulum", "--motion", "free", "--seconds", "0.5", *TUNED),
}
OTHER = {"validate": ("--steps-per-rev", "100"), "forces": ("--steps-per-rev", "100"), "motion": ("--seconds", "0.25")}
COLUMNS = {"validate": "position_max", "forces": "torque_rms", "motion": "energy_final"}
TIGHT = {"validate": "position=1e-200", "forces": "torque=1e-200", "motion": "energy=1e-200"}


def validated(kind: str, folder: Path, *more: str, ledger: str = "ledger.sqlite") -> tuple[str, dict[str, Any], int]:
    """What a validation says of the runs it makes, the document that it writes, and its exit status."""
    file = folder / "results.json"
    done = conrod("validate", *KINDS[kind], *more, "--jobs", "1", "--json", str(file), ledger=folder / ledger)
    assert done.returncode in (0, 1), done.stderr
    return done.stderr.splitlines()[0], json.loads(file.read_text()), done.returncode


EVERY = ["validate", *(pytest.param(kind, marks=pytest.mark.slow) for kind in ("forces", "motion"))]  # by one frame


@pytest.mark.parametrize("kind", EVERY)
def test_what_the_ledger_has_is_not_run_again_unless_asked_for(kind: str, tmp_path: Path) -> None:
    said, first, status = validated(kind, tmp_path)
    count = int(said.split()[1])
    assert said == f"runs: {count} to do, 0 in the ledger"
    said, again, _ = validated(kind, tmp_path)
    assert (said, again) == (f"runs: 0 to do, {count} in the ledger", first)
    said, fresh, _ = validated(kind, tmp_path, "--fresh")
    assert (said, fresh) == (f"runs: {count} to do, 0 in the ledger", first)
    # Another tolerance is judged without a run, and its verdict is not what is kept.
    said, _, strict = validated(kind, tmp_path, "--tolerance", TIGHT[kind])
    assert (said, strict) == (f"runs: 0 to do, {count} in the ledger", 1)
    assert validated(kind, tmp_path)[1:] == (first, status)
    # Negative control: what is not the same run is run.
    said, other, _ = validated(kind, tmp_path, *OTHER[kind])
    assert not said.startswith("runs: 0 to do")
    assert other != first


@pytest.mark.slow  # a faster sibling, of cells, is in test_execution.py
@pytest.mark.parametrize("kind", KINDS)
def test_killed_in_the_middle_and_continued_the_results_are_those_of_an_undisturbed_run(
    kind: str, tmp_path: Path
) -> None:
    said, undisturbed, _ = validated(kind, tmp_path, ledger="undisturbed.sqlite")
    count, ledger = int(said.split()[1]), tmp_path / "ledger.sqlite"
    command = [sys.executable, "-m", "conrod", "validate", *KINDS[kind], "--jobs", "1"]
    with subprocess.Popen(command, env={**os.environ, "CONROD_LEDGER": str(ledger)}, stdout=subprocess.DEVNULL) as run:
        while kept_in(ledger) < 1:
            assert run.poll() is None
            time.sleep(0.005)
        run.kill()
    kept = kept_in(ledger)
    # Negative control: it was killed in the middle, not at the end.
    assert 1 <= kept < count
    said, continued, _ = validated(kind, tmp_path)
    assert said == f"runs: {count - kept} to do, {kept} in the ledger"
    assert continued == undisturbed
    # The results are rows of the table of all results.
    done = conrod("results", "--json", "rows.json", ledger=ledger, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    every = json.loads((tmp_path / "rows.json").read_text())
    rows = [row for row in every if (row["study"], row["preset"]) == (kind, "tuned")]
    assert {row["engine"]: row[COLUMNS[kind]] > 0.0 for row in rows} == {"mujoco": True, "pymunk": True}


def kept_in(ledger: Path) -> int:
    if not ledger.exists():
        return 0
    with closing(sqlite3.connect(ledger)) as connection:
        try:
            return int(connection.execute("SELECT count(*) FROM runs").fetchone()[0])
        except sqlite3.OperationalError:
            return 0  # it has no tables yet
