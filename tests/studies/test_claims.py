"""Processes that share a ledger share its runs: each is made once, and a killed process leaves nothing undone."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from itertools import islice
from pathlib import Path

import pytest

from conrod.studies.execution import dispatch
from conrod.studies.frame.ledger_file import Claims

COUNT, CLAIMED = 24, 4  # of them, by a process of one job whose runs take long
SHARING = """
import sys
from pathlib import Path
sys.path.insert(0, {tests!r})
import cell_tasks
from conrod.studies.execution.dispatch import run_cases
from conrod.studies.execution.local import LocalProcesses
from conrod.studies.frame import ledger_file as claims
from conrod.studies.frame.ledger import Ledger

{first}
class Told:
    def started(self, total, already_finished): ...
    def advanced(self, case, how):
        print(how, flush=True)

with Ledger.open(Path(sys.argv[1])) as ledger, LocalProcesses(1) as executor:
    cells = cell_tasks.assigned(cell_tasks.cells({count}), cell_tasks.noted)
    table = run_cases(cells, ledger, executor, watcher=Told())
    print([measured.reason for measured in table.values()])
"""
SELFISH = "claims.Claims.take = lambda self, name: True"


@contextmanager
def sharing(
    folder: Path, own: str, others: str, first: str = "", **environment: str
) -> Iterator[subprocess.Popen[str]]:
    """A process that runs all cells on the ledger of a folder, from when another one does, too."""
    tests = str(Path(__file__).parents[1] / "support")
    script = SHARING.format(tests=tests, first=first, count=COUNT)
    notes = {"CONROD_STARTS": str(folder / own), "CONROD_OTHER_STARTS": str(folder / others)}
    given, asked = {**os.environ, **notes, **environment}, [sys.executable, "-c", script, str(folder / "ledger")]
    with subprocess.Popen(asked, stdout=subprocess.PIPE, text=True, env=given) as running:
        try:
            yield running
        finally:
            running.kill()


def starts(folder: Path) -> Counter[int]:
    notes = [folder / own for own in ("a", "b") if (folder / own).exists()]
    return Counter(int(k) for note in notes for k in note.read_text(encoding="ascii").split())


@pytest.mark.parametrize("first", ["", pytest.param(SELFISH, marks=pytest.mark.slow)], ids=["claims", "none"])
def test_two_processes_run_each_cell_once_and_both_have_all(first: str, tmp_path: Path) -> None:
    with ExitStack() as both:
        pair = [both.enter_context(sharing(tmp_path, *names, first)) for names in (("a", "b"), ("b", "a"))]
        said = [running.communicate(timeout=120)[0].splitlines() for running in pair]
    assert said[0][-1] == said[1][-1] == str([str(k) for k in range(COUNT)])
    assert starts(tmp_path).keys() == set(range(COUNT))
    if first:
        assert starts(tmp_path).total() > COUNT
        return
    assert starts(tmp_path).total() == COUNT
    done = [Counter(lines[:-1]) for lines in said]
    assert [found.total() for found in done] == [COUNT, COUNT]
    # Both took part.
    assert done[0]["completed"] + done[1]["completed"] == COUNT
    assert min(found["completed"] for found in done) > 0


def test_what_a_killed_process_had_claimed_the_other_runs(tmp_path: Path) -> None:
    with sharing(tmp_path, "a", "a", CONROD_HANGS="yes") as hanging:
        while not starts(tmp_path):
            assert hanging.poll() is None
        with sharing(tmp_path, "b", "a") as other:
            assert other.stdout is not None
            assert list(islice(other.stdout, COUNT - CLAIMED)) == ["completed\n"] * (COUNT - CLAIMED)
            # The rest is claimed: it waits, and runs none of it.
            with pytest.raises(subprocess.TimeoutExpired):
                other.wait(5 * dispatch.POLL)
            assert starts(tmp_path).total() == COUNT - CLAIMED + 1
            hanging.kill()
            said = other.communicate(timeout=120)[0].splitlines()
    assert said == [*["completed"] * CLAIMED, str([str(k) for k in range(COUNT)])]
    assert starts(tmp_path).total() == COUNT + 1


HOLDER = """
import sys
from pathlib import Path
from conrod.studies.frame.ledger_file import Claims
claims = Claims(Path(sys.argv[1]))
print(claims.take(sys.argv[2]), flush=True)
sys.stdin.read()
"""


@contextmanager
def held(ledger: Path, name: str) -> Iterator[None]:
    """A name claimed by another process."""
    asked = [sys.executable, "-c", HOLDER, str(ledger), name]
    with subprocess.Popen(asked, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "True\n"
        yield
        holder.kill()


def test_a_claim_keeps_others_off_as_long_as_its_process_lives(path: Path) -> None:
    claims = Claims(path)
    with held(path, "one"):
        assert [claims.take(name) for name in ("one", "two")] == [False, True]
    assert claims.take("one")
    claims.close()
    assert [entry.name for entry in path.parent.iterdir()] == [f"{path.name}-claims"]
