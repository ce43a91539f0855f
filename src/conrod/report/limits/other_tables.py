"""Whether engines do the same thing twice.

Long runs in numbers: the first mark beside the last one.

How many of its nodes each map took, and of what its areas are.

At how many steps per revolution each engine and preset leaves its tolerance, and at how many it breaks.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.limits.words import BOUNDARIES, EVERYWHERE, boundary_of, not_held, text_at
from conrod.report.tables import table
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.determinism import RUNS, Determinism
from conrod.studies.limits.grade import Level
from conrod.studies.limits.maps import LimitMap, standing
from conrod.studies.limits.results import LongRun, Walk

DETERMINISM_HEAD = [
    "engine",
    "preset",
    "again in one process",
    "after another machine",
    "in another process",
    "ended",
    "fingerprint",
]
SHOWN = 12  # hexadecimal digits
ANSWERS = {True: "identical", False: "**different**", None: numbers.MISSING}


def determinism_table(found: Sequence[Determinism], with_scene: bool = False) -> str:
    """A row for each engine and preset; nothing where there is none."""
    rows = [[*([one.scene] if with_scene else []), *_determinism_cells(one)] for one in found]
    return table([*(["machine"] if with_scene else []), *DETERMINISM_HEAD], rows)


def _determinism_cells(one: Determinism) -> list[str]:
    same = tuple(one.identical.get(run) for run in RUNS[1:])
    first = one.fingerprints.get("first")
    return [
        engine_title(one.engine),
        one.preset,
        *(ANSWERS[answer] for answer in same),
        one.outcome,
        numbers.MISSING if first is None else f"`{first[:SHOWN]}`",
    ]


LONG_RUN_HEAD = ["engine", "preset", "steps per revolution", "revolutions", "ended", "loop error / L, first revolution"]
LONG_RUN_HEAD += ["at the end", "phase at the end (rad)", "of a clock that sums its steps (rad)"]


def long_run_table(runs: Sequence[LongRun], with_scene: bool = False) -> str:
    """A row for each run; nothing where there is none."""
    rows = [[*([run.scene] if with_scene else []), *_cells(run)] for run in runs]
    return table([*(["machine"] if with_scene else []), *LONG_RUN_HEAD], rows)


def _cells(run: LongRun) -> list[str]:
    first, last = (run.marks[0], run.marks[-1]) if run.marks else (None, None)
    return [
        engine_title(run.engine),
        run.preset,
        str(run.steps_per_revolution),
        numbers.quantity(run.revolutions),
        run.outcome + (f" after {numbers.quantity(last.revolution)}" if run.outcome != "completed" and last else ""),
        *(numbers.measured(None if mark is None else mark.closure) for mark in (first, last)),
        numbers.measured(None if last is None else last.phase),
        numbers.measured(None if last is None else last.clock),
    ]


MAPS_HEAD = ["engine", "preset", "across", "upwards", "nodes", "runs", "share"]
STANDINGS = list(dict.fromkeys(standing(level.slug) for level in Level))


def maps_table(maps: Sequence[LimitMap]) -> str:
    """A row for each map; nothing where there is none."""
    return table([*MAPS_HEAD, *(f"{name} nodes" for name in STANDINGS)], [_row(found) for found in maps])


def _row(found: LimitMap) -> list[str]:
    counted = Counter(standing(found.at((i, j)).level) for i in range(len(found.x)) for j in range(len(found.y)))
    return [
        engine_title(found.engine),
        found.preset,
        AXES[found.x_axis].title,
        AXES[found.y_axis].title,
        str(found.nodes),
        str(len(found.runs)),
        numbers.percent(found.share),
        *(numbers.percent(counted[name] / found.nodes) for name in STANDINGS),
    ]


STEPS = AXES["steps"].name


def steps_table(walks: Sequence[Walk]) -> str:
    """A row for each scene, engine and preset whose steps were walked; nothing where there is none."""
    rows = [
        [walk.scene, engine_title(walk.engine), walk.preset, *(_held(walk, criterion) for criterion in BOUNDARIES)]
        for walk in walks
        if walk.axis == STEPS and walk.boundaries
    ]
    return table(["machine", "engine", "preset", *BOUNDARIES.values()], rows)


def _held(walk: Walk, criterion: str) -> str:
    """The last number of steps that keeps a criterion, and how the next one ended: `34 (33: opened, undetected)`."""
    boundary = boundary_of(walk, criterion)
    if boundary.first_bad is None:
        return EVERYWHERE
    bad = next(probe for probe in walk.probes if probe.value == boundary.first_bad)
    ended = bad.level if bad.outcome == "completed" else bad.outcome
    held = not_held(boundary) if boundary.last_good is None else _number(text_at(walk, boundary.last_good))
    return f"{held} ({_number(bad.text)}: {ended}{', undetected' if boundary.undetected else ''})"


def _number(text: str) -> str:
    """Without the unit, which stands in the heading."""
    return text.removesuffix(" steps")
