"""Releases of an engine side by side: what changed is seen, what did not is not, and what cannot be had is said."""

from __future__ import annotations

import os
import sys
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from synthetic import completed_result

from conrod.engines import engine_named
from conrod.engines.mujoco import MuJoCoSettings, compat
from conrod.engines.mujoco.model import build, compile_mjcf
from conrod.engines.releases import version_numbers
from conrod.errors import InvalidInput
from conrod.exact.motion import QUANTITIES
from conrod.execution import releases
from conrod.execution.paired_timing import PairedTiming
from conrod.execution.release_costs import BLOCK_TIMEOUT, advance_stepper, prepare_stepper, time_in_releases
from conrod.execution.releases import (
    ReleaseProcesses,
    ReleaseResult,
    VersionCase,
    interpreter_path,
    release_interpreter,
)
from conrod.execution.run import RunResult
from conrod.execution.runner import Runner, Runs
from conrod.report.findings import Findings
from conrod.scenes import SCENES, scene_named
from conrod.studies.versions.report import VERSIONS_REPORT, results_to_print
from conrod.studies.versions.study import (
    LINKAGE_STEPS,
    RunHistory,
    VersionStudy,
    change_between,
    release_cases,
    versions_study,
)

SAW: Any = SCENES["saw-40rpm"]
MUJOCO: Any = engine_named("mujoco")
STATE, OUTPUT = "bodies position", "C acceleration"
DIGIT = 1e-13


def measured(off: float = 0.0, outcome: str = "completed", **bits: str) -> ReleaseResult:
    """A run whose signed errors are all `off`, with a digest for each state and output."""
    named = {name.replace("_", " "): text for name, text in bits.items()}
    if outcome != "completed":
        return ReleaseResult(outcome, "planted", bits=named)
    signed = {"C": {quantity: [[off, 0.0]] for quantity in QUANTITIES}}
    return completed_result(abs(off), ReleaseResult, signed=signed, bits=named)


SAME = measured(0.5, bodies_position="a", C_acceleration="b")


@pytest.mark.parametrize(
    ("other", "differ", "size", "last_digits"),
    [
        (measured(0.5 + DIGIT, bodies_position="x", C_acceleration="b"), (STATE,), DIGIT, True),
        (measured(0.5, bodies_position="a", C_acceleration="x"), (OUTPUT,), 0.0, True),
        (measured(0.5 + 1e-4, bodies_position="x", C_acceleration="b"), (STATE,), 1e-4, False),
        (measured(outcome="opened", bodies_position="a", C_acceleration="b"), (), None, False),
    ],
)
def test_the_same_bits_are_no_change_and_each_other_one_is_seen(
    other: RunResult, differ: tuple[str, ...], size: float | None, last_digits: bool
) -> None:
    assert change_between(SAME, SAME, LINKAGE_STEPS) is None
    found = change_between(SAME, other, LINKAGE_STEPS)
    assert (found.differ, found.last_digits) == (differ, last_digits)
    assert found.outcomes == ("completed", other.outcome)
    assert found.size.get("position") == (None if size is None else pytest.approx(size, rel=1e-3))


def planted(runs: dict[str, RunResult | str]) -> VersionStudy:
    """The study of planted releases: what each run of one shows, or why it cannot be had."""

    def perform(requirement: str, cases: Sequence[VersionCase]) -> Any:
        found = runs[cases[0].version]
        assert requirement.endswith(f"=={cases[0].version}")
        if isinstance(found, str):
            raise InvalidInput(found)
        return {case.key: found for case in cases}

    return versions_study(MUJOCO, list(runs), release_cases({"saw": SAW}, MUJOCO), perform)


