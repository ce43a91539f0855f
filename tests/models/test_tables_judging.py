"""A table is judged as an engine's run is, also as a user types it; what is unknown of it is found where asked for."""

from __future__ import annotations

import json
import math
import struct
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import conrod
from synthetic import synthetic_trajectory
from table_files import LETTERS, ROWS, Columns, csv_text, exact_table, judge_columns

from conrod import InvalidInput, Trajectory, compare
from conrod.cli.options import names_in
from conrod.execution.tolerances import UnscaledLimit
from conrod.models.tables.errors import TableComparison
from conrod.models.tables.estimation import check_estimated, estimate
from conrod.models.tables.study import TableStudy
from conrod.scenes import SCENES, CamFollower, Saw, ShearPress, scene_named

ALL = ("position", "velocity", "acceleration")
SAW, TURN = Saw(speed=20.0), 2.0 * math.pi


def table_of(trajectory: Trajectory, quantity: str) -> Columns:
    """One quantity of a run as a table, at the instants that it belongs to."""
    tracks = {point: getattr(own, quantity) for point, own in trajectory.points.items()}
    at = next(iter(tracks.values())).instants
    columns = {"time": at.times, "crank_angle": at.angle, "crank_speed": at.rate, "crank_acceleration": at.acceleration}
    for point, track in tracks.items():
        columns |= {f"{point}.{LETTERS[quantity]}{axis}": track.values[:, k] for k, axis in enumerate("xy")}
    return columns


def test_table_is_judged_as_a_run_and_drive_error_is_in_total(tmp_path: Path) -> None:
    trajectory = synthetic_trajectory(SAW, drive=1e-4)
    expected = compare(trajectory, SAW)
    for quantity in ALL:
        study = judge_columns(table_of(trajectory, quantity), SAW, tmp_path)
        names = ("total", "position") if quantity == "position" else (quantity,)
        assert {name for errors in study.errors.values() for name in errors} == set(names)
        for point, errors in study.errors.items():
            for name in names:
                found, reference = errors[name].size, getattr(expected.points[point], name).size
                for measure in ("max", "rms", "final"):
                    assert getattr(found, measure) == pytest.approx(getattr(reference, measure), rel=0, abs=1e-12)
        if quantity == "position":
            assert study.largest("phase") == pytest.approx(expected.phase_max, rel=0, abs=1e-12)
            assert (study.largest("position") or 0.0) < 1e-12
            assert (study.largest("total") or 0.0) > 1e-4


def test_total_is_weighed_as_the_position_that_is_asked_for(tmp_path: Path) -> None:
    # Of M alone, late by 1e-3 rad: a share of its own travel is a smaller one of that of C, which travels further.
    late = exact_table(SAW, phase=1e-3, crank=True)
    table = {name: own for name, own in late.items() if not name.startswith("C")}
    table["crank_angle"] = table["crank_angle"] + 1e-3
    plain = judge_columns(table, SAW, tmp_path, tolerance={"position": 1e-4})
    limit: Any = UnscaledLimit(1e-4 * SAW.lengths["C"], is_share=False)
    study = judge_columns(table, SAW, tmp_path, tolerance={"position": limit})
    assert study.tolerance == pytest.approx(plain.tolerance)
    assert study.weights["total"] == study.weights["position"]
    share = SAW.lengths["M"] / SAW.lengths["C"]
    assert study.largest("total") == pytest.approx(share * (plain.largest("total") or 0.0))
    assert study.largest("total") > 1e-4


@pytest.mark.parametrize(("name", "size"), [("saw-500rpm", 1e-4), ("shear-press", 1e-9)])
def test_a_planted_error_is_found_with_its_size(name: str, size: float, tmp_path: Path) -> None:
    scene = SCENES[name]
    table, point = exact_table(scene), scene.output
    # In one row alone, along a slanting direction.
    table[f"{point}.x"][77] += 0.6 * size * scene.lengths[point]
    table[f"{point}.y"][77] -= 0.8 * size * scene.lengths[point]
    study = judge_columns(table, scene, tmp_path, tolerance={"total": 0.99 * size})
    assert study.passed is False
    assert study.largest("total") == pytest.approx(size, rel=1e-6)
    assert int(np.argmax(study.errors[point]["total"].largest)) == 77
    assert judge_columns(table, scene, tmp_path, tolerance={"total": 1.01 * size}).passed is True
    with pytest.raises(InvalidInput, match="no velocity column; conrod does not differentiate"):
        judge_columns(table, scene, tmp_path, tolerance={"velocity": 1.0})


