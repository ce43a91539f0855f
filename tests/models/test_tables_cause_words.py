"""The words of each likely cause, with its size in its unit; and what a study says besides of a table."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from handmade_studies import SCENE as HALVED
from handmade_studies import table_study
from table_files import Columns, exact_table, judge_columns

from conrod.errors import InvalidInput
from conrod.models.tables.causes import Cause, likely_causes
from conrod.models.tables.errors import ERRORS, TableComparison
from conrod.models.tables.study import CLOCK_NOTE, TableStudy
from conrod.scenes import Saw, scene_named

SAW = Saw(speed=20.0)
ALL = ("position", "velocity", "acceleration")
EXACT = exact_table(SAW, ALL, crank=True, rows=30)
PLACES = exact_table(SAW, rows=30)
STEP = SAW.period / 30.0  # [s]


def causes(table: Columns, *wrong: str, **allowed: float) -> list[tuple[str, str]]:
    """Kind and words of the likely causes of a table's errors; of all that are not small where none is named."""
    compared = TableComparison(table, SAW)
    names = wrong or [name for name in ERRORS if (compared.largest(name) or 0.0) > 1e-6]
    return [(cause.kind, cause.text) for cause in likely_causes(compared, names, allowed)]


def scaled(table: Columns, factor: float, part: str) -> Columns:
    return {name: own * factor if part in name else own for name, own in table.items()}


@pytest.mark.parametrize(("factor", "words"), [
    (1e3, "lengths are 1000 times too large: mm taken for m"),
    (1e-3, "lengths are 0.001 times too large: m taken for mm"),
    (1e2, "lengths are 100 times too large: cm taken for m"),
    (1e-2, "lengths are 0.01 times too large: m taken for cm"),
    (10.0, "lengths are 10 times too large: mm taken for cm"),
    (0.1, "lengths are 0.1 times too large: cm taken for mm"),
    (1.0 / 0.0254, "lengths are 39.3701 times too large: inches taken for m"),
    (0.0254, "lengths are 0.0254 times too large: m taken for inches"),
])  # fmt: skip
def test_units_of_lengths_that_were_mistaken(factor: float, words: str) -> None:
    assert causes(scaled(EXACT, factor, ".")) == [("length unit", words)]


@pytest.mark.parametrize(("factor", "words"), [
    (180.0 / math.pi, "crank angles are 57.2958 times too large: degrees taken for radians"),
    (math.pi / 180.0, "crank angles are 0.0174533 times too large: radians taken for degrees"),
    (0.5 / math.pi, "crank angles are 0.159155 times too large: turns taken for radians"),
    (2.0 * math.pi, "crank angles are 6.28319 times too large: radians taken for turns"),
])  # fmt: skip
def test_units_of_the_crank_that_were_mistaken(factor: float, words: str) -> None:
    assert causes(scaled(EXACT, factor, "crank"))[0] == ("angle unit", words)


@pytest.mark.parametrize(("factor", "words"), [
    (180.0 / math.pi, "the crank turns at 57.2958 times the nominal speed: deg/s taken for rad/s"),
    (math.pi / 180.0, "the crank turns at 0.0174533 times the nominal speed: rad/s taken for deg/s"),
    (30.0 / math.pi, "the crank turns at 9.5493 times the nominal speed: rpm taken for rad/s"),
    (math.pi / 30.0, "the crank turns at 0.10472 times the nominal speed: rad/s taken for rpm"),
])  # fmt: skip
def test_units_of_the_speed_that_were_mistaken(factor: float, words: str) -> None:
    assert causes(PLACES | {"time": PLACES["time"] / factor})[0] == ("speed unit", words)


def test_an_opposite_sense_and_swapped_axes() -> None:
    assert causes(exact_table(Saw(speed=-20.0), ALL, rows=30))[0] == (
        "opposite sense", "the crank turns in the opposite sense",
    )  # fmt: skip
    letters = str.maketrans("xy", "yx")
    swapped = {n[:-1] + n[-1].translate(letters) if "." in n else n: own for n, own in PLACES.items()}
    assert causes(swapped)[0] == ("axes swapped", "x and y are swapped")


