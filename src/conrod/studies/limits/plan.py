"""Walks along an axis with bisected boundaries, and the plan of all searches on a scene."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from typing import Any

from conrod.engines import Engine
from conrod.errors import InvalidInput
from conrod.exact.motion import QUANTITIES
from conrod.execution.case import Results, Study, pursue
from conrod.execution.reference_guard import ReferenceGuard
from conrod.scenes import Scene
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.axis import Axis, spaced_values
from conrod.studies.limits.case import LimitCase, Setup
from conrod.studies.limits.determinism import determinism_search
from conrod.studies.limits.follower_float import onset_search
from conrod.studies.limits.maps import MAPPED_AXES, map_search
from conrod.studies.limits.records import LEVELS, Level, LimitResult, is_undetected, level_of
from conrod.studies.limits.results import STUDY_PARTS, Boundary, LimitStudy, Probe, Walk

# First values of a walk, 3 in each of 4 decades; a failure that lies between two of them is missed.
SCAN_COUNT = 13
# Worst level that satisfies a criterion; a boundary is searched for each.
CRITERIA = (Level.SAFE, Level.ROUGH, Level.WRONG, Level.BROKEN)


def walk_search(axis: Axis, setup: Setup, first: float, last: float) -> Study[Walk]:
    """Run values of an axis from a safe to a failing one, and bisect the boundaries.

    Raises:
        InvalidInput: the machine cannot have a value of the range.
    """
    probes: dict[float, Probe] = {}
    boundaries: tuple[Boundary, ...] = ()
    if axis.listed:
        asked = list(axis.values(setup))
    else:
        asked = list(dict.fromkeys(axis.nearest(value) for value in spaced_values(axis.scale, first, last, SCAN_COUNT)))
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
        middles = [axis.midpoint(good, bad) for good, bad in ends if good is not None and bad is not None]
        asked = [middle for middle in dict.fromkeys(middles) if middle is not None]
    return Walk(axis.name, *setup.names, "", tuple(probes.values()), boundaries)


def probe_of(axis: Axis, setup: Setup, value: float, result: LimitResult) -> Probe:
    """Return the findings of a run at a value of an axis."""
    errors = {q: result.largest(q) for q in QUANTITIES}
    return Probe(
        value=value,
        text=axis.value_text(setup, value),
        level=level_of(result).slug,
        outcome=result.outcome,
        undetected=is_undetected(result),
        reason=result.reason,
        errors=None if result.errors is None else {q: e for q, e in errors.items() if e is not None},
        torque=result.torque,
    )


def boundary_of(probes: Sequence[Probe], criterion: Level) -> Boundary:
    """Return the boundary of a criterion from probes, the safe end first."""
    held = [LEVELS.index(probe.level) <= LEVELS.index(criterion.slug) for probe in probes]
    if all(held):
        return Boundary(criterion.slug, probes[-1].value, None, None, False, ())
    k = held.index(False)
    again = tuple(probe.value for probe, good in zip(probes[k:], held[k:], strict=True) if good)
    last_good, bad = probes[k - 1].value if k else None, probes[k]
    return Boundary(criterion.slug, last_good, bad.value, bad.outcome, bad.undetected, again)


# -- the plan ----------------------------------------------------------------------------------------------------------

Search = Callable[[], Study[Any]]  # begins a study whose findings are one part of a `LimitStudy`
Span = tuple[float, float] | None  # first and last value asked for; None for the usual ends of the axis


def _walk_searches(axis: Axis, setup: Setup, asked: Span) -> list[Search]:
    """Return the walks along an axis on a setup.

    Raises InvalidInput if the machine cannot have an end of the range.
    """
    spans = (asked,) if asked else axis.spans(setup)
    for end in (end for span in spans for end in span):
        axis.case(setup, end)
    return [partial(walk_search, axis, setup, *span) for span in spans]


def _map_searches(other: str, setup: Setup, _: Span) -> list[Search]:
    """Return the search for the map of steps and another axis."""
    return [partial(map_search, setup, other)]


# By the names that `--axis` takes: a function that says why a setup lacks it, or None, and a function that returns its
# searches on a setup, and raises InvalidInput if the machine cannot have an end of the range.
SEARCHES: dict[str, tuple[Callable[[Setup], str | None], Callable[[Setup, Span], list[Search]]]] = {
    **{name: (axis.refusal, partial(_walk_searches, axis)) for name, axis in AXES.items()},
    **{f"steps-x-{other}": (AXES[other].refusal, partial(_map_searches, other)) for other in MAPPED_AXES},
    "determinism": (lambda setup: None, lambda setup, _: [partial(determinism_search, setup)]),
    "flight": (AXES["float"].refusal, lambda setup, _: [partial(onset_search, setup)]),
}


@dataclass(frozen=True)
class LimitPlan:
    """Plan of all searches on one scene.

    Attributes:
        empty: study without findings; its only walks are those refused by the scene or an engine.
        unfit: reasons why no engine and preset has an axis or pair that was asked for, by name.
        searches: functions that begin the searches.
    """

    empty: LimitStudy
    unfit: Mapping[str, str]
    searches: tuple[Search, ...]

    def study(self, found: Iterable[Any], distrust: str = "") -> LimitStudy:
        """Collect the findings of all searches, with the reasons to distrust them, in a study."""
        every = [*found, *self.empty.walks]
        every.sort(key=lambda part: list(AXES).index(part.axis) if isinstance(part, Walk) else 0)
        parts: dict[str, Any] = {
            name: tuple(part for part in every if isinstance(part, kind)) for name, kind in STUDY_PARTS.items()
        }
        return replace(self.empty, **parts, distrust=distrust)


def plan_limits(
    name: str, scene: Scene, engines: Sequence[Engine[Any]], preset: str | None, asked: Sequence[str], span: Span
) -> LimitPlan:
    """Return the plan of all searches on a scene.

    Args:
        name, scene: the scene.
        engines: engines to drive to their limits.
        preset: name of the only preset; None for all.
        asked: names of `SEARCHES`; empty for all.
        span: other ends of the one axis.

    Raises:
        InvalidInput: the machine cannot have an end of the range.
    """
    setups = [Setup(name, scene, e.name, p) for e in engines for p in e.presets if preset in (None, p)]
    unfit = {setup.preset: refusal for setup in setups if (refusal := setup.refusal()) is not None}
    searches: list[Search] = []
    refused: list[Walk] = []
    refusals: dict[str, list[str | None]] = {}
    for setup in (setup for setup in setups if setup.refusal() is None):
        for item in asked or SEARCHES:
            lacks, searches_of = SEARCHES[item]
            refusal = lacks(setup)
            refusals.setdefault(item, []).append(refusal)
            if refusal is None:
                searches += searches_of(setup, span)
            elif item in AXES:
                refused.append(Walk(item, *setup.names, refusal, (), ()))
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


def check_applicable(plans: Sequence[LimitPlan]) -> None:
    """Raise an error if an axis, a pair or a preset applies to none of the scenes.

    Raises:
        InvalidInput: names it, and says why.
    """
    for name, reason in plans[0].unfit.items():
        if all(name in plan.unfit for plan in plans):
            raise InvalidInput(f"{name}: {reason}")
