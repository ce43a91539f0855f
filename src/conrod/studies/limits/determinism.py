"""Runs that are made again, compared to the last bit: in one process, and in another one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from conrod.engines import engine_named
from conrod.runs.plain_values import plain_values
from conrod.scenes import Saw, Scene, ShearPress
from conrod.studies.execution.local import FailedCall, call_isolated
from conrod.studies.frame.case import Measurement, Study
from conrod.studies.limits.case import LimitCase, Setup
from conrod.studies.limits.records import Extremes
from conrod.studies.limits.stream_run import stream_run

# Runs that a case of this kind is made of, in their order.
RUNS = ("first", "again", "after another machine", "in another process")
BETWEEN_STEPS = 200  # a revolution of the machine that runs in between

Task = Callable[[LimitCase], Measurement]


@dataclass(frozen=True)
class RepeatedCase(LimitCase):
    """A run that is made four times, see `RUNS`; its measurement is the first one's, with the others' fingerprints."""

    def perform(self) -> Measurement:
        return repeated(self)

    def _identity(self, parameters: dict[str, float] | None) -> dict[str, Any]:
        return super()._identity(parameters) | {"repeated": RUNS}


@dataclass(frozen=True)
class Determinism:
    """Comparison of the repeated runs of an engine with a preset on a scene.

    Attributes:
        outcome, reason: of the run itself, or, where the other process had none, how that one ended.
        fingerprints: of all states and observed points, by the names of `RUNS`; empty where there is no run.
    """

    scene: str
    engine: str
    preset: str
    outcome: str
    reason: str
    fingerprints: Mapping[str, str]

    @property
    def identical(self) -> dict[str, bool]:
        """True for each of the other runs that was the first one bit for bit; empty where there is no run."""
        others = RUNS[1:] if self.fingerprints else ()
        return {run: self.fingerprints[run] == self.fingerprints[RUNS[0]] for run in others}


def determinism_search(setup: Setup) -> Study[Determinism]:
    """Make the runs of a setup, at its usual steps, again and again."""
    case = RepeatedCase(setup.name, setup.scene, setup.settings())
    results = yield (case,)
    measurement = results[case.key]
    recorded = Extremes.of(measurement)
    prints = (recorded.fingerprint, *recorded.again) if recorded.again else ()
    named = dict(zip(RUNS, prints, strict=False))
    return Determinism(*setup.who, measurement.outcome, measurement.reason, named)


def repeated(case: RepeatedCase, task: Task = stream_run) -> Measurement:
    """Return the measurement of a run that is made again and again.

    Args:
        task: what makes one run; a function that can be pickled.
    """
    once = LimitCase(case.name, case.scene, case.settings)
    first, again = task(once), task(once)
    task(_another(once))
    after = task(once)
    elsewhere = call_isolated(task, once)
    if isinstance(elsewhere, FailedCall):
        return Measurement(elsewhere.outcome.slug, f"in another process: {elsewhere.reason}")
    if first.extremes is None:
        return first
    others = tuple(Extremes.of(run).fingerprint for run in (again, after, elsewhere))
    return replace(first, extremes=plain_values(replace(Extremes.of(first), again=others)))


def _another(case: LimitCase) -> LimitCase:
    """A run of another machine in the same engine: what it leaves behind there is not that machine's own."""
    scene: Scene = Saw() if not isinstance(case.scene, Saw) else ShearPress()
    # Whatever preset the engine names first: every machine can be run with it.
    preset = next(iter(engine_named(case.settings.engine).presets.values()))
    return LimitCase("another", scene, preset(scene, BETWEEN_STEPS), revolutions=1.0)
