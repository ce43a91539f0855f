"""A table is judged as an engine's run is, also as a user types it; what is unknown of it is found where asked for."""

from __future__ import annotations

import json
import math
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest
from command_line import conrod
from synthetic import synthetic_trajectory
from table_files import LETTERS, ROWS, Columns, csv_text, exact_table, judged

from conrod import InvalidInput, Trajectory, compare
from conrod.own.tables.errors import Exact
from conrod.own.tables.estimation import estimate, parse_estimate
from conrod.own.tables.study import TableStudy
from conrod.scenes import SCENES, CamFollower, Saw, Scene, ShearPress

ALL = ("position", "velocity", "acceleration")


def table_of(trajectory: Trajectory, quantity: str) -> Columns:
    """One quantity of a run as a table, at the instants that it belongs to."""
    tracks = {point: getattr(own, quantity) for point, own in trajectory.points.items()}
    at = next(iter(tracks.values())).instants
    columns = {"time": at.times, "crank_angle": at.angle, "crank_speed": at.rate, "crank_acceleration": at.acceleration}
    for point, track in tracks.items():
        columns |= {f"{point}.{LETTERS[quantity]}{axis}": track.values[:, k] for k, axis in enumerate("xy")}
    return columns


def agrees_with_compare(trajectory: Trajectory, scene: Scene, folder: Path) -> None:
    expected = compare(trajectory, scene)
    for quantity in ALL:
        study = judged(table_of(trajectory, quantity), scene, folder)
        names = ("total", "position") if quantity == "position" else (quantity,)
        assert {name for errors in study.errors.values() for name in errors} == set(names)
        for point, errors in study.errors.items():
            for name in names:
                found, reference = errors[name].size, getattr(expected.points[point], name).size
                for measure in ("max", "rms", "final"):
                    assert getattr(found, measure) == pytest.approx(getattr(reference, measure), rel=0, abs=1e-12)
        if quantity == "position":
            assert study.largest("phase") == pytest.approx(expected.phase_max, rel=0, abs=1e-12)


def test_a_drive_that_is_off_shows_in_total_and_not_in_position(tmp_path: Path) -> None:
    scene = Saw(speed=20.0)
    trajectory = synthetic_trajectory(scene, drive=1e-4)
    agrees_with_compare(trajectory, scene, tmp_path)
    study = judged(table_of(trajectory, "position"), scene, tmp_path)
    assert (study.largest("position") or 0.0) < 1e-12
    assert (study.largest("total") or 0.0) > 1e-4


@pytest.mark.parametrize(("name", "size"), [("saw-500rpm", 1e-4), ("shear-press", 1e-9)])
def test_a_planted_error_is_found_with_its_size(name: str, size: float, tmp_path: Path) -> None:
    scene = SCENES[name]
    table = exact_table(scene)
    point = scene.output
    # In one row alone, along a slanting direction.
    table[f"{point}.x"][77] += 0.6 * size * scene.lengths[point]
    table[f"{point}.y"][77] -= 0.8 * size * scene.lengths[point]
    study = judged(table, scene, tmp_path, tolerance={"total": 0.99 * size})
    assert study.passed is False
    assert study.largest("total") == pytest.approx(size, rel=1e-6)
    assert int(np.argmax(study.errors[point]["total"].largest)) == 77
    assert judged(table, scene, tmp_path, tolerance={"total": 1.01 * size}).passed is True


def test_rates_that_a_table_has_not_are_not_made_up(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="no velocity column; conrod does not differentiate"):
        judged(exact_table(Saw()), Saw(), tmp_path, tolerance={"velocity": 1.0})


def test_an_encoder_log_is_judged_by_its_crank_angle(tmp_path: Path) -> None:
    scene = Saw(speed=5.0)
    times = np.linspace(0.0, 2.0 * scene.period, 500)
    wobble = 0.01 * np.sin(7.0 * times)
    # An encoder counts from 0 to a turn, again and again.
    table = {"time": times, "crank_angle": np.mod(5.0 * times + wobble, 2.0 * np.pi)}
    study = judged(table, scene, tmp_path, tolerance={"phase": 0.0101})
    assert study.largest("phase") == pytest.approx(np.abs(wobble).max(), abs=1e-12)
    assert study.passed is True
    assert study.errors == {}
    assert judged(table, scene, tmp_path, tolerance={"phase": 0.0099}).passed is False


