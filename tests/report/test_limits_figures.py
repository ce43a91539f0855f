"""The figures of limits: boundaries are drawn where they are, quiet runs stand out, every failure has its mark."""

from __future__ import annotations

from collections.abc import Sequence

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
from matplotlib.colors import to_hex
from matplotlib.patches import Rectangle

from conrod.report.charts.canvas import drawing_style
from conrod.report.charts.styles import OUTCOME_MARKS
from conrod.report.limits.boundary_chart import TICK_COLOUR, boundary_chart
from conrod.report.limits.error_chart import POSITION, TORQUE, Panel, error_chart
from conrod.report.limits.marks import LEVEL_COLOURS, UNDETECTED_COLOUR
from conrod.runs.trajectory import Outcome
from conrod.studies.limits.axes import AXES, Axis, Scale
from conrod.studies.limits.results import Walk

# -- the boundary chart ------------------------------------------------------------------------------------------------


def charted(walks: Sequence[Walk]) -> Axes:
    with drawing_style():
        figure = boundary_chart(walks)
    return figure.axes[0]


def bars(axes: Axes, lane: int) -> list[tuple[str, float, float]]:
    """Colour, left and right end of the bars of a lane."""
    found = [patch for patch in axes.patches if isinstance(patch, Rectangle)]
    inside = [p for p in found if p.get_y() < lane < p.get_y() + p.get_height()]
    return [(to_hex(p.get_facecolor()), p.get_x(), p.get_x() + p.get_width()) for p in inside]


def test_a_bar_changes_its_colour_at_the_boundary() -> None:
    # Places are decades, so a bar's left end in numbers is its right end in the figure.
    (safe, leaves, first), (rough, breaks, _), (unbounded, last, _) = bars(charted(steps_walks()), 1)
    assert [safe, rough, unbounded] == [LEVEL_COLOURS[level] for level in ("safe", "rough", "unbounded")]
    assert [round(10.0**end, -1) for end in (first, last)] == [20000, 0]
    assert 59.0 < 10.0**leaves < 60.0
    assert 24.0 < 10.0**breaks < 25.0


def red_lines(axes: Axes) -> int:
    return sum(line.get_color() == UNDETECTED_COLOUR for line in axes.lines)


def test_undetected_stretches_stand_out_and_only_they() -> None:
    walks = steps_walks()
    undetected = sum(probe.undetected for walk in walks for probe in walk.probes)
    assert undetected > 0
    assert red_lines(charted(walks)) == 5  # wrong and opened with MuJoCo; wrong, flipped and opened with pymunk
    assert red_lines(charted(detected(walks))) == 0


def test_every_run_is_a_tick_and_every_way_of_failing_has_its_mark() -> None:
    walks = steps_walks()
    axes = charted(walks)
    ticks = sum(len(ticks.get_paths()) for ticks in axes.collections if to_hex(ticks.get_color()[0]) == TICK_COLOUR)
    assert ticks == sum(len(walk.probes) for walk in walks)
    drawn = {line.get_marker() for line in axes.lines} - {"None"}
    ended = {probe.outcome for walk in walks for probe in walk.probes} - {"completed"}
    assert drawn == {OUTCOME_MARKS[outcome] for outcome in ended}


def test_every_failure_has_a_mark_of_its_own() -> None:
    failures = {outcome.slug for outcome in Outcome} - {Outcome.COMPLETED.slug}
    assert set(OUTCOME_MARKS) == failures
    assert len(set(OUTCOME_MARKS.values())) == len(failures)


@pytest.mark.parametrize("axis", AXES.values(), ids=lambda axis: axis.name)
def test_every_axis_can_be_drawn_from_end_to_end(axis: Axis) -> None:
    if axis.scale is Scale.LISTED:
        walks = [listed(axis.name, "mujoco", "stock", [probe(v, "safe", "completed", False, 1e-3) for v in (0.0, 1.0)])]
        with drawing_style():
            figure = error_chart(walks)
        axes = figure.axes[0]
    else:
        part = (axis.failing_end, "safe", "completed", False, 1e-3)
        axes = charted([walked(axis.name, "mujoco", "stock", axis.safe_end, [part], axis.scale)])
    assert axes.get_xlabel() == axis.label
    assert 2 <= len(axes.get_xticks()) <= 16
    low, high = sorted(axes.get_xlim())
    assert all(low <= tick <= high for tick in axes.get_xticks())


# -- errors along an axis ----------------------------------------------------------------------------------------------


def panels(walks: Sequence[Walk], *of: Panel, reference: bool = False) -> list[Axes]:
    with drawing_style():
        figure = error_chart(walks, of or (POSITION,), reference)
    return figure.axes


def test_the_drive_torque_has_a_panel_where_it_is_known() -> None:
    axes = panels([walk for walk in saved().walks if walk.axis == "regularisation"], TORQUE, POSITION)
    assert [a.get_ylabel() for a in axes] == ["drive torque error, max / peak", "position error, max / L"]
    # Negative control: steps have no torque, and no empty panel either.
    assert len(panels(steps_walks(), TORQUE, POSITION)) == 1


def test_runs_of_a_list_that_did_not_complete_stand_above_it() -> None:
    def above(walks: Sequence[Walk]) -> int:
        return sum(line.get_marker() == OUTCOME_MARKS["flipped"] for line in panels(walks)[0].lines)

    assert above(pose_walks()) == 3
    assert above(pose_walks()[1:]) == 0