def test_a_frame_is_said_in_mm_and_degrees() -> None:
    moved = {n: own + {"x": 0.25, "y": -0.1}.get(n[-1], 0.0) if n != "time" else own for n, own in PLACES.items()}
    assert causes(moved) == [("frame", "the table's frame is offset by (250, -100) mm")]
    turn = np.exp(1j * math.radians(20.0))
    turned = {"time": PLACES["time"]}
    for point in "CM":
        both = (PLACES[f"{point}.x"] + 1j * PLACES[f"{point}.y"]) * turn + complex(0.03, -0.04)
        turned |= {f"{point}.x": both.real, f"{point}.y": both.imag}
    assert causes(turned) == [("frame", "the table's frame is offset by (30, -40) mm and turned by 20 deg")]
    assert causes(moved, "total") == [("frame", "the table's frame is offset by (250, -100) mm")]
    # One component alone shows an offset along it, and no turn.
    assert causes({"time": PLACES["time"], "M.x": PLACES["M.x"] + 0.25}) == [
        ("frame", "the table's frame is offset by (250, 0) mm")
    ]


def test_a_turned_frame_turns_velocities_and_accelerations_too() -> None:
    turn = np.exp(1j * math.radians(-30.0))
    table = {"time": EXACT["time"]}
    for name in ("C.", "C.v", "C.a", "M.", "M.v", "M.a"):
        both = (EXACT[f"{name}x"] + 1j * EXACT[f"{name}y"]) * turn + (0.1 - 0.05j if name.endswith(".") else 0.0)
        table |= {f"{name}x": both.real, f"{name}y": both.imag}
    (cause,) = likely_causes(TableComparison(table, SAW), tuple(ERRORS))
    assert cause.text == "the table's frame is offset by (100, -50) mm and turned by -30 deg"
    assert set(cause.explains) == set(ERRORS)
    assert all(after < 1e-9 < before for before, after in cause.explains.values())


@pytest.mark.parametrize(("share", "way"), [(0.5, "later"), (-0.25, "earlier")])
def test_rows_that_belong_to_another_time(share: float, way: str) -> None:
    late = exact_table(SAW, ALL, times=PLACES["time"] + share * STEP)
    angle = math.degrees(abs(share) * STEP * 20.0)
    assert causes(late | {"time": PLACES["time"]}) == [
        (
            "time offset",
            f"each row belongs {abs(share) * STEP:.4g} s ({abs(share):.3g} of a step) {way} than its time says "
            f"(or the crank is {angle:.4g} deg off)",
        )
    ]


def test_a_crank_whose_zero_is_another() -> None:
    table = EXACT | {"crank_angle": EXACT["crank_angle"] - math.pi / 6.0}
    assert causes(table, *ALL)[0] == ("crank zero", "the table's crank angle is 0 where the scene's is 30 deg")


@pytest.mark.parametrize("quantity", ["velocity", "acceleration"])
@pytest.mark.parametrize(("share", "way"), [(0.5, "later"), (-0.25, "earlier")])
def test_rates_that_belong_to_another_time(quantity: str, share: float, way: str) -> None:
    late = exact_table(SAW, (quantity,), times=EXACT["time"] + share * STEP)
    table = exact_table(SAW, ALL, rows=30) | late | {"time": EXACT["time"]}
    assert causes(table) == [
        (f"{quantity} stamp",
         f"each {quantity} belongs {abs(share) * STEP:.4g} s ({abs(share):.3g} of a step) {way} than its row says")
    ]  # fmt: skip


def test_a_stamp_that_is_that_of_all_rows_is_no_further_cause() -> None:
    # Velocities are as late as all else: one cause, that explains all.
    late = exact_table(SAW, ALL, times=PLACES["time"] + 0.5 * STEP) | {"time": PLACES["time"]}
    (cause,) = likely_causes(TableComparison(late, SAW), tuple(ERRORS))
    assert cause.kind == "time offset"
    assert list(cause.explains) == list(ERRORS)