def test_the_sides_of_a_jump_are_told_by_the_crank(tmp_path: Path) -> None:
    # At a joint of the cam's arcs the acceleration has two values; the table's own account of it is the right one.
    scene = CamFollower(speed=2.0)
    times = np.sort(np.append(np.linspace(0.0, scene.period, 50), scene.break_angles()[0] / 2.0))
    study = judged(exact_table(scene, ALL, times=times), scene, tmp_path)
    assert study.largest("acceleration") == 0.0


# -- the clock: errors at the crank angle that a table says show nothing of it -----------------------------------------

WRONG = 1e-4  # of the timestep: 0.01 %


def with_clock(scene: Scene, step: float = 0.0, late: int = 0) -> Columns:
    """A table with a crank angle, whose times alone are wrong: timesteps too long, and stamps that many rows late."""
    table = exact_table(scene, ALL, crank=True)
    return table | {"time": table["time"] * (1.0 - step) + late * (table["time"][1] - table["time"][0])}


def written_with(table: Columns, digits: int | None) -> Columns:
    """The table as a tool writes it that has so many digits, its angle in degrees from 0 to 360; None: as it is."""
    if digits is None:
        return table
    crank = np.degrees(table["crank_angle"]) % 360.0
    rounded = {"time": table["time"], "crank_angle [deg]": crank}
    short = {name: np.array([float(f"{v:.{digits}g}") for v in column]) for name, column in rounded.items()}
    return {name: column for name, column in (table | short).items() if name != "crank_angle"}


@pytest.mark.parametrize("digits", [None, 7])
@pytest.mark.parametrize(
    ("fault", "turned"),
    [({}, 0.0), ({"step": WRONG}, WRONG * 4.0 * np.pi), ({"late": 1}, 2.0 * np.pi / ROWS)],
    ids=["right", "long steps", "stamps a step late"],
)
def test_a_table_is_judged_by_its_clock(
    fault: dict[str, float], turned: float, digits: int | None, tmp_path: Path
) -> None:
    scene = ShearPress(speed=-3.0)
    table = written_with(with_clock(scene, **fault), digits)
    study = judged(table, scene, tmp_path, tolerance={"position": 2e-6, "velocity": 2e-6})
    assert study.largest("phase") == pytest.approx(turned, rel=1e-3, abs=3e-6 if digits else 1e-12)
    assert study.passed is (turned == 0.0)
    # At the angle that the table says there is nothing to be seen of it.
    assert set(study.exceeded) == ({"phase", "total"} if turned else set())
    assert any("--estimate time" in note for note in study.notes) is (turned > 0.0)
    assert study.tolerance["phase"] < (2e-5 if digits else 1e-10)


def test_a_wrong_start_is_estimated_and_a_wrong_timestep_is_not(tmp_path: Path) -> None:
    scene, allowed = Saw(speed=20.0), {"position": 1e-9}
    assert judged(with_clock(scene, late=1), scene, tmp_path, ("time",), allowed).passed is True
    assert judged(with_clock(scene, step=WRONG), scene, tmp_path, ("time",), allowed).passed is False


def test_a_user_says_how_well_the_drive_keeps_its_speed(tmp_path: Path) -> None:
    scene, table = Saw(speed=20.0), with_clock(Saw(speed=20.0), step=WRONG)
    study = judged(table, scene, tmp_path, tolerance={"position": 1e-6, "phase": 2e-3})
    assert study.passed is True
    assert set(judged(table, scene, tmp_path, tolerance={"position": 1e-6, "phase": 1e-3}).exceeded) == {
        "phase",
        "total",
    }
    # Whoever limits the total has said what the clock may do.
    assert set(judged(table, scene, tmp_path, tolerance={"position": 1e-6, "total": 1e-2}).exceeded) == set()