def test_study_names_release_of_a_change_and_skips_missing_ones() -> None:
    moved = measured(0.4, bodies_position="x", C_acceleration="y")
    study = planted({"3.5.0": SAME, "3.6.0": SAME, "3.6.5": "no wheel", "3.7.0": moved, "3.7.1": moved, "4.1.0": SAME})
    assert study.measured == ("3.5.0", "3.6.0", "3.7.0", "3.7.1", "4.1.0")
    assert study.unsupported == {"3.6.5": "no wheel"}
    assert {change.version for one in study.histories for change in one.changes} == {"3.7.0", "4.1.0"}
    changes = [change for _, change in study.changes_at("3.7.0")]
    assert {change.before for change in changes} == {"3.6.0"}
    # MuJoCo's changelog names the first; of the second nothing is known.
    assert all("dJ/dt" in change.explained[0] for change in changes)
    assert not any(change.explained for _, change in study.changes_at("4.1.0"))
    with pytest.raises(InvalidInput, match=r"mujoco 4\.1\.0: no network"):
        planted({"4.1.0": "no network"})


def costs(ratios: dict[str, float], noise: float = 0.02) -> VersionStudy:
    """The study of planted costs, by release, with intervals of a planted half-width."""

    def time(case: VersionCase, other: VersionCase) -> PairedTiming:
        if case.version == "3.6.0":
            raise InvalidInput("mujoco 3.6.0: no result after 60 s")
        ratio = ratios[case.version] / ratios[other.version]
        return PairedTiming(ratio, ratio - noise, ratio + noise, 1.0, 1.0, 24)

    cases = release_cases({"saw": SAW}, MUJOCO)
    return versions_study(MUJOCO, list(ratios), cases, lambda _, asked: {case.key: SAME for case in asked}, time)


def test_cost_of_a_release_is_judged_beyond_the_spread_alone() -> None:
    here = MUJOCO.version
    study = costs({"3.5.0": 0.8, "3.6.0": 1.0, "3.7.0": 1.03, here: 1.0, "4.9.0": 1.3})
    found = {one.version: one for one in study.costs if one.settings == "tuned"}
    assert study.reference == here
    assert {version: one.word for version, one in found.items()} == {
        "3.5.0": "faster", "3.6.0": "", "3.7.0": "within the spread", "4.9.0": "slower",
    }  # fmt: skip
    # 3 % is more than the interval of its own, and not more than the installed release shows against itself.
    assert found["3.7.0"].timing.low > 1.0
    assert "no result after 60 s" in found["3.6.0"].reason
    page = "".join(str(part) for part in results_to_print([study]))
    assert all(words in page for words in ("slower", "within the spread", "not timed: mujoco 3.6.0"))
    # Negative control: in a wide spread the same ratios say nothing.
    assert {one.word for one in costs({"3.5.0": 0.8, here: 1.0, "4.9.0": 1.3}, 0.4).costs} == {"within the spread"}


def test_costs_are_relative_to_first_if_not_installed() -> None:
    assert costs({"3.5.0": 1.0, "3.7.0": 1.0}).reference == "3.5.0"
    assert planted({"3.5.0": SAME, "3.7.0": SAME}).costs == ()


def test_only_runs_that_complete_in_both_releases_are_timed() -> None:
    opened = measured(outcome="opened")

    def perform(requirement: str, asked: Sequence[VersionCase]) -> Any:
        return {case.key: opened if requirement.endswith("3.5.0") else SAME for case in asked}

    cases = release_cases({"saw": SAW}, MUJOCO)
    study = versions_study(MUJOCO, ["3.5.0", "3.7.0"], cases, perform, lambda *_: pytest.fail("timed"))
    assert study.costs == ()


