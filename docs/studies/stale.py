"""`python -m docs.studies.stale [--seconds N] [--seed S]`: what of the committed reports is out of date.

Of each report some runs are drawn at random and made again, and compared with the digits that are printed; its set of
runs with that of today's command; its fields with those that today's command writes; its engines with those installed.
So are cells of the tables that the pages of docs/ print. Costs are not compared. Exit status 1: something is out of
date.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from conrod.crash import error_text, run_guarded
from conrod.engines import engine_named
from conrod.errors import InvalidInput
from conrod.report.folder import EXACT_FIELDS, ReportFolder, plain_findings, restore_findings
from conrod.report.kept_digits import keep_earlier_digits
from conrod.report.kind import KINDS, Kind
from conrod.report.writer import reports_in
from docs.studies.committed_cells import CELLS_OF, MACHINES, Cell, PartCells
from docs.studies.printed_tables import stale_cells

REPORTS = Path(__file__).parents[2] / "reports"
SECONDS_PER_STEP = 2e-4  # of a run with its comparison, at most
REPORTS_SHARE = 0.7  # of the time for runs; the rest is for tables that the pages of docs/ print
SHOWN = 4  # names of a kind in a line


def differences(cell: Cell, kind: Kind[Any]) -> list[str]:
    """Make a run again, and return what of its values is not what is printed."""
    digits_of = {**EXACT_FIELDS, **kind.digits_of}
    found = cell.find()
    lacking = [f"{key} is lacking" for key in found if key not in cell.printed]
    before = {key: cell.printed[key] for key in found if key in cell.printed}
    now = {key: found[key] for key in before}
    # Texts are compared apart: a number in one of them may have another last digit.
    words = [
        f"{key} {before[key]!r}, today {now[key]!r}" for key in before if key == "outcome" and now[key] != before[key]
    ]
    kept = {key: keep_earlier_digits(before[key], now[key], kind.digits, digits_of, kind.places) for key in before}
    changed = [
        f"{place} {was}, today {is_}"
        for key in before
        if key not in ("outcome", "reason", "misfit", "order")
        for place, was, is_ in _unlike(key, before[key], kept[key])
    ]
    return [*lacking, *words, *changed]


def _unlike(place: str, before: Any, now: Any) -> Iterator[tuple[str, Any, Any]]:
    """Yield the places where two plain values differ, with both."""
    if isinstance(before, dict) and isinstance(now, dict):
        for key in before.keys() | now.keys():
            if not isinstance(before.get(key, now.get(key)), str) or key == "outcome":
                yield from _unlike(f"{place} {key}", before.get(key), now.get(key))
    elif isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        for k, pair in enumerate(zip(before, now, strict=True)):
            yield from _unlike(f"{place} {k}", *pair)
    elif before != now:
        yield place, before, now


def lacking_fields(saved: Any, today: Any) -> set[str]:
    """Return the names of fields that today's findings have, and the saved ones lack."""
    if isinstance(saved, dict) and isinstance(today, dict):
        inner = (lacking_fields(saved[key], part) for key, part in today.items() if key in saved)
        return {key for key in today if key not in saved}.union(*inner)
    if isinstance(saved, list) and isinstance(today, list):
        return set().union(*map(lacking_fields, saved, today))
    return set()


def set_lines(name: str, part: PartCells) -> Iterator[str]:
    """Yield what of a part's set of runs, and of its engines, is not today's."""
    for missing, words in ((part.today - part.printed, "missing"), (part.printed - part.today, "not of today's grid")):
        if missing:
            some = sorted(missing)
            more = f", and {len(some) - SHOWN} more" if len(some) > SHOWN else ""
            yield f"{name}: {len(some)} cells {words}: {', '.join(some[:SHOWN])}{more}"
    for engine, version in part.versions.items():
        try:
            installed = engine_named(engine).version
        except InvalidInput:
            yield f"{name}: {engine} {version} is not installed"
            continue
        if installed != version:
            yield f"{name}: {engine} {version} is not installed, {installed} is"


