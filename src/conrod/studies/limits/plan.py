"""Plan of a scene's limits: axes walked with their boundaries found by halving, and all searches of a request."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from typing import Any

from conrod.engines import Engine
from conrod.errors import InvalidInput
from conrod.scenes import Scene
from conrod.studies.frame.case import QUANTITIES, Measurement, Results, Study, pursue
from conrod.studies.frame.reference_guard import ReferenceGuard
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.axis import Axis, spaced
from conrod.studies.limits.case import LimitCase, Setup
from conrod.studies.limits.determinism import determinism_search
from conrod.studies.limits.follower_float import float_search
from conrod.studies.limits.maps import PAIRS, map_search
from conrod.studies.limits.records import LEVELS, Extremes, Level, is_undetected, level_of
from conrod.studies.limits.results import PARTS, Boundary, LimitStudy, Probe, Walk

# Three runs in each of four decades: what fails and holds again between two of them is missed.
SCANNED = 13
# The worst level that still counts, for each boundary that is looked for.
CRITERIA = (Level.SAFE, Level.ROUGH, Level.WRONG, Level.BROKEN)


def walk_search(axis: Axis, setup: Setup, first: float, last: float) -> Study[Walk]:
    """Walk an axis between two values, the safe one first.

    Raises:
        InvalidInput: the machine cannot be given with a value of the range.
    """
    probes: dict[float, Probe] = {}
    boundaries: tuple[Boundary, ...] = ()
    if axis.listed:
        asked = list(axis.values(setup))
    else:
        asked = list(dict.fromkeys(axis.nearest(value) for value in spaced(axis.scale, first, last, SCANNED)))
    while asked:
        cases = {value: axis.case(setup, value) for value in asked}
        results = yield tuple(cases.values())
        probes |= {value: probe_of(axis, setup, value, results[case.key]) for value, case in cases.items()}
        if axis.listed:
            break
        probes = {value: probes[value] for value in sorted(probes, reverse=last < first)}
        boundaries = tuple(boundary_of(list(probes.values()), level) for level in CRITERIA)
        # Halved where a boundary is not yet narrow enough.
        ends = [(b.last_good, b.first_bad) for b in boundaries]
        middles = [axis.between(good, bad) for good, bad in ends if good is not None and bad is not None]
        asked = [middle for middle in dict.fromkeys(middles) if middle is not None]
    return Walk(axis.name, *setup.who, "", tuple(probes.values()), boundaries)


def probe_of(axis: Axis, setup: Setup, value: float, measurement: Measurement) -> Probe:
    """Return what a run on an axis showed."""
    errors = {q: measurement.largest(q) for q in QUANTITIES}
    return Probe(
        value=value,
        text=axis.readable(setup, value),
        level=level_of(measurement).slug,
        outcome=measurement.outcome,
        undetected=is_undetected(measurement),
        reason=measurement.reason,
        errors=None if measurement.errors is None else {q: e for q, e in errors.items() if e is not None},
        torque=Extremes.of(measurement).torque,
    )


def boundary_of(probes: Sequence[Probe], criterion: Level) -> Boundary:
    """Return the boundary of a criterion, among probes in the order from the safe end to the failing one."""
    held = [LEVELS.index(probe.level) <= LEVELS.index(criterion.slug) for probe in probes]
    if all(held):
        return Boundary(criterion.slug, probes[-1].value, None, None, False, ())
    k = held.index(False)
    again = tuple(probe.value for probe, good in zip(probes[k:], held[k:], strict=True) if good)
    last_good, bad = probes[k - 1].value if k else None, probes[k]
    return Boundary(criterion.slug, last_good, bad.value, bad.outcome, bad.undetected, again)


# -- the plan ----------------------------------------------------------------------------------------------------------

Search = Callable[[], Study[Any]]  # not begun; its findings are one part of a study
Span = tuple[float, float] | None  # first and last value of an axis, where other ends than its own are asked for


def _walks(axis: Axis, setup: Setup, asked: Span) -> list[Search]:
    spans = (asked,) if asked else axis.spans(setup)
    for end in (end for span in spans for end in span):
        axis.case(setup, end)
    return [partial(walk_search, axis, setup, *span) for span in spans]


def _map(other: str, setup: Setup, _: Span) -> list[Search]:
    return [partial(map_search, setup, other)]


# What `--axis` can name: why a setup does not have it, or None; and its searches in a setup, which raise InvalidInput
# where the machine cannot be given with an end of the range.
ITEMS: dict[str, tuple[Callable[[Setup], str | None], Callable[[Setup, Span], list[Search]]]] = {
    **{name: (axis.refusal, partial(_walks, axis)) for name, axis in AXES.items()},
    **{f"steps-x-{other}": (AXES[other].refusal, partial(_map, other)) for other in PAIRS},
    "determinism": (lambda setup: None, lambda setup, _: [partial(determinism_search, setup)]),
    "flight": (AXES["float"].refusal, lambda setup, _: [partial(float_search, setup)]),
}


@dataclass(frozen=True)
class LimitPlan:
    """Searches of one scene.

    Attributes:
        empty: the study without findings; its walks are those of axes that the scene or an engine does not have.
        unfit: of what was asked for, name -> why no engine and preset has it on this scene.
    """

    empty: LimitStudy
    unfit: Mapping[str, str]
    searches: tuple[Search, ...]

    def study(self, found: Iterable[Any], distrust: str = "") -> LimitStudy:
        """Return the study, from the findings of the searches and what the guard says of their runs."""
        every = [*found, *self.empty.walks]
        every.sort(key=lambda part: list(AXES).index(part.axis) if isinstance(part, Walk) else 0)
        parts: dict[str, Any] = {
            name: tuple(part for part in every if isinstance(part, kind)) for name, kind in PARTS.items()
        }
        return replace(self.empty, **parts, distrust=distrust)


def plan_limits(
    name: str, scene: Scene, engines: Sequence[Engine[Any]], preset: str | None, asked: Sequence[str], span: Span
) -> LimitPlan:
    """Return the plan of a scene.

    Args:
        asked: names of `ITEMS`; everything where there is none.

    Raises:
        InvalidInput: the machine cannot be given with an end of the range.
    """
    setups = [Setup(name, scene, e.name, p) for e in engines for p in e.presets if preset in (None, p)]
    unfit = {setup.preset: refusal for setup in setups if (refusal := setup.refusal()) is not None}
    searches: list[Search] = []
    refused: list[Walk] = []
    refusals: dict[str, list[str | None]] = {}
    for setup in (setup for setup in setups if setup.refusal() is None):
        for item in asked or ITEMS:
            lacks, searches_of = ITEMS[item]
            refusal = lacks(setup)
            refusals.setdefault(item, []).append(refusal)
            if refusal is None:
                searches += searches_of(setup, span)
            elif item in AXES:
                refused.append(Walk(item, *setup.who, refusal, (), ()))
    if refusals:
        unfit = {item: found[0] for item, found in refusals.items() if asked and found[0] and None not in found}
    versions, lengths = {engine.name: engine.version for engine in engines}, dict(scene.lengths)
    about = name, scene.kind, scene.title, scene.parameters, versions
    return LimitPlan(LimitStudy(*about, tuple(refused), (), (), (), lengths), unfit, tuple(searches))


def pursue_plans(plans: Sequence[LimitPlan], run: Callable[[list[LimitCase]], Results]) -> list[LimitStudy]:
    """Return the studies of all plans, their runs in common batches."""
    guards = [ReferenceGuard() for _ in plans]
    pairs = zip(guards, plans, strict=True)
    found = iter(pursue([guard.watch(search()) for guard, plan in pairs for search in plan.searches], run))
    return [
        plan.study(list(islice(found, len(plan.searches))), guard.distrust)
        for guard, plan in zip(guards, plans, strict=True)
    ]


def check_asked(plans: Sequence[LimitPlan]) -> None:
    """Refuse an axis, a pair or a preset that none of the scenes has.

    Raises:
        InvalidInput: says why not.
    """
    for name, reason in plans[0].unfit.items():
        if all(name in plan.unfit for plan in plans):
            raise InvalidInput(f"{name}: {reason}")
