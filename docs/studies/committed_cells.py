"""Cells of the committed reports: runs that today's code can make again, beside what is printed of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from conrod.engines import Engine, engine_named
from conrod.engines.capabilities import KnownReleases, MissingCapability, ModelIngredients, capability
from conrod.engines.engine import default_steps
from conrod.engines.variants import grid_named
from conrod.errors import InvalidInput
from conrod.exact.motion import QUANTITIES
from conrod.execution.resolve_arguments import choose_engines
from conrod.execution.result import Plan
from conrod.execution.run import RunCase
from conrod.report.folder import plain_findings
from conrod.scenes import SCENES, Scene, catalogue_names, scene_named
from conrod.studies.ablate.findings import JUDGED_ERRORS, AblationStudy, Role
from conrod.studies.ablate.study import AblationCases, minimal_variants
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.axis import Axis, spaced_values
from conrod.studies.limits.case import Setup
from conrod.studies.limits.plan import SCAN_COUNT, probe_of
from conrod.studies.limits.results import LimitStudy, Walk
from conrod.studies.sweep.findings import SweepStudy
from conrod.studies.sweep.study import plan_sweep
from conrod.studies.validation.api import REVOLUTIONS
from conrod.studies.validation.results import SceneStudy
from conrod.studies.validation.study import ValidationCase, validation_study
from conrod.studies.versions.api import DEFAULT_SCENES
from conrod.studies.versions.study import VersionStudy, release_cases

DRAWN_FIELDS = ("curves", "poses", "samples")  # of a validation: what figures draw, of which a page keeps a part


@dataclass(frozen=True)
class Cell:
    """A run of a report.

    Attributes:
        name: in words.
        printed: its values in the report's data.
        steps: time steps that it takes, all revolutions together.
        find: makes the run, and returns today's values.
    """

    name: str
    printed: Mapping[str, Any]
    steps: float
    find: Callable[[], Mapping[str, Any]]


@dataclass(frozen=True)
class PartCells:
    """What is printed of one machine, and what today's command would print.

    Attributes:
        cells: its runs.
        printed, today: names of the cells of both.
        versions: versions by engine that are printed.
    """

    cells: tuple[Cell, ...] = ()
    printed: frozenset[str] = frozenset()
    today: frozenset[str] = frozenset()
    versions: Mapping[str, str] = field(default_factory=dict)


def scene_of(name: str) -> Scene:
    """Return a shipped scene."""
    return SCENES.get(name) or scene_named(name)


def validation_cells(study: SceneStudy, values: Any) -> PartCells:
    """Return the runs of a validation."""
    engines = choose_engines(None)
    cases = next(
        validation_study(
            {study.name: study.scene}, engines, {e.name: tuple(e.presets) for e in engines}, Plan(None, REVOLUTIONS)
        )
    )
    today = {f"{case.engine} {case.preset}": case for case in cases if isinstance(case, ValidationCase)}
    printed = {f"{one['engine']} {one['preset']}": one for one in values["results"]}

    def find(name: str) -> Mapping[str, Any]:
        found = plain_findings(today[name].perform())
        return {key: part for key, part in found.items() if key not in DRAWN_FIELDS}

    cells = tuple(
        # Of a refinement the runs take as many steps again.
        Cell(f"{study.name} {name}", printed[name], 3.0 * REVOLUTIONS * today[name].effort, partial(find, name))
        for name in printed.keys() & today.keys()
    )
    versions = {one["engine"]: one["engine_version"] for one in values["results"]}
    return PartCells(cells, frozenset(printed), frozenset(today), versions)


def sweep_cells(study: SweepStudy, values: Any) -> PartCells:
    """Return the points of a sweep."""
    engines, scene = [engine_named(name) for name in study.engines if _is_installed(name)], scene_of(study.name)
    plan = plan_sweep(study.name, scene, engines, grid_named(study.grid))
    today = {
        f"{rule.engine.name} {rule.rule.name} {case.settings.steps_per_revolution}": case
        for rule in plan.rules
        for case in rule.cases
    }
    printed = {f"{one['engine']} {one['rule']} {one['steps_per_revolution']}": one for one in values["points"]}

    def find(name: str) -> Mapping[str, Any]:
        run = today[name].perform()
        return {
            "outcome": run.outcome,
            "errors": None if run.errors is None else {q: run.largest(q) or 0.0 for q in QUANTITIES},
        }

    cells = tuple(
        Cell(f"{study.name} {name}", printed[name], _steps_of(today[name]), partial(find, name))
        for name in printed.keys() & today.keys()
    )
    return PartCells(cells, frozenset(printed), frozenset(today), study.engines)


def limit_cells(study: LimitStudy, values: Any) -> PartCells:
    """Return the probes of the walks of `conrod limits`; what a walk adds where it bisects is in no set."""
    scene = scene_of(study.name)
    setups = [
        Setup(study.name, scene, engine.name, preset) for engine in choose_engines(None) for preset in engine.presets
    ]
    today = {
        _probe_name(axis.name, setup, value)
        for setup in setups
        if setup.refusal() is None
        for axis in AXES.values()
        if axis.refusal(setup) is None
        for value in _first_values(axis, setup)
    }
    printed, cells = set[str](), list[Cell]()
    for walk, saved in zip(study.walks, values["walks"], strict=True):
        setup = Setup(study.name, scene, walk.engine, walk.preset)
        for one in saved["probes"]:
            name = _probe_name(walk.axis, setup, one["value"])
            printed.add(name)
            cells.append(
                Cell(
                    f"{study.name} {name}",
                    one,
                    _probe_steps(walk, setup, one["value"]),
                    partial(_find_probe, walk, setup, one),
                )
            )
    return PartCells(tuple(cells), frozenset(printed & today), frozenset(today), study.engines)


def _first_values(axis: Axis, setup: Setup) -> Iterator[float]:
    """Yield the values that a walk begins with."""
    if axis.listed:
        yield from axis.values(setup)
        return
    for first, last in axis.spans(setup):
        yield from map(axis.nearest, spaced_values(axis.scale, first, last, SCAN_COUNT))


def _probe_name(axis: str, setup: Setup, value: float) -> str:
    return f"{axis} {setup.engine} {setup.preset} {value:.9g}"


def _probe_steps(walk: Walk, setup: Setup, value: float) -> float:
    """Return about how many steps the run at a value of an axis takes."""
    per_turn = value if walk.axis == "steps" else setup.steps
    return per_turn * (value if walk.axis == "run-length" else REVOLUTIONS)


def _find_probe(walk: Walk, setup: Setup, printed: Any) -> Mapping[str, Any]:
    axis, value = AXES[walk.axis], printed["value"]
    found: Mapping[str, Any] = plain_findings(probe_of(axis, setup, value, axis.case(setup, value).perform()))
    return found


def ablation_cells(study: AblationStudy, values: Any) -> PartCells:
    """Return the models of `conrod ablate`: the minimal one, and those that differ from it by one ingredient."""
    today, printed, cells = set[str](), set[str](), list[Cell]()
    scene = scene_of(study.name)
    of_engine = {one.engine: (one, saved) for one, saved in zip(study.engines, values["engines"], strict=True)}
    for engine in choose_engines(None):
        models = capability(engine, ModelIngredients)
        if isinstance(models, MissingCapability):
            continue
        minimal = models.minimal_settings(scene, default_steps(scene))
        variants = minimal_variants(minimal, [one for one in models.ingredients(scene, minimal) if not one.refusal])
        today |= {_variant_name(engine, one.role.value, one.ingredient) for one in variants}
        if engine.name not in of_engine:
            continue
        saved = {(one["role"], one["ingredient"]): one for one in of_engine[engine.name][1]["variants"]}
        printed |= {
            _variant_name(engine, *key)
            for key in saved
            if key[0] not in (Role.FULL.value, Role.REMOVED_FROM_FULL.value)
        }
        for one in variants:
            if (key := (one.role.value, one.ingredient)) in saved:
                case = AblationCases(study.name, scene, 2).run_case(one.settings)
                cells.append(
                    Cell(
                        f"{study.name} {_variant_name(engine, *key)}",
                        saved[key],
                        _steps_of(case),
                        partial(_find_variant, case),
                    )
                )
    return PartCells(
        tuple(cells), frozenset(printed), frozenset(today), {one.engine: one.version for one in study.engines}
    )


def _variant_name(engine: Engine[Any], role: str, ingredient: str) -> str:
    return f"{engine.name} {role} {ingredient}".rstrip()


def _find_variant(case: RunCase) -> Mapping[str, Any]:
    run = case.perform()
    errors = None if run.errors is None else {q: run.largest(q) or 0.0 for q in JUDGED_ERRORS}
    return {"outcome": run.outcome, "reason": run.reason, "errors": errors, "settings": case.settings.as_dict()}


def version_cells(study: VersionStudy, values: Any) -> PartCells:
    """Return the runs of `conrod versions`, which are not made again: they need each release installed."""
    engine = engine_named(study.engine)
    releases = capability(engine, KnownReleases)
    assert not isinstance(releases, MissingCapability)
    runs = {" ".join(key) for key in release_cases({name: scene_of(name) for name in DEFAULT_SCENES}, engine)}
    today = {*runs, *releases.releases.versions}
    printed = {*study.measured, *study.unsupported, *(f"{one.scene} {one.settings}" for one in study.histories)}
    return PartCells((), frozenset(printed), frozenset(today), {study.engine: study.measured[-1]})


def _steps_of(case: RunCase) -> float:
    return case.revolutions * case.settings.steps_per_revolution


def _is_installed(engine: str) -> bool:
    try:
        return bool(engine_named(engine).version)
    except InvalidInput:
        return False


# By the kind of report.
CELLS_OF: Mapping[str, Callable[[Any, Any], PartCells]] = {
    "validation": validation_cells,
    "sweep": sweep_cells,
    "limits": limit_cells,
    "ablate": ablation_cells,
    "versions": version_cells,
}
# Machines that today's command makes a report of, by the report's folder.
MACHINES: Mapping[str, Callable[[], tuple[str, ...]]] = {
    ".": lambda: tuple(SCENES),
    "catalogue": lambda: tuple(catalogue_names()),
}
