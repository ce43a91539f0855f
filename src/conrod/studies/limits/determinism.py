"""Repeated runs, compared to the last bit: in the same process and in another."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from conrod.engines import engine_named
from conrod.execution.case import Study
from conrod.execution.local import FailedCall, call_isolated
from conrod.scenes import Saw, Scene, ShearPress
from conrod.studies.limits.case import LimitCase, Setup
from conrod.studies.limits.records import LimitResult
from conrod.studies.limits.stream_run import stream_run

# Runs of a `RepeatedCase`, in their order.
REPEATED_RUNS = ("first", "again", "after another machine", "in another process")
OTHER_MACHINE_STEPS = 200  # per revolution, of the machine that runs in between

RunFunction = Callable[[LimitCase], LimitResult]  # makes one run; can be pickled


@dataclass(frozen=True)
class RepeatedCase(LimitCase):
    """A run made four times (`REPEATED_RUNS`), whose result has all fingerprints."""

    def perform(self) -> LimitResult:
        return run_repeatedly(self)

    def key_fields(self) -> dict[str, Any]:
        return super().key_fields() | {"repeated": REPEATED_RUNS}


@dataclass(frozen=True)
class Determinism:
    """Comparison of the repeated runs of an engine with a preset on a scene.

    Attributes:
        outcome, reason: how the run ended; how the other process ended if it failed.
        fingerprints: hashes of all states and observed points, by the names of `REPEATED_RUNS`; empty without a run.
    """

    scene: str
    engine: str
    preset: str
    outcome: str
    reason: str
    fingerprints: Mapping[str, str]

    @property
    def identical(self) -> dict[str, bool]:
        """True for each repeated run that equals the first to the last bit; empty without a run."""
        others = REPEATED_RUNS[1:] if self.fingerprints else ()
        return {run: self.fingerprints[run] == self.fingerprints[REPEATED_RUNS[0]] for run in others}


def determinism_search(setup: Setup) -> Study[Determinism]:
    """Repeat the run of a setup at its usual steps, and compare the fingerprints."""
    case = RepeatedCase(setup.name, setup.scene, setup.settings())
    results = yield (case,)
    result: LimitResult = results[case.key]
    prints = (result.fingerprint, *result.again) if result.again else ()
    named = dict(zip(REPEATED_RUNS, prints, strict=False))
    return Determinism(*setup.names, result.outcome, result.reason, named)


def run_repeatedly(case: RepeatedCase, task: RunFunction = stream_run) -> LimitResult:
    """Make a run four times, and return its result with the fingerprints of all.

    Args:
        case: the run.
        task: makes one run; a function that can be pickled.
    """
    once = LimitCase(case.name, case.scene, case.settings)
    first, again = task(once), task(once)
    task(_case_of_other_machine(once))
    after = task(once)
    elsewhere = call_isolated(task, once)
    if isinstance(elsewhere, FailedCall):
        return LimitResult(elsewhere.outcome.slug, f"in another process: {elsewhere.reason}")
    if not first.fingerprint:  # the engine refuses the run
        return first
    return replace(first, again=tuple(run.fingerprint for run in (again, after, elsewhere)))


def _case_of_other_machine(case: LimitCase) -> LimitCase:
    """Case of another machine in the same engine, to find state kept between runs."""
    scene: Scene = Saw() if not isinstance(case.scene, Saw) else ShearPress()
    # The engine's first preset can run every machine.
    preset = next(iter(engine_named(case.settings.engine).presets.values()))
    return LimitCase("another", scene, preset(scene, OTHER_MACHINE_STEPS), revolutions=1.0)