def test_release_timer_steps_each_release_in_its_own_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conrod.execution.paired_timing.BLOCK_TIME", 2e-5)
    monkeypatch.setattr("conrod.execution.paired_timing.STEPPER_PAIRS", 1)
    monkeypatch.setattr("conrod.execution.releases.release_interpreter", lambda *_: sys.executable)
    case = replace(release_cases({"saw": SAW}, MUJOCO)["saw", "tuned"], version=MUJOCO.version)
    with ReleaseProcesses("mujoco", MUJOCO.releases.requirement, BLOCK_TIMEOUT) as processes:
        found = time_in_releases(processes, case, case)
        assert (found.rounds, found.low <= found.ratio <= found.high) == (24, True)
        with pytest.raises(InvalidInput, match=f"mujoco {MUJOCO.version}: AttributeError"):
            time_in_releases(processes, replace(case, scene=None), case)


def test_timed_blocks_are_steps_or_whole_passes() -> None:
    for name in ("saw-40rpm", "swinging-four-bar"):
        scene = scene_named(name)
        case = replace(release_cases({name: scene}, MUJOCO)[name, "stock"], version=MUJOCO.version)
        assert prepare_stepper(case) == 0
        assert advance_stepper(case, 2) >= 0


def test_a_case_is_of_its_release_and_keeps_every_bit() -> None:
    made = replace(release_cases({"saw": SAW}, MUJOCO)["saw", "tuned"], settings=MuJoCoSettings.tuned(SAW, 100))
    here, other = (replace(made, version=version) for version in (MUJOCO.version, "3.6.0"))
    assert here.key != other.key
    first, again = here.perform(), here.perform()
    assert change_between(first, again, LINKAGE_STEPS) is None
    heavier = replace(here, scene=SAW.with_parameters(slider_mass=1.001 * SAW.slider_mass)).perform()
    assert change_between(first, heavier, LINKAGE_STEPS) is not None
    with pytest.raises(InvalidInput, match=rf"mujoco {MUJOCO.version} was to run what is for 3\.6\.0"):
        other.perform()


@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_known_releases_are_in_order_and_facts_are_of_them(engine: str) -> None:
    made: Any = engine_named(engine)
    known = made.releases.versions
    assert list(known) == sorted(set(known), key=version_numbers)
    assert made.version in known
    assert {fact.version for fact in made.releases.facts} <= set(known)
    assert made.releases.select_versions("7.3.0, 7.0.0") == ("7.0.0", "7.3.0")
    for wrong, why in {"3.x": "is no version", "": "is no version", "2.1.0": "is older than"}.items():
        with pytest.raises(InvalidInput, match=why):
            made.releases.select_versions(wrong)


def test_model_without_site_equalities_has_the_same_constraint(monkeypatch: pytest.MonkeyPatch) -> None:
    scene: Any = scene_named("six-bar")
    settings = MuJoCoSettings.tuned(scene, 100)
    usual = build(scene, settings).model
    monkeypatch.setattr(compat, "RELEASE", (3, 2, 0))
    changed = build(scene, settings).model
    assert set(usual.eq_objtype) == {int(mujoco.mjtObj.mjOBJ_SITE)}
    assert set(changed.eq_objtype) == {int(mujoco.mjtObj.mjOBJ_BODY)}
    gaps = []
    for model in (usual, changed):
        data = mujoco.MjData(model)
        data.qpos[:] = 0.1
        mujoco.mj_forward(model, data)
        gaps.append(data.efc_pos.copy())
    assert np.abs(gaps[0]).max() > 1e-3
    np.testing.assert_allclose(*gaps, atol=1e-15)
    text = compile_mjcf('<mujoco><option><flag autoreset="disable"/></option></mujoco>')
    assert text.opt.disableflags == 0
    assert compat.adapt_model(ET.Element("mujoco"))


# -- environments ------------------------------------------------------------------------------------------------------


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "conrod" / "environments"


def installing(monkeypatch: pytest.MonkeyPatch, script: str) -> None:
    """Have an environment made whose interpreter is a script of a shell."""

    def make(folder: Path, requirements: Sequence[str]) -> None:
        python = interpreter_path(folder)
        python.parent.mkdir(parents=True)
        python.write_text(f"#!/bin/sh\n{script}\n")
        python.chmod(0o755)

    monkeypatch.setattr(releases, "install_requirements", make)


