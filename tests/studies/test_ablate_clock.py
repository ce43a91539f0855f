"""Paired timing: claims that hold whatever the speed of the machine, by a clock of the tests' own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import pytest
from ablations import MINIMAL, MINIMAL_ERROR, variant
from catalogue import SAW

from conrod import MuJoCoSettings
from conrod.scenes.catalogue import catalogue_scene
from conrod.studies.ablate.findings import Role, Verdict, costs_time, evidence_of, levels, verdict
from conrod.studies.frame.paired_timing import LONG_BLOCK, PairedTiming, time_pair

STEP = 10_000  # [ns] that a step of the minimal model takes
MINIMAL_SETTINGS = MuJoCoSettings.stock(SAW, 1000)
WITH_IT = MuJoCoSettings.tuned(SAW, 1000)


@dataclass
class FakeEngine:
    """An engine whose steps cost what a function of the settings and the time says, on a clock of its own."""

    cost: Callable[[Any, float], float]  # (settings, seconds since the start) -> [ns] a step
    now: float = 0.0
    blocks: list[tuple[str, int]] = field(default_factory=list)

    def clock(self) -> int:
        return round(self.now)

    def reference_loop(self) -> Callable[[int], None]:
        raise AssertionError("a pair is timed against each other")

    def stepper(self, machine: object, settings: Any) -> Callable[[int], None]:
        def advance(steps: int) -> None:
            self.blocks.append((settings.preset, steps))
            self.now += steps * self.cost(settings, 1e-9 * self.now)

        return advance


def timed(engine: Any, settings: Any = WITH_IT, other: Any = MINIMAL_SETTINGS, rounds: int = 100) -> PairedTiming:
    return time_pair(engine, SAW, settings, other, rounds=rounds, clock=engine.clock)


def dearer(share: float) -> Callable[[Any, float], float]:
    return lambda settings, now: STEP * (1.0 + share * (settings.preset == "tuned"))


def test_a_pass_is_made_anew_in_every_block_and_never_driven_beyond_its_end() -> None:
    machine, made = catalogue_scene("swinging-four-bar"), list[list[int]]()

    class Counting(FakeEngine):
        def stepper(self, machine: object, settings: Any) -> Callable[[int], None]:
            advance, taken = super().stepper(machine, settings), list[int]()
            made.append(taken)
            self.now += 50 * STEP  # to make a machine takes time, which is in no block

            def advanced(steps: int) -> None:
                taken.append(steps)
                advance(steps)

            return advanced

    engine: Any = Counting(dearer(0.5))
    twice = replace(WITH_IT, steps_per_revolution=2000)
    found = time_pair(engine, machine, twice, MINIMAL_SETTINGS, rounds=10, clock=engine.clock)
    assert found.ratio == pytest.approx(3.0, rel=0.01)  # of a revolution, with twice as many steps
    assert found.other_seconds == pytest.approx(1000 * 1e-9 * STEP, rel=1e-4)
    assert {sum(taken) for taken in made} == {194, 388}
    # Negative control: what turns goes on and on, in the same two machines.
    made.clear()
    time_pair(engine, SAW, WITH_IT, MINIMAL_SETTINGS, rounds=10, clock=engine.clock)
    assert len(made) == 2
    assert min(sum(taken) for taken in made) > 1000


def test_the_ratio_is_that_of_the_costs() -> None:
    found = timed(FakeEngine(dearer(0.5)))
    assert found.ratio == pytest.approx(1.5, rel=1e-4)
    assert found.low == pytest.approx(1.5, rel=1e-4)
    assert found.seconds == pytest.approx(1.5 * found.other_seconds, rel=1e-4)
    assert found.other_seconds == pytest.approx(1000 * 1e-9 * STEP, rel=1e-4)
    assert found.inverse.ratio == pytest.approx(1.0 / 1.5, rel=1e-4)
    assert found.rounds == 100


def test_a_machine_that_slows_down_meanwhile_does_not_change_the_ratio() -> None:
    def slower_and_slower(settings: Any, now: float) -> float:
        return dearer(0.2)(settings, now) * (1.0 + 2.0 * now)

    engine = FakeEngine(slower_and_slower)
    found = timed(engine)
    assert engine.now > 0.3e9  # by two thirds at its end
    assert found.ratio == pytest.approx(1.2, rel=0.01)
    # Negative control: one after the other the same machine would give a ratio far off.
    alone = FakeEngine(slower_and_slower)
    one, two = alone.stepper(SAW, WITH_IT), alone.stepper(SAW, MINIMAL_SETTINGS)
    spent = []
    for stepper in (one, two):
        begin = alone.now
        stepper(1)
        for _ in range(10_000):
            stepper(1)
        spent.append(alone.now - begin)
    assert spent[0] / spent[1] < 1.0


def test_what_favours_the_first_of_a_round_favours_neither() -> None:
    class FirstIsDearer(FakeEngine):
        def stepper(self, machine: object, settings: Any) -> Callable[[int], None]:
            advance = super().stepper(machine, settings)

            def advanced(steps: int) -> None:
                first_of_round = len(self.blocks) % 2 == 0
                advance(steps)
                self.now += 0.3 * STEP * steps * first_of_round

            return advanced

    found = timed(FirstIsDearer(dearer(0.0)))
    assert found.ratio == pytest.approx(1.0, abs=0.05)
    assert found.low < 1.0 < found.high


def test_one_that_is_far_faster_is_not_timed_in_blocks_that_are_nothing() -> None:
    engine = FakeEngine(dearer(99.0))
    found = timed(engine, rounds=10)
    assert found.ratio == pytest.approx(100.0, rel=1e-3)
    assert max(steps for _, steps in engine.blocks[-20:]) * 100 * STEP <= 1.01e9 * LONG_BLOCK
    assert min(steps for _, steps in engine.blocks[-20:]) * STEP >= 0.4e6


def judged(share: float) -> Verdict:
    """The verdict on an ingredient that costs a share of time and does nothing else."""
    found = timed(FakeEngine(dearer(share)))
    added = replace(variant(Role.ADDED, "sleep", MINIMAL_ERROR), cost=found)
    return verdict([evidence_of(added, MINIMAL, levels(MINIMAL))])[0]


def test_a_planted_sleep_is_costly() -> None:
    assert judged(0.25) is Verdict.COSTLY
    # Negative controls: nothing is free, and so is what no clock could tell from nothing.
    assert judged(0.0) is Verdict.FREE
    assert judged(0.02) is Verdict.FREE
    assert not costs_time(None)
