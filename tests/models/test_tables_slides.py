"""A slide that is tilted and one that is offset are told apart; where a table cannot tell, both are said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from described import SLIDER_CRANK, tables
from table_files import Columns, exact_table, judge_columns

from conrod.models.tables.study import TableStudy
from conrod.scenes import Scene, scene_named
from conrod.scenes.described_scene import read_scene, scene_from_tables

MEANT = read_scene(SLIDER_CRANK)
POINTS = ("B.x", "B.y", "G.x", "G.y")


def slider_crank(offset: str = "0 mm", tilt: str = "0 deg", rod: str = "560 mm") -> Scene:
    given = tables(SLIDER_CRANK)
    given["ground"]["points"]["Q"] = [0, offset]
    given["joints"]["slide"] |= {"guide": "ground.Q", "direction": tilt}
    given["bodies"]["rod"]["points"]["B"] = [rod, 0]
    return scene_from_tables(given)


def study_of(scene: Scene, columns: tuple[str, ...], folder: Path, noise: float = 0.0) -> TableStudy:
    table: Columns = exact_table(scene, ("position", "velocity"))
    random = np.random.default_rng(6)
    chosen = {name: table[name] + noise * random.normal(size=len(table[name])) for name in columns}
    limit = "velocity" if columns[0].split(".")[1].startswith("v") else "position"
    return judge_columns({"time": table["time"], **chosen}, MEANT, folder, tolerance={limit: 1e-7})


COLUMNS = (("B.x",), ("B.x", "B.y"), POINTS, ("B.vx", "B.vy"), ("B.y", "G.y"))
CHANGES = [
    ({"offset": "5 mm"}, "slide offset", "the slide 'slide' is offset by 5 mm to the left of its direction"),
    ({"offset": "-0.2 mm"}, "slide offset", "the slide 'slide' is offset by 0.2 mm to the right of its direction"),
    ({"tilt": "0.5 deg"}, "slide tilt", "the slide 'slide' is tilted by 0.5 deg about its point on the ground"),
    ({"tilt": "-0.05 deg"}, "slide tilt", "tilted by -0.05 deg about"),
    (
        {"tilt": "0.5 deg", "offset": "5 mm"},
        "slide",
        "is offset by 5 mm to the left of its direction and tilted by 0.5",
    ),
]
# Each change by two sets of columns, and each set for two changes, are fast.
CASES = [
    pytest.param(columns, *change, marks=() if (k - n) % len(COLUMNS) < 2 else pytest.mark.slow)
    for k, columns in enumerate(COLUMNS)
    for n, change in enumerate(CHANGES)
]


@pytest.mark.parametrize(("columns", "change", "kind", "said"), CASES)
def test_a_tilt_and_an_offset_of_a_slide_are_told_apart(
    columns: tuple[str, ...], change: dict[str, str], kind: str, said: str, tmp_path: Path
) -> None:
    study = study_of(slider_crank(**change), columns, tmp_path)
    assert [cause.kind for cause in study.causes] == [kind]
    assert said in study.causes[0].text


def test_noise_that_hides_which_it_is_has_both_said(tmp_path: Path) -> None:
    # By B.x alone a tilt of 0.03 deg is all but an angle of the crank.
    study = study_of(slider_crank(tilt="0.03 deg"), ("B.x",), tmp_path, noise=1e-6)
    assert {"slide tilt", "time offset"} <= {cause.kind for cause in study.causes}


def test_a_rod_of_another_length_is_no_slide(tmp_path: Path) -> None:
    (cause,) = study_of(slider_crank(rod="561 mm"), POINTS, tmp_path).causes
    assert cause.kind == "length"
    assert cause.text == "bodies.rod.points.B.x is 0.18 % too long: 561 mm instead of 560 mm"


def test_a_machine_without_a_slide_on_the_ground_has_none_fitted(tmp_path: Path) -> None:
    scene = scene_named("swinging-four-bar")
    first, last = (angle / scene.speed for angle in sorted(scene.mechanism().driver.span or ()))
    table = exact_table(scene, times=np.linspace(first, last, 60))
    moved = {name: column + (1e-3 if name.endswith(".x") else 0.0) for name, column in table.items()}
    found = judge_columns(moved, scene, tmp_path, tolerance={"position": 1e-6})
    assert [cause.kind for cause in found.causes] == ["frame"]
