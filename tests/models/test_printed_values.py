"""`conrod audit`: printed values of a user's own, judged row by row, or refused in one line that names the row."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from command_line import conrod, refusal
from table_files import write_file

from conrod.errors import InvalidInput
from conrod.models.printed.table import audit_file, audit_table
from conrod.models.printed.verdicts import PrintedNumber, VerdictKind
from conrod.scenes import ShearPress, catalogue_text, scene_named

ROOT = Path(__file__).parents[2]
HEADING = "scene,quantity,angle_deg,printed,unit\n"
GOOD = "shear-press,G velocity y,10,-33.3,mm/s\n"
PRESS = ShearPress()


def speeds(turn: float = math.pi / 180.0, factor: float = 1e3) -> list[str]:
    """Printed velocities of A every ten degrees, mm/s with two digits."""
    angles = range(10, 180, 10)
    return [f"{PRESS.motion([k * turn], PRESS.speed).point('A').velocity[0, 1] * factor:.2f}" for k in angles]


def table(printed: list[str]) -> str:
    rows = (f"shear-press,A velocity y,{10 * k},{text},mm/s" for k, text in enumerate(printed, start=1))
    return HEADING + "\n".join(rows)


def test_cause_is_named_for_a_column_and_not_for_a_single_value() -> None:
    verdicts = audit_table("mine", table(speeds(3.14 / 180.0)))
    assert VerdictKind.EXPLAINED in {v.kind for v in verdicts} <= {VerdictKind.EXPLAINED, VerdictKind.AGREES}
    assert all("3.14 " in v.reason for v in verdicts if v.kind is VerdictKind.EXPLAINED)
    verdict = audit_table("mine", table(speeds(factor=1.0)))[8]
    assert (verdict.kind, verdict.should_be) == (VerdictKind.WRONG_STEP, "-186.88")
    # Negative control: one wrong value among right ones.
    printed = speeds()
    printed[3] = speeds(3.14 / 180.0)[3]
    verdict = audit_table("mine", table(printed))[3]
    assert (verdict.kind, verdict.should_be) == (VerdictKind.NOT_REPRODUCIBLE, speeds()[3])


def test_audit_of_a_pass_stays_where_the_machine_goes() -> None:
    scene, angles = scene_named("swinging-four-bar"), range(-10, 60, 10)
    values = scene.motion([math.radians(k) for k in angles], scene.speed).point("B").velocity[:, 0]
    pairs = zip(angles, values, strict=True)
    rows = [f"swinging-four-bar,B velocity x,{k},{value / 10.0:.3f},m/s" for k, value in pairs]
    found = audit_table("mine", HEADING + "\n".join(rows))
    assert VerdictKind.WRONG_STEP in {v.kind for v in found}
    assert all("a unit 10 times as large" in v.reason for v in found if v.kind is VerdictKind.WRONG_STEP)


def test_parameters_decimal_commas_and_a_typeset_minus_are_read() -> None:
    text = HEADING.replace("unit\n", "unit,parameters\n") + "saw-40rpm,C position x,180,-250,mm,crank=125mm; offset=0\n"
    assert audit_table("mine", text)[0].kind is VerdictKind.AGREES
    assert audit_table("mine", text.replace("125", "124"))[0].kind is not VerdictKind.AGREES
    found = audit_table("mine", HEADING.replace(",", ";") + "shear-press;A velocity y;12,5;\u221244,04;mm/s\n")[0]
    exact = PRESS.motion([math.radians(12.5)], PRESS.speed).point("A").velocity[0, 1] * 1e3
    assert (found.exact, found.condition, found.printed) == (pytest.approx(exact), "12.5 deg", "-44,04")


@pytest.mark.parametrize(("text", "value", "rounds", "cuts"), [
    ("63,45", 63.457, False, True),
    ("63.46", 63.457, True, False),
    ("-2.3", 2.34, False, False),
    ("520,408", 520.40816, True, True),
])  # fmt: skip
def test_printed_digits_round_and_cut(text: str, value: float, rounds: bool, cuts: bool) -> None:
    assert (PrintedNumber(text).is_rounding_of(value), PrintedNumber(text).is_truncation_of(value)) == (rounds, cuts)


# -- as a user calls it ------------------------------------------------------------------------------------------------


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_example_of_the_documentation_gives_what_it_says(here: Path) -> None:
    text = (ROOT / "docs" / "audit.md").read_text(encoding="utf-8")
    values = re.findall(r"```csv\n(.*?)```", text, re.DOTALL)[0]
    told = re.findall(r"```text\n(.*?)```", text, re.DOTALL)[0]
    write_file(here, values, "velocities.csv")
    result = conrod("audit", "velocities.csv")
    assert (result.returncode, result.stdout) == (0, told)
    # Negative control: with the digits put right nothing is told.
    write_file(here, values.replace("-146.1", "-164.1"), "velocities.csv")
    assert "should be" not in conrod("audit", "velocities.csv").stdout


def test_a_users_report_has_a_page_and_its_numbers(here: Path) -> None:
    write_file(here, HEADING + GOOD + GOOD.replace("-33.3", "-33.4"), "My table.csv")
    result = conrod("audit", "My table.csv", "--out", "found")
    assert (result.returncode, result.stdout.splitlines()[-1]) == (0, "report: found/my-table.md")
    entry = json.loads((here / "found" / "results.json").read_text(encoding="utf-8"))["parts"]["my-table"]
    assert entry["command"] == "conrod audit 'My table.csv' --out found"
    findings = json.loads((here / "found" / entry["data"]).read_text(encoding="utf-8"))
    assert [item["kind"] for item in findings["verdicts"]] == ["agrees", "not reproducible as printed"]
    # Pages of other files stay, and all are rendered again from what was saved.
    page = (here / "found" / "my-table.md").read_text(encoding="utf-8")
    write_file(here, HEADING + GOOD, "other.csv")
    assert conrod("audit", "other.csv", "--out", "found").returncode == 0
    assert conrod("report", "found", "--out", "again").returncode == 0
    assert (here / "again" / "my-table.md").read_text(encoding="utf-8") == page


def test_table_uses_mechanism_file_only_from_its_own_folder(here: Path) -> None:
    own, row = write_file(here, catalogue_text("slider-crank"), "mine.toml"), "mine.toml,B position x,0,860.0,mm\n"
    rows = (row, row.replace("mine.toml", "slider-crank"))
    found = [audit_file(write_file(here, HEADING + text)).verdicts for text in rows]
    assert [(v.exact, v.kind) for v in found[0]] == [(v.exact, v.kind) for v in found[1]]
    (here / "tables").mkdir()
    (here / "tables" / "link.toml").symlink_to(own)
    for name in ("sub/../../mine.toml", "link.toml"):
        outside = write_file(here / "tables", HEADING + row.replace("mine.toml", name))
        assert "leads out of the folder of the table" in refusal("audit", str(outside))


@pytest.mark.parametrize(("text", "message"), [
    (HEADING + GOOD.replace("shear-press", "shear-pres"), "values.csv: row 2: unknown scene .*mean 'shear-press'"),
    (HEADING + GOOD.replace("G velocity", "H velocity"), "unknown point 'H': choose from A, G"),
    (HEADING + GOOD.replace("-33.3", "1e3"), "is not a decimal number"),
    (HEADING + GOOD.replace("-33.3", "9" * 400), "row 2: printed value '9999"),
    (HEADING + GOOD.replace("mm/s", "mm"), "'mm' is not a unit of m/s"),
    (HEADING + "shear-press", "row 2: quantity: nothing is given"),
    (HEADING + GOOD + GOOD.replace(",10,", ",ten,"), "row 3: angle_deg = 'ten'"),
    (HEADING + "missing.toml,G velocity y,0,1.0,mm/s\n", r"row 2: .*missing.toml: there is no such file"),
    (HEADING + "swinging-four-bar,B velocity x,170,1.0,m/s\n", "angle_deg = 170: swinging-four-bar is driven from"),
    (HEADING.replace(",unit", ""), "no column 'unit'"),
    (HEADING.replace("unit", "units"), "unknown column 'units': did you mean 'unit'"),
    (HEADING, "no rows below the heading"),
])  # fmt: skip
def test_unusable_table_or_row_is_named_in_one_line(here: Path, text: str, message: str) -> None:
    write_file(here, HEADING + GOOD, "values.csv")
    assert conrod("audit", "values.csv").returncode == 0
    write_file(here, text, "values.csv")
    assert re.search(message, refusal("audit", "values.csv"))


def test_files_that_are_no_tables_are_refused(here: Path) -> None:
    assert "there is no such file" in refusal("audit", "missing.csv")
    (here / "bytes.csv").write_bytes(b"\xff\xfe\x00")
    assert "no text in UTF-16" in refusal("audit", "bytes.csv")
    write_file(here, HEADING + GOOD, "README.csv")
    assert "is taken" in refusal("audit", "README.csv")


# -- rotations of links ------------------------------------------------------------------------------------------------

# What document 001 prints of its links, at the instant that is crank angle 0.
MODULE = [
    ("two-slider-linkage", "rod-3 omega", "-21,88", "rad/s"), ("two-slider-linkage", "crank omega", "104.72", "rad/s"),
    ("swinging-four-bar", "crank omega", "-60", "rad/s"), ("six-bar", "crank omega", "-62,83", "rad/s"),
    ("six-bar", "slider omega", "0", "rad/s"), ("six-bar", "slider alpha", "0", "rad/s^2"),
    ("rack-and-wheel", "rod omega", "20", "rad/s"), ("rack-and-wheel", "wheel omega", "20", "rad/s"),
    ("rack-and-wheel", "wheel alpha", "0", "rad/s^2"),
]  # fmt: skip


def link_table(rows: list[tuple[str, str, str, str]], angle: str = "0") -> str:
    return HEADING + "\n".join(f'{scene},{what},{angle},"{value}",{unit}' for scene, what, value, unit in rows)


def test_rotations_of_document_001_agree_and_changed_ones_do_not() -> None:
    assert [v.kind for v in audit_table("001", link_table(MODULE))] == [VerdictKind.AGREES] * len(MODULE)
    off = [(scene, what, value[:-1] + str((int(value[-1]) + 5) % 10), unit) for scene, what, value, unit in MODULE]
    assert VerdictKind.AGREES not in {v.kind for v in audit_table("001", link_table(off))}


def test_angles_of_links_agree_in_any_turn_and_from_either_end() -> None:
    turned = [("saw-40rpm", "rod angle", text, "deg") for text in ("179.351", "-180.649", "539.351")]
    assert {v.kind for v in audit_table("a", link_table(turned, "60"))} == {VerdictKind.AGREES}
    rows = "\n".join(f"saw-40rpm,rod angle,{at},{other_end(at)},deg" for at in (10, 60, 90, 130))
    verdicts = audit_table("a", HEADING + rows)
    assert {v.cause for v in verdicts} == {"the link's angle counted from its other end"}


def other_end(degrees: int) -> str:
    """Angle [deg] of the saw's rod at a crank angle, counted from its other end."""
    saw = scene_named("saw-40rpm").kinematics
    rotation = saw.poses(np.radians([degrees]))[0, 3 * saw.mechanism.body_index["rod"] + 2]
    return f"{(math.degrees(rotation) + 180.0) % 360.0:.3f}"


@pytest.mark.parametrize(("quantity", "words"), [
    ("rod omeg", "unknown quantity of a link 'omeg': did you mean 'omega'?"),
    ("rode omega", "unknown link 'rode': did you mean 'rod'?"),
    ("omega", "or a link and angle/omega/alpha, like 'crank omega'"),
])  # fmt: skip
def test_unknown_rotation_is_refused_with_the_choices(quantity: str, words: str) -> None:
    with pytest.raises(InvalidInput, match=re.escape(words)):
        audit_table("a", HEADING + f"saw-40rpm,{quantity},60,0.698,rad/s\n")
