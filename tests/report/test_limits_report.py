"""The report of limits: undetected runs stand out, every run is drawn, and a folder keeps what it holds."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from committed_studies import SCENE, limit_study, of_axis, with_all_detected
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.text import Annotation

from conrod.execution.writing import Batch, write_together
from conrod.report.charts.canvas import drawing_style
from conrod.report.charts.styles import OUTCOME_MARKS
from conrod.report.folder import restore_findings
from conrod.report.kind import Reproduction
from conrod.report.writer import report_batch
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.axis import Axis
from conrod.studies.limits.charts import UNDETECTED_COLOUR, axis_places, error_chart
from conrod.studies.limits.report import LIMITS_REPORT, merge_studies
from conrod.studies.limits.results import LimitStudy, Walk
from conrod.studies.limits.tables import limits_table, undetected_table, undetected_words

COMMAND = Reproduction("conrod limits {scene} --out reports/limits")


def render(study: LimitStudy, folder: Path, command: Reproduction = COMMAND) -> Batch:
    return report_batch(LIMITS_REPORT, {study.name: study}, folder, command)


def panels(walks: Sequence[Walk]) -> list[Axes]:
    with drawing_style():
        return error_chart(walks).axes


def mark_count(lines: Iterable[Line2D]) -> int:
    """Places of curves that have a mark."""
    return sum(int(np.isfinite(np.asarray(line.get_ydata(), dtype=float)).sum()) for line in lines)


def reds(axes: Axes) -> list[Line2D]:
    """Runs that are drawn as undetected: rings on curves, and red marks above."""
    return [line for line in axes.lines if line.get_color() == UNDETECTED_COLOUR]


def test_page_of_an_axis_with_two_values_has_no_figure(tmp_path: Path) -> None:
    whole = of_axis("steps")
    study = replace(whole, walks=tuple(replace(walk, probes=walk.probes[:2]) for walk in whole.walks))
    page = render(study, tmp_path).files[f"{study.name}.md"]
    assert "![" not in page
    assert "![" in render(whole, tmp_path).files[f"{whole.name}.md"]


def test_every_run_is_drawn_by_outcome_and_undetected_in_red() -> None:
    told = of_axis("steps").walks
    walks = [replace(walk, probes=tuple(replace(probe, torque=None) for probe in walk.probes)) for walk in told]
    probes = [probe for walk in walks for probe in walk.probes]
    (axes,) = panels(walks)
    assert len(panels(told)) == 2  # where the drive's torque is known it has a panel
    assert mark_count(reds(axes)) == sum(probe.undetected for probe in probes) > 0
    assert reds(panels(with_all_detected(walks))[0]) == []
    # Above the panel are marks alone, those of a look as one line.
    marks = [line for line in axes.lines if line.get_marker() in OUTCOME_MARKS.values() and not line.get_clip_on()]
    assert mark_count(marks) == sum(probe.position is None for probe in probes)
    ended = {probe.outcome for probe in probes} - {"completed"}
    assert {line.get_marker() for line in marks} == {OUTCOME_MARKS[outcome] for outcome in ended}
    curves = [x for x in axes.lines if x not in (*marks, *reds(axes)) and x.get_marker() != "None"]
    assert mark_count(curves) == sum(probe.position is not None for probe in probes)


def test_lines_of_one_and_ten_per_cent_and_the_sense_are_named() -> None:
    *_, axes = panels(of_axis("steps").walks)
    lines = [line for line in axes.lines if line.get_linestyle() == "--" and len({*line.get_ydata()}) == 1]
    named = {text.get_text(): text.xy[1] for text in axes.texts if isinstance(text, Annotation)}
    assert {"1 % of L", "10 % of L"} <= named.keys()
    heights = sorted(float(line.get_ydata()[0]) for line in lines)
    assert heights == [named["1 % of L"], named["10 % of L"]] == [0.01, 0.1]
    assert axes.get_xlabel().endswith(": safe at the left, failing at the right")
    # Negative control: a list of values has no sense.
    (listed,) = panels(of_axis("start-pose").walks)[-1:]
    assert "safe at the left" not in listed.get_xlabel()
    assert 90.0 in np.diff(listed.get_xticks())


def test_title_names_machine_and_axis_above_the_failed_runs() -> None:
    walks = of_axis("steps").walks
    first, *others = panels(walks)
    title = AXES["steps"].title
    assert first.get_title("left") == f"{SCENE}: {title}"
    assert [axes.get_title("left") for axes in others] == [""] * len(others)
    low = float(first.titleOffsetTrans.transform((0.0, 0.0))[1])
    assert any(probe.errors is None for walk in walks for probe in walk.probes)
    # Negative control: the title of another machine, and one with no failed run above the panel, which stands lower.
    whole = [replace(walk, probes=tuple(p for p in walk.probes if p.errors), scene="shear-press") for walk in walks]
    (other, *_) = panels(whole)
    assert other.get_title("left") == f"shear-press: {title}"
    assert float(other.titleOffsetTrans.transform((0.0, 0.0))[1]) < low


@pytest.mark.parametrize("axis", AXES.values(), ids=lambda axis: axis.name)
def test_every_axis_can_be_drawn_from_end_to_end(axis: Axis) -> None:
    good = replace(next(probe for probe in of_axis("steps").walks[0].probes if probe.good), torque=None)
    ends = (0.0, 1.0) if axis.listed else (axis.safe_end, axis.failing_end)
    (axes,) = panels([Walk(axis.name, SCENE, "mujoco", "stock", "", tuple(replace(good, value=v) for v in ends), ())])
    assert axis.label in axes.get_xlabel()
    low, high = sorted(axes.get_xlim())
    assert 2 <= sum(low <= tick <= high for tick in axes.get_xticks()) <= 16


def test_each_walk_has_a_row_and_wrong_undetected_come_first() -> None:
    walks = [walk for walk in limit_study().walks if walk.probes]
    assert len(limits_table(walks).rows) == len(walks)
    rows = undetected_table(walks).rows
    levels = [str(row[1]).partition(",")[0] for row in rows]
    assert levels == sorted(levels, key=["wrong", "broken", "unbounded"].index)
    # Negative control: there is no row where no run is undetected.
    assert not undetected_table(with_all_detected(walks))
    assert undetected_words(with_all_detected(walks)).startswith("0 of ")


@pytest.mark.usefixtures("undrawn")
def test_pages_state_undetected_runs_first(tmp_path: Path) -> None:
    study = limit_study()
    files = render(study, tmp_path).files
    for name in ("README.md", f"{SCENE}.md"):
        text = str(files[name])
        first = next(line for line in text.splitlines()[1:] if line)
        found = r"\*\*\d+ of \d+ runs were wrong without any warning\.\*\* They lie on \d+ of \d+ walks"
        assert re.match(found, first), name
    runs = study.maps[0].runs
    on_maps = f"On maps of two parameters: {sum(run.undetected for run in runs)} of {len(runs)} runs"
    assert on_maps in str(files[f"{SCENE}.md"])
    # Negative control: nothing is said where nothing is.
    calm = str(render(replace(study, walks=with_all_detected(study.walks), maps=()), tmp_path).files[f"{SCENE}.md"])
    assert "No run was wrong and undetected" in calm
    assert "On maps" not in calm


@pytest.mark.usefixtures("undrawn")
def test_study_of_one_axis_replaces_that_axis_alone(tmp_path: Path) -> None:
    study, again = limit_study(), of_axis("mass-ratio")
    write_together([render(study, tmp_path)])
    walks = (replace(w, probes=tuple(replace(p, reason="new") for p in w.probes)) for w in again.walks)
    command = Reproduction("conrod limits {scene} --axis mass-ratio --out reports/limits")
    batch = render(replace(again, walks=tuple(walks)), tmp_path, command)
    write_together([batch])
    found = restore_findings(LimitStudy, json.loads(str(batch.files[f"data/{SCENE}.json"])))
    assert [(w.axis, w.engine, w.preset) for w in found.walks] == [(w.axis, w.engine, w.preset) for w in study.walks]
    assert {w.axis for w in found.walks if any(p.reason == "new" for p in w.probes)} == {"mass-ratio"}
    assert found.determinism == study.determinism
    assert f"`{COMMAND.command_for(SCENE)}; {command.command_for(SCENE)}`" in str(batch.files[f"{SCENE}.md"])
    # The same study whole again: nothing of the two remains.
    assert command.command_for(SCENE) not in str(render(study, tmp_path).files[f"{SCENE}.md"])


def test_nothing_is_kept_of_another_machine_or_another_engine() -> None:
    study, steps = limit_study(), of_axis("steps")
    assert merge_studies(study, replace(steps, parameters={**study.parameters, "rod": 9.0})).walks == steps.walks
    newer = merge_studies(study, replace(steps, engines={**study.engines, "pymunk": "8.0.0"}))
    assert {walk.axis for walk in newer.walks if walk.engine == "pymunk"} == {"steps"}
    assert {walk.axis for walk in newer.walks if walk.engine == "mujoco"} == {walk.axis for walk in study.walks}


def test_single_value_is_placed_as_it_is_beside_others() -> None:
    alone, beside = (axis_places(AXES["steps"], values)[0] for values in ([2.0], [2.0, 20_000.0]))
    assert alone == pytest.approx(beside, rel=1e-3) == pytest.approx(2.0, rel=1e-3)
