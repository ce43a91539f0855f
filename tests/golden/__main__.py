"""Check that conrod finds what it found when the golden records were made. Exit status 1 where it does not."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from conrod.crash import run_guarded
from tests.golden import store
from tests.golden.compare import Comparison, compare
from tests.golden.perform import Answers, make_ledger, perform, source
from tests.golden.record import Record
from tests.golden.tasks import Task, all_tasks

DATA = Path(__file__).parent / "data"
SHOWN = 5  # names of a kind


def main(arguments: Sequence[str] | None = None) -> int:
    """Check or write the records of the groups or tasks that are named."""
    parser = argparse.ArgumentParser(prog="python -m tests.golden", description=__doc__)
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="commands at a time [2]")
    doing = parser.add_subparsers(dest="doing", required=True)
    check = doing.add_parser("check", help="compare today's records with the golden ones")
    check.add_argument("names", nargs="*", metavar="GROUP[/TASK]", help="only these [all]")
    check.add_argument("--identical", action="store_true", help="fail, too, where a value is not equal to the last bit")
    write = doing.add_parser("write", help="make today's records the golden ones; there is no way back but git")
    write.add_argument("names", nargs="+", metavar="GROUP", help="groups, or `all`")
    doing.add_parser(
        "new-ledger", help="replace the kept ledger by one of today: runs are then to be found by its keys"
    )
    chosen = parser.parse_args(arguments)
    if chosen.doing == "new-ledger":
        make_ledger(DATA)
        return 0
    tasks = all_tasks()
    if chosen.names and chosen.names != ["all"]:
        known = {task.group for task in tasks} | (
            {_place(task) for task in tasks} if chosen.doing == "check" else set()
        )
        if unknown := sorted(set(chosen.names) - known):
            parser.error(f"unknown {', '.join(unknown)}; there are {', '.join(sorted({t.group for t in tasks}))}")
        tasks = [task for task in tasks if {task.group, _place(task)} & set(chosen.names)]
    _say(f"conrod of {source()}")
    answers = perform(tasks, chosen.jobs, DATA, _say)
    if chosen.doing == "write":
        _write(answers, DATA)
        return 0
    return 0 if check_answers(answers, DATA, identical=chosen.identical) else 1


def check_answers(answers: Answers, data: Path, *, identical: bool = False) -> bool:
    """Print a line for each group, and what is wrong with it; whether nothing is.

    Args:
        identical: whether a value that is not equal to the last bit is wrong.
    """
    passed = True
    for group, tasks in _grouped(answers).items():
        made_with, golden = store.read(data, group)
        now = {f"{task}: {name}": record for task, records in tasks.items() for name, record in records.items()}
        before: dict[str, Any] = {
            f"{task}: {name}": value for task in tasks for name, value in golden.get(task, {}).items()
        }
        found = compare(before, now)
        passed &= found.passed and not (identical and found.changed)
        _print(group, found, made_with)
    print("golden: nothing is out" if passed else "golden: FAILED")
    return passed


def _print(group: str, found: Comparison, made_with: Mapping[str, str]) -> None:
    print(
        f"{group:12}{found.count:8} values: {found.identical} identical, {found.within} within 1e-13, "
        f"{len(found.out)} out; records: {len(found.missing)} missing, {len(found.added)} added"
    )
    if found.worst is not None:
        was, now, excess = found.out[found.worst]
        print(f"    worst: {found.worst}: was {was!r}, is {now!r}, {excess:.3g} times what is allowed")
    for kind, names in (("out", list(found.out)), ("missing", found.missing), ("added", found.added)):
        for name in names[:SHOWN]:
            print(f"    {kind}: {name}")
    changed = [*found.changed, *found.out]
    today = store.environment()
    differences = [f"{key} {made_with.get(key)}, here {is_}" for key, is_ in today.items() if made_with.get(key) != is_]
    if changed and differences:
        print(f"    the records were made with {'; '.join(differences)}")
    elif found.changed:
        print(f"    not identical on a machine of the same kind: {', '.join(found.changed[:SHOWN])}")


def _grouped(answers: Answers) -> dict[str, dict[str, dict[str, Record]]]:
    groups: dict[str, dict[str, dict[str, Record]]] = {}
    for task, records in answers.items():
        groups.setdefault(task.group, {})[task.name] = records
    return groups


def _write(answers: Answers, data: Path) -> None:
    for group, tasks in _grouped(answers).items():
        store.write(data, group, tasks)
        print(f"{group}: {sum(map(len, tasks.values()))} records written")


def _place(task: Task) -> str:
    return f"{task.group}/{task.name}"


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


if __name__ == "__main__":
    run_guarded(main)
