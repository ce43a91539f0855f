"""Machines in space in several engines, compared with their closed forms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from conrod.comparison.trajectory import Outcome
from conrod.engines import Engine, engine_style
from conrod.engines.capabilities import MissingCapability, SpatialRuns, capability
from conrod.engines.engine import DOUBLE_EPSILON
from conrod.errors import InvalidInput, as_names
from conrod.execution.local import FailedCall, call_each
from conrod.execution.resolve_arguments import (
    ALL_ENGINES,
    REVOLUTIONS_RANGE,
    STEPS_RANGE,
    Engines,
    choose_engines,
    engine_names_given,
    select_presets,
)
from conrod.execution.runner import Runs
from conrod.execution.tolerances import Limit, UnscaledLimit, check_tolerance
from conrod.mechanism.units import check_count
from conrod.report.findings import Findings, text_of_call
from conrod.scenes.space import MACHINES, SPATIAL
from conrod.studies.space.plan import SpatialCell, motion_scales
from conrod.studies.space.report import SPACE_REPORT
from conrod.studies.space.results import UNITS, SpatialResult, SpatialStudy
from conrod.studies.space.study import run_cell

STEPS_PER_REV, REVOLUTIONS = 1000, 2
MAX_STEPS = 2_000_000  # of a run
MIN_TOLERANCE_EPSILONS = 8.4  # least tolerance over the spacing of an engine's numbers: 1e-6 in single precision


def validate_in_space(
    machines: str | Sequence[str] = SPATIAL,
    *,
    engines: Engines = ALL_ENGINES,
    preset: str | None = None,
    steps_per_rev: int | Sequence[int] = STEPS_PER_REV,
    revolutions: int = REVOLUTIONS,
    tolerance: Mapping[str, float | str] | None = None,
    runs: Runs | None = None,
) -> Findings[SpatialStudy]:
    """Compare engines with the exact motion of machines in space, driven by the laws that they are made for.

    Args:
        machines: names; "spatial" for all of them.
        engines: names of engines that run machines in space, or "all" for those that are installed.
        preset: preset of settings; all of each engine where none is given.
        steps_per_rev: time steps in a revolution of the slowest drive, or in its law; half of them are run as well, for
            the order. Several numbers are all run, and the largest is judged.
        revolutions: revolutions of the slowest drive.
        tolerance: largest error by quantity, as in `check_loops`: a number [m, m/s, m/s^2], or a text with a unit, or a
            share of L, of the largest speed or acceleration, as "0.1mm" or "1e-6L".
        runs: how runs are made; nothing is kept in a ledger.

    Raises:
        InvalidInput: an argument cannot be used; says what can.
    """
    names = as_names(machines)
    chosen = tuple(dict.fromkeys(MACHINES if SPATIAL in names or not names else names))
    for name in chosen:
        MACHINES[name]  # says which there are
    able = engines_in_space(engines)
    presets, path = select_presets(able, preset), steps_to_run(steps_per_rev)
    check_count("--revolutions", revolutions, *REVOLUTIONS_RANGE)
    if path[-1] * revolutions > MAX_STEPS:
        raise InvalidInput(f"{path[-1] * revolutions:,} steps are too many: a run in space may have {MAX_STEPS:,}")
    asked = None if tolerance is None else check_tolerance(tolerance, UNITS)
    scales = {name: motion_scales(MACHINES[name]()) for name in chosen}
    too_coarse = refuse_finer_than_precision(able, engines, asked or {}, [*scales.values()])
    cells = [
        SpatialCell(name, engine.name, one, path, revolutions)
        for name in chosen
        for engine in able
        for one in presets[engine.name]
    ]
    results, studies = run_cells(cells, runs or Runs(), too_coarse), dict[str, SpatialStudy]()
    for name in chosen:
        machine = MACHINES[name]()
        judged = tuple(judge_result(one, asked, scales[name]) for one in results if one.scene == name)
        studies[name] = SpatialStudy(name, machine.title, dict(machine.drives), scales[name], judged)
    call = text_of_call(
        "validate_in_space",
        *([] if chosen == tuple(MACHINES) else [list(chosen)]),
        engines=None if engine_names_given(engines) == (ALL_ENGINES,) else engine_names_given(engines),
        preset=preset,
        steps_per_rev=None if steps_per_rev == STEPS_PER_REV else steps_per_rev,
        revolutions=None if revolutions == REVOLUTIONS else revolutions,
        tolerance=tolerance,
    )
    return Findings(SPACE_REPORT, studies, call)


def engines_in_space(engines: Engines) -> list[Engine[Any]]:
    """Return the named engines, which must run machines in space; for "all" the engines that do.

    Raises:
        InvalidInput: an engine that was named does not.
    """
    found = choose_engines(engines)
    capable = [one for one in found if not isinstance(capability(one, SpatialRuns), MissingCapability)]
    named = {one for one in engine_names_given(engines) if one != ALL_ENGINES}
    if other := next((one for one in found if one.name in named and one not in capable), None):
        raise InvalidInput(
            f"--engine {other.name}: unsupported, it has no runs of machines in space; `conrod engines` says which have"
        )
    return capable


def steps_to_run(steps_per_rev: int | Sequence[int]) -> tuple[int, ...]:
    """Numbers of steps in a revolution, in increasing order: as given, or a single number and its half."""
    given = [steps_per_rev] if isinstance(steps_per_rev, int) else list(steps_per_rev)
    for steps in given:
        check_count("--steps-per-rev", steps, *STEPS_RANGE)
    if isinstance(steps_per_rev, int):
        given = [steps_per_rev // 2, steps_per_rev]
    return tuple(sorted({steps for steps in given if steps >= STEPS_RANGE[0]}))


def refuse_finer_than_precision(
    able: Sequence[Engine[Any]], given: Engines, asked: Mapping[str, Limit], scales: Sequence[Mapping[str, float]]
) -> dict[str, str]:
    """Return reasons, by engine, why its precision cannot tell whether it is within the tolerances.

    Args:
        given: engines as the user named them.

    Raises:
        InvalidInput: it is so of an engine that was named.
    """
    found = dict[str, str]()
    for engine in able:
        least = MIN_TOLERANCE_EPSILONS * engine.epsilon
        for name, limit in asked.items():
            share = min(_as_share(limit, own[name]) for own in scales)
            if engine.epsilon > DOUBLE_EPSILON and share < least:
                reason = (
                    f"--tolerance {name}={share:.3g}L: {engine.name} computes in single precision, which tells "
                    f"{engine.epsilon:.1e} of it: ask for {least:.0e}L or more"
                )
                found.setdefault(engine.name, reason)
    if named := next((found[name] for name in engine_names_given(given) if name in found), ""):
        raise InvalidInput(named)
    return found


def run_cells(cells: Sequence[SpatialCell], runs: Runs, refused: Mapping[str, str]) -> list[SpatialResult]:
    """Run all cells in other processes; a process that crashes costs its cell alone.

    Args:
        refused: reasons, by engine, why its cells are not run.
    """
    to_run = [cell for cell in cells if cell.engine not in refused]
    found = {
        cell: replace(cell.empty_result(), outcome=Outcome.UNSUPPORTED.slug, reason=refused[cell.engine])
        for cell in cells
        if cell.engine in refused
    }
    with runs.processes() as processes, runs.progress("runs", Outcome.COMPLETED.slug) as watcher:
        for note in dict.fromkeys(engine_style(cell.engine).first_run for cell in to_run):
            if note:
                watcher.on_note(note)
        watcher.on_start(len(to_run), 0)
        for cell, made in zip(to_run, call_each(processes, run_cell, to_run), strict=True):
            if isinstance(made, FailedCall):
                found[cell] = replace(cell.empty_result(), outcome=made.outcome.slug, reason=made.reason)
            else:
                found[cell] = made
            watcher.on_case_end(None, found[cell].outcome)
    return [found[cell] for cell in cells]


def judge_result(
    result: SpatialResult, asked: Mapping[str, Limit] | None, scales: Mapping[str, float]
) -> SpatialResult:
    """Judge a result by the tolerances that were asked for, in SI or as shares of the scales."""
    if asked is None:
        return result
    return result.with_verdict({name: _as_share(limit, scales[name]) for name, limit in asked.items()})


def _as_share(limit: Limit, scale: float) -> float:
    """A tolerance as a share of its quantity's scale."""
    return limit.size if isinstance(limit, UnscaledLimit) else limit / scale