def test_encoder_log_is_judged_by_crank_angle_and_time_offset(tmp_path: Path) -> None:
    scene = Saw(speed=5.0)
    times = np.linspace(0.0, 2.0 * scene.period, 500)
    wobble = 0.01 * np.sin(7.0 * times)
    # An encoder counts from 0 to a turn, again and again.
    table = {"time": times, "crank_angle": np.mod(5.0 * times + wobble, TURN)}
    study = judge_columns(table, scene, tmp_path, tolerance={"phase": 0.0101})
    assert study.largest("phase") == pytest.approx(np.abs(wobble).max(), abs=1e-12)
    assert (study.passed, study.errors) == (True, {})
    assert judge_columns(table, scene, tmp_path, tolerance={"phase": 0.0099}).passed is False
    study = judge_columns(table | {"crank_angle": np.mod(5.0 * (times - 0.05), TURN)}, scene, tmp_path, ["time"])
    assert values(study)["time"] == pytest.approx(0.05, abs=1e-12)
    assert (study.largest("phase") or 0.0) < 1e-12


def test_the_sides_of_a_jump_are_told_by_the_crank(tmp_path: Path) -> None:
    # At a joint of the cam's arcs the acceleration has two values; the table's own account of it is the right one.
    scene = CamFollower(speed=2.0)
    times = np.sort(np.append(np.linspace(0.0, scene.period, 50), scene.break_angles()[0] / 2.0))
    study = judge_columns(exact_table(scene, ALL, times=times), scene, tmp_path)
    assert study.largest("acceleration") == 0.0


# -- the clock: errors at the crank angle that a table says show nothing of it -----------------------------------------

WRONG = 1e-4  # of the timestep: 0.01 %


def with_clock(scene: Saw | ShearPress, step: float = 0.0, late: int = 0) -> Columns:
    """A table with a crank angle, whose times alone are wrong: timesteps too long, and stamps that many rows late."""
    table = exact_table(scene, ALL, crank=True)
    return table | {"time": table["time"] * (1.0 - step) + late * (table["time"][1] - table["time"][0])}


def written_with(table: Columns, digits: int) -> Columns:
    """The table as a tool writes it that has so many digits, its angle in degrees from 0 to 360."""
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
    table = with_clock(scene, **fault) if digits is None else written_with(with_clock(scene, **fault), digits)
    study = judge_columns(table, scene, tmp_path, tolerance={"position": 2e-6, "velocity": 2e-6})
    assert study.largest("phase") == pytest.approx(turned, rel=1e-3, abs=3e-6 if digits else 1e-12)
    assert study.passed is (turned == 0.0)
    # At the angle that the table says there is nothing to be seen of it.
    assert set(study.exceeded) == ({"phase", "total"} if turned else set())
    assert any("--estimate time" in note for note in study.notes) is (turned > 0.0)
    assert study.tolerance["phase"] < (2e-5 if digits else 1e-10)


def test_estimate_corrects_a_wrong_start_and_no_wrong_timestep(tmp_path: Path) -> None:
    late, slow = with_clock(SAW, late=1), with_clock(SAW, step=WRONG)
    assert judge_columns(late, SAW, tmp_path, ("time",), {"position": 1e-9}).passed is True
    assert judge_columns(slow, SAW, tmp_path, ("time",), {"position": 1e-9}).passed is False
    for name, allowed, exceeded in (
        ("phase", 2e-3, set()),
        ("phase", 1e-3, {"phase", "total"}),
        ("total", 1e-2, set()),  # whoever limits the total has said what the clock may do
    ):
        assert set(judge_columns(slow, SAW, tmp_path, tolerance={"position": 1e-6, name: allowed}).exceeded) == exceeded


