"""An engine's run as a table: at its own stamps, beside the exact motion, the same each time."""

from __future__ import annotations

import csv
import io
import json
from typing import Any

import numpy as np
import pytest
from command_line import conrod as typed

import conrod
from conrod import InvalidInput
from conrod.exact.motion import Array
from conrod.models.tables.columns import split_heading

STEPS = 100
SAW = conrod.SCENES["saw-500rpm"]


def columns_of(text: str) -> tuple[dict[str, str], dict[str, Array]]:
    """Comments and columns of a table; NaN where a cell is empty."""
    lines = text.splitlines()
    about = dict(line.removeprefix("# ").split(": ", 1) for line in lines if line.startswith("#"))
    headings, *rows = csv.reader(line for line in lines if not line.startswith("#"))
    values = np.array([[float(cell or "nan") for cell in row] for row in rows])
    return about, {split_heading(heading)[0]: values[:, k] for k, heading in enumerate(headings)}


@pytest.fixture(scope="module")
def tables() -> dict[str, str]:
    return {name: str(conrod.export(SAW, "csv", engine=name, steps_per_rev=STEPS)) for name in ("mujoco", "pymunk")}


def test_table_of_a_run_has_its_samples_beside_the_exact_ones(tables: dict[str, str]) -> None:
    about, columns = columns_of(tables["mujoco"])
    assert about["preset"] == "tuned"
    assert about["engine"].startswith("mujoco ")
    assert about["outcome"] == "completed"
    assert json.loads(about["settings"])["steps_per_revolution"] == STEPS
    exact = SAW.reference(columns["time"]).point("C")
    assert np.abs(columns["exact.C.x"] - exact.position[:, 0]).max() < 1e-15
    assert 1e-9 < np.abs(columns["C.x"] - columns["exact.C.x"]).max() < 1e-4
    assert 1e-9 < np.abs(columns["omega_rod"] - columns["exact.omega_rod"]).max() < 1e-2
    assert not any("at " in name for name in columns)
    # The table is one that `conrod check` judges.
    assert conrod.check({"time": columns["time"], "C.x": columns["C.x"]}, SAW, tolerance={"position": 1e-4}).passed


def test_quantities_of_other_instants_have_a_time_of_their_own(tables: dict[str, str]) -> None:
    _, columns = columns_of(tables["pymunk"])
    half = 0.5 * SAW.period / STEPS
    assert "C.vx" not in columns
    times, there = columns["velocity_time"], np.isfinite(columns["velocity_time"])
    assert times[there] - columns["time"][there] == pytest.approx(half, rel=1e-9)
    name = "C.vx at velocity_time"
    exact = SAW.reference(times[there]).point("C").velocity[:, 0]
    assert np.abs(columns[f"exact.{name}"][there] - exact).max() < 1e-14
    # Negative control: at the positions' times the velocities would be off by what a half step makes.
    error = np.abs(columns[name][there] - exact).max()
    assert (
        np.abs(columns[name][there] - SAW.reference(columns["time"][there]).point("C").velocity[:, 0]).max()
        > 10 * error
    )


def test_archive_has_the_columns_and_the_same_bytes_each_time(tables: dict[str, str]) -> None:
    first, again = (conrod.export(SAW, "npz", engine="pymunk", steps_per_rev=STEPS) for _ in range(2))
    assert first == again
    assert isinstance(first, bytes)
    archive = np.load(io.BytesIO(first))
    _, columns = columns_of(tables["pymunk"])
    units, about = (json.loads(str(archive[name])) for name in ("units", "about"))
    assert {*units} == {*columns} == {*archive.files} - {"units", "about"}
    for name, values in columns.items():
        assert np.array_equal(archive[name], values[np.isfinite(values)])
    assert units["C.ax at acceleration_time"] == "m/s^2"
    assert about["engine"].startswith("pymunk ")
    assert tables["pymunk"] == conrod.export(SAW, "csv", engine="pymunk", steps_per_rev=STEPS)


def test_exact_motion_is_the_same_in_both_formats() -> None:
    content: Any = conrod.export(SAW, "npz", steps_per_rev=36)
    archive = np.load(io.BytesIO(content))
    _, columns = columns_of(str(conrod.export(SAW, "csv", steps_per_rev=36)))
    assert all(np.array_equal(archive[name], values) for name, values in columns.items())


REFUSED = {
    "engine": (("csv", {"engine": "mujco"}), "unknown engine 'mujco': did you mean 'mujoco'?"),
    "preset": (("csv", {"engine": "pymunk", "preset": "hardened"}), "unknown preset of pymunk 'hardened'"),
    "format": (("mjcf", {"engine": "mujoco"}), "--engine does not go with --format mjcf: a run is sampled as csv"),
    "exact": (("csv", {"preset": "tuned"}), "--preset does not go with --format csv: of a table it is that of an"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_a_run_that_cannot_be_sampled_is_refused(case: str) -> None:
    (format, words), line = REFUSED[case]
    with pytest.raises(InvalidInput) as refusal:
        conrod.export(SAW, format, **words)
    assert line in str(refusal.value)


def test_command_samples_one_engine_and_writes_archives_to_files() -> None:
    done = typed("export", "saw-500rpm", "--engine", "mujoco", "--engine", "pymunk", "--format", "csv")
    assert (done.returncode, "the run of one engine is sampled" in done.stderr) == (2, True)
    done = typed("export", "saw-500rpm", "--engine", "mujoco", "--format", "npz")
    assert (done.returncode, "--format npz is not text: give a file with -o" in done.stderr) == (2, True)


def test_a_run_that_does_not_complete_is_written_with_a_warning() -> None:
    with pytest.warns(UserWarning, match="saw-500rpm in mujoco: the run is"):
        text = str(conrod.export(("saw-500rpm", SAW), "csv", engine="mujoco", preset="tuned", steps_per_rev=3))
    about, _ = columns_of(text)
    assert about["outcome"] != "completed"
