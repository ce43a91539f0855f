"""A run at an engine's limits: when it ends, what is kept of it, and whether its failure is noticed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from catalogue import CAM, PRESS, SAW
from synthetic import completed_result

from conrod import InvalidInput
from conrod.comparison.plain_values import plain_values
from conrod.comparison.trajectory import Outcome
from conrod.engines import engine_named
from conrod.execution.local import FailedCall
from conrod.execution.run import RunCase, measure
from conrod.mechanism.loads import Displacement, Load, Steady
from conrod.scenes import Saw, Scene, ShearPress, scene_named
from conrod.studies.limits import determinism, stream_run
from conrod.studies.limits.case import LimitCase
from conrod.studies.limits.determinism import RepeatedCase
from conrod.studies.limits.recorders import ExactTorque, FlightRecorder
from conrod.studies.limits.records import Flight, Level, LimitResult, is_undetected, level_of


def case_of(scene: Any = SAW, engine: str = "mujoco", preset: str = "hardened", steps: int = 100, **facts: Any) -> Any:
    return LimitCase("mine", scene, engine_named(engine).presets[preset](scene, steps), **facts)


# -- when a run ends ---------------------------------------------------------------------------------------------------


class Recorder:
    """What a run of made-up pieces is recorded by: their first steps, and the verdict at the end."""

    def __init__(self, case: Any) -> None:
        self.case, self.added, self.compared = case, list[int](), list[int]()

    def add(self, piece: Any) -> None:
        self.added.append(piece.first_step)

    def compare(self, piece: Any) -> None:
        self.compared.append(piece.first_step)

    def result(self, verdict: Any) -> Any:
        return self, verdict


def streamed(monkeypatch: pytest.MonkeyPatch, *outcomes: Outcome) -> tuple[Recorder, Any, Any]:
    """Run of 12 revolutions of 100 steps, a piece of which is one revolution, with an outcome so far for each."""
    asked: list[Any] = []

    def run(*given: Any) -> Iterator[Any]:
        asked.append(given)
        for k in range(12):
            outcome = outcomes[min(k, len(outcomes) - 1)]
            yield SimpleNamespace(first_step=100 * k, trajectory=SimpleNamespace(outcome=outcome, reason=f"piece {k}"))

    engine = SimpleNamespace(name="mine", run=run, refusal=lambda *_: None)
    case = case_of(revolutions=12.0, start_angle=0.5)
    monkeypatch.setattr(stream_run, "engine_named", lambda name: engine)
    monkeypatch.setattr(stream_run, "run_refusal", lambda *_: None)
    monkeypatch.setattr(stream_run, "RunStatistics", Recorder)
    made: Any = stream_run.stream_run(case)
    # 1200 steps in 40 pieces are 30 steps in each.
    assert asked == [(SAW, case.settings, 12.0, 0.5, 30)]
    assert made[0].case == case
    return made[0], made[1], asked


HELD, OPENED, OFF = Outcome.COMPLETED, Outcome.OPENED, Outcome.LOST_CONTACT


@pytest.mark.parametrize(
    ("outcomes", "pieces", "compared"),
    [
        ((HELD,), 12, 12),
        # Two revolutions after the first failure, whatever else fails meanwhile.
        ((HELD, OPENED), 4, 1),
        ((OPENED, OPENED, Outcome.FLIPPED), 3, 0),
        # A follower that left its cam may land again.
        ((HELD, OFF), 12, 1),
        ((OFF, OFF, OPENED), 5, 0),
        # Nothing comes after these.
        *(((HELD, HELD, final), 3, 2) for final in (Outcome.RESET, Outcome.DIVERGED, Outcome.EXPLODED)),
    ],
)
def test_a_run_ends_two_revolutions_after_its_failure(
    outcomes: tuple[Outcome, ...], pieces: int, compared: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorder, verdict, _ = streamed(monkeypatch, *outcomes)
    assert recorder.added == [100 * k for k in range(pieces)]
    assert recorder.compared == recorder.added[:compared]
    assert (verdict.outcome, verdict.reason) == (outcomes[min(pieces, len(outcomes)) - 1], f"piece {pieces - 1}")


@pytest.mark.parametrize(
    ("steps", "revolutions", "length"),
    [(100, 12.0, 30), (100, 2.0, 25), (3, 1.0, 25), (50_000, 2.0, 2500), (10_000_000, 10.0, 4096)],
)
def test_a_run_has_forty_pieces_or_pieces_that_are_long_enough(steps: int, revolutions: float, length: int) -> None:
    assert stream_run.piece_length(case_of(steps=steps, revolutions=revolutions)) == length


def test_a_run_of_two_steps_is_too_short() -> None:
    with pytest.raises(InvalidInput) as raised:
        stream_run.piece_length(case_of(steps=20, revolutions=0.1))
    assert str(raised.value) == ("revolutions = 0.1 at 20 steps each are 2 steps; a run needs 3 to have accelerations")


def test_what_an_engine_refuses_has_its_reason_and_no_records() -> None:
    refused = case_of(CAM)
    reason = measure(RunCase("mine", CAM, refused.settings)).reason
    assert refused.perform() == LimitResult("unsupported", reason)
    assert reason


# -- what is kept ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("compared", [60, 2048])
@pytest.mark.parametrize(("engine", "preset"), [("mujoco", "stock"), ("pymunk", "tuned")])
def test_a_streamed_run_has_the_errors_of_a_whole_one(
    engine: str, preset: str, compared: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stream_run, "MIN_COMPARED_SAMPLES", compared)
    case = case_of(SAW, engine, preset, revolutions=1.5, start_angle=0.3)
    found, whole = case.perform(), measure(RunCase("mine", SAW, case.settings, 1.5, 0.3))
    assert (found.outcome, found.misfit) == ("completed", None)
    for name, quantities in (whole.errors or {}).items():
        for quantity, sizes in quantities.items():
            # Bit for bit: it does not depend on how the run was cut.
            assert (found.errors or {})[name][quantity] == sizes
    records = found
    assert (records.samples, records.finite, records.warnings) == (151, True, {})
    assert (records.penetration, records.flights, len(records.fingerprint) > 10) == (None, (), True)
    # The drive's torque is compared at all samples but the first, over its peak.
    (piece,) = engine_named(engine).run(SAW, case.settings, 1.5, 0.3, 1000)
    if piece.drive_torque is None:
        assert records.torque is None
        return
    exact = ExactTorque(SAW.kinematics, SAW.speed, gravity=True)
    at = piece.trajectory.bodies.acceleration.instants.angle  # type: ignore[union-attr]
    off = np.abs(piece.drive_torque - exact.evaluate(at))[1:].max() / exact.peak
    assert records.torque == pytest.approx(off, rel=1e-9)


def test_a_failed_run_has_its_outcome_and_reason_and_no_errors() -> None:
    scene = scene_named("saw-500rpm")
    case = case_of(scene, "pymunk", "stock", 20)
    found, whole = case.perform(), measure(RunCase("mine", scene, case.settings))
    assert (found.outcome, found.errors) == (whole.outcome, None)
    assert found.outcome != "completed"
    assert found.reason
    assert found.samples > 0


def test_a_follower_has_a_penetration_and_no_torque() -> None:
    records = case_of(CAM, "pymunk", "tuned", 2000, revolutions=0.2).perform()
    assert records.torque is None
    assert records.penetration is not None
    assert 0.0 < records.penetration < 1e-3


def test_records_of_a_run_are_restored_whole() -> None:
    kept = LimitResult(
        "opened", samples=3, warnings={"BADQACC": 1}, torque=0.1, flights=(Flight(1.0, 2.0),), again=("a",)
    )
    assert case_of(SAW).restore_result(plain_values(kept)) == kept
    never_began = case_of(SAW).failed_result(Outcome.CRASHED, "why")
    assert (never_began.outcome, never_began.reason) == ("crashed", "why")
    assert (never_began.samples, never_began.fingerprint, never_began.flights, never_began.again) == (0, "", (), ())


def test_a_load_takes_torque_by_its_virtual_work() -> None:
    """T dtheta = - F dx where a force F moves along by dx."""
    given = SAW.kinematics.mechanism
    push = Load("push", Displacement(given.bodies[-1].name, (0.0, 0.0), 0.0), Steady(100.0))
    kinematics = type(SAW.kinematics)(replace(given, loads=(push,)))
    angles = np.linspace(0.1, 6.2, 20)
    loaded, free = (ExactTorque(one, SAW.speed, gravity=True).evaluate(angles) for one in (kinematics, SAW.kinematics))
    along = kinematics.derivatives(angles, 1)[1][:, -3]
    assert loaded - free == pytest.approx(-100.0 * along, rel=1e-9, abs=1e-9)
    assert np.abs(along).max() > 0.05


def test_first_of_equal_flights_is_longest_and_a_touch_is_none() -> None:
    found = FlightRecorder(2, travel=1.0)
    found.add(np.arange(9.0), np.array([-1e-3, 0.0, 0.02, 0.0, 0.0, 0.02, 0.0, 0.01, 0.0]))
    assert found.longest_flight() == Flight(1.5, 2.5)
    assert found.penetration == 1e-3
    # Without any penetration a flight is a gap above a millionth of the travel.
    least = FlightRecorder(1, travel=2.0)
    least.add(np.arange(4.0), np.array([0.0, 0.0, 4e-6, 0.0]))
    assert least.threshold == pytest.approx(2e-6)
    assert least.longest_flight() == Flight(pytest.approx(1.5), pytest.approx(2.5))  # type: ignore[arg-type]
    assert Flight(-1.0, -3.0).length == 2.0


def test_a_torque_of_rounding_alone_is_negligible() -> None:
    turning = ExactTorque(SAW.kinematics, 1.0, gravity=False)
    mass = sum(body.mass for body in SAW.kinematics.mechanism.bodies)
    least = 1e-12 * mass * SAW.kinematics.travel**2
    for share, negligible in ((0.9, True), (1.1, False)):
        turning.__dict__["peak"] = share * least
        turning.__dict__.pop("is_negligible", None)
        assert turning.is_negligible is negligible


# -- levels ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("outcome", "level", "undetected"),
    [
        ("crashed", Level.UNBOUNDED, False),
        ("timed_out", Level.UNBOUNDED, False),
        ("out_of_memory", Level.UNBOUNDED, False),
        ("unsupported", Level.UNBOUNDED, False),
        ("diverged", Level.UNBOUNDED, True),
        ("exploded", Level.UNBOUNDED, True),
        ("reset", Level.UNBOUNDED, True),
        ("opened", Level.BROKEN, True),
    ],
)
def test_failure_is_undetected_when_numbers_and_engine_are_clean(outcome: str, level: Level, undetected: bool) -> None:
    outcome = Outcome[outcome.upper()].slug

    def measured(**facts: Any) -> LimitResult:
        return LimitResult(outcome, **{"samples": 1} | facts)

    assert level_of(measured()) is level
    assert is_undetected(measured()) is undetected
    assert not is_undetected(measured(finite=False))
    assert not is_undetected(measured(warnings={"BADQACC": 1}))


def test_a_wrong_run_is_undetected_and_a_rough_one_is_none() -> None:
    assert is_undetected(completed_result(0.11, LimitResult, samples=1))
    assert not is_undetected(completed_result(0.09, LimitResult, samples=1))


def test_failed_second_process_is_the_outcome_with_its_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    settings = engine_named("mujoco").presets["hardened"](SAW, 100)
    case, done = RepeatedCase("mine", SAW, settings), list[str]()

    def task(one: Any) -> LimitResult:
        done.append(one.name)
        return LimitResult(fingerprint=f"run {len(done)}")

    def isolated(answer: Any) -> None:
        monkeypatch.setattr(determinism, "call_isolated", lambda function, one: answer if answer else function(one))

    isolated(FailedCall(Outcome.CRASHED, "signal 11"))
    assert determinism.run_repeatedly(case, task) == LimitResult("crashed", "in another process: signal 11")
    isolated(None)
    done.clear()
    found = determinism.run_repeatedly(case, task)
    # Twice, after another machine, and in another process.
    assert done == ["mine", "mine", "another", "mine", "mine"]
    assert (found.fingerprint, found.again) == ("run 1", ("run 2", "run 4", "run 5"))


@pytest.mark.parametrize(("scene", "other"), [(SAW, ShearPress), (PRESS, Saw)])
def test_machine_between_repeats_is_another_for_one_turn(
    scene: Scene, other: type[Scene], monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[LimitCase] = []

    def task(one: LimitCase) -> LimitResult:
        done.append(one)
        return LimitResult(fingerprint="same")

    monkeypatch.setattr(determinism, "call_isolated", lambda function, one: function(one))
    case = RepeatedCase("mine", scene, engine_named("mujoco").presets["hardened"](scene, 100), revolutions=3.0)
    determinism.run_repeatedly(case, task)
    between = done[2]
    assert isinstance(between.scene, other)
    assert (between.settings.steps_per_revolution, between.revolutions) == (determinism.OTHER_MACHINE_STEPS, 1.0)
    # What is kept of a run is found again by the names of these fields.
    assert case.key_fields() == LimitCase.key_fields(case) | {"repeated": determinism.REPEATED_RUNS}


def test_engine_without_a_setting_of_gravity_has_all_weights(monkeypatch: pytest.MonkeyPatch) -> None:
    known: list[Any] = []
    monkeypatch.setattr(stream_run, "ExactTorque", lambda *_, gravity: known.append(gravity))
    exudyn, mujoco = case_of(engine="exudyn", preset=next(iter(engine_named("exudyn").presets))), case_of()
    assert "gravity" not in exudyn.settings.as_dict()
    for case in (exudyn, mujoco, replace(mujoco, settings=replace(mujoco.settings, gravity=False))):
        stream_run.RunStatistics(case)
    assert known == [True, True, False]