def test_whole_degrees_are_exact_at_equal_distances(tmp_path: Path) -> None:
    table = written_with(exact_table(SAW, crank=True), 7)
    table["crank_angle [deg]"] = np.rint(table["crank_angle [deg]"])
    assert judge_columns(table, SAW, tmp_path, tolerance={"position": 1e-6}).tolerance["phase"] < 2e-6
    # Written to whole degrees of others, half a degree is all that can be known.
    table["crank_angle [deg]"][7] += 1.0
    assert 0.008 < judge_columns(table, SAW, tmp_path, tolerance={"position": 1e-2}).tolerance["phase"] < 0.009


# -- estimates ---------------------------------------------------------------------------------------------------------


def values(study: TableStudy) -> dict[str, float]:
    return {one.name: one.value for one in study.estimates}


@pytest.mark.parametrize(("name", "share"), [("saw-500rpm", 0.37), ("cam-follower", 0.37), ("shear-press", 1e-7)])
def test_a_time_offset_is_found(name: str, share: float, tmp_path: Path) -> None:
    scene = SCENES[name]
    table = exact_table(scene)
    table["time"] = table["time"] + share * scene.period
    study = judge_columns(table, scene, tmp_path, ["time"])
    assert values(study)["time"] == pytest.approx(share * scene.period, rel=1e-7, abs=1e-14 * scene.period)
    assert (study.largest("total") or 0.0) < 1e-11
    # Negative control: it is not taken off unasked.
    assert (judge_columns(table, scene, tmp_path).largest("total") or 0.0) > 1e-8


def test_phase_is_estimated_apart_from_clock_with_a_crank_angle(tmp_path: Path) -> None:
    scene = ShearPress(speed=-5.0)
    study = judge_columns(exact_table(scene, phase=1.1), scene, tmp_path, ["phase"])
    assert values(study) == {"phase": pytest.approx(1.1, abs=1e-12)}
    assert (study.largest("total") or 0.0) < 1e-11
    # The encoder's zero is 0.3 rad ahead of the scene's, and its clock 2 ms.
    table = exact_table(SAW, crank=True)
    table |= {"crank_angle": table["crank_angle"] - 0.3, "time": table["time"] + 0.002}
    study = judge_columns(table, SAW, tmp_path, ["time", "phase"])
    assert values(study) == {"zero": pytest.approx(0.3, abs=1e-12), "time": pytest.approx(0.002, abs=1e-13)}
    assert max(study.largest(name) or 0.0 for name in ("total", "position")) < 1e-11
    # Noise moves both alike: the clock stays within what rounding makes of it.
    table["C.x"] = table["C.x"] + 1e-4 * np.random.default_rng(4).normal(size=2 * ROWS + 1)
    assert judge_columns(table, SAW, tmp_path, ["time", "phase"], {"position": 1e-2}).passed is True


def test_standard_errors_are_the_scatter_of_estimates() -> None:
    generator, noise = np.random.default_rng(20), 1e-3
    times, found = np.arange(0.0, 2.0 * SAW.period, SAW.period / 30), []
    for _ in range(40):
        table = exact_table(SAW, times=times)
        for name in (name for name in table if name != "time"):
            table[name] += noise * SAW.lengths[name[0]] * generator.normal(size=len(times))
        found += estimate(TableComparison(table | {"time": times + 0.01}, SAW), ["time"])
        assert found[-1].remaining == pytest.approx(noise * math.sqrt(2.0), rel=0.2)
    error, offsets = np.mean([one.error for one in found]), [one.value for one in found]
    # Of 40 estimates the scatter is known to 1/sqrt(78) = 11 %, their mean to 1/sqrt(40) = 16 % of it.
    assert np.std(offsets) == pytest.approx(error, rel=0.35)
    assert abs(np.mean(offsets) - 0.01) < 4.0 * error / math.sqrt(40.0)


def test_what_cannot_be_told_is_refused() -> None:
    assert check_estimated(names_in("time, phase,time") or ()) == ("time", "phase")
    with pytest.raises(InvalidInput, match="'fase': did you mean 'phase'"):
        check_estimated(["fase"])
    table = exact_table(CamFollower())
    for names, asked, said in (
        (("roller.x", "roller.y"), ("time", "phase"), "at constant speed one looks like the other"),
        # A follower that moves along y tells nothing by its x.
        (("roller.x",), ("time",), "time cannot be determined: nothing in this table depends on it"),
        ((), ("time",), "the table has no positions"),
    ):
        with pytest.raises(InvalidInput, match=said):
            estimate(TableComparison({name: table[name] for name in ("time", *names)}, CamFollower()), asked)


