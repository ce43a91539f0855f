"""`python -m docs.studies.all_reports`: every committed report made anew, with today's code and engines.

In an order that shares runs, what times steps last and alone. All runs are kept in one ledger, of this code and these
versions alone: interrupted, the same command goes on where it stopped. `--list` says what is made, and what is left.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from conrod.comparison.plain_values import json_document
from conrod.crash import run_guarded
from conrod.engines import ENGINES, OPTIONAL_ENGINES, engine_named
from conrod.engines.capabilities import TimedStepping, require_capability
from conrod.errors import InvalidInput, unknown_choice
from conrod.execution.paired_timing import PairedTiming, time_stepper_pair
from conrod.execution.timing import machine_fingerprint
from conrod.execution.writing import Batch, single_file, write_together
from conrod.report.table import table
from conrod.report.template import table_text

ROOT = Path(__file__).parents[2]
STATE = ROOT / ".reports"
SOURCES = ("src", "audits", "docs/studies", "mjcf")
TIMING_PAGE = "reports/timing.md"
SPREAD = 0.01  # of a loop timed against itself, up to which the machine counts as idle
ROUNDS = 200


@dataclass(frozen=True)
class Report:
    """A report of the repository, made by `make NAME`.

    Attributes:
        timed: whether it times steps, for which the machine has to be idle.
        needs: what has to be there, in words; empty if nothing.
    """

    name: str
    timed: bool = False
    needs: str = ""


REPORTS = (
    Report("validate"),
    Report("audit"),
    Report("cams"),
    Report("limits"),
    Report("verification"),
    Report("detection"),
    Report("inputs"),
    Report("versions", needs="package indexes"),
    Report("own-models", needs="MODELS=DIR, with clones of the repositories that reports/own-models names"),
    Report("space", timed=True),
    Report("sweep", timed=True),
    Report("engines", timed=True),
    Report("ablate", timed=True),
    Report("batch", timed=True),
)


@dataclass(frozen=True)
class Progress:
    """What has been made by this code and these versions.

    Attributes:
        folder: of the ledger and of the record.
        minutes: wall time [min] of each report that was made.
        spreads: of the loop timed against itself, before and after each report that times steps.
    """

    folder: Path
    minutes: Mapping[str, float]
    spreads: Mapping[str, tuple[float, float]]

    @classmethod
    def read(cls, folder: Path) -> Progress:
        """Read the record in a folder; empty without one, or where it was cut short."""
        try:
            found: dict[str, Any] = json.loads((folder / "made.json").read_text(encoding="utf-8"))
            spreads = {name: (float(low), float(high)) for name, (low, high) in found["spreads"].items()}
            return cls(folder, {name: float(spent) for name, spent in found["minutes"].items()}, spreads)
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            return cls(folder, {}, {})

    def with_report(self, name: str, minutes: float, spreads: tuple[float, float] | None) -> Progress:
        """Record that a report was made."""
        more = {} if spreads is None else {name: spreads}
        made = Progress(self.folder, {**self.minutes, name: minutes}, {**self.spreads, **more})
        text = json_document({"minutes": made.minutes, "spreads": made.spreads})
        write_together([single_file(self.folder / "made.json", text)])
        return made


def code_digest() -> str:
    """Digest of conrod's code and of the versions of the engines: what determines a report."""
    digest = hashlib.sha256()
    for folder in SOURCES:
        for file in sorted((ROOT / folder).rglob("*")):
            if file.is_file() and "__pycache__" not in file.parts:
                digest.update(f"{file.relative_to(ROOT)}\0".encode() + file.read_bytes())
    for package in sorted(
        {*ENGINES, *(about.distribution or name for name, about in OPTIONAL_ENGINES.items()), "numpy"}
    ):
        with suppress(PackageNotFoundError):
            digest.update(f"{package} {version(package)}\0".encode())
    digest.update(sys.version.encode())
    return digest.hexdigest()[:12]


def clock_spread() -> float:
    """How far MuJoCo's reference loop, timed against itself, is from a ratio of 1, with 95 % confidence."""
    engine = require_capability(engine_named("mujoco"), TimedStepping)
    found: PairedTiming = time_stepper_pair(engine.reference_loop, engine.reference_loop, rounds=ROUNDS)
    return max(found.high - 1.0, 1.0 - found.low)


