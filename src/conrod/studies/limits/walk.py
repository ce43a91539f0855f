"""An axis walked from its safe end to its failing one, and the boundaries on the way found by halving."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.studies.frame.case import Study
from conrod.studies.frame.measurement import QUANTITIES, Measurement
from conrod.studies.limits.axis import Axis, between, spaced
from conrod.studies.limits.case import Setup
from conrod.studies.limits.records import LEVELS, Extremes, Level, is_undetected, level_of
from conrod.studies.limits.results import Boundary, Probe, Walk

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
    asked = list(axis.values(setup)) if axis.listed else _scanned(axis, first, last)
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
        middles = [_middle(axis, good, bad) for good, bad in ends if good is not None and bad is not None]
        asked = [middle for middle in dict.fromkeys(middles) if middle is not None]
    return Walk(axis.name, setup.name, setup.engine, setup.preset, "", tuple(probes.values()), boundaries)


def _scanned(axis: Axis, first: float, last: float) -> list[float]:
    return list(dict.fromkeys(axis.nearest(value) for value in spaced(axis.scale, first, last, SCANNED)))


def _middle(axis: Axis, good: float, bad: float) -> float | None:
    """Return the value that exists half-way between two; None where they are near enough, or none does."""
    found = between(axis.scale, good, bad)
    nearest = None if found is None else axis.nearest(found)
    return None if nearest in (good, bad) else nearest


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
