"""Plan of a scene's limits: the searches that a request needs, how many runs they may take, and their findings."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

from conrod.engines import Engine, engine_named, engine_names
from conrod.engines.engine import judged_preset
from conrod.errors import InvalidInput
from conrod.scenes import Scene
from conrod.studies.execution.isolation import Ended, isolated
from conrod.studies.execution.worker import address_space
from conrod.studies.frame.study import Results, Study, pursue
from conrod.studies.limits.axes import AXES, LENGTH_AXIS, Axis
from conrod.studies.limits.case import LimitCase, Setup
from conrod.studies.limits.determinism import determinism_search
from conrod.studies.limits.follower_float import float_search, most_float_runs
from conrod.studies.limits.maps import PAIRS, Pair, map_search, most_map_runs
from conrod.studies.limits.results import LimitStudy, Walk
from conrod.studies.limits.walk import (
    ITERATIONS,
    MASS_RATIO,
    length_search,
    most_length_runs,
    most_need_runs,
    most_runs,
    need_search,
    walk_search,
)

REVOLUTIONS = 1000.0  # of the long runs, unless more are asked for


class Planned(NamedTuple):
    """A search.

    Attributes:
        part: field of `LimitStudy` that keeps its findings, or "lengths", which belong to two.
        made: the search, not begun.
        most: how many runs it can ask for.
    """

    part: str
    made: Callable[[], Study[Any]]
    most: int


@dataclass(frozen=True)
class Request:
    """Items to be studied; everything where nothing is named.

    Attributes:
        names: of `ITEMS`.
        span: first and last value of the only axis, where other ends than its own are asked for.
        revolutions: of the long runs.
    """

    names: tuple[str, ...] = ()
    span: tuple[float, float] | None = None
    revolutions: float = REVOLUTIONS

    @property
    def everything(self) -> bool:
        """True where nothing was named, so that all is studied that there is."""
        return not self.names


@dataclass(frozen=True)
class Item:
    """Something that `--axis` can name: an axis, a pair of axes, or something besides.

    Attributes:
        refusal: None, or why a setup does not have it.
        searches: those of a setup; raises InvalidInput where the machine cannot be given with an end of the range.
    """

    name: str
    refusal: Callable[[Setup], str | None]
    searches: Callable[[Setup, Request], Sequence[Planned]]


def _axis(axis: Axis) -> Item:
    def searches(setup: Setup, asked: Request) -> list[Planned]:
        if axis.name == LENGTH_AXIS:
            last = asked.revolutions if asked.span is None else max(asked.span)
            axis.case(setup, last)
            most = most_length_runs(axis, setup, last)
            return [Planned("lengths", partial(length_search, axis, setup, last), most)]
        planned = []
        for first, last in (asked.span,) if asked.span else axis.spans(setup):
            for end in (first, last):
                axis.case(setup, end)
            most = most_runs(axis, setup, first, last)
            planned.append(Planned("walks", partial(walk_search, axis, setup, first, last), most))
        return planned

    return Item(axis.name, axis.refusal, searches)


def _pair(pair: Pair) -> Item:
    def searches(setup: Setup, asked: Request) -> list[Planned]:
        return [Planned("maps", partial(map_search, setup, pair), most_map_runs(setup, pair))]

    return Item(pair.name, pair.refusal, searches)


def _no_rule_to_replace(setup: Setup) -> str | None:
    # An engine as it comes is off whatever its iterations leave; later presets are the first judged one, changed.
    preset = judged_preset(setup.made_by)
    if setup.preset != preset:
        return f"iterations that stay are studied with the preset {preset} alone"
    return MASS_RATIO.refusal(setup)


def _needs(setup: Setup, asked: Request) -> list[Planned]:
    most = most_need_runs(setup)
    return [Planned("needs", partial(need_search, setup, iterations), most) for iterations in ITERATIONS]


def _determinism(setup: Setup, asked: Request) -> list[Planned]:
    return [Planned("determinism", partial(determinism_search, setup), 1)]  # one case, which runs again and again


def _no_follower(setup: Setup) -> str | None:
    if setup.contact and not setup.scene.closed_form:
        return AXES["float"].refusal(setup)
    return None if setup.contact else f"the {setup.scene.kind} has no cam: there is no follower to fly"


def _flight(setup: Setup, asked: Request) -> list[Planned]:
    return [Planned("floats", partial(float_search, setup), most_float_runs())]


ITEMS = {
    item.name: item
    for item in (
        *map(_axis, AXES.values()),
        *map(_pair, PAIRS),
        Item("mass-ratio-at-iterations", _no_rule_to_replace, _needs),
        Item("determinism", lambda setup: None, _determinism),
        Item("flight", _no_follower, _flight),
    )
}


@dataclass(frozen=True)
class LimitPlan:
    """Searches of one scene.

    Attributes:
        refused: walks of axes that the scene or an engine does not have.
        unfit: of what was asked for, name -> why no engine and preset has it on this scene.
    """

    name: str
    scene: Scene = field(repr=False)
    engines: tuple[Engine[Any], ...]
    refused: tuple[Walk, ...]
    unfit: Mapping[str, str]
    searches: tuple[Planned, ...]

    @property
    def most(self) -> int:
        """Number of runs that all searches together can ask for."""
        return sum(planned.most for planned in self.searches)

    def study(self, found: Sequence[tuple[str, Any]]) -> LimitStudy:
        """Return the study, from what each search found and the part that it belongs to."""

        def of(part: str) -> tuple[Any, ...]:
            return tuple(finding for name, finding in found if name == part)

        names, lengths = list(AXES), of("lengths")
        walks = (*of("walks"), *(walk for walk, _ in lengths), *self.refused)
        return LimitStudy(
            name=self.name,
            kind=self.scene.kind,
            title=self.scene.title,
            parameters=self.scene.parameters,
            engines={engine.name: engine.version for engine in self.engines},
            walks=tuple(sorted(walks, key=lambda walk: names.index(walk.axis))),
            long_runs=tuple(run for _, run in lengths),
            maps=of("maps"),
            needs=of("needs"),
            determinism=of("determinism"),
            floats=of("floats"),
        )


def plan_limits(
    name: str, scene: Scene, engines: Sequence[Engine[Any]], preset: str | None, asked: Request
) -> LimitPlan:
    """Return the plan of a scene.

    Raises:
        InvalidInput: the machine cannot be given with an end of the range.
    """
    setups = [Setup(name, scene, e.name, p) for e in engines for p in e.presets if preset in (None, p)]
    unfit = {setup.preset: refusal for setup in setups if (refusal := setup.refusal()) is not None}
    fit = [setup for setup in setups if setup.refusal() is None]
    searches: list[Planned] = []
    refused: list[Walk] = []
    reasons: dict[str, str] = {}
    had: set[str] = set()
    for setup in fit:
        for item in (ITEMS[name] for name in asked.names or ITEMS):
            refusal = item.refusal(setup)
            if refusal is None:
                had.add(item.name)
                searches += item.searches(setup, asked)
                continue
            reasons[item.name] = refusal
            if item.name in AXES:
                refused.append(Walk(item.name, setup.name, setup.engine, setup.preset, refusal, (), ()))
    if fit:
        unfit = {} if asked.everything else {item: reason for item, reason in reasons.items() if item not in had}
    return LimitPlan(name, scene, tuple(engines), tuple(refused), unfit, tuple(searches))


def pursue_plans(plans: Sequence[LimitPlan], run: Callable[[list[LimitCase]], Results]) -> list[LimitStudy]:
    """Return the studies of all plans, their runs in common batches."""
    places = [(k, planned) for k, plan in enumerate(plans) for planned in plan.searches]
    found = pursue([planned.made() for _, planned in places], run)
    by_plan: list[list[tuple[str, Any]]] = [[] for _ in plans]
    for (k, planned), finding in zip(places, found, strict=True):
        by_plan[k].append((planned.part, finding))
    return [plan.study(findings) for plan, findings in zip(plans, by_plan, strict=True)]


# -- refusals before any run -----------------------------------------------------------------------------------------


def check_asked(plans: Sequence[LimitPlan]) -> None:
    """Refuse an axis, a pair or a preset that none of the scenes has.

    Raises:
        InvalidInput: says why not.
    """
    for name, reason in plans[0].unfit.items():
        if all(name in plan.unfit for plan in plans):
            raise InvalidInput(f"{name}: {reason}")


def check_runs(plans: Sequence[LimitPlan], most: int) -> None:
    """Refuse before it starts what may need more runs than are allowed.

    Raises:
        InvalidInput: with both figures.
    """
    needed = sum(plan.most for plan in plans)
    if needed > most:
        raise InvalidInput(
            f"this may need up to {needed} runs, and --most-runs allows {most}: name one scene or --axis, or allow more"
        )


# The memory of a run is that of one piece, however long it is. Beyond what a process starts with [bytes]; measured: 73
# to 108 MB, the most for a cam in MuJoCo.
OF_A_RUN = 128_000_000
PATIENCE = 120.0  # [s], for a process to start


def check_memory(limit: int | None) -> None:
    """Refuse a limit in which not every run could end as it would without one.

    Args:
        limit: address space of a process [bytes]; None is none.

    Raises:
        InvalidInput: with both figures.
    """
    if limit is None:
        return
    begins_with = isolated(_at_the_start, timeout=PATIENCE)
    if isinstance(begins_with, Ended):
        return  # what stops every process is reported by the first that runs a case
    if limit < begins_with + OF_A_RUN:
        raise InvalidInput(
            f"--cell-memory: {limit} bytes for a run are too few: one may need {begins_with + OF_A_RUN}, "
            f"{begins_with} of which a process starts with"
        )


def _at_the_start() -> int:
    for name in engine_names():
        engine_named(name)
    return address_space()