def test_velocity_stamp_of_a_pass_stays_within_linkage_reach() -> None:
    scene = scene_named("swinging-four-bar")
    first, last = sorted(angle / scene.speed for angle in scene.mechanism().driver.span or ())
    times = np.linspace(0.9 * first, 0.9 * last, 40)
    table = exact_table(scene, ("position", "velocity"), times=times)
    late = exact_table(scene, ("velocity",), times=times + 0.02 * (last - first))
    found = likely_causes(TableComparison(table | late | {"time": times}, scene), ("velocity",))
    assert [cause.kind for cause in found] == ["velocity stamp"]
    assert found[0].text.startswith(f"each velocity belongs {0.02 * (last - first):.4g} s (")


def test_a_dead_sensor_has_its_share_of_the_errors() -> None:
    table = PLACES | {"C.x": np.zeros_like(PLACES["C.x"])}
    (cause,) = likely_causes(TableComparison(table, SAW), ("total", "position"))
    assert cause == Cause("dead sensor", "C.x does not change: it is 0 m in all 61 rows", cause.explains)
    largest = np.abs(PLACES["C.x"]).max() / SAW.lengths["C"]
    for name in ("total", "position"):
        assert cause.explains[name] == (pytest.approx(largest), pytest.approx(0.0, abs=1e-12))


def test_a_fault_of_a_sensor_has_to_leave_what_is_allowed() -> None:
    rng = np.random.default_rng(2)
    table = PLACES | {"M.y": 0.97 * PLACES["M.y"] + 1e-5 * rng.normal(size=61)}
    # The least-squares factor of the exact column, which noise moves a little.
    gain = float(table["M.y"] @ PLACES["M.y"] / (PLACES["M.y"] @ PLACES["M.y"]))
    assert gain == pytest.approx(0.97, abs=1e-4)
    assert causes(table, "total", "position", position=1e-3) == [
        ("gain", f"M.y is {gain:.6g} times what it should be (a gain)")
    ]
    assert causes(table, "total", "position", position=1e-6) == []
    assert causes(table, "total", "position", total=1e-6, position=1e-3) != []


# -- studies ---------------------------------------------------------------------------------------------------------


def test_study_has_its_largest_errors_and_revolutions() -> None:
    study = table_study()
    assert study.revolutions == pytest.approx(3.0)
    assert replace(study, span=(1.0, 1.0 + HALVED.period)).revolutions == pytest.approx(1.0)
    assert (study.largest("total"), study.largest("position")) == (4e-3, 2e-3)
    assert study.largest("phase") == pytest.approx(math.radians(0.5))
    assert study.largest("velocity") is None
    errors = {**study.errors, "M": {"velocity": study.errors["C"]["total"]}}
    rates = replace(study, errors=errors)
    assert (rates.largest("velocity"), rates.largest("velocity_rms")) == (4e-3, 2e-3)
    assert study.passed is True
    assert replace(study, tolerance={}).passed is None
    assert replace(study, distrust="it contradicts itself").passed is False
    late = replace(study, tolerance={"position": 1e-3, "total": 4e-3, "velocity": 1.0, "phase": 1e-3})
    assert late.exceeded == {"position": (2e-3, 1e-3), "phase": (math.radians(0.5), 1e-3)}
    assert late.passed is False
    assert list(replace(study, phase=math.nan).exceeded) == ["phase"]


def judged_places(folder: Path, **tolerance: float) -> TableStudy:
    return judge_columns(PLACES, SAW, folder, tolerance=tolerance)


@pytest.mark.parametrize(("name", "what"), [
    ("velocity", "velocity"), ("velocity_rms", "velocity"), ("acceleration", "acceleration"), ("phase", "crank angle"),
])  # fmt: skip
def test_a_tolerance_without_a_column_is_refused(name: str, what: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidInput) as refused:
        judged_places(tmp_path, position=1e-3, **{name: 1e-3})
    assert str(refused.value) == f"--tolerance {name}: the table has no {what} column; conrod does not differentiate"