def _parts(folder: ReportFolder, place: str) -> Iterator[tuple[str, PartCells, list[str]]]:
    """Yield each part of a report with its cells, and what is out of date without a run."""
    missing = sorted(set(MACHINES[place]()) - folder.entries.keys()) if place in MACHINES else []
    if missing:
        yield "", PartCells(), [f"{len(missing)} machines missing: {', '.join(missing)}"]
    for name in folder.entries:
        try:
            values = folder.values(name)
            findings = restore_findings(folder.kind.findings, values)
            part = CELLS_OF[folder.kind.name](findings, values) if folder.kind.name in CELLS_OF else PartCells()
        except (InvalidInput, KeyError, ValueError) as error:
            yield name, PartCells(), [f"{name}: it cannot be read: {error_text(error)}"]
            continue
        fields = sorted(lacking_fields(values, plain_findings(findings)))
        lines = [f"{name}: fields lacking: {', '.join(fields)}"] if fields else []
        yield name, part, [*lines, *set_lines(name, part)]


def stale_lines(root: Path, seconds: float, draw: random.Random, most: int | None = None) -> Iterator[str]:
    """Yield what is out of date in each report below a folder, and how much was looked at.

    Args:
        seconds: CPU time for all runs.
        draw: draws the runs.
        most: most runs of each report.
    """
    folders = list[tuple[str, ReportFolder]]()
    for place in _places(root):
        try:
            folders += [(place, one) for one in reports_in(root / place)]
        except InvalidInput as error:
            yield f"{place}: {error}"
    for number, (place, folder) in enumerate(folders):
        found = list(_parts(folder, place))
        yield from (f"{place}: {line}" for _, _, lines in found for line in lines)
        cells = [cell for _, part, _ in found for cell in part.cells]
        share, begun, made = seconds / (len(folders) - number), time.process_time(), 0
        for cell in draw.sample(cells, len(cells)):
            left = share - (time.process_time() - begun)
            if left <= 0.0 or made == most:
                break
            if cell.steps * SECONDS_PER_STEP > left:
                continue
            made += 1
            try:
                yield from (f"{place}: {cell.name}: {line}" for line in differences(cell, folder.kind)[:SHOWN])
            except InvalidInput as error:
                yield f"{place}: {cell.name}: today it is refused: {error}"
        seconds -= time.process_time() - begun
        print(f"{place}: {made} of {len(cells)} runs made again", file=sys.stderr)


def _places(root: Path) -> list[str]:
    """Return the folders below a folder, and itself, that have a report that can be rendered."""
    found = []
    for folder in (root, *sorted(one for one in root.iterdir() if one.is_dir())):
        files = [json.loads(file.read_text(encoding="utf-8")) for file in sorted(folder.glob("*.json"))]
        if any(isinstance(one, Mapping) and one.get("kind") in KINDS for one in files):
            found.append(str(folder.relative_to(root)))
    return found


def main(arguments: Sequence[str] | None = None) -> None:
    """Print what is out of date."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.stale", description=main.__doc__)
    parser.add_argument("--seconds", type=float, default=60.0, metavar="N", help="CPU time for runs [60]")
    parser.add_argument("--seed", type=int, metavar="S", help="which runs are drawn [another each time]")
    parser.add_argument("--reports", type=Path, default=REPORTS, metavar="DIR", help="[reports]")
    asked = parser.parse_args(arguments)
    seed = random.randrange(10**6) if asked.seed is None else asked.seed
    print(f"seed {seed}", file=sys.stderr)
    stale, draw = False, random.Random(seed)
    lines = chain(
        stale_lines(asked.reports, REPORTS_SHARE * asked.seconds, draw),
        stale_cells((1.0 - REPORTS_SHARE) * asked.seconds, draw),
    )
    for line in lines:
        stale = True
        print(line, flush=True)
    if not stale:
        print("nothing that was looked at is out of date")
    sys.exit(int(stale))


if __name__ == "__main__":
    run_guarded(main)
