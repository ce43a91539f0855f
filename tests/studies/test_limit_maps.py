"""Pairs of axes mapped together: what is run, what is told of the rest, and how it is drawn."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise, product

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.path import Path

from conrod.report.charts.canvas import drawing_style
from conrod.report.limits.charts import UNDETECTED_COLOUR
from conrod.report.limits.map_figure import borders, cells, map_figure
from conrod.report.limits.report import KIND
from conrod.scenes import SCENES
from conrod.studies.frame.case import pursue
from conrod.studies.frame.measurement import Measurement
from conrod.studies.limits.case import Setup
from conrod.studies.limits.maps import PAIRS, LimitMap, MapRun, Pair, map_search, standing
from conrod.studies.limits.records import level_of
from conrod.studies.limits.results import LimitStudy

MASSES, NEARNESS, STABILISATION = PAIRS
QUARTER = 0.25
Told = Callable[[float, float], Measurement]  # of steps and of the other axis' value


def case_of(scene: str = "saw-500rpm", engine: str = "mujoco", preset: str = "hardened") -> Setup:
    return Setup(scene, SCENES[scene], engine, preset)


def completed(error: float) -> Measurement:
    sizes = {"max": error, "rms": error, "final": error}
    return Measurement("completed", errors={"C": dict.fromkeys(("position", "velocity", "acceleration"), sizes)})


def at_fewer(steps: float, mass: float) -> Measurement:
    """Order 4; a heavy slider opens the loop at few steps and blows up at still fewer, there by one of two ways."""
    bound = 6.0 + 10.0 * abs(np.log10(mass)) ** 1.5
    if steps > bound:
        return completed(50.0 / steps**4)
    return Measurement("opened") if steps > 0.5 * bound else Measurement(("exploded", "diverged")[int(steps) % 2])


# The case of runs that are made up: its settings ask for no tables of a machine.
MADE_UP = case_of(engine="pymunk", preset="stock")


def mapped(case: Setup, pair: Pair, told: Told, resolution: tuple[int, int] = (65, 33)) -> LimitMap:
    """The map of runs that are made up; nothing is run."""
    x, y = pair.values(case, resolution)
    answers = {pair.case(case, steps, value).key: told(steps, value) for steps, value in product(x, y)}
    return pursue([map_search(case, pair, resolution)], lambda cells: {c.key: answers[c.key] for c in cells})[0]


# -- values and cells --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("scene", "ends"), [("saw-500rpm", (1000.0, 4.0)), ("cam-follower", (20000.0, 80.0))])
def test_steps_are_different_whole_numbers(scene: str, ends: tuple[float, float]) -> None:
    steps, _ = STABILISATION.values(case_of(scene), (65, 33))
    assert (steps[0], steps[-1]) == ends
    assert all(value == round(value) for value in steps)
    assert all(more > fewer for more, fewer in pairwise(steps))
    assert 55 < len(steps) <= 65


def test_a_node_is_made_from_both_axes() -> None:
    case = case_of()
    heavy = MASSES.case(case, 50.0, 100.0)
    assert heavy.settings.steps_per_revolution == 50
    assert heavy.scene.parameters["slider_mass"] == pytest.approx(100.0 * heavy.scene.parameters["rod_mass"])
    near = NEARNESS.case(case, 50.0, 0.5)
    assert near.scene.parameters["offset"] == pytest.approx(0.5 * (0.3 - 0.1))
    soft = STABILISATION.case(case, 50.0, 20.0)
    assert soft.settings.time_constant(contact=False) == pytest.approx(20.0 * soft.settings.timestep)
    assert soft.settings.timestep == pytest.approx(case.scene.period / 50)


def test_a_cam_has_neither_rod_nor_change_point() -> None:
    cam = case_of("cam-follower")
    assert [pair.refusal(cam) is None for pair in PAIRS] == [False, False, True]
    assert all(pair.refusal(case_of()) is None for pair in PAIRS)


# -- searching ---------------------------------------------------------------------------------------------------------


def test_all_nodes_stand_as_on_the_full_grid_for_a_quarter_of_its_runs() -> None:
    found = mapped(MADE_UP, MASSES, at_fewer, (49, 25))
    full = {n: level_of(at_fewer(found.x[n[0]], found.y[n[1]])) for n in product(range(len(found.x)), range(25))}
    assert [n for n, level in full.items() if standing(found.shown[n].level) != standing(level.slug)] == []
    assert found.share <= QUARTER
    assert found.nodes == len(full)
    assert {standing(level.slug) for level in full.values()} == {"safe", "rough", "failed"}


def test_a_real_map_is_safe_at_many_steps_and_fails_at_few() -> None:
    case = case_of()
    found = pursue([map_search(case, MASSES, (3, 3), 1)], lambda cells: {c.key: c.perform() for c in cells})[0]
    assert [found.shown[0, j].level for j in range(3)] == ["safe"] * 3
    assert [standing(found.shown[2, j].level) for j in range(3)] == ["failed"] * 3
    assert all(run.error is not None for run in found.runs if run.level == "safe")


# -- figures -----------------------------------------------------------------------------------------------------------


def drawn(found: LimitMap) -> Figure:
    with drawing_style():
        return map_figure(found)


@pytest.mark.parametrize("undetected", [True, False])
def test_an_undetected_failure_has_a_red_mark(undetected: bool) -> None:
    runs = (MapRun(0, 0, "safe", "completed", False, 1e-3), MapRun(1, 0, "broken", "opened", undetected, None))
    found = LimitMap("saw-500rpm", "mujoco", "tuned", "steps", "mass-ratio", (100.0, 10.0), (1.0, 2.0), runs)
    figure = drawn(found)
    assert [line.get_color() == UNDETECTED_COLOUR for line in figure.axes[0].lines] == [undetected]
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert any("undetected" in text for text in legend) is undetected
    assert KIND.spots is not None
    (spots,) = KIND.spots(LimitStudy("saw-500rpm", "saw", "", {}, {}, (), (found,), (), ())).values()
    said = f"10 steps per revolution, mass of slider : rod 1, broken, opened, {'un' if undetected else ''}detected"
    assert said in {words for *_, words in spots}


def test_cells_and_borders_are_those_of_the_nodes() -> None:
    inside = np.array([[True, True], [True, False], [True, True]])
    x, y = np.arange(4.0), np.arange(3.0)
    rows = [path.get_extents().bounds for path in separate(cells(inside, x, y))]
    assert rows == [(0, 0, 3, 1), (0, 1, 1, 1), (2, 1, 1, 1)]
    sides = {tuple(map(tuple, path.vertices)) for path in separate(borders(inside, x, y))}
    assert sides == {((1, 1), (1, 2)), ((2, 1), (2, 2)), ((1, 1), (2, 1))}


def separate(path: Path) -> list[Path]:
    starts = [*np.flatnonzero(path.codes == Path.MOVETO), len(path.vertices)]
    return [Path(path.vertices[a:b]) for a, b in pairwise(starts)]
