"""The cams of document 004 in the engines: the families that are run, what is measured, and the committed report."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from catalogue import CAMS

from audits.cam_runs import (
    EXACT,
    EXACT_MEAN,
    FINE_DEGREES,
    STEPS,
    CamFamily,
    CamRun,
    cam_run,
    engine_lift,
    families,
    mark_degrees,
    mean_motion,
)
from audits.cam_survey import cams, surveys
from audits.cams import PART
from audits.documents.arc_cam import ArcCam
from audits.report.cam_motion import exact_curve, printed_marks
from audits.report.cams import CAMS_REPORT, errors_table, rates_table, verdict_text
from conrod.engines import engine_named
from conrod.execution.case import pursue
from conrod.execution.result import Plan
from conrod.report.folder import restore_findings
from conrod.report.kind import Part
from conrod.report.table import cell_text
from conrod.report.writer import render_again
from conrod.studies.validation.study import validation_study

COMMITTED = Path(__file__).parents[2] / "reports" / "cams"
PYMUNK = engine_named("pymunk")
EXTREME = ArcCam(36.0, 118.0)


# -- what is run and measured ------------------------------------------------------------------------------------------


def test_families_have_the_25_cams_of_the_document() -> None:
    found = families(cams())
    assert len(found) == 25
    assert "cam-follower-base_radius=76mm-flank_radius=92.5mm" in found
    sizes = {
        tuple(round(one.parameters[name], 9) for name in ("base_radius", "flank_radius")) for one in found.values()
    }
    assert sizes == {(round(cam.base_radius, 9), round(cam.flank_radius, 9)) for cam in CAMS.values()}


def test_mean_rates_of_a_parabola_are_its_derivatives() -> None:
    degrees = np.array([10.0, 200.0])
    lift, velocity, acceleration = mean_motion(lambda angle: 3.0 * angle**2, degrees)
    assert np.allclose(lift, 3.0 * np.radians(degrees) ** 2)
    assert np.allclose(velocity, 6.0 * np.radians(degrees))
    assert np.allclose(acceleration, 6.0)


def test_exact_curve_has_both_values_of_a_jump() -> None:
    degrees, acceleration = exact_curve(EXTREME, 2)
    (at,) = np.flatnonzero(np.diff(degrees)[:150] == 0.0)[1:2]
    assert degrees[at] == pytest.approx(EXTREME.joint_c)
    assert acceleration[at] > 50.0
    assert acceleration[at + 1] == pytest.approx(-395.242, abs=0.001)


def test_printed_extremes_are_those_of_the_text() -> None:
    found = printed_marks()
    assert (36.0, 118.0, "velocity", 162.244, 86.744) in found
    assert (36.0, 118.0, "velocity", 197.772, -86.744) in found
    assert (36.0, 118.0, "acceleration", 180.0, -248.421) in found
    assert (36.0, 118.0, "jerk", 163.323, -89.616) in found
    assert len(found) == len(set(found)) == 15


def cam_in_pymunk(monkeypatch: pytest.MonkeyPatch, slip: float) -> CamRun:
    """Findings on the extreme cam, of which the engine has flanks that are longer by a slip [m]."""
    run = PYMUNK.run

    def run_slipped(self: Any, machine: Any, *arguments: Any, **more: Any) -> Iterator[Any]:
        return run(machine.with_parameters(flank_radius=machine.flank_radius + slip), *arguments, **more)

    with monkeypatch.context() as patch:
        patch.setattr(type(PYMUNK), "run", run_slipped)
        study = validation_study(families((EXTREME,)), [PYMUNK], {"pymunk": ("tuned",)}, Plan(1500, 2.0))
        ((found,),) = pursue([study], lambda cases: {case.key: case.perform() for case in cases})
        return cam_run(found, [PYMUNK], 1500)


def test_cam_with_a_slip_of_a_millimetre_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    right, wrong = (cam_in_pymunk(monkeypatch, slip) for slip in (0.0, 1e-3))
    family = CamFamily({"pymunk": "1"}, 1500, (right,))
    assert (family.passed, verdict_text(family)) == (True, "All 1 cams are within tolerance in pymunk 1.")
    exact = right.peaks[EXACT_MEAN]
    assert right.peaks["pymunk"][0] == pytest.approx(exact[0], rel=0.05)
    family = replace(family, cams=(replace(right, flank=108.0), wrong))
    assert family.passed is False
    assert verdict_text(family) == "OUT OF TOLERANCE in pymunk 1: 1 of 2 cams: R = 36, rho = 118 mm."
    assert [cell_text(row[-1]) for row in errors_table(family).rows] == ["within tolerance", "OUT OF TOLERANCE: pymunk"]
    lost = replace(right, errors={"pymunk": None}, passed={"pymunk": False}, peaks={EXACT: exact, EXACT_MEAN: exact})
    family = replace(family, cams=(lost,))
    assert cell_text(errors_table(family).rows[0][2]) == "did not complete"
    assert [cell_text(cell) for cell in rates_table(family, "velocity").rows[0][4:]] == ["n/a", "86.744"]


# -- the committed report ----------------------------------------------------------------------------------------------


def committed() -> CamFamily:
    values = json.loads((COMMITTED / CAMS_REPORT.data_file(PART)).read_text(encoding="utf-8"))
    found: CamFamily = restore_findings(CAMS_REPORT.findings, values)
    return found


def contradictions(family: CamFamily) -> list[str]:
    """Cams whose exact peaks are not those of the audit, or whose engines' peaks are off from the exact ones."""
    exact = {(one.base, one.flank): one.exact_peak[1:3] for one in surveys()}
    found = []
    for cam in family.cams:
        engines = [cam.peaks[name] / cam.peaks[EXACT_MEAN] - 1.0 for name in family.engines]
        if not np.allclose(cam.peaks[EXACT], exact[cam.base, cam.flank], rtol=1e-3) or np.abs(engines).max() > 0.02:
            found.append(f"{cam.base:g} {cam.flank:g}")
    return found


