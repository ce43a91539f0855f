"""The figures of limits: boundaries are drawn where they are, quiet runs stand out, every failure has its mark."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from limit_studies import long_run
from limit_walks import (
    Part,
    detected,
    listed,
    mass_walks,
    nearness_walks,
    pose_walks,
    probe,
    regularisation_walks,
    steps_walks,
    walked,
)
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from conrod.report.charts.canvas import drawing_style
from conrod.report.charts.styles import OUTCOME_MARKS
from conrod.report.limits.axis_scale import AxisScale, place
from conrod.report.limits.boundary_chart import TICK_COLOUR, UP, boundary_chart, preset_lanes
from conrod.report.limits.error_chart import POSITION, TORQUE, Panel, error_chart
from conrod.report.limits.long_runs import long_run_figure
from conrod.report.limits.marks import LEVEL_COLOURS, UNDETECTED_COLOUR
from conrod.runs.trajectory import Outcome
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.grade import Level
from conrod.studies.limits.results import Walk

# -- the boundary chart ------------------------------------------------------------------------------------------------


def charted(walks: Sequence[Walk]) -> Axes:
    with drawing_style():
        figure = boundary_chart(preset_lanes(walks))
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


@pytest.mark.parametrize(
    "walks", [steps_walks(), nearness_walks(), regularisation_walks()[:1]], ids=lambda w: w[0].axis
)
def test_the_safe_end_is_on_the_left(walks: Sequence[Walk]) -> None:
    scale = AXES[walks[0].axis].scale
    left, right = charted(walks).get_xlim()
    safe, failing = (place(scale, p.value) for p in (walks[0].probes[0], walks[0].probes[-1]))
    assert abs(left - safe) < abs(left - failing)
    assert abs(right - failing) < abs(right - safe)


def test_two_ways_from_one_value_share_a_bar() -> None:
    axes = charted(mass_walks())
    assert [text.get_text() for text in axes.get_yticklabels()] == ["MuJoCo stock", "pymunk stock"]
    left, right = axes.get_xlim()
    assert left < -6.0 < 6.0 < right
    spans = sorted((start, end) for _, start, end in bars(axes, 0))
    assert all(one[1] == pytest.approx(other[0]) for one, other in pairwise(spans))


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


def test_a_narrow_stretch_has_its_mark_above_it() -> None:
    parts = ((1e3, "safe", "completed", False, 1e-4), (1e6, "broken", "opened", True, None))
    narrow = ((9.5e5, "safe", "completed", False, 1e-4), (1e6, "broken", "opened", True, None))

    def heights(of: Sequence[Part]) -> list[float]:
        axes = charted([walked("mass-ratio", "mujoco", "stock", 1.0, of)])
        lines = [line for line in axes.lines if line.get_marker() == OUTCOME_MARKS["opened"]]
        return [float(np.asarray(line.get_ydata())[0]) for line in lines]

    assert heights(parts) == [0.0]
    assert heights(narrow) == [-UP]


def legend_of(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_the_legend_names_what_occurs_and_nothing_else() -> None:
    with drawing_style():
        figure = boundary_chart(preset_lanes(mass_walks()))
    assert legend_of(figure) == [
        "safe",
        "rough",
        "wrong",
        "unbounded",
        "undetected",
        "exploded",
        "a run",
    ]


def test_levels_are_told_apart_without_colour() -> None:
    def lightness(colour: str) -> float:
        return sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), to_rgb(colour), strict=True))

    shades = [lightness(LEVEL_COLOURS[level.slug]) for level in Level]
    assert all(lighter - darker > 0.1 for lighter, darker in pairwise(shades))


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


def test_nearness_has_ticks_down_to_the_last_nine() -> None:
    scale = AxisScale.of(Scale.NEARNESS, nearness_walks())
    ticks = scale.ticks()
    assert ticks[0] == 0.1
    assert ticks[-1] == pytest.approx(1.0 - 1e-9, abs=1e-12)


# -- errors along an axis ----------------------------------------------------------------------------------------------


def panels(walks: Sequence[Walk], *of: Panel, reference: bool = False) -> list[Axes]:
    with drawing_style():
        figure = error_chart(walks, of or (POSITION,), reference)
    return figure.axes


def test_the_drive_torque_has_a_panel_where_it_is_known() -> None:
    axes = panels(regularisation_walks(), TORQUE, POSITION)
    assert [a.get_ylabel() for a in axes] == ["drive torque error, max / peak", "position error, max / L"]
    # Negative control: steps have no torque, and no empty panel either.
    assert len(panels(steps_walks(), TORQUE, POSITION)) == 1


def test_the_reference_is_drawn_where_it_is_in_doubt() -> None:
    def black(walks: Sequence[Walk]) -> int:
        return sum(line.get_color() == "black" for line in panels(walks, reference=True)[0].lines)

    assert black(nearness_walks()) == 1
    assert black(steps_walks()) == 0


def test_runs_of_a_list_that_did_not_complete_stand_above_it() -> None:
    def above(walks: Sequence[Walk]) -> int:
        return sum(line.get_marker() == OUTCOME_MARKS["flipped"] for line in panels(walks)[0].lines)

    assert above(pose_walks()) == 3
    assert above(pose_walks()[1:]) == 0


def test_long_runs_show_loop_error_and_both_clocks() -> None:
    with drawing_style():
        figure = long_run_figure([long_run("mujoco", "tuned", revolutions=1e6)])
    loop, phase = figure.axes
    assert len(loop.lines) == 1
    assert len([line for line in phase.lines if line.get_color() == "black"]) == 1
    assert len(phase.lines) == 2
    assert loop.get_xlim()[1] > 1e6