# -- as a user types it ------------------------------------------------------------------------------------------------

CHECK = ("check", "t.csv", "--scene", "saw-500rpm")


@pytest.mark.usefixtures("at_once")
def test_table_out_of_tolerance_has_status_1_cause_and_report(tmp_path: Path) -> None:
    # Three tenths of a millisecond late: so much of a step.
    table = exact_table(SCENES["saw-500rpm"], ("position", "velocity"))
    (tmp_path / "t.csv").write_text(csv_text(table | {"time": table["time"] + 3e-4}))
    done = conrod(
        *CHECK, "--tolerance", "position=1e-4,velocity=1e-3", "--json", "o.json", "--out", "rep", cwd=tmp_path
    )
    assert done.returncode == 1, done.stderr
    assert "OUT OF TOLERANCE: position" in done.stdout
    assert "likely cause: each row belongs 0.0003 s (0.3 of a step) earlier than its time says" in done.stdout
    part = json.loads((tmp_path / "o.json").read_text())["parts"]["table"]
    summary, findings = part["summary"], part["findings"]
    assert (summary["passed"], summary["causes"], findings["rows"]) == (False, ["time offset"], 2 * ROWS + 1)
    assert summary["figure"] == max(curves["total"]["size"]["max"] for curves in findings["errors"].values())
    assert findings == json.loads((tmp_path / "rep/data/table.json").read_text())
    assert "likely cause: each row belongs" in (tmp_path / "rep/README.md").read_text()
    assert (tmp_path / "rep/figures/error.svg").read_text().rstrip().endswith("</svg>")


def test_confined_archive_fails_alone_when_it_needs_all_memory(tmp_path: Path) -> None:
    # Its header promises 10^13 numbers; what reads it is told so by the system, in a process of its own.
    head = b"{'descr': '<f8', 'fortran_order': False, 'shape': (10000000000000,), }"
    with zipfile.ZipFile(tmp_path / "t.npz", "w") as archive:
        archive.writestr("time.npy", b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head)
    done = conrod("check", "t.npz", "--scene", "saw-500rpm", cwd=tmp_path)
    assert (done.returncode, done.stderr[:19], len(done.stderr.splitlines())) == (2, "conrod: t.npz: it c", 1)


def test_report_is_of_another_version_when_column_shapes_differ(tmp_path: Path) -> None:
    file, out = tmp_path / "t.csv", tmp_path / "r"
    file.write_text(csv_text(exact_table(SAW)))
    conrod("check", str(file), "--scene", "saw-500rpm", "--out", str(out))
    document = out / "results.json"
    document.write_text(document.read_text().replace('"schema": 4', '"schema": 3'))
    assert "another version of conrod" in conrod("report", str(out), "--out", str(tmp_path / "again")).stderr


@pytest.mark.parametrize("speed", [1.0, -1.0])
def test_table_is_refused_when_it_leaves_a_pass_at_either_end(speed: float, tmp_path: Path) -> None:
    given = scene_named("geneva")
    scene = given.with_parameters(speed=speed * given.speed)
    ends = sorted(angle / scene.speed for angle in scene.mechanism().driver.span or ())
    begin = f"{ends[0]:.6g} s"

    def study(first: float, last: float) -> TableStudy:
        # Digits that are left out may lead a millionth beyond.
        times = np.linspace(ends[0], ends[1], 50)
        table = exact_table(scene, times=times)
        stretched = np.linspace(ends[0] + first, ends[1] + last, 50)
        return judge_columns(table | {"time": stretched}, scene, tmp_path)

    assert (study(0.0, 0.0).largest("total") or 0.0) < 1e-9
    little = 5e-7 / abs(scene.speed)
    assert (study(-little, little).largest("total") or 0.0) < 1e-5
    for first, last in ((-0.01, 0.0), (0.0, 0.01), (-4.0 * little, 0.0), (0.0, 4.0 * little)):
        with pytest.raises(InvalidInput, match="out of the pass from -45 to 45 deg") as refused:
            study(first, last)
        assert str(refused.value).endswith(f"the pass begins at {begin}")
