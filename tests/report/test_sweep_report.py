"""The report of a sweep: every run is in it, every name is explained, every sentence has its numbers."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import takewhile
from pathlib import Path

import numpy as np
import pytest
from handmade import handmade_sweep
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from conrod.exact.motion import QUANTITIES
from conrod.report import numbers
from conrod.report.charts.canvas import drawing_style, round_to_log_grid
from conrod.report.folder import restore_findings
from conrod.report.kind import Reproduction
from conrod.report.writer import report_batch
from conrod.studies.sweep.findings import SweepStudy, SweptPoint
from conrod.studies.sweep.report import SWEEP_REPORT, work_precision_figure
from conrod.studies.sweep.tables import findings

COMMAND = Reproduction("conrod sweep {scene} --out reports/sweep")


@pytest.fixture(scope="module")
def study() -> SweepStudy:
    return handmade_sweep()


@pytest.fixture(scope="module")
def figure(study: SweepStudy) -> Figure:
    with drawing_style():
        return work_precision_figure(study)


def without_timings(study: SweepStudy) -> SweepStudy:
    return replace(study, points=tuple(replace(p, cost=None, ratio=None) for p in study.points))


# -- the work-precision diagram ----------------------------------------------------------------------------------------


def panel(figure: Figure, quantity: str) -> Axes:
    return next(axes for axes in figure.axes if axes.get_ylabel().startswith(f"{quantity} error"))


def test_the_front_in_the_figure_is_the_front_of_the_data(study: SweepStudy, figure: Figure) -> None:
    for quantity in QUANTITIES:
        for engine, hue in (("mujoco", "#0072B2"), ("pymunk", "#D55E00")):
            # A front by its definition, not by the code that is tested.
            own = [p for p in study.points if p.engine == engine and p.completed]
            front = [p for p in own if not any(beats(other, p, quantity) for other in own)]
            expected = sorted((p.cost or 0.0, p.error(quantity) or 0.0) for p in front)
            lines = [x for x in panel(figure, quantity).lines if (x.get_linewidth(), x.get_color()) == (2.2, hue)]
            assert len(lines) == 1
            assert lines[0].get_xydata() == pytest.approx(round_to_log_grid(np.array(expected)))


def beats(one: SweptPoint, other: SweptPoint, quantity: str) -> bool:
    costs = [(p.cost or 0.0, p.error(quantity) or 0.0) for p in (one, other)]
    return costs[0] != costs[1] and all(a <= b for a, b in zip(*costs, strict=True))


def test_every_run_with_a_cost_is_drawn_and_no_failed_one(study: SweepStudy, figure: Figure) -> None:
    seen = np.concatenate([np.asarray(line.get_xydata()) for line in panel(figure, "position").lines])
    for point in study.points:
        at = round_to_log_grid(np.array([point.cost, point.error("position")], dtype=float))
        assert np.isclose(seen, at, rtol=1e-9).all(axis=1).any() == point.completed, point.label


@pytest.mark.usefixtures("undrawn")
def test_report_without_timings_has_no_diagram_and_no_costs(study: SweepStudy, tmp_path: Path) -> None:
    batch = report_batch(SWEEP_REPORT, {study.name: without_timings(study)}, tmp_path, COMMAND)
    assert "work-precision.svg" not in str(batch.files["saw-500rpm.md"])
    assert "No run was timed" in str(batch.files["saw-500rpm.md"])
    assert not findings(without_timings(study))
    assert findings(study)


# -- the page that explains --------------------------------------------------------------------------------------------

ROOT = Path(__file__).parents[2]
MEASURED_HEAD = "| settings | steps per revolution | position | velocity | acceleration |\n|" + " --- |" * 5 + "\n"


def test_work_precision_page_quotes_measured_values() -> None:
    tables = (ROOT / "docs" / "work-precision.md").read_text(encoding="utf-8").split(MEASURED_HEAD)[1:]
    rows = [row for table in tables for row in takewhile(lambda line: line[:1] == "|", table.splitlines())]
    assert len(rows) > 20
    results = (ROOT / "reports" / "sweep" / "data" / "saw-500rpm.json").read_text(encoding="utf-8")
    points = restore_findings(SweepStudy, json.loads(results)).points
    measured = {f"| {p.rule} | {p.steps_per_revolution} | {' | '.join(quoted_cells(p))} |" for p in points}
    assert [row for row in rows if row not in measured] == []
    # Negative control: another digit is noticed.
    assert rows[0].replace("0.067", "0.068") not in measured


def quoted_cells(point: SweptPoint) -> list[str]:
    if not point.completed:
        return [point.outcome] * len(QUANTITIES)
    return [numbers.measured_text(point.error(quantity)) for quantity in QUANTITIES]