HERE = f'exec {getattr(sys, "_base_executable", sys.executable)} "$@"'  # which has no packages of its own


def test_environment_is_made_once_for_its_requirements_alone(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    installing(monkeypatch, HERE)
    requirement = MUJOCO.releases.requirement(MUJOCO.version)
    first = release_interpreter("mujoco", requirement, MUJOCO.version)
    # An engine that is another one than its distribution says is not kept.
    with pytest.raises(InvalidInput, match=f"mujoco==3.6.0 calls itself {MUJOCO.version}"):
        release_interpreter("mujoco", "mujoco==3.6.0", "3.6.0")
    installing(monkeypatch, "kill -SEGV $$")
    assert release_interpreter("mujoco", requirement, MUJOCO.version) == first
    # Nor is one that crashes on import.
    with pytest.raises(InvalidInput, match=r"cannot be imported|cannot start"):
        release_interpreter("mujoco", "mujoco==3.6.0", "3.6.0")
    assert [interpreter_path(place) for place in cache.iterdir()] == [Path(first)]


@pytest.mark.parametrize("how", ["open to all", "another user's", "above it is another user's"])
def test_no_engine_is_run_from_a_folder_that_others_write(
    how: str, cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    installing(monkeypatch, HERE)
    requirement = MUJOCO.releases.requirement(MUJOCO.version)
    release_interpreter("mujoco", requirement, MUJOCO.version)
    if how == "open to all":
        cache.parent.chmod(0o777)
    else:
        if os.geteuid() != 0:
            pytest.skip("only root can be two users")
        for place in [tmp_path] if "above" in how else cache.glob("*/bin/python"):
            os.chown(place.parent if place.name == "python" else place, 1002, 1002)
    for wanted in (requirement, "mujoco==3.6.0"):
        if wanted == requirement or how != "another user's":
            with pytest.raises(InvalidInput, match=r"no engine is run from .*(another user|all may write)"):
                release_interpreter("mujoco", wanted, MUJOCO.version)


@pytest.mark.slow
def test_two_real_releases_differ_where_mujoco_says_so(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InvalidInput, match=r"(?i)mujoco==3\.99\.0"):
        release_interpreter("mujoco", "mujoco==3.99.0", "3.99.0")
    try:
        for version in ("3.6.0", "3.7.0"):
            release_interpreter("mujoco", f"mujoco=={version}", version)
    except InvalidInput as error:
        pytest.skip(f"MuJoCo cannot be installed here: {error}")
    planned = release_cases({"saw": SAW}, MUJOCO)
    cases = {key: case for key, case in planned.items() if key[1] in ("tuned", "hardened")}
    with Runner.open(Runs(ledger=cache / "ledger.sqlite", jobs=2)) as runner:
        study = versions_study(MUJOCO, ["3.6.0", "3.7.0"], cases, runner.run_in_release)
        # All is in the ledger now: nothing is installed for it, nothing runs.
        monkeypatch.setenv("XDG_CACHE_HOME", str(cache / "other"))
        installing(monkeypatch, "exit 1")
        assert versions_study(MUJOCO, ["3.6.0", "3.7.0"], cases, runner.run_in_release) == study
    tuned, hardened = study.histories
    assert tuned.changes[0].size["acceleration"] > 1e-4
    assert all(one.changes[0].explained for one in (tuned, hardened))
    before, after = tuned.changes[0].errors
    assert before > 100.0 * after


def test_report_of_a_single_release_is_written(tmp_path: Path) -> None:
    history = RunHistory("saw-500rpm", "tuned", 100, ())
    study = VersionStudy("mujoco", "address", (MUJOCO.version,), {}, (history,))
    page = Findings(VERSIONS_REPORT, {"mujoco": study}).write(tmp_path / "report")
    assert "No release changed a bit." in page.read_text(encoding="utf-8")
