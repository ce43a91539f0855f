"""Every study that compares runs with the exact motion fails where that motion contradicts the joints' equations."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import conrod

from conrod.comparison.trajectory import Outcome
from conrod.engines import engine_named
from conrod.engines.variants import PRESETS_GRID
from conrod.execution import reference_guard
from conrod.execution.case import Case, pursue
from conrod.execution.reference_guard import ReferenceGuard
from conrod.execution.run import RunCase, RunResult
from conrod.execution.timing import Timing
from conrod.report.findings import Findings
from conrod.scenes.saw import Saw
from conrod.scenes.scene import Scene
from conrod.studies.ablate.report import ABLATE_REPORT as ABLATE
from conrod.studies.ablate.study import CostCase, ablate_engine, ablation_study
from conrod.studies.limits.case import LimitCase, Setup
from conrod.studies.limits.plan import plan_limits, pursue_plans
from conrod.studies.limits.report import LIMITS_REPORT as LIMITS
from conrod.studies.limits.report import merge_studies
from conrod.studies.sweep.api import findings_of
from conrod.studies.sweep.recommend import recommendation_studies
from conrod.studies.sweep.report import SWEEP_REPORT as SWEEP
from conrod.studies.sweep.study import RulePlan, SweepPlan, plan_sweep, sweep_scene
from conrod.studies.versions.report import VERSIONS_REPORT as VERSIONS
from conrod.studies.versions.study import release_cases, versions_study

MUJOCO, NAME = engine_named("mujoco"), "machine"
ACCUSATION = "CANNOT BE TRUSTED: machine in MuJoCo"
REASON = "the exact motion contradicts the joints' equations"


class WrongSaw(Saw):
    """A saw whose closed form gives positions that are too large by a millionth."""

    def _angle_derivatives(self, angle: Any, side: Any) -> Any:
        found = super()._angle_derivatives(angle, side)
        return {
            name: tuple([np.asarray(axis[0]) * (1.0 + 1e-6), *axis[1:]] for axis in axes)
            for name, axes in found.items()
        }


KEPT: dict[tuple[type[Scene], str], RunResult] = {}


def performed(cases: Sequence[Case]) -> dict[str, RunResult]:
    """Make all runs in this process, each once for all tests; timings of pairs are not made."""
    return {
        case.key: case.failed_result(Outcome.TIMED_OUT, "") if isinstance(case, CostCase) else perform_once(case)
        for case in cases
    }


def perform_once(case: Any) -> RunResult:
    kept = type(case.scene), case.key
    if kept not in KEPT:
        KEPT[kept] = case.perform()
    return KEPT[kept]


def pretended_times(cases: Sequence[RunCase]) -> dict[str, Timing]:
    return {case.key: Timing(1e-3, 1e-6, 1000.0, 1, 1, "m") for case in cases}


def small_plan(scene: Scene) -> SweepPlan:
    """The preset `tuned` alone, at two numbers of steps."""
    plan = plan_sweep(NAME, scene, [MUJOCO], PRESETS_GRID)
    (rule,) = [one for one in plan.rules if one.rule.name == "tuned"]
    cases = tuple(RunCase(NAME, scene, rule.rule.settings(scene, n)) for n in (100, 200))
    return replace(plan, rules=(RulePlan(MUJOCO, rule.rule, cases),))


def swept(scene: Scene) -> Findings[Any]:
    (study,) = pursue([sweep_scene(small_plan(scene), pretended_times)], performed)
    return Findings(SWEEP, {NAME: study})


def recommended(scene: Scene) -> Findings[Any]:
    allowed = {"position": 1e-2}
    answers = pursue(recommendation_studies(small_plan(scene), allowed, pretended_times, {}), performed)
    return findings_of((NAME, scene), allowed, answers)


def limited(scene: Scene) -> Findings[Any]:
    (study,) = pursue_plans([plan_limits(NAME, scene, [MUJOCO], "tuned", ["rounding"], None)], performed)
    return Findings(LIMITS, {NAME: study})


def ablated(scene: Scene) -> Findings[Any]:
    (found,) = pursue([ablate_engine(NAME, scene, MUJOCO, 50, 2)], performed)
    return Findings(ABLATE, {NAME: ablation_study(NAME, scene, [found], {})})


def of_releases(scene: Scene) -> Findings[Any]:
    """Two releases, both run in the installed one."""
    (label, case), *_ = release_cases({NAME: scene}, MUJOCO).items()

    def perform(_: str, cases: Sequence[Any]) -> dict[str, RunResult]:
        return {one.key: perform_once(replace(one, version=MUJOCO.version)) for one in cases}

    study = versions_study(MUJOCO, ["3.8.0", MUJOCO.version], {label: case}, perform)
    return Findings(VERSIONS, {"mujoco": study})


STUDIES = [swept, recommended, limited, ablated, of_releases]
every_study = pytest.mark.parametrize("study", STUDIES)


@pytest.fixture
def runs_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """The exact motion is not compared with its own equations: a run has to show the contradiction."""
    monkeypatch.setattr(reference_guard, "reference_misfit", lambda _: {})


@every_study
def test_healthy_study_is_trusted(study: Callable[[Scene], Findings[Any]]) -> None:
    found = study(Saw())
    assert found.passed is (True if study is recommended else None)
    assert "TRUSTED" not in f"{found.text} {found.verdict}"
    assert all(one.distrust == "" for one in found.values())


@every_study
@pytest.mark.usefixtures("runs_alone")
def test_study_with_a_wrong_closed_form_fails(study: Callable[[Scene], Findings[Any]], tmp_path: Path) -> None:
    found = study(WrongSaw())
    assert found.passed is False
    assert found.text.strip().startswith(f"{ACCUSATION} ")
    assert f" {MUJOCO.version}: {REASON}: position by " in found.text
    assert ACCUSATION in found.verdict.splitlines()[0]
    assert REASON in found.json
    _, first, *_ = filter(None, found.write(tmp_path / "report").read_text(encoding="utf-8").splitlines())
    assert first.startswith(ACCUSATION)


@every_study
def test_first_page_of_several_parts_begins_with_the_distrust(
    study: Callable[[Scene], Findings[Any]], tmp_path: Path
) -> None:
    found = study(WrongSaw())
    if found.kind.one_part:
        pytest.skip("a recommendation has one page")
    (part,) = found.values()
    page = Findings(found.kind, {"a": part, "b": part}).write(tmp_path / "report")
    _, first, *_ = filter(None, page.read_text(encoding="utf-8").splitlines())
    assert (page.name, first.startswith(ACCUSATION)) == ("README.md", True)


@every_study
def test_study_fails_whose_kept_runs_show_nothing(
    study: Callable[[Scene], Findings[Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Runs from a ledger of before have no misfit: the exact motion's own contradiction is still seen."""
    planted = {"velocity": {"difference": 1e-6, "allowed": 1e-12, "angle": 0.0}}
    monkeypatch.setattr(reference_guard, "reference_misfit", lambda _: planted)
    found = study(Saw())
    assert found.passed is False
    assert found.text.strip().startswith(f"{ACCUSATION} ")
    assert f" {MUJOCO.version}: {REASON}: velocity by 1e-06" in found.text


