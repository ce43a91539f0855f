"""No false pass: what is no number, did not complete or is on another branch is never within tolerance."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from planted_engine import LawfulEngine
from synthetic import other_branch

from conrod import InvalidInput
from conrod.comparison.plain_values import plain_values
from conrod.comparison.trajectory import Outcome
from conrod.engines import engine_named
from conrod.engines.capabilities import KinematicResult
from conrod.engines.engine import Machine, default_steps, run_extent
from conrod.exact.motion import QUANTITIES, Array
from conrod.execution.case import CACHE_VERSION, SIZES, Case, ResultsOfRounds, identity_digest, pursue
from conrod.execution.releases import VersionCase
from conrod.execution.result import AS_ASKED, Plan, SceneResults, presets_study, refinement_path, run_refinement_path
from conrod.execution.results_table import tidy_row
from conrod.execution.run import RunCase, RunResult
from conrod.execution.tolerances import UnscaledLimit
from conrod.scenes import SCENES, scene_named
from conrod.studies.ablate.study import CostCase
from conrod.studies.forces.results import ForceErrors, ForceResult
from conrod.studies.forces.study import ForceCase, ForcePlan
from conrod.studies.free_motion.plan import MotionPlan
from conrod.studies.free_motion.results import ExactSummary, MotionResult
from conrod.studies.free_motion.study import MotionCase
from conrod.studies.limits.case import LimitCase
from conrod.studies.validation.kinematic_mode import validate_kinematic
from conrod.studies.validation.results import DefectVerdict, Qualification, Tolerance, ValidationResult, empty_result
from conrod.studies.validation.study import ValidationCase

SAW: Any = SCENES["saw-40rpm"]
WITHIN, ALLOWED = 1e-7, 1e-6


def result(found: Mapping[str, float | None], /, **facts: Any) -> ValidationResult:
    """A run with these errors, of which the position is judged."""
    sizes = {q: None if e is None else dict.fromkeys(("max", "rms", "final"), e) for q, e in found.items()}
    given: dict[str, Any] = {
        "tolerance": Tolerance(position=ALLOWED),
        "errors": {"A": {"position": None} | sizes},
    } | facts
    return ValidationResult(
        scene="saw", engine="mujoco", engine_version="1", preset="tuned", mode="dynamic", parameters={},
        revolutions=1.0, **given,
    )  # fmt: skip


# -- the verdict -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("error", [math.nan, math.inf, 2.0 * ALLOWED, float(np.nextafter(ALLOWED, 1.0)), None])
def test_an_error_that_is_not_within_is_out_of_tolerance(error: float | None) -> None:
    found = result({"position": error}).with_verdict()
    assert found.passed is False
    ((name, (size, allowed)),) = found.out_of_tolerance().items()
    assert (name, allowed) == ("position", ALLOWED)
    assert repr(size) == repr(error)


def test_nan_error_fails_beside_a_smaller_error() -> None:
    by = {"engine": "mujoco", "engine_version": "1", "preset": "tuned", "scene": "saw"}
    sizes = [dict.fromkeys(("max", "rms", "final"), size) for size in (WITHIN, math.nan)]
    forces = ForceResult(
        **by, parameters={}, steps_per_revolution=1, revolutions=1.0, groups={"reactions": ("a", "b")},
        errors={n: ForceErrors(s["max"], s["rms"], None, 1.0, True) for n, s in zip("ab", sizes, strict=True)},
        tolerance={"reactions": ALLOWED},
    )  # fmt: skip
    motion = MotionResult(
        **by, motion="free", exact=ExactSummary(0.0, "", 1.0, ""), step=1.0, seconds=1.0, leaving=1.0,
        errors=dict(zip("ab", sizes, strict=True)), tolerance={"position": ALLOWED},
    )  # fmt: skip
    assert [one.with_verdict().passed for one in (forces, motion)] == [False, False]
    kept = RunResult("completed", errors={n: {"position": s} for n, s in zip("ab", sizes, strict=True)})
    assert math.isnan(kept.largest("position") or 0.0)


def test_verdict_without_detection_fails_at_its_own_tolerances() -> None:
    for smallest, passed in ((None, False), (1e-9, True)):
        seen = DefectVerdict("longer rod", "m", "rod", 1e-3, (), smallest)
        found = result({"position": WITHIN}, qualified=Qualification((seen,), ()))
        assert found.with_verdict().passed is passed
        assert found.with_verdict({"position": ALLOWED}).passed is True


@pytest.mark.parametrize("error", [0.0, WITHIN, ALLOWED])
def test_an_error_up_to_what_is_allowed_is_within(error: float) -> None:
    assert result({"position": error}).with_verdict().passed is True


def test_worst_point_decides_and_nan_is_the_worst() -> None:
    size = dict.fromkeys(("max", "rms", "final"), WITHIN)
    for bad in (2.0 * ALLOWED, math.nan):
        wrong = dict.fromkeys(("max", "rms", "final"), bad)
        for first, second in ((size, wrong), (wrong, size)):
            errors = {"A": {"position": first}, "B": {"position": second}}
            assert result({}, errors=errors).with_verdict().passed is False


def test_errors_of_links_and_points_are_judged_by_their_weights() -> None:
    turned = {"rod": {"rotation": {"max": 3e-7}}, "crank": {"angular_velocity": {"max": 9.0}}}
    found = result({"position": 8e-7}, links=turned, weights={"position": {"A": 2.0}, "rotation": {"rod": 5.0}})
    assert found.judged_points("rotation") == {"rod": pytest.approx(15e-7)}
    assert found.judged_points("position") == {"A": pytest.approx(16e-7)}
    assert found.judged_points("velocity") == {}
    assert found.with_verdict().passed is False
    assert replace(found, weights=None).with_verdict().passed is True


def test_each_quantity_is_held_to_its_own_tolerance() -> None:
    allowed = {"position": 1.0, "velocity": 2.0, "acceleration": 3.0, "total": 4.0}
    for name, most in allowed.items():
        errors: dict[str, float | None] = {**allowed, name: 1.01 * most}
        found = result(errors, tolerance=Tolerance(**allowed)).with_verdict()
        assert (found.passed, list(found.out_of_tolerance())) == (False, [name])
    sizes = {"A": {"velocity": {"max": 9.0, "rms": 0.5, "final": 9.0}}}
    for bound, passed in ((0.6, True), (0.4, False)):
        assert result({}, errors=sizes, tolerance=Tolerance(velocity_rms=bound)).with_verdict().passed is passed
    sizes = {"A": {"position": {"max": 9.0, "rms": 0.5, "final": 0.5}}}
    assert result({}, errors=sizes, tolerance=Tolerance(position=0.6)).with_verdict().passed is False
    phase = {"max": 0.5, "final": 0.0}
    for bound, passed in ((0.6, True), (0.4, False)):
        assert result({}, phase=phase, tolerance=Tolerance(phase=bound)).with_verdict().passed is passed
    assert result({}, tolerance=Tolerance(phase=0.4)).with_verdict().passed is False


@pytest.mark.parametrize("outcome", [one for one in Outcome if one is not Outcome.COMPLETED])
def test_a_run_that_failed_never_passes_whatever_its_errors(outcome: Outcome) -> None:
    found = result({"position": WITHIN}, outcome=outcome.slug)
    # What an engine cannot do is not held against it.
    expected = None if outcome is Outcome.UNSUPPORTED else False
    assert found.with_verdict().passed is expected
    assert found.with_verdict({"position": 1.0}).passed is expected


def test_where_nothing_is_judged_there_is_no_verdict() -> None:
    assert result({"position": math.nan}, tolerance=Tolerance()).with_verdict().passed is None


def test_given_tolerances_replace_all_others() -> None:
    found = result({"position": WITHIN, "velocity": 1.0}, tolerance=Tolerance(position=1e-9, velocity=1e-9))
    asked = found.with_verdict({"position": ALLOWED})
    assert (asked.passed, asked.limits, asked.tolerance.reason) == (True, {"position": ALLOWED}, AS_ASKED)
    assert found.with_verdict({"position": 1e-8}).passed is False


def validation(preset: str | None, tolerance: dict[str, float] | None = None) -> ValidationCase:
    return ValidationCase("saw", SAW, "mujoco", preset, Plan(100, 1.0, tolerance))


def forces(preset: str, tolerance: dict[str, float] | None = None) -> ForceCase:
    return ForceCase("saw", SAW, "mujoco", preset, ForcePlan(100, tolerance=tolerance))


@pytest.mark.parametrize(
    ("case", "passed"),
    [
        (validation("tuned"), False), (validation(None), False), (validation("stock"), None),
        (validation("stock", {"position": 1.0}), False), (forces("hardened"), False), (forces("stock"), None),
        (forces("stock", {"torque": 1.0}), False),
    ],
)  # fmt: skip
def test_crashed_run_fails_when_it_was_to_be_judged(case: Any, passed: bool | None) -> None:
    found = case.requested_result(case.failed_result(Outcome.CRASHED, "signal 11"))
    assert (found.scene, found.outcome, found.reason, found.passed) == ("saw", "crashed", "signal 11", passed)
    assert case.effort == 100


def test_study_asks_each_case_once_and_groups_results_by_scene() -> None:
    scenes, engines = {"one": SAW, "two": SCENES["saw-500rpm"]}, [engine_named("mujoco"), engine_named("pymunk")]
    presets, plan = {"mujoco": ("tuned", "stock"), "pymunk": ("stock",)}, Plan(40, 1.0)
    study = presets_study(ValidationCase, scenes, engines, presets, plan)
    cases: Any = next(study)
    each = [("mujoco", "tuned"), ("mujoco", "stock"), ("pymunk", "stock")]
    assert [(c.name, c.engine, c.preset) for c in cases] == [(name, *one) for name in scenes for one in each]
    assert {(c.name, c.scene) for c in cases} == set(scenes.items())
    assert all(c.plan is plan for c in cases)
    with pytest.raises(StopIteration) as end:
        study.send({c.key: c.failed_result(Outcome.CRASHED, f"{c.name} {c.engine} {c.preset}") for c in cases})
    for found, name in zip(end.value.value, scenes, strict=True):
        assert (found.name, found.scene) == (name, scenes[name])
        assert [one.reason for one in found.results] == [f"{name} {engine} {preset}" for engine, preset in each]


# -- kinematic mode ----------------------------------------------------------------------------------------------------


class OnBranch(LawfulEngine):
    """Has its observed points where they belong, and its links on an assembly branch."""

    def __init__(self, other: bool, off: float = 0.0) -> None:
        super().__init__()
        self.other, self.off = other, off

    def solve_kinematics(self, machine: Machine, angle: Array) -> KinematicResult:
        exact = machine.motion(angle, machine.speed)
        points = {
            name: (exact.point(name).position + self.off * length, exact.point(name).velocity)
            for name, length in machine.lengths.items()
        }
        solver = other_branch(machine) if self.other else machine.kinematics
        return KinematicResult(angle, solver.poses(angle), points)


def test_kinematic_mode_fails_on_other_branch_with_right_points() -> None:
    right, other = (validate_kinematic("saw", SAW, OnBranch(branch)) for branch in (False, True))
    assert (right.outcome, right.passed) == ("completed", True)
    assert (other.outcome, other.passed) == ("flipped", False)
    assert list(other.out_of_tolerance()) == ["rotation of rod"]  # no point
    assert "on the other branch at 0.0 deg" in other.reason


@pytest.mark.parametrize(("off", "passed"), [(0.5e-12, True), (2e-12, False)])
def test_kinematic_mode_is_held_to_rounding(off: float, passed: bool) -> None:
    assert validate_kinematic("saw", SAW, OnBranch(False, off)).passed is passed


def test_a_study_that_needs_no_run_has_its_findings() -> None:
    def study() -> Any:
        return "found"
        yield []

    assert pursue([study()], lambda cases: {}) == ["found"]


def test_each_result_is_of_the_round_that_made_it() -> None:
    found = ResultsOfRounds({"a": {"a": 1, "b": 2}, "b": {"b": 3}})
    assert dict(found) == {"a": 1, "b": 3}
    assert len(found) == 2


@pytest.mark.parametrize(("verdicts", "passed"), [
    ((), True), ((True, None), True), ((None,), True), ((True, False), False), ((False,), False),
])  # fmt: skip
def test_a_scene_passes_unless_a_judged_result_fails(verdicts: tuple[bool | None, ...], passed: bool) -> None:
    results: Any = tuple(SimpleNamespace(passed=one) for one in verdicts)
    assert SceneResults("saw", SAW, results).passed is passed


def test_run_has_the_extent_of_its_plan_or_of_a_pass() -> None:
    assert Plan(revolutions=3.0).extent(SAW) == (0.0, 3.0)
    swing = scene_named("swinging-four-bar")
    assert Plan().extent(swing) == run_extent(swing, default_steps(swing), 2.0)
    with pytest.raises(InvalidInput, match=r"10 steps per revolution are \d+ of the pass: at least \d+ are run"):
        Plan(10).extent(swing)


def test_result_without_measurements_says_what_was_asked() -> None:
    engine, plan = engine_named("mujoco"), Plan(500, 3.0)
    dynamic = empty_result("saw", SAW, engine, "tuned", plan)
    assert (dynamic.mode, dynamic.preset, dynamic.steps_per_revolution, dynamic.revolutions) == (
        "dynamic", "tuned", 500, 3.0,
    )  # fmt: skip
    kinematic = empty_result("saw", SAW, engine, None, plan)
    assert (kinematic.mode, kinematic.preset, kinematic.steps_per_revolution, kinematic.revolutions) == (
        "kinematic", None, None, 1.0,
    )  # fmt: skip
    for one in (dynamic, kinematic):
        assert (one.scene, one.parameters, one.engine, one.engine_version, one.errors) == (
            "saw", SAW.parameters, "mujoco", engine.version, None,
        )  # fmt: skip


# -- keys --------------------------------------------------------------------------------------------------------------


def case_of(scene: Any, settings: Any = None, **changes: Any) -> RunCase:
    """A run with settings that a change of the scene does not change with it."""
    return replace(RunCase("any", scene, settings or SETTINGS), **changes)


SETTINGS = engine_named("mujoco").presets["tuned"](SAW, 100)


@pytest.mark.parametrize("name", [*SCENES, "slider-crank", "cam-3-4-5"])
def test_every_parameter_is_in_the_key_of_a_run(name: str) -> None:
    scene = scene_named(name)
    varied = ["speed", *[one for one, value in scene.parameters.items() if value][:3]]
    others = [scene.with_parameters(**{one: scene.parameters[one] * (1.0 + 1e-9)}) for one in dict.fromkeys(varied)]
    changes = ({"revolutions": 3.0}, {"start_angle": 0.1}, {"signed_angles": 10})
    keys = {case_of(one).key for one in (scene, *others)} | {case_of(scene, **change).key for change in changes}
    assert len(keys) == 4 + len(others)
    assert case_of(scene_named(name)).key in keys


@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_every_setting_is_in_the_key_but_the_name_of_its_preset(engine: str) -> None:
    settings: Any = engine_named(engine).presets["tuned"](SAW, 100)
    other = {"timestep": 2.0 * settings.timestep, "steps_per_revolution": 101, "iterations": 7, "gravity": False}
    keys = {case_of(SAW, replace(settings, **{name: value})).key for name, value in other.items()}
    assert len(keys | {case_of(SAW, settings).key}) == 1 + len(other)
    assert case_of(SAW, replace(settings, preset="custom")).key == case_of(SAW, settings).key


def test_file_machine_has_identity_of_joint_kinds_and_speed() -> None:
    scene: Any = scene_named("planetary-gear")
    kinds = [type(joint).__name__ for joint in scene.mechanism().joints]
    assert len(set(kinds)) > 1
    assert scene.identity()["kinds"] == kinds
    assert scene.identity()["speed"] == scene.speed
    # The speed alone, with settings that have nothing of it.
    assert case_of(scene.with_parameters(speed=2.0 * scene.speed)).key != case_of(scene).key


def test_an_identity_names_all_that_determines_a_validation() -> None:
    """By names that stay: another name would be another key, and every kept result lost."""
    case = validation("tuned")
    assert replace(case, name="other", plan=Plan(100, 1.0, {"position": 1.0})).key == case.key
    others = [replace(case, preset=one) for one in ("hardened", None)] + [replace(case, plan=Plan(100, 2.0))]
    assert len({one.key for one in (case, *others)}) == 1 + len(others)
    assert case.identity() == {
        "cache_version": CACHE_VERSION, "study": "validate", "scene": "saw", "parameters": SAW.parameters,
        "engine": "mujoco", "engine_version": engine_named("mujoco").version, "preset": "tuned",
        "settings": SETTINGS.as_dict(), "refined": [tuned(n).as_dict() for n in (12, 25, 50, 100)],
        "revolutions": 1.0, "start_angle": 0.0,
    }  # fmt: skip


def test_an_identity_names_all_that_determines_a_run() -> None:
    settings = tuned(50)
    case = RunCase("mine", SAW, settings, 3.0, 0.5, 8)
    assert case.identity() == {
        "cache_version": CACHE_VERSION, "study": "sweep", "scene": "saw", "parameters": SAW.parameters,
        "engine": "mujoco", "engine_version": engine_named("mujoco").version,
        "settings": {name: value for name, value in settings.as_dict().items() if name != "preset"},
        "revolutions": 3.0, "start_angle": 0.5, "signed_angles": 8,
    }  # fmt: skip
    assert case.labels == {"label": "tuned"}
    assert identity_digest("") == "e3b0c44298fc1c149afbf4c8996fb924"  # SHA-256, half of it
    assert replace(case, settings=replace(settings, preset="custom")).labels == {}


def tuned(steps: int) -> Any:
    return engine_named("mujoco").presets["tuned"](SAW, steps)


# -- what is kept, and read again --------------------------------------------------------------------------------------


KEPT = ValidationCase("saw", SAW, "pymunk", "tuned", Plan(40, 1.0))


def without_arrays(found: ValidationResult) -> ValidationResult:
    """A result without its arrays, which have no one answer to whether they are equal."""
    return replace(found, curves=None, poses=None, samples=None)


def test_result_is_restored_whole_from_its_plain_values() -> None:
    found, plain = KEPT.perform(), plain_values(KEPT.perform())
    restored = KEPT.restore_result(plain)
    assert plain_values(restored) == plain
    assert without_arrays(restored) == without_arrays(found)
    assert found.passed is True
    assert found.sizes() == {
        q: {m: found.largest(q, m) for m in ("max", "rms", "final")} for q in (*QUANTITIES, "total")
    }


def test_verdict_and_columns_of_a_result_stand_in_the_table() -> None:
    found = KEPT.perform()
    saved = plain_values(found) | {SIZES: found.sizes()}
    row = tidy_row(KEPT.key, KEPT.name, KEPT.identity(), saved, None)
    assert (row["study"], row["cache_version"], row["passed"], row["outcome"]) == (
        "validate", CACHE_VERSION, True, "completed",
    )  # fmt: skip
    assert row["position_max"] == found.largest("position")
    assert (found.closure is None, found.phase is None, found.drive is None, found.prediction is None) == (False,) * 4
    assert row["closure_velocity"] == (found.closure or {})["velocity"]
    assert row["phase_max"] == (found.phase or {})["max"]
    assert row["drive_speed"] == (found.drive or {})["speed"]
    assert row["predicted_position"] == (found.prediction or {})["position"]["predicted"]
    failing = replace(KEPT, scene=SCENES["saw-500rpm"], preset="stock", plan=Plan(20, 1.0)).perform()
    assert (failing.completed, failing.reason == "") == (False, False)


def cases_by_study() -> dict[str, Case]:
    settings = tuned(50)
    cases: list[Case] = [
        validation("tuned"), forces("stock"), RunCase("mine", SAW, settings, 3.0),
        LimitCase("mine", SAW, settings),
        MotionCase("mine", SAW, "mujoco", "tuned", MotionPlan("free")),
        VersionCase("mine", SAW, settings, version="4.0.0"),
        CostCase("mine", SAW, settings, against=tuned(40), machine="here"),
    ]  # fmt: skip
    return {case.study: case for case in cases}


# A key that changed without a new version of the cache would have every run made again, unsaid.
PINNED = (
    4,
    {
        "validate": "95cced7ac2a38f093b6ed90b735f377f",
        "forces": "239fb3b7b311b9622b79712f45c315da",
        "sweep": "c456f8e6bd5349b1d1b4a4fa570ab7cc",
        "limits": "92aaafc4f68c86966d5f0e86fa52d707",
        "motion": "2f6170e5e25db8389a94f181f9effb68",
        "versions": "977fd38361fd23290f7271478fc5d964",
        "ablate": "6026ec3cf5a48ef0913a55bd79beeda1",
    },
)


def test_keys_change_with_the_version_of_the_cache_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(type(engine_named("mujoco")), "version", "4.0.0")
    assert (CACHE_VERSION, {study: case.key for study, case in cases_by_study().items()}) == PINNED


def test_kept_result_takes_name_and_tolerances_of_the_request() -> None:
    found = KEPT.perform()
    asked = replace(KEPT, name="mine", plan=replace(KEPT.plan, tolerance={"position": 1e-9}))
    strict = asked.requested_result(found)
    assert (strict.scene, strict.parameters, strict.passed) == ("mine", SAW.parameters, False)
    loose = replace(asked, plan=replace(KEPT.plan, tolerance={"position": 1.0}))
    assert loose.requested_result(strict).passed is True
    for metres, passed in ((1.0, True), (1e-12, False)):
        limit = {"position": UnscaledLimit(metres, is_share=False)}
        assert replace(asked, plan=replace(KEPT.plan, tolerance=limit)).requested_result(found).passed is passed
    assert KEPT.requested_result(found) == found
    ended = asked.requested_result(asked.failed_result(Outcome.CRASHED, "signal 11"))
    assert (ended.outcome, ended.reason, ended.passed) == ("crashed", "signal 11", False)


def test_a_tolerance_asked_for_is_not_kept_with_the_result() -> None:
    # Else the next user would be judged by the tolerance of the first.
    asked = replace(KEPT, plan=replace(KEPT.plan, tolerance={"position": 1e-9}))
    assert asked.key == KEPT.key
    assert without_arrays(asked.perform()) == without_arrays(KEPT.perform())
    failed = [case.failed_result(Outcome.CRASHED, "signal 11") for case in (asked, KEPT)]
    assert failed[0] == failed[1]


@pytest.mark.parametrize("broken", [{"outcome": "gone"}, {"outcome": None}, {"tolerance": 1.0}, {"scene": None}])
def test_a_result_of_another_form_is_not_restored(broken: dict[str, Any]) -> None:
    with pytest.raises(InvalidInput):
        KEPT.restore_result(plain_values(KEPT.failed_result(Outcome.CRASHED, "why")) | broken)


def test_refinement_runs_all_steps_and_reuses_the_judged_run() -> None:
    def refined(scene: Any, steps: int) -> list[Any]:
        return list(run_refinement_path(scene, steps, 2.0, "judged", lambda *run: run))

    assert refinement_path(SAW, 6) == (2, 3, 6)  # no two alike, none shorter than two steps
    assert refinement_path(SCENES["cam-follower"], 160) == (10, 20, 40, 80)
    assert refined(SAW, 100) == [(12, 2.0, 0.0), (25, 2.0, 0.0), (50, 2.0, 0.0), "judged"]
    # A pass is cut to what the longest steps have room for that make three of it (11 a revolution are two); then the
    # judged run, which was longer, is made once more.
    geneva: Any = scene_named("geneva")
    start, turns = run_extent(geneva, 22, 2.0)
    assert run_extent(geneva, 90, 2.0) != (start, turns)
    assert refined(geneva, 90) == [(n, turns, start) for n in (22, 45, 90)]
