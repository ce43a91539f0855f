"""Pairs of axes mapped together: the map of the full grid, for a quarter of its runs, and how failures are drawn."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Hashable, Sequence
from itertools import product

import numpy as np
import pytest
from cell_tasks import answer_study
from hypothesis import given, settings
from hypothesis import strategies as st

from conrod.report.charts.canvas import drawing_style
from conrod.scenes import SCENES
from conrod.studies.limits import maps
from conrod.studies.limits.case import Setup
from conrod.studies.limits.charts import UNDETECTED_COLOUR
from conrod.studies.limits.map_figure import map_figure
from conrod.studies.limits.report import figure_of_map

# -- searching ---------------------------------------------------------------------------------------------------------


def test_a_real_map_is_safe_at_many_steps_and_fails_at_few() -> None:
    case = Setup("saw-500rpm", SCENES["saw-500rpm"], "mujoco", "hardened")
    steps, _ = maps.grid_values(case, "mass-ratio", (65, 33))
    assert (steps[0], steps[-1]) == (1000.0, 4.0)
    assert all(value == round(value) for value in steps)
    found = answer_study(maps.map_search(case, "mass-ratio", (3, 3), 1))
    assert [found.run_by_node[0, j].level for j in range(3)] == ["safe"] * 3
    assert [maps.map_class(found.run_by_node[2, j].level) for j in range(3)] == ["failed"] * 3
    assert all(run.error is not None for run in found.runs if run.level == "safe")


# -- figures -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("undetected", [True, False])
def test_an_undetected_failure_has_a_red_mark(undetected: bool) -> None:
    runs = (
        maps.MapRun(0, 0, "safe", "completed", False, 1e-3),
        maps.MapRun(1, 0, "broken", "opened", undetected, None),
    )
    found = maps.LimitMap("saw-500rpm", "mujoco", "tuned", "steps", "mass-ratio", (100.0, 10.0), (1.0, 2.0), runs)
    with drawing_style():
        figure = map_figure(found)
    assert [line.get_color() == UNDETECTED_COLOUR for line in figure.axes[0].lines] == [undetected]
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert any("undetected" in text for text in legend) is undetected
    said = f"10 steps per revolution, mass of slider : rod 1, broken, opened, {'un' if undetected else ''}detected"
    assert said in {words for *_, words in figure_of_map(found).laid_out_spots()}


Kind = Callable[[float, float], Hashable]  # class at x, y from 0 to 1
QUARTER = 0.25
ONE_BOUNDARY: dict[str, Kind] = {
    "slanted": lambda x, y: x + 0.6 * y < 0.8,
    "stairs": lambda x, y: x < (0.2, 0.4, 0.7)[min(2, int(3 * y))],
    # Narrower than a coarse cell, it leaves the area that it belongs to through a side without a run.
    "thin tongue": lambda x, y: x < 0.3 or (abs(y - 0.53) < 0.04 and x < 0.83),
    "nothing": lambda x, y: "same",
}
SEVERAL: dict[str, Kind] = {
    "waves": lambda x, y: sum(x * (1.0 + 0.3 * math.sin(3.0 * y)) < edge for edge in (0.1, 0.3, 0.45, 0.7)),
    "a meeting of three": lambda x, y: "a" if x < 0.45 else "b" if y < 0.5 * x else "c",
}


def on_grid(kind: Kind, size: int) -> dict[maps.Node, Hashable]:
    return {(i, j): kind(i / (size - 1), j / (size - 1)) for i, j in product(range(size), repeat=2)}


Classes = dict[maps.Node, Hashable]


def refined(full: Classes, stride: int = maps.COARSE_STRIDE) -> tuple[set[maps.Node], Classes]:
    """The nodes that were run, none of them twice, and the class that every node has or inherits."""
    shape = max(i for i, _ in full) + 1, max(j for _, j in full) + 1
    asked: list[maps.Node] = []
    found: Classes = {}

    def ask(nodes: Sequence[maps.Node]) -> Generator[None, None, Classes]:
        asked.extend(nodes)
        yield
        return {node: full[node] for node in nodes}

    def search() -> Generator[None, None, None]:
        found.update((yield from maps.classify_grid(shape, ask, stride)))

    list(search())
    assert sorted(asked) == sorted(found)
    nearest = maps.nearest_known_nodes(maps.class_numbers(shape, found))
    return set(found), {node: found[tuple(nearest[:, *node].tolist())] for node in full}


@pytest.mark.parametrize(("name", "size"), list(product(ONE_BOUNDARY | SEVERAL, (33, 65))), ids=str)
def test_map_equals_the_full_grid_for_a_quarter_of_its_runs(name: str, size: int) -> None:
    full = on_grid((ONE_BOUNDARY | SEVERAL)[name], size)
    run, found = refined(full)
    assert found == full
    assert 0 < len(run) <= QUARTER * len(full) or (name in SEVERAL and size == 33)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 4), st.floats(0.5, 1.0))
def test_unrun_node_has_neighbours_of_one_class_on_any_map(seed: int, kinds: int, calm: float) -> None:
    # Not even where classes are strewn at random is a node given a class that one of its neighbours contradicts.
    random = np.random.default_rng(seed)
    strewn = np.where(random.random((23, 19)) < calm, 0, random.integers(0, kinds, (23, 19)))
    full: dict[maps.Node, Hashable] = {node: int(kind) for node, kind in np.ndenumerate(strewn)}
    run, found = refined(full)
    for i, j in full:
        for beside in ((i + 1, j), (i, j + 1)):
            if beside in full and found[i, j] != found[beside]:
                assert {(i, j), beside} <= run


def test_what_slips_between_the_coarse_lines_is_missed() -> None:
    # Negative control: the comparison with the full grid does see a wrong map.
    full = on_grid(lambda x, y: math.hypot(x - 4.5 / 32, y - 4.5 / 32) < 3.0 / 32, 33)
    found = refined(full)[1]
    assert sum(found[node] != kind for node, kind in full.items()) == sum(map(bool, full.values())) > 0
    assert refined(full, stride=4)[1] == full