def timing_page(progress: Progress) -> str:
    """Say on which machine costs were taken, and whether it was idle."""
    busy = [name for name, spreads in progress.spreads.items() if max(spreads) > SPREAD]
    rows = [
        (name, *(f"{100.0 * one:.1f} %" for one in spreads), "busy" if name in busy else "idle")
        for name, spreads in progress.spreads.items()
    ]
    said = (
        f"Costs in {', '.join(busy)} are unreliable: the machine was busy."
        if busy
        else f"Costs are of an idle machine: a loop timed against itself was within {100.0 * SPREAD:g} %."
    )
    headings = ("report", "before", "after", "machine")
    return "\n".join([
        "# Was the machine idle?", "", f"**{said}**", "",
        f"On {machine_fingerprint()}. MuJoCo's reference loop was timed against itself just before and just after each "
        "report that times steps: by how far the median ratio may be off 1, with 95 % confidence.", "",
        table_text(table(headings, rows, headings[1:3])), "", "Written by `make reports`.", "",
    ])  # fmt: skip


def reports_left(progress: Progress, asked: Iterable[str]) -> list[Report]:
    """The reports that are asked for and not made yet, in the order in which they are made."""
    names = [one.name for one in REPORTS]
    for name in asked:
        if name not in names:
            raise unknown_choice("report", name, names)
    wanted = set(asked) or {one.name for one in REPORTS if not one.needs}
    return [one for one in REPORTS if one.name in wanted and one.name not in progress.minutes]


def progress_line(progress: Progress, left: Sequence[Report], before: Mapping[str, float]) -> str:
    """Say what is made and what is left, with the minutes that it took the last time."""
    shown = [f"{one.name} ({before[one.name]:.0f} min)" if one.name in before else one.name for one in left]
    return f"{len(progress.minutes)} made, {len(left)} left: {', '.join(shown) or 'none'}"


def last_minutes() -> dict[str, float]:
    """Minutes that each report took when it was last made, by any code."""
    found: dict[str, float] = {}
    for folder in sorted(STATE.glob("*/"), key=lambda one: one.stat().st_mtime):
        found |= Progress.read(folder).minutes
    return found


def make_report(report: Report, folder: Path, make: Sequence[str]) -> None:
    """Run `make NAME`; its runs are kept in the folder's ledger.

    Raises:
        InvalidInput: it failed; what it has finished is kept.
    """
    environment = {**os.environ, "CONROD_LEDGER": str(folder / "ledger.sqlite")}
    with subprocess.Popen([*make, report.name], cwd=ROOT, env=environment) as process:
        try:
            status = process.wait()
        except KeyboardInterrupt:
            process.send_signal(signal.SIGINT)
            process.wait()
            raise
    if status:
        raise InvalidInput(f"make {report.name} ended with status {status}; `make reports` goes on from there")


def main(arguments: Sequence[str] | None = None, make: Sequence[str] = ("make", "--no-print-directory")) -> None:
    """Make every committed report anew that this code has not made yet."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.all_reports", description=main.__doc__)
    parser.add_argument("reports", nargs="*", metavar="REPORT", help="these alone [all that need nothing from outside]")
    parser.add_argument("--list", action="store_true", help="say what is made and what is left")
    asked = parser.parse_args(arguments)
    folder = STATE / code_digest()
    progress, before = Progress.read(folder), last_minutes()
    left = reports_left(progress, asked.reports)
    print(progress_line(progress, left, before), flush=True)
    for report in REPORTS if asked.list else ():
        state = "made" if report.name in progress.minutes else f"needs {report.needs}" if report.needs else "left"
        print(f"{report.name}: {state}")
    if asked.list:
        return
    folder.mkdir(parents=True, exist_ok=True)
    while left:
        report = left[0]
        begun = time.monotonic()
        first = clock_spread() if report.timed else 0.0
        make_report(report, folder, make)
        spreads = (first, clock_spread()) if report.timed else None
        progress = progress.with_report(report.name, (time.monotonic() - begun) / 60.0, spreads)
        if spreads and max(spreads) > SPREAD:
            print(f"{report.name}: costs are unreliable: the same loop timed against itself differs", flush=True)
        left = reports_left(progress, asked.reports)
        print(progress_line(progress, left, before), flush=True)
    if progress.spreads:
        page = Batch(ROOT, {TIMING_PAGE: timing_page(progress)})
        write_together([page])


if __name__ == "__main__":
    run_guarded(main)
