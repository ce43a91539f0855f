"""The figure of motion: samples lie on the exact line unless they are off, and extremes are those of the machine."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes

from conrod.exact.motion import QUANTITIES
from conrod.report.charts.canvas import drawing_style
from conrod.report.folder import restore_findings
from conrod.report.kind import Part
from conrod.scenes import SCENES, catalogue_names, scene_named
from conrod.studies.validation.motion_chart import motion_figure
from conrod.studies.validation.motion_curves import PAGE_UNITS, DrawnTurn, motion_words
from conrod.studies.validation.report import VALIDATION_REPORT, figures
from conrod.studies.validation.results import PointSamples, SceneStudy

REPORTS = Path(__file__).parents[2] / "reports"
QUICK = ("geneva", "planetary-gear", "six-bar")
OTHERS = sorted({*catalogue_names()} - {*QUICK})
MAX_BYTES = 60_000  # of a figure
# Share of a panel's height that rounding of saved and drawn digits, and straight lines from degree to degree, make.
DRAWN_SHARE = 1e-3


def committed_study(name: str) -> SceneStudy:
    return restore_findings(SceneStudy, json.loads((REPORTS / "data" / f"{name}.json").read_text(encoding="utf-8")))


def with_judged_runs_alone(study: SceneStudy) -> SceneStudy:
    return replace(study, results=tuple(run for run in study.results if run.samples and run.limits))


def with_offset(study: SceneStudy, share: float) -> SceneStudy:
    """The study with all samples off by a share of the exact motion's span."""
    exact = study.scene.motion(np.linspace(0.0, 2.0 * np.pi, 3601), study.scene.speed).point(study.scene.output)
    off = {q: share * np.ptp(getattr(exact, q), axis=0).max() for q in QUANTITIES}
    moved = [
        {q: PointSamples(one.angle, one.x + off[q], one.y + off[q]) for q, one in (run.samples or {}).items()}
        for run in study.results
    ]
    runs = zip(study.results, moved, strict=True)
    return replace(study, results=tuple(replace(run, samples=samples) for run, samples in runs))


def largest_distance_from_line(axes: Axes) -> float:
    """Largest vertical distance of a panel's marks from its exact line, over the line's height."""
    exact, _, *marked = axes.lines
    at, line = (np.asarray(one, dtype=float) for one in (exact.get_xdata(), exact.get_ydata()))
    known = np.isfinite(line)
    height = np.ptp(line[known])
    off = [np.abs(one.get_ydata() - np.interp(one.get_xdata(), at[known], line[known])) for one in marked]
    return float(max(np.max(one, initial=0.0) for one in off) / height)


@pytest.mark.parametrize("name", SCENES)
def test_marks_of_judged_runs_lie_on_the_exact_line(name: str) -> None:
    study = with_judged_runs_alone(committed_study(name))
    assert len(study.results) >= 2
    judged = QUANTITIES[:2] if name == "cam-follower" else QUANTITIES  # accelerations of a contact are not judged
    with drawing_style():
        right, wrong = (motion_figure(one).axes for one in (study, with_offset(study, 0.01)))
    for k, quantity in enumerate(judged):
        allowed = max(run.limits.get(quantity, run.limits["position"]) for run in study.results)
        off = [largest_distance_from_line(panels[k]) for panels in (right, wrong)]
        assert off[0] < DRAWN_SHARE + allowed
        # Negative control: an offset of 1 % is seen.
        assert off[1] > 0.009 > DRAWN_SHARE + allowed


def test_an_extreme_is_that_of_the_machine() -> None:
    press = motion_words(SceneStudy("shear-press", SCENES["shear-press"], ()))
    # Rod minus and plus crank, at the dead centres; -r w^2 (1 + r / l) at the upper one.
    assert "position [mm] y from 357.5 at 180.0 deg to 422.5 at 0.0 deg" in press
    assert "acceleration [m/s²] y from -1.164 at 0.0 deg" in press
    assert "jerk" not in press
    cam = motion_words(SceneStudy("cam-follower", SCENES["cam-follower"], ()))
    assert "position [mm] y from 45 at 0.0 deg to 118 at 180.0 deg" in cam
    assert "jerk [m/s³] y from" in cam
    # A dwell begins where its law ends, however flat that is.
    dwelling = motion_words(SceneStudy("cam", scene_named("cam-4-5-6-7"), ()))
    assert "position [mm] y from 85 at 0.0 deg to 118 at 120.0 deg" in dwelling


def test_crank_angles_are_negative_if_the_crank_turns_back() -> None:
    scene = SCENES["saw-500rpm"]
    forward, backward = (
        DrawnTurn.from_study(SceneStudy("saw", one, ())) for one in (scene, scene.with_parameters(speed=-scene.speed))
    )
    assert (forward.printed_ends, backward.printed_ends) == ((0.0, 360.0), (0.0, -360.0))
    for a, b in zip(forward.curves["position"][0].extremes, backward.curves["position"][0].extremes, strict=True):
        assert b == pytest.approx((a[0] - 2.0 * np.pi, a[1]), abs=1e-9)


@pytest.mark.parametrize("name", [*SCENES, *QUICK, *(pytest.param(n, marks=pytest.mark.slow) for n in OTHERS)])
def test_extremes_bound_the_exact_motion_of_a_machine(name: str) -> None:
    scene = scene_named(name)
    turn = DrawnTurn.from_study(SceneStudy(name, scene, ()))
    motion = scene.motion(np.linspace(*sorted(turn.ends), 3601), scene.speed).point(scene.output)
    assert ("jerk" in turn.curves) is name.startswith("cam")
    for quantity, curves in turn.curves.items():
        for curve in curves:
            values = PAGE_UNITS[quantity][1] * getattr(motion, quantity)[:, curve.component]
            (_, least), (_, most) = curve.extremes
            slack = 1e-5 * (most - least) + curve.noise
            # At a jump an extreme is the limit, which samples come near to.
            near = slack + (2e-2 if scene.break_angles() else 1e-3) * (most - least)
            assert least - slack <= values.min() <= least + near
            assert most + slack >= values.max() >= most - near


def motion_svg(study: SceneStudy) -> str:
    return figures(study)["motion"].svg()


def test_figure_ignores_last_bits_and_shows_an_offset() -> None:
    study = committed_study("saw-500rpm")
    svg = motion_svg(study)
    assert motion_svg(with_offset(study, 1e-14)) == svg != motion_svg(with_offset(study, 0.01))


def test_report_of_before_has_the_exact_line_alone() -> None:
    study = committed_study("shear-press")
    before = replace(study, results=tuple(replace(run, samples=None) for run in study.results))
    said = ["Marks are samples" in VALIDATION_REPORT.page_of(Part("", one, "", "")).text for one in (study, before)]
    assert said == [True, False]
    with drawing_style():
        assert [len(axes.lines) for axes in motion_figure(before).axes] == [2, 2, 2]


def test_runs_take_turns_so_that_marks_stay_apart() -> None:
    study = committed_study("saw-40rpm")
    at = np.sort(np.concatenate([run.samples["position"].angle for run in study.results if run.samples]))
    assert len(at) > 40
    assert np.degrees(np.diff(at)).min() > 7.0


def test_committed_figures_of_motion_are_small() -> None:
    files = list(REPORTS.rglob("*-motion.svg"))
    assert len(files) >= len(SCENES)
    texts = {file.name: file.read_text(encoding="utf-8") for file in files}
    assert [name for name, text in texts.items() if len(text.encode()) > MAX_BYTES] == []
    assert [name for name, text in texts.items() if "-0.0 " in text or "e-1" in text] == []
