"""The report: what it says of a result, and what it leaves alone."""

from __future__ import annotations

import json
import math
import os
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import conrod
from conrod.exact.motion import QUANTITIES
from conrod.execution.writing import write_together
from conrod.report import numbers
from conrod.report.figure import Figure
from conrod.report.kind import Part, Reproduction
from conrod.report.writer import report_batch
from conrod.scenes import SCENES
from conrod.studies.validation.report import VALIDATION_REPORT, heading
from conrod.studies.validation.results import Curve, RefinementPoint, SceneStudy, Tolerance, ValidationResult
from tests.report.test_frame import contents

COMMAND = Reproduction("conrod validate {scene} --out reports")
ALL = sorted(SCENES)


def a_result(name: str, size: float = 1e-6, engine: str = "mujoco", preset: str | None = "tuned") -> ValidationResult:
    """A run that is off by about `size`, without any engine."""
    scene = SCENES[name]
    shape = size * (1.0 + 0.5 * np.sin(np.arange(60)))
    norm = {"max": 1.5 * size, "rms": size, "final": 0.5 * size}
    steps = (125, 250, 500, 1000)
    return ValidationResult(
        scene=name,
        parameters=scene.parameters,
        engine=engine,
        engine_version="1.2.3",
        preset=preset,
        settings={"preset": preset, "steps_per_revolution": 1000, "timestep": 1e-3, "solref": [0.02, 1.0]},
        mode="dynamic",
        steps_per_revolution=1000,
        revolutions=2.0,
        outcome="completed",
        reason="",
        errors={p: dict.fromkeys((*QUANTITIES, "total"), norm) for p in scene.lengths},
        closure=dict.fromkeys(QUANTITIES, size),
        phase={"max": 1e-14, "final": 1e-14},
        drive={"speed": 0.0, "acceleration": 1e-15},
        order=dict.fromkeys(QUANTITIES, 2.0),
        tolerance=Tolerance(position=1e-5, reason="a law of this test"),
        passed=True,
        refinement=tuple(RefinementPoint(n, "completed", *(3 * [size * (1000 / n) ** 2])) for n in steps),
        curves={p: dict.fromkeys(QUANTITIES, Curve(np.linspace(0.0, 4.0 * np.pi, 60), shape)) for p in scene.lengths},
    )


def incomplete_run(name: str, outcome: str, reason: str, passed: bool | None) -> ValidationResult:
    """A run that did not complete: it has no figures."""
    none = dict.fromkeys(("errors", "closure", "phase", "drive", "order", "curves"))
    run = a_result(name, preset="hardened")
    return replace(run, outcome=outcome, reason=reason, passed=passed, refinement=(), **none)


def a_study(name: str, *results: ValidationResult) -> SceneStudy:
    return SceneStudy(name, SCENES[name], results or (a_result(name), a_result(name, 1e-4, "pymunk", "stock")))


def page_of(study: SceneStudy, command: str = "conrod validate saw-40rpm --out reports") -> str:
    return VALIDATION_REPORT.page_of(Part(study.name, study, command, "0.0.0")).text


def figures(study: SceneStudy) -> dict[str, Figure]:
    """The figures of a scene's page by name."""
    drawn = VALIDATION_REPORT.page_of(Part(study.name, VALIDATION_REPORT.prepare_to_save(study), "", "0.0.0")).figures
    return {figure.name.removeprefix(f"{study.name}-"): figure for figure in drawn}


def write_report(folder: Path, *studies: SceneStudy) -> None:
    write_together([report_batch(VALIDATION_REPORT, {study.name: study for study in studies}, folder, COMMAND)])


def last_bits_changed(result: ValidationResult) -> ValidationResult:
    """The same run as another machine would compute it."""

    def other(curve: Curve) -> Curve:
        noise = 1.0 + 4e-16 * np.resize([1.0, -1.0, 0.0], len(curve.error))
        return Curve(np.nextafter(curve.error_angle, 9.0), curve.error * noise)

    curves = {p: {q: other(c) for q, c in quantities.items()} for p, quantities in result.curves.items()}
    points = tuple(replace(p, **{q: getattr(p, q) * (1.0 + 4e-16) for q in QUANTITIES}) for p in result.refinement)
    return replace(result, curves=curves, refinement=points)


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (None, "n/a"),
        (-2e-13, "< 1e-12"),
        (1e-12, "1.0e-12"),
        (3.8014e-11, "3.8e-11"),
        (9.96e-4, "1.0e-3"),
        (0.0097430, "0.0097"),
        (0.0399, "0.040"),
        (0.999, "1.0"),
        (137.25, "140"),
        (math.nan, "not finite"),
    ],
)
def test_measured_numbers_have_two_significant_digits(value: float | None, shown: str) -> None:
    assert numbers.measured_text(value) == shown


def test_figures_ignore_last_bits_and_show_other_differences() -> None:
    study = a_study("saw-40rpm")
    same = a_study("saw-40rpm", *(last_bits_changed(r) for r in study.results))
    other = a_study("saw-40rpm", a_result("saw-40rpm", 2e-6), study.results[1])
    for name in ("error", "order"):
        svg = figures(study)[name].svg()
        assert svg == figures(same)[name].svg()
        assert svg != figures(other)[name].svg()


