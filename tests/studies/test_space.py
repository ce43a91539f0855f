"""`conrod validate MACHINE --engine ENGINE`: verdicts, what is refused, the report, and an engine that crashes."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from pathlib import Path

import pytest
from command_line import conrod, refusal

import conrod as api
from conrod.comparison.trajectory import Outcome
from conrod.errors import InvalidInput
from conrod.execution.local import FailedCall, LocalProcesses, call_each
from conrod.report.findings import Findings
from conrod.studies.space.report import SPACE_REPORT, cheapest_run, cheapest_words, finding
from conrod.studies.space.results import SpatialResult, SpatialStudy, StepRun

QUICK = ("--preset", "hardened", "--steps-per-rev", "60", "--revolutions", "1")


def test_validate_judges_engines_in_space(tmp_path: Path) -> None:
    asked = ("--engine", "mujoco", *QUICK, "--tolerance", "position=1e-3L", "--out", str(tmp_path / "report"))
    found = conrod("validate", "cardan", *asked)
    assert found.returncode == 0, found.stderr
    assert found.stdout.startswith(
        "Within tolerance: MuJoCo hardened. On cardan the largest position errors over L are: MuJoCo hardened"
    )
    assert "within tolerance" in found.stdout
    page = (tmp_path / "report" / "cardan-space.md").read_text(encoding="utf-8")
    assert "Reproduced by `conrod validate cardan " in page
    tight = conrod("validate", "cardan", "--engine", "mujoco", *QUICK, "--tolerance", "position=1e-9L")
    assert tight.returncode == 1
    assert re.search(r"OUT OF TOLERANCE: position [\d.e-]+ \([\d.e-]+ mm\) > 1\.0e-9", tight.stdout)
    assert tight.stdout.startswith("Within tolerance: none. On cardan")


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (("--engine", "pymunk"), "pymunk: unsupported, it has no runs of machines in space"),
        (("--engine", "mujoco", "--preset", "tund"), "did you mean 'tuned'"),
        (("--engine", "mujoco", "--steps-per-rev", "1"), "steps-per-rev"),
        (("--engine", "mujoco", "--preset", "stock", "--baseline", "b.json"), "--baseline does not go with"),
        (("--engine", "mujoco", "--preset", "stock", "--tolerance", "position=1e-4"), "position=1e-4L"),
        (("--engine", "mujoco", "--steps-per-rev", "2000000"), "too many"),
    ],
    ids=["planar", "preset", "steps", "baseline", "unit", "long"],
)
def test_wrong_wishes_in_space_are_refused(asked: tuple[str, ...], said: str) -> None:
    assert said in refusal("validate", "bennett", *asked)


def test_validate_in_space_refuses_unknown_machines() -> None:
    with pytest.raises(InvalidInput, match="bennett"):
        api.validate_in_space("benett")


def test_a_crash_costs_its_own_call() -> None:
    with LocalProcesses(1) as processes:
        found = list(call_each(processes, _crash_at_two, [1, 2, 3]))
    assert found[0] == 1
    assert found[2] == 3
    assert isinstance(found[1], FailedCall)
    assert found[1].outcome is Outcome.CRASHED


def _crash_at_two(number: int) -> int:
    if number == 2:
        os._exit(3)
    return number


def result(preset: str, *runs: StepRun) -> SpatialResult:
    return SpatialResult(
        scene="m", engine="mujoco", engine_version="4", preset=preset, steps_per_rev=100, revolutions=1, runs=runs,
        outcome=runs[-1].outcome, reason=runs[-1].reason,
    )  # fmt: skip


def run(steps: int, error: float, cost: float) -> StepRun:
    sizes = {"position": error, "velocity": 10.0 * error, "acceleration": 100.0 * error}
    return StepRun(steps, "completed", errors=sizes, gap=error, cost=cost)


def test_cheapest_run_counts_the_cost_of_a_revolution() -> None:
    cheap, fine = result("stock", run(50, 1e-4, 1.0), run(400, 1e-7, 1.0)), result("tuned", run(100, 1e-7, 3.0))
    study = SpatialStudy("m", "M", {}, {}, (cheap, fine))
    found = [cheapest_run(study, bar, ["position"]) for bar in (1e-3, 1e-6, 1e-9)]
    assert [one and one[1].revolution_cost for one in found] == [50.0, 300.0, None]
    assert cheapest_run(study, 1e-6, ["velocity"]) is not None
    assert cheapest_run(study, 1e-6, ["acceleration"]) is None


def test_cheapest_of_costs_that_are_alike_is_the_most_accurate() -> None:
    study = SpatialStudy("m", "M", {}, {}, (result("stock", run(100, 1e-4, 1.0)), result("tuned", run(100, 1e-6, 1.2))))
    found = cheapest_run(study, 1e-3, ["position"])
    assert found is not None
    assert found[0].preset == "tuned"
    said = cheapest_words([study, study])
    assert said.startswith("Cheapest, of 2 machines, for position within 0.001: MuJoCo tuned on 2")
    assert "position within 1e-9: none on 2" in said


def test_finding_names_who_diverges_and_why() -> None:
    failed = StepRun(100, "diverged", "Newton's iteration did not converge")
    studies = [SpatialStudy("m", "M", {}, {}, (result("stock", run(100, 1e-4, 1.0)), result("tuned", failed)))]
    said = finding(studies)
    assert said.startswith("On m the largest position errors over L are: MuJoCo stock 1.0e-4.")
    assert "MuJoCo tuned has no result on m (diverged: Newton's iteration did not converge)" in said


def test_report_in_space_has_a_figure_of_several_steps(tmp_path: Path) -> None:
    scales = {"position": 1.0, "velocity": 1.0, "acceleration": 1.0}
    runs = [run(50, 1e-3, 1.0), run(100, 1e-4, 1.0), run(200, 1e-5, 1.0)]
    studies = {"m": SpatialStudy("m", "M", {"input": "60rpm"}, scales, (result("stock", *runs),))}
    page = Findings(SPACE_REPORT, studies, "call").write(tmp_path / "report")
    assert "m-space.svg" in page.read_text(encoding="utf-8")


def test_short_runs_stay_beside_longer_ones_and_are_named() -> None:
    long = SpatialStudy("m", "M", {}, {}, (result("stock", run(100, 1e-4, 1.0)), result("tuned", run(100, 1e-6, 1.0))))
    short = replace(result("hardened", run(50, 1e-5, 1.0)), steps_per_rev=50)
    assert SPACE_REPORT.merge is not None
    merged = SPACE_REPORT.merge(long, replace(long, results=(short,)))
    assert [one.preset for one in merged.results] == ["stock", "tuned", "hardened"]
    assert "MuJoCo tuned 1.0e-6, MuJoCo hardened 1.0e-5 (at 50 steps), MuJoCo stock 1.0e-4." in finding([merged])
    again = replace(result("stock", run(100, 2e-4, 1.0)))
    assert SPACE_REPORT.merge(merged, replace(long, results=(again,))).results == (*merged.results[1:], again)
    # Errors of more revolutions are others: nothing is kept.
    more = replace(short, revolutions=2)
    assert SPACE_REPORT.merge(long, replace(long, results=(more,))).results == (more,)
