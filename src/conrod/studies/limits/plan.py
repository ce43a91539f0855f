"""Plan of a scene's limits: the searches that a request needs, and their findings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import islice
from typing import Any

from conrod.engines import Engine
from conrod.errors import InvalidInput
from conrod.scenes import Scene
from conrod.studies.frame.case import Results, Study, pursue
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.axis import Axis
from conrod.studies.limits.case import LimitCase, Setup
from conrod.studies.limits.determinism import determinism_search
from conrod.studies.limits.follower_float import float_search
from conrod.studies.limits.maps import PAIRS, Pair, map_search
from conrod.studies.limits.results import PARTS, LimitStudy, Walk
from conrod.studies.limits.walk import walk_search

Search = Callable[[], Study[Any]]  # not begun; its findings are one part of a study


@dataclass(frozen=True)
class Request:
    """Items to be studied.

    Attributes:
        names: of `ITEMS`; everything where it is empty.
        span: first and last value of the only axis, where other ends than its own are asked for.
    """

    names: tuple[str, ...] = ()
    span: tuple[float, float] | None = None


@dataclass(frozen=True)
class Item:
    """Something that `--axis` can name: an axis, a pair of axes, or something besides.

    Attributes:
        refusal: None, or why a setup does not have it.
        searches: those of a setup; raises InvalidInput where the machine cannot be given with an end of the range.
    """

    name: str
    refusal: Callable[[Setup], str | None]
    searches: Callable[[Setup, Request], Sequence[Search]]


def _axis(axis: Axis) -> Item:
    def searches(setup: Setup, asked: Request) -> list[Search]:
        spans = (asked.span,) if asked.span else axis.spans(setup)
        for end in (end for span in spans for end in span):
            axis.case(setup, end)
        return [partial(walk_search, axis, setup, *span) for span in spans]

    return Item(axis.name, axis.refusal, searches)


def _pair(pair: Pair) -> Item:
    return Item(pair.name, pair.refusal, lambda setup, _: [partial(map_search, setup, pair)])


ITEMS = {
    item.name: item
    for item in (
        *map(_axis, AXES.values()),
        *map(_pair, PAIRS),
        Item("determinism", lambda setup: None, lambda setup, _: [partial(determinism_search, setup)]),
        Item("flight", AXES["float"].refusal, lambda setup, _: [partial(float_search, setup)]),
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
    searches: tuple[Search, ...]

    def study(self, found: Iterable[Any]) -> LimitStudy:
        """Return the study, from the findings of the searches."""
        every = [*found, *self.refused]
        parts = {name: [part for part in every if isinstance(part, kind)] for name, kind in PARTS.items()}
        parts["walks"].sort(key=lambda walk: list(AXES).index(walk.axis))
        return LimitStudy(
            name=self.name,
            kind=self.scene.kind,
            title=self.scene.title,
            parameters=self.scene.parameters,
            engines={engine.name: engine.version for engine in self.engines},
            **{name: tuple(of) for name, of in parts.items()},
            lengths=dict(self.scene.lengths),
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
    searches: list[Search] = []
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
        unfit = {} if not asked.names else {item: reason for item, reason in reasons.items() if item not in had}
    return LimitPlan(name, scene, tuple(engines), tuple(refused), unfit, tuple(searches))


def pursue_plans(plans: Sequence[LimitPlan], run: Callable[[list[LimitCase]], Results]) -> list[LimitStudy]:
    """Return the studies of all plans, their runs in common batches."""
    found = iter(pursue([search() for plan in plans for search in plan.searches], run))
    return [plan.study(list(islice(found, len(plan.searches)))) for plan in plans]


def check_asked(plans: Sequence[LimitPlan]) -> None:
    """Refuse an axis, a pair or a preset that none of the scenes has.

    Raises:
        InvalidInput: says why not.
    """
    for name, reason in plans[0].unfit.items():
        if all(name in plan.unfit for plan in plans):
            raise InvalidInput(f"{name}: {reason}")
