"""Which runs a study of a scene's limits needs, and what they show together."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from conrod.engines import Engine
from conrod.errors import InvalidInput
from conrod.scenes import Scene
from conrod.studies.frame.study import Results, Study, pursue
from conrod.studies.limits.axes import AXES, LENGTH_AXIS
from conrod.studies.limits.axis import Axis
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell
from conrod.studies.limits.conditioning import reference_error
from conrod.studies.limits.maps import PAIRS, Pair, map_search, most_map_runs
from conrod.studies.limits.parts import PARTS, Part
from conrod.studies.limits.results import Walk
from conrod.studies.limits.run_length import length_search, most_length_runs
from conrod.studies.limits.study import LimitStudy
from conrod.studies.limits.walk import most_runs, walk_search

REVOLUTIONS = 1000.0  # of the long runs, unless more are asked for
KINDS = ("walks", "lengths", "maps", "needs", "determinism", "floats")


@dataclass(frozen=True)
class Request:
    """What is to be looked at; everything where nothing is named.

    Attributes:
        axes: walked alone.
        pairs: mapped together.
        span: first and last value of the only axis, where its own ends are not wanted.
        revolutions: of the long runs.
        parts: what is no axis and no pair, see `PARTS`.
    """

    axes: tuple[Axis, ...] = tuple(AXES.values())
    pairs: tuple[Pair, ...] = PAIRS
    span: tuple[float, float] | None = None
    revolutions: float = REVOLUTIONS
    parts: tuple[Part, ...] = tuple(PARTS.values())

    @property
    def everything(self) -> bool:
        """Whether nothing was named, so that all is looked at that there is."""
        return self == Request(span=self.span, revolutions=self.revolutions)


@dataclass(frozen=True)
class LimitPlan:
    """The searches of one scene.

    Attributes:
        refused: walks of axes that the scene or an engine does not have.
        unfit: of what was asked for, name -> why no engine and preset has it on this scene.
        most: how many runs all searches together can ask for.
    """

    name: str
    scene: Scene = field(repr=False)
    engines: tuple[Engine[Any], ...]
    refused: tuple[Walk, ...]
    unfit: Mapping[str, str]
    searches: Mapping[str, tuple[Callable[[], Study[Any]], ...]]
    most: int

    def study(self, found: Mapping[str, Sequence[Any]]) -> LimitStudy:
        """The study, from what the searches of each kind found."""
        lengths = found["lengths"]
        return LimitStudy(
            name=self.name,
            kind=self.scene.kind,
            title=self.scene.title,
            parameters=self.scene.parameters,
            engines={engine.name: engine.version for engine in self.engines},
            walks=_in_order((*found["walks"], *(walk for walk, _ in lengths), *self.refused)),
            long_runs=tuple(run for _, run in lengths),
            maps=tuple(found["maps"]),
            needs=tuple(found["needs"]),
            determinism=tuple(found["determinism"]),
            floats=tuple(found["floats"]),
        )


def plan_limits(
    name: str, scene: Scene, engines: Sequence[Engine[Any]], preset: str | None, asked: Request
) -> LimitPlan:
    """The plan of a scene.

    Raises:
        InvalidInput: the machine cannot be given with an end of the range.
    """
    made = [Case(name, scene, e.name, p) for e in engines for p in e.presets if preset in (None, p)]
    unfit = {case.preset: refusal for case in made if (refusal := case.refusal()) is not None}
    cases = [case for case in made if case.refusal() is None]
    plan = _Planner(asked)
    for case in cases:
        for axis in asked.axes:
            plan.walk(axis, case)
        for pair in asked.pairs:
            plan.map(pair, case)
        for part in asked.parts:
            plan.part(part, case)
    searches = {kind: tuple(made) for kind, made in plan.searches.items()}
    missing = unfit if not cases else plan.unfit if not asked.everything else {}
    return LimitPlan(name, scene, tuple(engines), tuple(plan.refused), missing, searches, plan.most)


class _Planner:
    def __init__(self, asked: Request) -> None:
        self._asked = asked
        self.refused: list[Walk] = []
        self.searches: dict[str, list[Callable[[], Study[Any]]]] = {kind: [] for kind in KINDS}
        self.most = 0
        self._reasons: dict[str, str] = {}
        self._fit: set[str] = set()

    @property
    def unfit(self) -> dict[str, str]:
        """Axes and pairs that no case has, and why."""
        return {name: reason for name, reason in self._reasons.items() if name not in self._fit}

    def walk(self, axis: Axis, case: Case) -> None:
        """An axis alone."""
        if self._refused(axis, case):
            refusal = self._reasons[axis.name]
            self.refused.append(Walk(axis.name, case.name, case.engine, case.preset, refusal, (), ()))
        elif axis.name == LENGTH_AXIS:
            last = self._asked.revolutions if self._asked.span is None else max(self._asked.span)
            axis.cell(case, last)
            self._add("lengths", partial(length_search, axis, case, last), most_length_runs(axis, case, last))
        else:
            for first, last in (self._asked.span,) if self._asked.span else axis.spans(case):
                _check_ends(axis, case, first, last)
                walk = partial(walk_search, axis, case, first, last, _ruler(axis))
                self._add("walks", walk, most_runs(axis, case, first, last))

    def map(self, pair: Pair, case: Case) -> None:
        """A pair of axes."""
        if not self._refused(pair, case):
            self._add("maps", partial(map_search, case, pair), most_map_runs(case, pair))

    def part(self, part: Part, case: Case) -> None:
        """What is no axis and no pair."""
        if not self._refused(part, case):
            for made in part.searches(case):
                self._add(part.kind, made, part.most(case))

    def _refused(self, asked: Axis | Pair | Part, case: Case) -> bool:
        refusal = asked.refusal(case)
        if refusal is None:
            self._fit.add(asked.name)
        else:
            self._reasons[asked.name] = refusal
        return refusal is not None

    def _add(self, kind: str, made: Callable[[], Study[Any]], runs: int) -> None:
        self.searches[kind].append(made)
        self.most += runs


def _check_ends(axis: Axis, case: Case, first: float, last: float) -> None:
    for value in (first, last):
        axis.cell(case, value)


def _ruler(axis: Axis) -> Callable[[LimitCell], float | None]:
    """The reference is in doubt only where an axis makes the machine ill-conditioned."""
    return (lambda cell: reference_error(cell.scene)) if axis.near_singular else (lambda _: None)


def _in_order(walks: Sequence[Walk]) -> tuple[Walk, ...]:
    names = list(AXES)
    return tuple(sorted(walks, key=lambda walk: names.index(walk.axis)))


def pursue_plans(plans: Sequence[LimitPlan], run: Callable[[list[LimitCell]], Results]) -> list[LimitStudy]:
    """The studies of all plans, their runs in common batches."""
    places = [(plan, kind, made) for plan in plans for kind, all_made in plan.searches.items() for made in all_made]
    found = pursue([made() for _, _, made in places], run)
    by_place: dict[tuple[str, str], list[Any]] = {}
    for (plan, kind, _), result in zip(places, found, strict=True):
        by_place.setdefault((plan.name, kind), []).append(result)
    return [plan.study({kind: by_place.get((plan.name, kind), []) for kind in plan.searches}) for plan in plans]


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