def test_whole_degrees_at_equal_distances_are_taken_at_their_word(tmp_path: Path) -> None:
    scene = Saw(speed=20.0)
    table = written_with(exact_table(scene, crank=True), 7)
    table["crank_angle [deg]"] = np.rint(table["crank_angle [deg]"])
    assert judged(table, scene, tmp_path, tolerance={"position": 1e-6}).tolerance["phase"] < 2e-6
    # Written to whole degrees of others, half a degree is all that can be known.
    table["crank_angle [deg]"][7] += 1.0
    assert 0.008 < judged(table, scene, tmp_path, tolerance={"position": 1e-2}).tolerance["phase"] < 0.009


TURN = 2.0 * math.pi


def values(study: TableStudy) -> dict[str, float]:
    return {one.name: one.value for one in study.estimates}


@pytest.mark.parametrize(("name", "share"), [("saw-500rpm", 0.37), ("cam-follower", 0.37), ("saw-40rpm", 1e-7)])
def test_a_time_offset_is_found(name: str, share: float, tmp_path: Path) -> None:
    scene = SCENES[name]
    table = exact_table(scene)
    table["time"] = table["time"] + share * scene.period
    study = judged(table, scene, tmp_path, ["time"])
    assert values(study)["time"] == pytest.approx(share * scene.period, rel=1e-7, abs=1e-14 * scene.period)
    assert (study.largest("total") or 0.0) < 1e-11
    # Negative control: it is not taken off unasked.
    assert (judged(table, scene, tmp_path).largest("total") or 0.0) > 1e-8


@pytest.mark.parametrize("scene", [Saw(speed=20.0), ShearPress(speed=-5.0)])
def test_a_phase_is_found(scene: Scene, tmp_path: Path) -> None:
    table = exact_table(scene)
    motion = scene.motion(scene.speed * table["time"] + 1.1, scene.speed)
    for point in scene.lengths:
        table[f"{point}.x"], table[f"{point}.y"] = motion.point(point).position.T
    study = judged(table, scene, tmp_path, ["phase"])
    assert values(study) == {"phase": pytest.approx(1.1, abs=1e-12)}
    assert (study.largest("total") or 0.0) < 1e-11


def test_with_a_crank_angle_the_clock_and_the_crank_are_told_apart(tmp_path: Path) -> None:
    scene = Saw(speed=20.0)
    table = exact_table(scene, crank=True)
    # The encoder's zero is 0.3 rad ahead of the scene's, and its clock 2 ms.
    table["crank_angle"] = table["crank_angle"] - 0.3
    table["time"] = table["time"] + 0.002
    study = judged(table, scene, tmp_path, ["time", "phase"])
    assert values(study) == {"zero": pytest.approx(0.3, abs=1e-12), "time": pytest.approx(0.002, abs=1e-13)}
    assert (study.largest("total") or 0.0) < 1e-11
    assert (study.largest("position") or 0.0) < 1e-11


def test_an_encoder_log_tells_its_time_offset(tmp_path: Path) -> None:
    scene = Saw(speed=5.0)
    times = np.linspace(0.0, 3.0, 300)
    table = {"time": times, "crank_angle": np.mod(5.0 * (times - 0.05), TURN)}
    study = judged(table, scene, tmp_path, ["time"])
    assert values(study)["time"] == pytest.approx(0.05, abs=1e-12)
    assert (study.largest("phase") or 0.0) < 1e-12


def test_standard_errors_are_the_scatter_of_estimates() -> None:
    scene = Saw(speed=20.0)
    generator, noise = np.random.default_rng(20), 1e-3
    times = np.arange(0.0, 2.0 * scene.period, scene.period / 30)
    motion = scene.reference(times)
    found, told = [], []
    for _ in range(40):
        table = {"time": times + 0.01}
        for name, length in scene.lengths.items():
            exact = motion.point(name).position
            places = exact + noise * length * generator.normal(size=exact.shape)
            table |= {f"{name}.{axis}": places[:, k] for k, axis in enumerate("xy")}
        (one,) = estimate(Exact(table, scene), ["time"])
        found.append(one.value)
        told.append(one.error)
        assert one.remaining == pytest.approx(noise * math.sqrt(2.0), rel=0.2)
    error = np.mean(told)
    # Of 40 estimates the scatter is known to 1/sqrt(78) = 11 %, their mean to 1/sqrt(40) = 16 % of it.
    assert np.std(found) == pytest.approx(error, rel=0.35)
    assert abs(np.mean(found) - 0.01) < 4.0 * error / math.sqrt(40.0)


