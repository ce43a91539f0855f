"""The verdict on a model made by hand: each thing that is off fails it, and nothing else does."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
from handmade_studies import judged_run, model_study

from conrod.comparison.compare import Size
from conrod.comparison.trajectory import Outcome
from conrod.mjcf.crank_speed import CrankSpeed
from conrod.mjcf.request import OpenStart, StartRates
from conrod.models.check.results import ModelStudy

# L of both points is 0.2 m, the crank turns at 40 rpm.
STUDY = model_study(tolerance=None)
SPEED = STUDY.scene.speed
STEADY = CrankSpeed(SPEED, SPEED, SPEED)


def started(**changes: Any) -> ModelStudy:
    """A model whose file starts it at its speed."""
    own = judged_run("its own run", phase=2.0)
    known = model_study(tolerance=None, own_run=own, crank=STEADY)
    return replace(known, model=replace(known.model, from_keyframe=True), **changes)


def with_model(study: ModelStudy, **changes: Any) -> ModelStudy:
    return replace(study, model=replace(study.model, **changes))


def test_the_worst_error_of_a_run_is_over_all_points() -> None:
    sizes = {"C": Size(1e-4, 9e-5, 0.0), "M": Size(3e-4, 2e-5, 0.0)}
    run = judged_run("as it is", errors={name: {"position": size} for name, size in sizes.items()}, opening=5e-4)
    assert (run.worst("position"), run.worst("position", "rms")) == (3e-4, 9e-5)
    assert run.judged_error("position") == 3e-4
    assert run.judged_error("closure") == 5e-4
    assert run.judged_error("phase") == 2e-9
    rates = judged_run("as it is")
    assert (rates.judged_error("velocity"), rates.judged_error("velocity_rms")) == (4e-4, 2e-4)
    failed = replace(rates, errors=None, phase=None)
    assert failed.worst("position") is None
    assert math.isnan(failed.judged_error("position"))
    assert math.isnan(failed.judged_error("phase"))


def test_errors_of_points_are_judged_by_their_limits_weights() -> None:
    sizes = {"C": Size(1e-4, 9e-5, 0.0), "M": Size(3e-4, 2e-5, 0.0)}
    run = judged_run("as it is", errors={name: {"velocity": size} for name, size in sizes.items()})
    weighed = replace(STUDY, weights={"velocity": {"M": 2.0}, "velocity_rms": {"C": 3.0}})
    assert weighed.judged_points(run, "velocity") == {"C": 1e-4, "M": 6e-4}
    assert weighed.judged_points(run, "velocity_rms") == {"C": pytest.approx(2.7e-4), "M": 2e-5}
    assert weighed.judged_points(run, "phase") == {}
    assert STUDY.judged_points(run, "velocity") == {"C": 1e-4, "M": 3e-4}


@pytest.mark.parametrize(("tolerance", "allowed"), [
    (None, 1e-6), ({"velocity": 0.1}, 1e-6), ({"position": 1e-4}, 1e-4), ({}, 1e-6),
])  # fmt: skip
def test_paths_are_held_to_the_tolerance_of_positions(tolerance: dict[str, float] | None, allowed: float) -> None:
    study = replace(STUDY, tolerance=tolerance)
    assert study.kinematic_tolerance == allowed
    for share, is_machine in ((0.99, True), (1.01, False)):
        identity = replace(study.identity, off_by={"C": share * allowed, "M": 0.0})
        assert replace(study, identity=identity).is_machine is is_machine
        # What is the error of the shape is none of the model.
        assert replace(study, identity=replace(identity, floor=0.1)).is_machine
        assert not replace(study, identity=replace(identity, floor=0.1, other_branch=True)).is_machine


@pytest.mark.parametrize(("tolerance", "allowed"), [
    (None, 0.01), ({"position": 1e-4}, 1e-4), ({"position": 0.1}, 0.01), ({"velocity": 0.05, "position": 1e-4}, 0.05),
])  # fmt: skip
def test_the_mean_speed_is_held_to_velocities_or_else_positions(
    tolerance: dict[str, float] | None, allowed: float
) -> None:
    assert replace(STUDY, tolerance=tolerance).speed_tolerance == allowed


def test_file_starts_motion_by_keyframe_rate_or_control() -> None:
    assert not STUDY.has_start
    assert with_model(STUDY, from_keyframe=True).has_start
    assert with_model(STUDY, moves=True).has_start
    assert with_model(STUDY, controls={"motor": 0.0, "brake": 4.0}).has_start
    assert not with_model(STUDY, controls={"motor": 0.0}).has_start


def test_a_started_machine_passes() -> None:
    study = started()
    assert [study.strays, study.rates_off, study.own_failed, study.begins_open] == [False] * 4
    assert [run.label for run in study.judged] == ["as it is", "its own run"]
    # Without a start its own run is not judged, but has to complete.
    assert [run.label for run in with_model(study, from_keyframe=False).judged] == ["as it is"]


def identified(study: ModelStudy) -> ModelStudy:
    return replace(study, identity=replace(study.identity, off_by={"C": 1e-7}))


@pytest.mark.parametrize(("change", "passed"), [
    (lambda s: s, True),
    (lambda s: replace(s, distrust="it contradicts itself"), False),
    (lambda s: replace(s, identity=replace(s.identity, off_by={"C": 1e-3})), False),
    (lambda s: with_model(s, stops=("slide is held",)), False),
    (lambda s: replace(s, own_run=None), False),
    (lambda s: replace(s, own_run=replace(s.own_run, outcome=Outcome.FLIPPED)), False),
    (lambda s: replace(s, crank=CrankSpeed(1.02 * SPEED, SPEED, SPEED)), False),
    (lambda s: with_model(replace(s, crank=CrankSpeed(1.02 * SPEED, SPEED, SPEED)), from_keyframe=False), True),
    (lambda s: with_model(s, begins=OpenStart("its own pose", {"pin": 2e-3}, 1.0, "")), False),
    (lambda s: with_model(s, begins=OpenStart("its own pose", {"pin": 0.9e-3}, 1.0, "")), True),
    (lambda s: replace(s, runs={}), False),
    (lambda s: replace(s, runs={"as it is": judged_run("as it is", outcome=Outcome.OPENED)}), False),
    (lambda s: replace(s, runs={"as it is": judged_run("as it is", phase=1e-3)}), False),
    # Presets are measured, and their clock judges nothing.
    (lambda s: replace(s, runs={**s.runs, "tuned": judged_run("tuned", outcome=Outcome.OPENED, phase=1.0)}), True),
    (lambda s: replace(s, tolerance={"position": 2.9e-4, "total": 1.0}), False),
    (lambda s: replace(s, tolerance={"position": 3.1e-4, "total": 1.0}), True),
    # A tolerance of positions limits them at the nominal time, too.
    (lambda s: replace(s, tolerance={"position": 3.1e-4}), False),
    (lambda s: replace(s, tolerance={"velocity_rms": 1.9e-4}), False),
    (lambda s: replace(s, tolerance={"velocity_rms": 2.1e-4}), True),
])  # fmt: skip
def test_a_model_passes_where_nothing_is_off(change: Any, passed: bool) -> None:
    assert change(identified(started())).passed is passed


@pytest.mark.parametrize(("tolerance", "unit", "limit"), [
    # 1 % of omega L in m/s, in the model's own unit; or what is asked for of velocities.
    (None, 1.0, 0.01 * 0.2), (None, 1e-3, 0.01 * 200.0), ({"velocity": 0.1}, 1.0, 0.1 * 0.2),
    ({"position": 0.1}, 1.0, 0.01 * 0.2),
])  # fmt: skip
def test_rates_that_open_the_loops_are_off(tolerance: dict[str, float] | None, unit: float, limit: float) -> None:
    study = started(tolerance=tolerance)
    study = replace(study, identity=replace(study.identity, frame=replace(study.identity.frame, unit=unit)))
    for share, off in ((0.99, False), (1.01, True), (math.nan, True)):
        rates = StartRates(share * limit * abs(SPEED), "crank-pin", 0.0, 1.0, "rad/s")
        assert with_model(study, rates=rates).rates_off is off
        assert with_model(study, rates=rates).own_failed is off
    assert not study.rates_off


@pytest.mark.parametrize(("tolerance", "unit", "allowed"), [
    (None, 1.0, 1e-3 * 7.0), ({"velocity": 1.0}, 1.0, 1e-3 * 7.0), ({"position": 0.1}, 1.0, 0.1 * 0.2),
    ({"position": 0.1}, 1e-3, 0.1 * 200.0),
])  # fmt: skip
def test_start_is_open_beyond_tolerance_or_thousandth_of_extent(
    tolerance: dict[str, float] | None, unit: float, allowed: float
) -> None:
    study = started(tolerance=tolerance)
    study = replace(study, identity=replace(study.identity, frame=replace(study.identity.frame, unit=unit)))
    for share, is_open in ((0.99, False), (1.01, True)):
        gaps = {"a": 0.1 * allowed, "b": share * allowed}
        assert with_model(study, begins=OpenStart("its own pose", gaps, 7.0, "")).begins_open is is_open
    assert not study.begins_open


def test_limits_follow_from_tolerances_the_drive_and_the_clock() -> None:
    # conrod's drive keeps its speed to 1e-7, over two revolutions.
    drive = 1e-7 * 2.0 * math.pi * 2.0
    assert STUDY.limits == {"phase": pytest.approx(drive, rel=1e-6)}
    found = replace(STUDY, tolerance={"position": 1e-4, "velocity": 1e-3}).limits
    # A point moves by at most 0.6 L a radian: the slider of a crank of L / 2 by up to 0.53 L.
    assert found == {
        "phase": pytest.approx(drive, rel=1e-6), "position": 1e-4, "velocity": 1e-3, "closure": 1e-4,
        "total": pytest.approx(1e-4 + 0.53 * drive, abs=0.03 * drive),
    }  # fmt: skip
    asked = replace(STUDY, tolerance={"position": 1e-4, "total": 0.5, "phase": 0.25})
    assert asked.limits == {"position": 1e-4, "total": 0.5, "phase": 0.25, "closure": 1e-4}
    assert asked.own_limits == asked.limits
    assert replace(STUDY, tolerance={"position": 1e-4}).own_limits == {"position": 1e-4, "closure": 1e-4}
    bare = replace(STUDY, runs={}, tolerance={"position": 1e-4})
    assert bare.limits == {"position": 1e-4, "closure": 1e-4}
    assert bare.driven_run is None
    assert replace(bare, tolerance=None).limits == {}


def test_phase_limit_allows_rounding_of_all_steps_of_all_turns() -> None:
    run = judged_run("as it is", steps_per_revolution=1e6)
    limits = replace(STUDY, revolutions=10.0, runs={"as it is": run}).limits
    # Ten million steps of eps times the angle of ten turns, beside the drive's share of 1e-7.
    turned = 2.0 * math.pi * 10.0
    assert limits["phase"] == pytest.approx(2.0**-52 * 1e7 * turned + 1e-7 * turned, rel=1e-9)


def test_exceeded_limits_are_the_largest_of_the_judged_runs() -> None:
    study = started(tolerance={"position": 1e-4, "velocity": 3e-4})
    far = judged_run("its own run", errors={"C": {"position": Size(9e-4, 0.0, 0.0), "velocity": Size(1e-4, 0.0, 0.0)}},
                     phase=2.0, opening=2e-4)  # fmt: skip
    study = replace(study, own_run=far, runs={"as it is": judged_run("as it is", errors={
        "C": {"position": Size(3e-4, 0.0, 0.0), "velocity": Size(4e-4, 0.0, 0.0), "total": Size(0.0, 0.0, 0.0)}
    })})  # fmt: skip
    assert study.exceeded_limits() == {"position": (9e-4, 1e-4), "velocity": (4e-4, 3e-4), "closure": (2e-4, 1e-4)}
    assert study.exceeded_limits(study.runs["as it is"]) == {"position": (3e-4, 1e-4), "velocity": (4e-4, 3e-4)}
    # The clock of its own run is limited where that is asked for.
    assert study.exceeded_limits(far) == {"position": (9e-4, 1e-4), "closure": (2e-4, 1e-4)}
    assert replace(study, tolerance={"phase": 1.0}).exceeded_limits(far) == {"phase": (2.0, 1.0)}
    assert replace(study, own_run=replace(far, errors=None)).exceeded_limits(replace(far, errors=None)) == {}