@pytest.mark.usefixtures("runs_alone")
def test_guard_names_each_scene_and_engine_once() -> None:
    guard, misfit = ReferenceGuard(), {"position": {"difference": 1e-6, "allowed": 1e-12, "angle": 0.0}}
    settings = [engine_named(name).presets["tuned"](Saw(), 100) for name in ("mujoco", "pymunk", "mujoco")]
    cases = [RunCase(name, Saw(), one) for name in ("a", "b") for one in settings]
    errors: Mapping[str, Any] = {"C": {"position": {"max": 1e-6}}}
    guard.check(cases, {case.key: RunResult("completed", errors=errors) for case in cases})
    assert guard.distrust == ""
    guard.check(cases[:3], {case.key: RunResult("completed", errors=errors, misfit=misfit) for case in cases})
    pymunk = engine_named("pymunk").version
    assert guard.distrust.startswith(f"a in MuJoCo {MUJOCO.version} and pymunk {pymunk}: {REASON}")
    assert guard.distrust.count("MuJoCo") == 1
    guard.check(cases, {case.key: RunResult("completed", errors=errors, misfit=misfit) for case in cases})
    assert "; b in MuJoCo" in guard.distrust


def test_run_that_did_not_complete_is_not_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reference_guard, "reference_misfit", lambda _: pytest.fail("there is no figure to trust"))
    guard, case = ReferenceGuard(), RunCase(NAME, Saw(), MUJOCO.presets["tuned"](Saw(), 100))
    guard.check([case], {case.key: RunResult("exploded", "planted")})
    assert guard.distrust == ""


def test_limit_run_keeps_a_misfit_only_of_a_contradiction() -> None:
    def measured(scene: Scene) -> RunResult:
        setup = Setup(NAME, scene, "mujoco", "tuned", 100)
        return LimitCase(NAME, scene, setup.settings()).perform()

    assert measured(Saw()).misfit is None
    assert "position" in (measured(WrongSaw()).misfit or {})


def test_merged_limits_keep_the_distrust_of_parts_that_stay() -> None:
    (doubted,) = limited(WrongSaw()).values()
    (healthy,) = limited(Saw()).values()
    assert merge_studies(doubted, healthy).distrust == ""
    assert merge_studies(doubted, replace(healthy, walks=())).distrust == doubted.distrust


# -- the command line --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("verb", ["sweep", "limits", "ablate", "versions", "recommend"])
@pytest.mark.parametrize("healthy", [True, False])
def test_verb_exits_with_1_without_trust(verb: str, healthy: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    made = {"sweep": swept, "limits": limited, "ablate": ablated, "versions": of_releases, "recommend": recommended}
    found = made[verb](Saw() if healthy else WrongSaw())
    arguments = [verb, *(["mujoco"] if verb == "versions" else []), "saw-500rpm"]
    if verb == "recommend":
        arguments += ["--position", "1e-2"]
        monkeypatch.setattr("conrod.studies.sweep.api.cheapest_settings", lambda *_, **__: [])
        monkeypatch.setattr("conrod.studies.sweep.api.findings_of", lambda *_, **__: found)
    else:
        monkeypatch.setattr(f"conrod.studies.{verb}.api.{verb}", lambda *_, **__: found)
    ended = conrod(*arguments)
    assert ended.returncode == (0 if healthy else 1), ended
    assert ended.stdout.startswith(ACCUSATION) is not healthy


def test_recommend_writes_no_model_without_trust(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for scene, written in ((Saw(), True), (WrongSaw(), False)):
        answers = pursue(recommendation_studies(small_plan(scene), {"position": 1e-2}, pretended_times, {}), performed)
        monkeypatch.setattr("conrod.studies.sweep.api.cheapest_settings", lambda *_, found=answers, **__: found)
        model = tmp_path / f"{written}.xml"
        ended = conrod("recommend", "saw-500rpm", "--position", "1e-2", "--model", str(model))
        assert (ended.returncode == 0, model.exists()) == (written, written)
    assert "no model is written: its figures cannot be trusted" in ended.stderr