def only(table: Columns, *names: str) -> Columns:
    return {name: table[name] for name in names}


def test_what_cannot_be_told_is_refused(tmp_path: Path) -> None:
    assert parse_estimate("time, phase,time") == ("time", "phase")
    with pytest.raises(InvalidInput, match="'fase': did you mean 'phase'"):
        parse_estimate("fase")
    scene = CamFollower()
    table = exact_table(scene)
    with pytest.raises(InvalidInput, match="at constant speed one looks like the other"):
        judged(table, scene, tmp_path, ["time", "phase"])
    # A follower that moves along y tells nothing by its x.
    with pytest.raises(InvalidInput, match="time cannot be determined: nothing in this table depends on it"):
        judged(only(table, "time", "roller.x"), scene, tmp_path, ["time"])
    speed = {"time": table["time"], "crank_speed": table["time"]}
    with pytest.raises(InvalidInput, match="the table has no positions"):
        judged(speed, scene, tmp_path, ["time"])


SAW = SCENES["saw-500rpm"]
VALIDATE = ("validate", "t.csv", "--scene", "saw-500rpm")


def late_table() -> Columns:
    """Three tenths of a millisecond late: so much of a step."""
    table = exact_table(SAW, ("position", "velocity"))
    table["time"] = table["time"] + 3e-4
    return table


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "t.csv").write_text(csv_text(late_table()))
    return tmp_path


@pytest.mark.usefixtures("at_once")
def test_a_table_out_of_tolerance_is_status_1_with_cause_document_and_report(folder: Path) -> None:
    before = (folder / "t.csv").read_bytes()
    done = conrod(
        *VALIDATE, "--tolerance", "position=1e-4,velocity=1e-3", "--json", "o.json", "--out", "rep", cwd=folder
    )
    assert done.returncode == 1, done.stderr
    assert "OUT OF TOLERANCE: position" in done.stdout
    assert "likely cause: each row belongs 0.0003 s (0.3 of a step) earlier than its time says" in done.stdout
    document = json.loads((folder / "o.json").read_text())
    summary, findings = document["parts"]["table"]["summary"], document["parts"]["table"]["findings"]
    assert summary["passed"] is False
    assert findings["rows"] == 2 * ROWS + 1
    assert summary["figure"] == max(curves["total"]["size"]["max"] for curves in findings["errors"].values())
    assert findings["causes"][0]["kind"] == "time offset"
    assert findings == json.loads((folder / "rep/data/table.json").read_text())
    page = (folder / "rep/README.md").read_text()
    assert "likely cause: each row belongs" in page
    assert "conrod validate t.csv --scene saw-500rpm --tolerance position=1e-4,velocity=1e-3 --out rep" in page
    assert (folder / "rep/figures/error.svg").read_text().rstrip().endswith("</svg>")
    assert (folder / "t.csv").read_bytes() == before


def test_confined_an_archive_that_asks_for_all_memory_costs_nobody_else(folder: Path) -> None:
    # Its header promises 10^13 numbers; what reads it is told so by the system, in a process of its own.
    head = b"{'descr': '<f8', 'fortran_order': False, 'shape': (10000000000000,), }"
    entry = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head
    with zipfile.ZipFile(folder / "t.npz", "w") as archive:
        archive.writestr("time.npy", entry)
    done = conrod("validate", "t.npz", "--scene", "saw-500rpm", cwd=folder)
    assert done.returncode == 2
    assert done.stderr.startswith("conrod: t.npz: it")
    assert len(done.stderr.splitlines()) == 1
