"""The figures of limits: boundaries are drawn where they are, quiet runs stand out, every failure has its mark."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import pytest
from limit_walks import (
    detected,
    listed,
    pose_walks,
    probe,
    saved,
    steps_walks,
    walked,
)
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from conrod.report.charts.canvas import drawing_style
from conrod.report.charts.styles import OUTCOME_MARKS
from conrod.report.limits.charts import UNDETECTED_COLOUR, error_chart
from conrod.runs.trajectory import Outcome
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.results import Walk


def panels(walks: Sequence[Walk]) -> list[Axes]:
    with drawing_style():
        return error_chart(walks).axes


def drawn(lines: Iterable[Line2D]) -> int:
    """Places of curves that have a mark."""
    return sum(int(np.isfinite(np.asarray(line.get_ydata(), dtype=float)).sum()) for line in lines)


def reds(axes: Axes) -> list[Line2D]:
    """Runs that are drawn as undetected: rings on curves, and red marks above."""
    return [line for line in axes.lines if line.get_color() == UNDETECTED_COLOUR]


def test_undetected_runs_stand_out_and_only_they() -> None:
    walks = steps_walks()
    undetected = sum(probe.undetected for walk in walks for probe in walk.probes)
    assert drawn(reds(panels(walks)[0])) == undetected > 0
    assert reds(panels(detected(walks))[0]) == []


def test_every_run_is_drawn_and_every_way_of_failing_has_its_mark() -> None:
    walks = steps_walks()
    probes = [probe for walk in walks for probe in walk.probes]
    (axes,) = panels(walks)
    # Above the panel are marks alone, those of a look as one line.
    marks = [line for line in axes.lines if line.get_marker() in OUTCOME_MARKS.values() and not line.get_clip_on()]
    assert drawn(marks) == sum(probe.position is None for probe in probes)
    ended = {probe.outcome for probe in probes} - {"completed"}
    assert {line.get_marker() for line in marks} == {OUTCOME_MARKS[outcome] for outcome in ended}
    curves = [x for x in axes.lines if x not in (*marks, *reds(axes)) and x.get_marker() != "None"]
    assert drawn(curves) == sum(probe.position is not None for probe in probes)


def test_every_failure_has_a_mark_of_its_own() -> None:
    failures = {outcome.slug for outcome in Outcome} - {Outcome.COMPLETED.slug}
    assert set(OUTCOME_MARKS) == failures
    assert len(set(OUTCOME_MARKS.values())) == len(failures)


@pytest.mark.parametrize("axis", AXES.values(), ids=lambda axis: axis.name)
def test_every_axis_can_be_drawn_from_end_to_end(axis: Axis) -> None:
    if axis.scale is Scale.LISTED:
        walk = listed(axis.name, "mujoco", "stock", [probe(v, "safe", "completed", False, 1e-3) for v in (0.0, 1.0)])
    else:
        part = (axis.failing_end, "safe", "completed", False, 1e-3)
        walk = walked(axis.name, "mujoco", "stock", axis.safe_end, [part], axis.scale)
    (axes,) = panels([walk])
    assert axis.label in axes.get_xlabel()
    low, high = sorted(axes.get_xlim())
    assert 2 <= sum(low <= tick <= high for tick in axes.get_xticks()) <= 16


# -- errors along an axis ----------------------------------------------------------------------------------------------


def test_the_drive_torque_has_a_panel_where_it_is_known() -> None:
    axes = panels([walk for walk in saved().walks if walk.axis == "regularisation"])
    assert [a.get_ylabel() for a in axes] == ["drive torque error, max / peak", "position error, max / L"]
    # Negative control: steps have no torque, and no empty panel either.
    assert len(panels(steps_walks())) == 1


def test_runs_of_a_list_that_did_not_complete_stand_above_it() -> None:
    def above(walks: Sequence[Walk]) -> int:
        return drawn(line for line in panels(walks)[0].lines if line.get_marker() == OUTCOME_MARKS["flipped"])

    assert above(pose_walks()) == 3
    assert above(pose_walks()[1:]) == 0
