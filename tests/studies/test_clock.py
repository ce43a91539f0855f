"""Timing: claims that hold whatever the speed of the machine, by a clock of the tests' own."""

from __future__ import annotations

import math
import os
import platform
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from catalogue import CAM, SAW

from conrod import MuJoCoSettings, run
from conrod.engines import ENGINES, engine_named
from conrod.engines.engine import run_extent
from conrod.engines.mujoco.model import build
from conrod.engines.numerics import frames_from_centres
from conrod.exact.motion import Array
from conrod.execution.paired_timing import PairedTiming, time_block_pair, time_settings_pair, time_stepper_pair
from conrod.execution.timing import (
    MAX_REPEAT_REVOLUTIONS,
    REFERENCE_STEPS,
    STEPS_PER_CALL,
    machine_fingerprint,
    time_run,
)
from conrod.scenes import catalogue_scene
from conrod.studies.ablate.findings import Effect, Evidence, IngredientVerdict, ingredient_verdict
from conrod.studies.space.study import step_cost

MILLISECOND = 1_000_000  # [ns]
REFERENCE_COST = 1000  # [ns] a step


class FakeEngine:
    """An engine whose steps cost what a list says [ns], on a clock that nothing else advances.

    The first cost is that of a stepper's first call, and so on; tuned settings are `dearer` by a share.
    """

    def __init__(self, *costs: int, dearer: float = 0.0) -> None:
        self.costs, self.dearer, self.now = list(costs), dearer, 0
        self.made, self.referred = list[list[int]](), list[int]()  # steps of each call
        self.given = list[tuple[Any, Any]]()  # machine and settings of each stepper

    def has_capability(self, kind: type[Any]) -> bool:
        return isinstance(self, kind)

    def clock(self) -> int:
        return self.now

    def stepper(self, machine: object, settings: Any) -> Callable[[int], None]:
        self.now += 50 * REFERENCE_COST  # to make a machine takes time, which is in no cost
        self.made.append(calls := list[int]())
        self.given.append((machine, settings))
        more = 1.0 + self.dearer * (settings.preset == "tuned")

        def advance(steps: int) -> None:
            self.now += round(steps * more * (self.costs.pop(0) if len(self.costs) > 1 else self.costs[0]))
            calls.append(steps)

        return advance

    def reference_loop(self) -> Callable[[int], None]:
        def advance(steps: int) -> None:
            self.now += steps * REFERENCE_COST
            self.referred.append(steps)

        return advance


def timed(engine: Any, steps: int) -> Any:
    return time_run(engine, SAW, MuJoCoSettings.stock(SAW, steps), clock=engine.clock)


def test_ratio_is_the_fastest_repeat_over_a_reference_step() -> None:
    # 1000 steps a turn of 5 ms or more: one turn a repeat, in one call. The first call is the warm-up.
    engine = FakeEngine(9000, 7000, 6000, 8000)
    found = timed(engine, 1000)
    assert found.seconds_per_revolution == pytest.approx(1000 * 6e-6, rel=1e-15)
    assert (found.steps, found.repeats) == (1000, 3)
    assert found.reference_seconds == pytest.approx(1e-9 * REFERENCE_COST, rel=1e-15)
    assert found.ratio == found.seconds_per_revolution / found.reference_seconds
    # Once to warm up, and once just before each repeat.
    assert engine.referred == [REFERENCE_STEPS] * 4
    assert engine.given == [(SAW, MuJoCoSettings.stock(SAW, 1000))]
    assert found.machine == machine_fingerprint()


def test_an_engine_without_a_stepper_is_not_timed() -> None:
    engine: Any = SimpleNamespace(name="mine", has_capability=lambda kind: False)
    assert time_run(engine, SAW, MuJoCoSettings.stock(SAW, 100)) is None


class BreakingStepper:
    """A stepper that breaks off after some steps, on the clock of an engine; after that its calls cost nothing."""

    def __init__(self, engine: FakeEngine, last: int) -> None:
        self.engine, self.done, self.last, self.failure = engine, 0, last, ""

    def __call__(self, steps: int) -> None:
        self.engine.now += 0 if self.failure else 5000 * steps
        self.done += steps
        self.failure = "no solution" if self.done > self.last else ""


