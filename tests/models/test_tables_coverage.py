"""A verdict rests on what moves, and its first line says what is not judged."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from command_line import conrod
from described import SLIDER_CRANK, tables
from table_files import ROWS, Columns, exact_table, judge_columns

from conrod import InvalidInput
from conrod.models.tables.report import verdict_text
from conrod.scenes import CamFollower, Saw
from conrod.scenes.described_scene import scene_from_tables

CASES = Path(__file__).parents[1] / "data" / "cases"
SAW, TIGHT = Saw(speed=20.0), {"position": 1e-4}
ALL = ("position", "velocity", "acceleration")


def of_columns(*names: str) -> Columns:
    table = exact_table(SAW, ALL, crank=True)
    return {name: table[name] for name in ("time", *names)}


NOISE = 1e-6 * np.random.default_rng(1).normal(size=2 * ROWS + 1)


@pytest.mark.parametrize("added", [0.0, 2e-6, NOISE], ids=["constant", "a little off", "noise"])
@pytest.mark.parametrize(
    ("columns", "tolerance", "said"),
    [
        (("C.y",), TIGHT, "position=0.0001: it judges nothing, for the exact C.y moves by no more than that"),
        (("C.y", "crank_angle"), TIGHT, "a column that moves: C.x, M.x, M.y"),
        (("C.y", "C.vx"), {**TIGHT, "velocity": 1e-3}, "position=0.0001: it judges nothing"),
        (("C.x", "C.vy"), {**TIGHT, "velocity": 1e-3}, "velocity=0.001: it judges nothing, for the exact C.vy"),
        (("C.x", "C.ay"), {"acceleration": 1e-3}, "acceleration=0.001: it judges nothing"),
        (("C.x", "C.vy"), {"velocity_rms": 1e-3}, "velocity_rms=0.001: it judges nothing"),
        (("C.y",), {"total": 1e-4}, "total=0.0001: it judges nothing"),
        (("C.x", "C.y"), {"position": 1.5}, "position=1.5: it judges nothing, for the exact C.x, C.y move by"),
    ],
)
def test_a_tolerance_of_what_stands_still_is_refused(
    columns: tuple[str, ...], tolerance: dict[str, float], added: float, said: str, tmp_path: Path
) -> None:
    table = of_columns(*columns)
    still = next((name for name in columns if "y" in name and "." in name), columns[0])
    with pytest.raises(InvalidInput) as refused:
        judge_columns(table | {still: table[still] + added}, SAW, tmp_path, tolerance=tolerance)
    assert said in str(refused.value)


def test_what_stands_still_but_is_off_is_out_of_tolerance(tmp_path: Path) -> None:
    table = of_columns("C.y")
    study = judge_columns(table | {"C.y": table["C.y"] + 1e-3}, SAW, tmp_path, tolerance=TIGHT)
    assert set(study.exceeded) == {"position"}
    # Nothing is judged without a tolerance, and a note says that nothing moves.
    study = judge_columns(table, SAW, tmp_path)
    assert study.passed is None
    assert any(note.startswith("C.y: the exact motion stands still there") for note in study.notes)
    assert not any("stands still" in note for note in judge_columns(of_columns("C.x"), SAW, tmp_path).notes)


def test_still_coordinate_away_from_zero_judges_nothing(tmp_path: Path) -> None:
    given = tables(SLIDER_CRANK)
    given["ground"]["points"]["Q"] = [0, "20 mm"]
    given["joints"]["slide"]["guide"] = "ground.Q"
    scene = scene_from_tables(given)
    table = exact_table(scene)
    assert float(table["B.y"].min()) == pytest.approx(0.02)
    with pytest.raises(InvalidInput, match=r"the exact B\.y moves by no more"):
        judge_columns({name: table[name] for name in ("time", "B.y")}, scene, tmp_path, tolerance=TIGHT)


def test_moving_column_is_judged_beside_a_still_one(tmp_path: Path) -> None:
    assert judge_columns(of_columns("C.x", "C.y"), SAW, tmp_path, tolerance=TIGHT).passed is True
    table = exact_table(CamFollower())
    assert judge_columns(table, CamFollower(), tmp_path, tolerance=TIGHT).passed is True
    with pytest.raises(InvalidInput, match=r"the exact roller\.x moves by no more"):
        judge_columns({name: table[name] for name in ("time", "roller.x")}, CamFollower(), tmp_path, tolerance=TIGHT)


def without_sizes(words: str) -> str:
    """A verdict without the sizes of what is not judged."""
    return re.sub(r" \(off by [^)]*\)", "", words)


@pytest.mark.parametrize(
    ("columns", "tolerance", "unjudged"),
    [
        (("C.x", "C.y", "M.x", "M.y"), TIGHT, ("velocity", "acceleration", "crank angle")),
        (("C.x", "M.x", "M.y", "crank_angle"), TIGHT, ("velocity", "acceleration")),
        (("C.x", "M.x", "crank_angle"), TIGHT, ("position of M.y", "velocity", "acceleration")),
        (("C.x", "crank_angle"), TIGHT, ("position of M", "velocity", "acceleration")),
        (("C.y", "M.x", "M.y", "crank_angle"), TIGHT,
         ("position of C (C.y stands still)", "velocity", "acceleration")),
        (("C.x", "C.vx", "crank_angle"), {**TIGHT, "velocity": 1e-3},
         ("position of M", "velocity of M", "acceleration")),
        (("M.vx", "M.vy"), {"velocity": 1e-3}, ("position", "velocity of C", "acceleration", "crank angle")),
        (("C.x", "crank_angle"), {"total": 1e-4}, ("position of M", "velocity", "acceleration", "crank angle")),
        (("crank_angle",), {"phase": 1e-4}, ("position", "velocity", "acceleration")),
    ],
)  # fmt: skip
def test_the_first_line_says_what_is_not_judged(
    columns: tuple[str, ...], tolerance: dict[str, float], unjudged: tuple[str, ...], tmp_path: Path
) -> None:
    study = judge_columns(of_columns(*columns), SAW, tmp_path, tolerance=tolerance)
    assert study.passed is True
    assert study.unjudged == unjudged
    assert without_sizes(verdict_text(study)).endswith(f"; not judged: {', '.join(unjudged)}")
    table = of_columns(*columns)
    late = judge_columns(table | {"time": table["time"] + 0.002}, SAW, tmp_path, tolerance=tolerance)
    assert verdict_text(late).startswith("OUT OF TOLERANCE: ")
    assert without_sizes(verdict_text(late)).endswith(f"; not judged: {', '.join(unjudged)}")
    has_size = "crank angle" in unjudged and "crank_angle" in columns
    assert ("crank angle (off by" in verdict_text(late)) is has_size


def test_all_that_is_there_and_judged_leaves_nothing_out(tmp_path: Path) -> None:
    table, every = exact_table(SAW, ALL, crank=True), dict.fromkeys(ALL, 1e-4)
    study = judge_columns(table, SAW, tmp_path, tolerance=every)
    assert (study.passed, study.unjudged) == (True, ())
    assert "not judged" not in verdict_text(study)


def test_still_table_and_late_clock_have_nonzero_exit_status(tmp_path: Path) -> None:
    for name in ("saw-y-only.csv", "saw-late-clock-gap.csv"):
        shutil.copy(CASES / name, tmp_path)
    limits = ("--scene", "saw-40rpm", "--tolerance", "position=1e-4")
    done = conrod("check", "saw-y-only.csv", *limits, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert "the exact C.y moves by no more than that; give a column that moves: C.x, M.x, M.y" in done.stderr
    done = conrod("check", "saw-late-clock-gap.csv", *limits, cwd=tmp_path)
    assert done.returncode == 1
    assert "each row belongs 0.0005 s (0.5 of a step) earlier than its time says" in done.stdout
    first = done.stdout.splitlines()[0]
    assert "position at time t 0.0012 (0.26 mm) > 1e-4 (0.021 mm); not judged: position of M, velocity (off by" in first