@pytest.mark.parametrize(("outcome", "passed"), [("opened", False), ("lost-contact", None)])
def test_incomplete_run_has_an_outcome_and_no_error_figure(outcome: str, passed: bool | None) -> None:
    study = a_study("saw-40rpm", incomplete_run("saw-40rpm", outcome, "seen at 12.5 deg", passed))
    page = page_of(study)
    assert f"{outcome}: seen at 12.5 deg" in page
    assert "No run completed" in page
    assert "saw-40rpm-error.svg" not in page
    assert set(figures(study)) == {"mechanism", "motion"}


# -- writing ---------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("undrawn")
def test_full_disk_leaves_an_existing_report_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    reports = tmp_path / "reports"
    write_report(reports, a_study("saw-40rpm"))
    before = contents(tmp_path)
    fsync, calls = os.fsync, []

    def full(descriptor: int) -> None:
        fsync(descriptor)
        calls.append(descriptor)
        if len(calls) == 5:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match=r"No space.*reports/"):
        write_report(reports, a_study("saw-40rpm", a_result("saw-40rpm", 1e-3)))
    assert contents(tmp_path) == before


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("count", [1, 7])
def test_an_interrupt_between_two_files_waits_for_the_rest(
    count: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    reports = tmp_path / "reports"
    both = [a_study("saw-40rpm", a_result("saw-40rpm", 1e-3)), a_study("cam-follower")]
    write_report(reports, a_study("saw-40rpm"))
    replace_file, calls = os.replace, []

    def interrupted(source: str, target: str, **folders: int) -> None:
        replace_file(source, target, **folders)
        calls.append(target)
        if len(calls) == count:
            raise KeyboardInterrupt

    monkeypatch.setattr(os, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_report(reports, *both)
    assert len(calls) > count
    found = contents(tmp_path)
    write_report(reports, *both)
    assert contents(tmp_path) == found


def index_of(folder: Path) -> str:
    return (folder / "README.md").read_text(encoding="utf-8")


@pytest.mark.usefixtures("undrawn")
def test_the_index_names_a_command_only_if_that_makes_all_of_it(tmp_path: Path) -> None:
    write_report(tmp_path, a_study("saw-40rpm"), a_study("cam-follower"))
    assert "`conrod validate saw-40rpm cam-follower --out reports`" in index_of(tmp_path)
    write_report(tmp_path, a_study("saw-40rpm"))
    assert "`conrod validate" not in index_of(tmp_path)
    assert "each page names its own" in index_of(tmp_path)
    write_report(tmp_path, *(a_study(name) for name in ALL))
    assert "`conrod validate --out reports`" in index_of(tmp_path)


@pytest.mark.usefixtures("undrawn")
def test_the_index_shows_errors_versions_and_what_failed(tmp_path: Path) -> None:
    lost = incomplete_run("cam-follower", "lost-contact", "seen at 12.5 deg", False)
    studies = a_study("saw-40rpm", a_result("saw-40rpm")), a_study("cam-follower", a_result("cam-follower"), lost)
    write_report(tmp_path, *studies)
    index = index_of(tmp_path)
    assert "**Not passed: cam-follower.**" in index
    assert "[cam-follower](cam-follower.md), MuJoCo hardened: failed, lost-contact: seen at 12.5 deg" in index
    assert re.search(r"\| 1\.5e-6 \([\d.e-]+ mm\) \| \*\*lost-contact\*\* \|", index)
    assert f"| numpy | {np.__version__} |" in index


@pytest.mark.usefixtures("undrawn")
def test_saved_findings_are_rounded_and_null_where_missing(tmp_path: Path) -> None:
    lost = incomplete_run("saw-40rpm", "opened", "pin", False)
    write_report(tmp_path, a_study("saw-40rpm", a_result("saw-40rpm", 1.2345678e-6), lost))
    good, bad = json.loads((tmp_path / "data/saw-40rpm.json").read_text(encoding="utf-8"))["results"]
    assert good["errors"]["C"]["position"]["rms"] == 1.23457e-6
    assert good["phase"] == {"max": 0.0, "final": 0.0}
    assert good["parameters"]["offset"] == 0.09
    assert bad["errors"] is None


def test_title_of_a_page_names_changes_of_a_shipped_machine() -> None:
    def title(name: str, **parameters: str) -> str:
        study: Any = SimpleNamespace(name=name, scene=conrod.scene("saw-500rpm", **parameters))
        return heading(study)

    changed = title("saw-500rpm", crank="110mm", speed="320rpm")
    assert changed == "saw-500rpm (crank 110 mm, speed 320 rpm): Power hacksaw (offset slider-crank)"
    # Negative controls: as it ships, the same value given, and a member of a family, which is named by its value.
    plain = "saw-500rpm: Power hacksaw (offset slider-crank)"
    assert title("saw-500rpm") == title("saw-500rpm", crank="10cm") == plain
    assert title("saw-500rpm-crank=110mm", crank="110mm").startswith("saw-500rpm-crank=110mm: ")