@pytest.mark.parametrize(("last", "costs"), [(10**9, True), (3000, False)])
def test_stepper_that_breaks_off_has_no_cost(last: int, costs: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    engine = FakeEngine(1)
    monkeypatch.setattr(engine, "stepper", lambda *_: BreakingStepper(engine, last))
    assert (timed(engine, 1000) is not None) is costs
    assert math.isnan(step_cost(lambda: BreakingStepper(engine, last), 4000)) is not costs


@pytest.mark.parametrize(
    ("cpuinfo", "named", "expected"),
    [
        ("processor\t: 0\nmodel name\t: Fast: 9 \nmodel name\t: other\n", "x86", "Fast: 9"),
        ("processor\t: 0\n", "x86", "x86"),
        (None, "x86", "x86"),  # no such file
        (None, "", "aarch64"),
    ],
)
def test_a_machine_is_told_by_processor_cores_and_python(
    monkeypatch: pytest.MonkeyPatch, cpuinfo: str | None, named: str, expected: str
) -> None:
    def read(path: Path, encoding: str) -> str:
        assert (str(path), encoding) == ("/proc/cpuinfo", "utf-8")
        if cpuinfo is None:
            raise FileNotFoundError(path)
        return cpuinfo

    monkeypatch.setattr(Path, "read_text", read)
    monkeypatch.setattr(platform, "processor", lambda: named)
    monkeypatch.setattr(platform, "machine", lambda: "aarch64")
    monkeypatch.setattr(platform, "python_version", lambda: "3.11.9")
    monkeypatch.setattr(os, "cpu_count", lambda: 6)
    assert machine_fingerprint.__wrapped__() == f"{expected}, 6 cores, Python 3.11.9"


@pytest.mark.parametrize(("machine", "within"), [(catalogue_scene("swinging-four-bar"), True), (SAW, False)])
def test_a_cost_is_that_of_steps_within_a_pass(machine: Any, within: bool) -> None:
    engine: Any = FakeEngine(1000)
    settings = engine_named("pymunk").presets["tuned"](machine, 200)
    found: Any = time_run(engine, machine, settings, clock=engine.clock)
    length = round(200 * run_extent(machine, 200, 1.0)[1])
    assert (max(map(sum, engine.made)) <= length) is within
    # A step costs 1 us, so a repeat of 5 ms takes 5000 steps in whole passes or turns.
    assert found.steps == math.ceil(5000 / length) * length
    assert found.seconds_per_revolution == pytest.approx(200e-6, rel=1e-12)
    assert engine.given == [(machine, settings)] * len(engine.given)


def test_short_turns_are_timed_in_bulk_and_long_ones_in_blocks() -> None:
    engine = FakeEngine(1000)
    found = timed(engine, 20)
    assert found.steps % 20 == 0
    assert found.steps * 1000 >= 5 * MILLISECOND
    assert found.seconds_per_revolution == pytest.approx(20e-6, rel=1e-15)
    engine = FakeEngine(1000)
    assert timed(engine, 20000).steps == 20000
    assert max(engine.made[0]) == STEPS_PER_CALL
    # A clock too coarse to see a turn does not ask for endlessly many.
    assert timed(FakeEngine(1), 20).steps == 20 * MAX_REPEAT_REVOLUTIONS


# -- one over another --------------------------------------------------------------------------------------------------


def paired(engine: Any, machine: Any, steps: int = 1000) -> PairedTiming:
    tuned, stock = MuJoCoSettings.tuned(SAW, 1000), MuJoCoSettings.stock(SAW, 1000)
    twice = replace(tuned, steps_per_revolution=steps)
    return time_settings_pair(engine, machine, twice, stock, rounds=10, clock=engine.clock)


def test_pass_restarts_in_every_block_and_stays_within_its_end() -> None:
    engine = FakeEngine(10 * REFERENCE_COST, dearer=0.5)
    found = paired(engine, catalogue_scene("swinging-four-bar"), 2000)
    assert found.ratio == pytest.approx(3.0, rel=0.01)  # of a revolution, with twice as many steps
    assert {machine.kind for machine, _ in engine.given} == {"swinging-four-bar"}
    assert {settings.preset for _, settings in engine.given} == {"tuned", "stock"}
    assert found.other_seconds == pytest.approx(1000 * 1e-8 * REFERENCE_COST, rel=1e-4)
    assert set(map(sum, engine.made)) == {194, 388}
    # Negative control: what turns goes on and on, in the same two machines.
    engine = FakeEngine(10 * REFERENCE_COST)
    paired(engine, SAW)
    assert engine.given == [(SAW, preset(SAW, 1000)) for preset in (MuJoCoSettings.tuned, MuJoCoSettings.stock)]
    assert min(map(sum, engine.made)) > 1000


@pytest.mark.parametrize(
    ("cost", "passes"),
    [
        (100, 26),  # 194 steps are 19.4 us: 26 of them last half a millisecond
        (100_000, 1),  # 19.4 ms, longer than half a millisecond
        (1_000_000, 1),  # 194 ms, longer than a block may last
    ],
)
def test_a_block_has_the_fewest_passes_that_last_long_enough(cost: int, passes: int) -> None:
    engine = FakeEngine(cost)
    assert paired(engine, catalogue_scene("swinging-four-bar")).ratio == pytest.approx(1.0, rel=1e-12)
    # Three passes of each tell how many to take; then come ten rounds of blocks of both.
    assert len(engine.made) == 2 * 3 + 2 * 10 * passes


@pytest.mark.parametrize(
    ("cost", "dearer", "passes"),
    [
        # Half a millisecond of the cheaper one takes 26 passes; 25.5 of the dearer one's, of 1.96 ms, last 50 ms.
        (100, 100.0, 26),
        (200, 100.0, 13),
        (1000, 1000.0, 1),  # of which one pass takes longer than a block may last
    ],
)
def test_block_of_the_slower_setting_limits_passes_of_both(cost: int, dearer: float, passes: int) -> None:
    engine = FakeEngine(cost, dearer=dearer)
    paired(engine, catalogue_scene("swinging-four-bar"))
    assert len(engine.made) == 2 * 3 + 2 * 10 * passes


@pytest.mark.parametrize(
    ("cost", "steps"),
    [
        (1000, 2000),  # of 1 us: a block of 2 ms
        (100_000_000, 1),  # of 0.1 s, longer than a block may last
        (0, 1 << 30),  # which no clock sees: as many as a block may have
    ],
)
def test_a_block_of_what_turns_lasts_two_milliseconds(cost: int, steps: int) -> None:
    engine = FakeEngine(cost)
    found = paired(engine, SAW)
    # Each block of the ten rounds is one call of either stepper; the warm-up comes before.
    assert [calls[-10:] for calls in engine.made] == [[steps] * 10] * 2
    assert max(map(max, engine.made)) <= max(steps, 64_000)
    assert found.rounds == 10
    assert (found.seconds, found.other_seconds) == pytest.approx((1e-6 * cost, 1e-6 * cost), rel=1e-12)


def test_warm_up_covers_both_settings_and_blocks_are_long_enough() -> None:
    # Steps of 10 us and 1 us. Blocks of 1, 2, .. 256 steps take 5.11 ms of the slower, and 18 more of 256 make 50 ms.
    # A block of 2 ms of the slower would be 0.2 ms of the faster, which is to last 0.5 ms.
    engine = FakeEngine(1000, dearer=9.0)
    paired(engine, SAW)
    assert [calls[-11:] for calls in engine.made] == [[256] + [500] * 10] * 2
    assert [len(calls) for calls in engine.made] == [9 + 18 + 10] * 2


def test_both_steppers_take_turns_in_going_first() -> None:
    order = list[str]()

    def make(name: str) -> Callable[[int], None]:
        return lambda steps: order.append(name)

    time_stepper_pair(lambda: make("one"), lambda: make("other"), rounds=3, clock=lambda: 1000 * len(order))
    # Three pairs of one round each, though four are usual; warmed up until 4096 steps, a thousandth of a block each.
    assert order[-2:] == ["one", "other"]
    assert order.count("one") == order.count("other") == 3 * (13 + 1)


def test_step_is_timed_against_a_step_by_four_stepper_pairs() -> None:
    engine = FakeEngine(1000, dearer=1.0)
    makers = [lambda p=preset: engine.stepper(SAW, SimpleNamespace(preset=p)) for preset in ("tuned", "stock")]
    found = time_stepper_pair(makers[0], makers[1], rounds=6, clock=engine.clock)
    # Steps of 2 us and 1 us; the dearer one's fill a block of 2 ms. Pairs share six rounds: 2, 2, 1 and 1.
    assert [settings.preset for _, settings in engine.given] == ["tuned", "stock"] * 4
    blocks = [sum(steps == 1000 for steps in calls) for calls in engine.made]
    assert blocks == [2, 2, 2, 2, 1, 1, 1, 1]
    assert (found.seconds, found.other_seconds, found.rounds) == pytest.approx((2e-6, 1e-6, 6), rel=1e-12)
    assert found.ratio == pytest.approx(2.0, rel=1e-9)


def test_block_pairs_widen_the_interval_by_each_pair() -> None:
    # Units of 1 ms against 1 ms, but the second of four pairs lies so that its first is 10 % dearer.
    made, costs = list[int](), [1.0, 1.1, 1.0, 1.0]

    def make() -> list[Callable[[int], int]]:
        made.append(len(made))
        dearer = costs[made[-1]]
        return [lambda units: round(1e6 * dearer * units), lambda units: 10**6 * units]

    found = time_block_pair(make, rounds=24)
    assert len(made) == 4
    assert (found.ratio, found.low, found.high) == (1.0, 1.0, pytest.approx(1.1))


def test_paired_timing_is_a_median_with_an_interval_of_ranks() -> None:
    spent = np.array([[3.0, 1.0], [1.0, 1.0], [10.0, 2.0], [4.0, 2.0], [4.0, 1.0], [7.0, 1.0], [12.0, 2.0]]) * 1e6
    # Ratios 1, 2, 3, 4, 5, 6, 7. (7 - 1.96 sqrt 7) / 2 = 0.907: the interval begins at the first and ends at the last.
    found = PairedTiming.from_rounds(spent)
    assert found == PairedTiming(*(pytest.approx(one) for one in (4.0, 1.0, 7.0, 1e-3, 1e-3)), 7)
    # Of 27 rounds with ratios 1 to 27: (27 - 1.96 sqrt 27) / 2 = 8.41, so the ninth from either end.
    many = np.column_stack([np.arange(27.0, 0.0, -1.0), np.ones(27)]) * 1e6
    found = PairedTiming.from_rounds(many)
    assert found == PairedTiming(*(pytest.approx(one) for one in (14.0, 9.0, 19.0, 1e-3, 1e-3)), 27)
    # One round is its own interval, and a clock that has not moved tells nothing.
    assert PairedTiming.from_rounds(np.zeros((1, 2))) == PairedTiming(1.0, 1.0, 1.0, 0.0, 0.0, 1)


def test_an_inverse_timing_exchanges_the_settings() -> None:
    assert PairedTiming(2.0, 1.6, 4.0, 6e-3, 3e-3, 24).inverse == PairedTiming(0.5, 0.25, 0.625, 3e-3, 6e-3, 24)


@pytest.mark.parametrize(
    ("share", "expected"),
    [(0.25, IngredientVerdict.COSTLY), (0.0, IngredientVerdict.FREE), (0.02, IngredientVerdict.FREE)],
)
def test_ingredient_is_costly_at_a_quarter_and_free_below_clock(share: float, expected: IngredientVerdict) -> None:
    found = paired(FakeEngine(10 * REFERENCE_COST, dearer=share), SAW)
    assert found.ratio == pytest.approx(1.0 + share, rel=1e-4)
    assert ingredient_verdict([Evidence(False, found, None, Effect.NONE, "")])[0] is expected


# -- the engines' own steppers ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("machine", [SAW, CAM], ids=["saw", "cam"])
@pytest.mark.parametrize(("engine", "preset"), [("mujoco", "stock"), ("mujoco", "tuned"), ("pymunk", "tuned")])
def test_the_steps_that_are_timed_are_those_of_a_recorded_run(engine: str, preset: str, machine: Any) -> None:
    settings = engine_named(engine).presets[preset](machine, 1000)
    recorded = run(machine, settings, revolutions=1.0).bodies
    advance: Any = engine_named(engine).stepper(machine, settings)
    advance(333)
    advance(667)
    poses, rates = poses_and_rates(engine, machine, settings, advance)
    assert np.array_equal(poses[0], recorded.position.poses[-1])
    assert np.array_equal(rates[0], recorded.position.rates[-1])


def states_of(bodies: Any) -> Array:
    """Of pymunk's bodies."""
    return np.array([[*b.position, b.angle, *b.velocity, b.angular_velocity] for b in bodies])


def poses_and_rates(engine: str, machine: Any, settings: Any, advance: Any) -> tuple[Array, Array]:
    """States of the bodies, as a recorded run has them."""
    if engine == "mujoco":
        return build(machine, settings).forward_kinematics(advance.data.qpos[None], advance.data.qvel[None])
    told = states_of(advance.made.bodies)
    return frames_from_centres(
        machine.kinematics.mechanism, told[None, :, :3].reshape(1, -1), told[:, 3:].reshape(1, -1)
    )


# -- the reference loops ---------------------------------------------------------------------------------------------


# Timings of all dates and machines relate to these very loops. They are never changed; nor is this.
AFTER_100: dict[str, list[float]] = {
    "mujoco": [
        *(-0.02460264912419562, 0.6278726734904517, -0.8246786625049323),
        *(-0.4684157870822607, 6.2710417382472805, -7.996326038893795),
    ],
    "pymunk": [
        *(0.0, 0.0, 0.6283185307179587, 0.0, 0.0, 6.283185307179586),
        *(0.22814723053363173, 0.02941376978929742, -0.19735549798855595),
        *(-0.4211044114559482, 0.2540059294046008, -1.7269918336553445),
        *(0.3752567214837482, 0.0, 0.0, -0.4720315460054893, 0.0, 0.0),
    ],
}


@pytest.mark.parametrize("engine", ENGINES)
def test_the_reference_loop_is_what_it_always_was(engine: str) -> None:
    loop: Any = engine_named(engine).reference_loop()

    def states() -> Array:
        return np.hstack([loop.data.qpos, loop.data.qvel]) if engine == "mujoco" else states_of(loop.made.space.bodies)

    before = states().ravel()
    loop(100)
    after = states().ravel()
    assert np.abs(after - before).max() > 0.1
    assert after == pytest.approx(AFTER_100[engine], rel=1e-6, abs=1e-9)


def in_a_thread(steps: int) -> None:
    """A millisecond of CPU time in a thread of its own."""

    def burn() -> None:
        end = time.thread_time_ns() + MILLISECOND
        while time.thread_time_ns() < end:
            pass

    worker = threading.Thread(target=burn)
    worker.start()
    worker.join()


@pytest.mark.parametrize(("clock", "least"), [({}, MILLISECOND), ({"clock": time.thread_time_ns}, 0)])
def test_what_an_engine_spends_in_threads_of_its_own_is_its_cost(clock: Any, least: int) -> None:
    engine: Any = SimpleNamespace(
        has_capability=lambda kind: True, stepper=lambda *_: in_a_thread, reference_loop=lambda: in_a_thread
    )
    found = time_run(engine, SAW, MuJoCoSettings.stock(SAW, 100), **clock)
    spent = 1e9 * found.seconds_per_revolution * found.steps / 100
    assert spent >= least
    # The negative control: on the calling thread's clock next to nothing was spent.
    assert least or spent < 0.6 * MILLISECOND * math.ceil(found.steps / STEPS_PER_CALL)