def test_notes_on_a_table(tmp_path: Path) -> None:
    table = {"time [s]": PLACES["time"], "C.x": PLACES["C.x"], "C.vy": 0.0 * PLACES["time"]}
    assert judge_columns(table, SAW, tmp_path).notes == (
        "no unit is given for C.x, C.vy: taken to be SI (s, m, rad); --unit says otherwise",
        "not in the table: crank_angle, crank_speed, crank_acceleration, C.y, C.vx, C.ax, C.ay, M.x, M.y, M.vx, M.vy, "
        "M.ax, M.ay; motion is not judged then, and the crank taken at its nominal",
        "C.vy: the exact motion stands still there, so that their errors say nothing of it",
    )
    twice = {name: np.repeat(own, 2)[: len(own) + 3] for name, own in PLACES.items()}
    assert judge_columns(twice, SAW, tmp_path).notes[0] == (
        "rows that repeat the time and all values of the row before are left out: 32"
    )


def test_a_clock_that_is_off_by_what_nobody_asked_for_has_a_note(tmp_path: Path) -> None:
    late = EXACT | {"time": EXACT["time"] + 1e-3}
    assert judge_columns(late, SAW, tmp_path, tolerance={"position": 1e-3}).notes[-1] == CLOCK_NOTE
    assert CLOCK_NOTE not in judge_columns(late, SAW, tmp_path, tolerance={"position": 1e-3, "phase": 1e-3}).notes
    assert CLOCK_NOTE not in judge_columns(EXACT, SAW, tmp_path, tolerance={"position": 1e-3}).notes


def test_facts_of_a_table_are_those_of_its_file(tmp_path: Path) -> None:
    study = judge_columns(PLACES, SAW, tmp_path, tolerance={"position": 1e-3})
    assert (study.file, study.scene_name, study.scene) == ("table.csv", "saw", SAW)
    assert (study.form, study.rows) == ("text, separated by commas, decimal points", 61)
    assert study.span == (0.0, pytest.approx(2.0 * SAW.period))
    assert [column.name for column in study.columns] == ["time", "C.x", "C.y", "M.x", "M.y"]
    assert (study.unused, study.estimates, study.phase, study.distrust) == ((), (), None, "")
    assert study.unjudged == ("velocity", "acceleration", "crank angle")
    shifted = judge_columns(PLACES | {"time": PLACES["time"] + 1.0}, SAW, tmp_path, ["time"])
    assert shifted.span == (1.0, pytest.approx(1.0 + 2.0 * SAW.period))
    assert [one.name for one in shifted.estimates] == ["time"]


def test_table_is_not_passed_by_a_motion_that_contradicts_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("conrod.models.tables.study.misfit_words", lambda misfit: "it contradicts itself")
    study = judged_places(tmp_path, position=1e-3)
    assert (study.distrust, study.passed) == ("it contradicts itself", False)


def test_a_table_that_leads_out_of_its_pass_is_refused(tmp_path: Path) -> None:
    scene = scene_named("swinging-four-bar")
    span = scene.mechanism().driver.span or (0.0, 0.0)
    times = np.linspace(*sorted(angle / scene.speed for angle in span), 30)
    table = exact_table(scene, times=times)
    assert judge_columns(table, scene, tmp_path, tolerance={"position": 1e-3}).passed is True
    begin, end = (math.degrees(angle) for angle in span)
    with pytest.raises(InvalidInput) as refused:
        judge_columns(table | {"time": times + 1.0}, scene, tmp_path)
    found = sorted(math.degrees(scene.speed * (time + 1.0)) for time in (times[0], times[-1]))
    assert str(refused.value) == (
        f"the table's times lead from crank angle {found[0]:.6g} to {found[1]:.6g} deg, out of the pass from "
        f"{begin:.6g} to {end:.6g} deg: time 0 is that of crank angle 0, so that the pass begins at {times[0]:.6g} s"
    )
    with pytest.raises(InvalidInput, match="out of the pass"):
        judge_columns(table | {"time": times - 1.0}, scene, tmp_path)