def test_committed_report_has_every_cam_within_tolerance() -> None:
    family = committed()
    assert (len(family.cams), family.steps, list(family.engines)) == (25, STEPS, ["mujoco", "pymunk"])
    assert {(cam.base, cam.flank) for cam in family.cams} == {(cam.base, cam.flank) for cam in cams()}
    assert all(passed is True for cam in family.cams for passed in cam.passed.values())
    assert contradictions(family) == []
    # Negative control: an engine that is 3 % too fast.
    cam = family.cams[0]
    fast = replace(cam, peaks={**cam.peaks, "pymunk": 1.03 * cam.peaks["pymunk"]})
    assert contradictions(replace(family, cams=(fast,))) == ["36 72.5"]


def test_committed_page_of_cams_is_what_its_numbers_give() -> None:
    part = Part(PART, committed(), "make cams", "")
    assert CAMS_REPORT.page_of(part).text == (COMMITTED / "README.md").read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_committed_cam_run_again_has_its_numbers(engine: str) -> None:
    (kept,) = (cam for cam in committed().cams if (cam.base, cam.flank) == (EXTREME.base, EXTREME.flank))
    lift = engine_lift(EXTREME.scene, engine, STEPS)
    assert lift is not None
    peaks = np.abs(mean_motion(lift, FINE_DEGREES)[1:]).max(axis=1)
    assert np.allclose(peaks, kept.peaks[engine], rtol=5e-4)
    at = mark_degrees(engine)
    assert np.allclose(
        mean_motion(lift, np.where(at < 180.0, at + 360.0, at)), kept.marks[engine], rtol=0.0, atol=0.051
    )


@pytest.mark.slow
def test_committed_figures_of_cams_are_drawn_again_alike(tmp_path: Path) -> None:
    (batch,) = render_again(COMMITTED, tmp_path)
    drawn = {name: text for name, text in batch.files.items() if name.endswith(".svg")}
    assert len(drawn) == 8
    assert {name for name, text in drawn.items() if (COMMITTED / name).read_text(encoding="utf-8") != text} == set()
