"""Every printed number and formula of the documents has a verdict, and no verdict comes without its computation."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from audits.__main__ import report
from audits.cam_survey import LARGEST_PRESSURE_ANGLE, cams, pressure_angles
from audits.documents import module, press
from audits.documents.arc_cam import ArcCam
from audits.documents.cam import CASES as CAM_CASES
from audits.documents.module_linkages import RackLinkage, SixBar, least_misfit
from audits.documents.press import exact, table
from audits.items import items_of, shipped_items
from audits.judged import audit
from audits.judging import Case, Explanation, Item, judge
from conrod.engines import ENGINES, engine_named
from conrod.engines.run import run_in_one_piece
from conrod.errors import InvalidInput
from conrod.models.printed.verdicts import PrintedNumber, VerdictKind
from conrod.report.writer import render_again
from conrod.scenes import ShearPress, catalogue_scene

# -- the documents ---------------------------------------------------------------------------------------------------


def test_audit_refuses_unknown_document_or_missing_column() -> None:
    with pytest.raises(InvalidInput, match="000, 001, 002, 004"):
        audit("003")
    with pytest.raises(InvalidInput, match="no column 'unit'"):
        list(items_of("mine", "key,place,line,quantity,condition,printed,mechanism\n"))


def test_only_truncated_constants_reproduce_the_press_cells() -> None:
    rows = press.table()
    degrees = np.array([float(row["theta_deg"]) for row in rows])
    misprints = {("ayG", "130"), ("ayG", "230")}

    def missed(columns: dict[str, np.ndarray]) -> set[tuple[str, str]]:
        return {
            (name, row["theta_deg"])
            for name, values in columns.items()
            for row, value in zip(rows, values, strict=True)
            if not PrintedNumber(row[name]).is_rounding_of(float(value))
        }

    assert missed(press.worked(degrees)) == misprints
    assert len(missed(press.exact(degrees))) == 117
    # Negative controls: each of the four constants is needed.
    for whole in ({"pi": math.pi}, {"third": 1.0 / 3.0}, {"two_thirds": 2.0 / 3.0}, {"ninth": 1.0 / 9.0}):
        assert missed(press.worked(degrees, **whole)) > misprints


@pytest.mark.parametrize(
    ("column", "quantity", "printed", "kind", "right"),
    [
        ("vyG", "velocity of G, y", "-146.1", VerdictKind.MISPRINT, "-164.1"),  # its size and its x contradict it
        ("yG", "y of G", "154.90", VerdictKind.NOT_REPRODUCIBLE, "145.91"),  # no neighbour fixes a position
    ],
)
def test_a_planted_wrong_cell_is_judged_by_its_neighbours(
    column: str, quantity: str, printed: str, kind: VerdictKind, right: str
) -> None:
    rows = [dict(row) for row in press.table()]
    assert rows[12][column] != printed
    rows[12][column] = printed
    cases = (case for case in press.cases(rows) if case.item.condition == "theta = 60 deg")
    verdict = next(judge(case) for case in cases if case.item.quantity == quantity)
    assert (verdict.kind, verdict.should_be) == (kind, right)


@pytest.mark.parametrize(
    ("document", "name", "cases"), [("001", "module.csv", module.CASES), ("004", "cam.csv", CAM_CASES)]
)
def test_a_planted_wrong_value_never_agrees(document: str, name: str, cases: dict) -> None:
    for item in shipped_items(document, name):
        wrong = replace(item, number=PrintedNumber(item.number.format_like(3.7 * item.number.value + 4.0)))
        before, after = (judge(cases[one.key](one)) for one in (item, wrong))
        assert after.kind not in (
            VerdictKind.AGREES,
            VerdictKind.AFTER_ROUNDING,
            VerdictKind.EXPLAINED,
            VerdictKind.WRONG_STEP,
        ), after
        assert after.printed != before.printed


def test_each_slip_of_the_cam_paper_matches_one_row_alone() -> None:
    flanks = (88.0, 98.0, 108.0, 118.0)
    values = [abs(float(c.series(c.joint_c, "nose")[2, 0])) for c in (ArcCam(36.0, rho) for rho in flanks)]
    assert [PrintedNumber("217,314").is_rounding_of(value) for value in values] == [False, False, True, False]
    found = [
        (rho, angle)
        for rho in (72.5, *flanks)
        for angle in (160.0, 162.228, 162.244, 162.728, 163.323)
        if PrintedNumber("-89,616").is_rounding_of(float(ArcCam(36.0, rho).series(angle, "flank")[3, 0]))
    ]
    assert found == [(88.0, 162.228)]


def test_unsupported_number_of_lost_polygon_is_not_reproducible() -> None:
    # A millimetre and a half of the drawing more than what is printed.
    item = next(i for i in shipped_items("001", "module.csv") if i.key == "6.15-vxc")
    found = [
        judge(module.CASES[item.key](replace(item, number=PrintedNumber(text)))).kind
        for text in (item.number.text, "25,7")
    ]
    assert found == [VerdictKind.AFTER_ROUNDING, VerdictKind.NOT_REPRODUCIBLE]


def test_pressure_angle_lies_between_follower_and_centre_line() -> None:
    cam = cams()[4]
    angle = 150.0
    sine = (cam.flank - cam.base) * math.sin(math.radians(angle - cam.joint_b)) / (cam.flank + 9.0)
    found = float(pressure_angles(cam, cam.exact(angle), 9.0)[0])
    assert found == pytest.approx(math.degrees(math.asin(sine)), abs=1e-10)
    assert found > LARGEST_PRESSURE_ANGLE


# -- linkages whose drawings are lost ------------------------------------------------------------------------------


def test_six_bar_has_printed_lengths_and_consistent_velocities() -> None:
    bar = SixBar()
    place = {**bar.places, "X": bar.auxiliary}
    for (a, b), length in {("O12", "A"): 0.2, ("A", "B"): 0.53, ("D", "B"): 0.53, ("B", "C"): 0.29, ("C", "D"): 0.45,
                           ("O15", "C"): 0.49, ("X", "B"): 1.05, ("X", "D"): 0.9}.items():  # fmt: skip
        arm, going = place[a] - place[b], bar.velocities[a] - bar.velocities[b] if a != "O12" else bar.velocities["A"]
        assert math.hypot(*arm) == pytest.approx(length, abs=1e-12)
        if a != "O12":
            assert abs(float(arm @ going)) < 1e-12
    assert abs(float(bar.velocities["D"] @ np.array([-bar.slide[1], bar.slide[0]]))) < 1e-12


def test_no_six_bar_pose_gives_the_printed_velocity_polygon() -> None:
    # A millimetre of the drawing is 0.2 m/s.
    assert least_misfit() > 0.9


def test_rack_linkage_speeds_and_accelerations_match_catalogue() -> None:
    scene, linkage = catalogue_scene("rack-and-wheel"), RackLinkage()
    points = scene.motion([0.0], scene.speed).points
    b, c = points["B"], points["C"]
    going, turning = c.velocity[0], (c.velocity - b.velocity)[0]
    assert math.hypot(*b.velocity[0]) == pytest.approx(linkage.speed_b, rel=1e-12)
    assert math.hypot(*going) == pytest.approx(linkage.speed_c, rel=1e-11)
    assert math.hypot(*turning) == pytest.approx(linkage.relative, rel=1e-11)
    along, rod = going / math.hypot(*going), turning / math.hypot(*turning)
    across_c, across_rod = linkage.tangential(6.0**2 / 0.3)
    assert abs(float(c.acceleration[0] @ along)) == pytest.approx(across_c, rel=1e-11)
    assert abs(float((c.acceleration - b.acceleration)[0] @ rod)) == pytest.approx(across_rod, rel=1e-11)


# -- the engine of verdicts ------------------------------------------------------------------------------------------

ITEM = Item("test", "key", "here", 1, "length", "", PrintedNumber("2.35"), "mm", "")
NEAR_MISSES = (Explanation("pi = 3.14", 2.3551), Explanation("pi = 22/7", 2.3449))


@pytest.mark.parametrize(("exact", "more", "kind"), [
    (2.3541, {}, VerdictKind.AGREES),
    (2.3591, {}, VerdictKind.AFTER_ROUNDING),
    (2.40, {"causes": (Explanation("pi = 3.14", 2.3502),)}, VerdictKind.EXPLAINED),
    (2.85, {"neighbours": (Explanation("beside", 2.85, 0.01),)}, VerdictKind.MISPRINT),
    # A neighbour that contradicts the exact value too proves no misprint.
    (2.85, {"neighbours": (Explanation("beside", 3.85, 0.01),)}, VerdictKind.NOT_REPRODUCIBLE),
    (2.40, {"wrong_steps": (Explanation("5 for 6", 2.3549),)}, VerdictKind.WRONG_STEP),
    (2.40, {"reading": 0.1}, VerdictKind.AFTER_ROUNDING),
    (2.40, {"causes": NEAR_MISSES, "wrong_steps": NEAR_MISSES[1:]}, VerdictKind.NOT_REPRODUCIBLE),
])  # fmt: skip
def test_each_verdict_requires_a_value_that_rounds_to_the_print(
    exact: float, more: dict[str, Any], kind: VerdictKind
) -> None:
    assert judge(Case(ITEM, exact, "sum", **more)).kind is kind


# -- engines meet the printed table of document 000 in the cells that the exact motion rounds to -----------------------

# Printed every 5 degrees, which 7200 steps have samples at; run in for ten, in which soft closures come to rest.
STEPS, LEAD = 7200, 200
ALLOWED = 0.55  # of the last printed unit: half of it is the rounding of the print
MM, UNITS = 1e-3, {"position": 0.01, "velocity": 0.1, "acceleration": 0.1}
ROWS = table()
ANGLES = np.array([float(row["theta_deg"]) for row in ROWS])


@pytest.mark.parametrize("preset", ["tuned", "hardened"])
@pytest.mark.parametrize("engine", ENGINES)
def test_every_judged_preset_meets_all_cells_that_are_right(engine: str, preset: str) -> None:
    used, press = engine_named(engine), ShearPress()
    if preset not in used.presets:
        pytest.skip("it has no such preset")
    settings, start = used.presets[preset](press, STEPS), -2.0 * np.pi * LEAD / STEPS
    run, right, agreed = run_in_one_piece(used, press, settings, 1.0 + 2.0 * LEAD / STEPS, start), exact(ANGLES), 0
    for quantity, columns in (("position", "xG yG"), ("velocity", "vxG vyG vG"), ("acceleration", "axG ayG aG")):
        track = getattr(run.points["G"], quantity)
        found = [np.interp(np.radians(ANGLES), track.instants.angle, values) / MM for values in track.values.T]
        for name, measured in zip(columns.split(), [*found, np.hypot(*found)], strict=False):
            printed, unit = np.array([float(row[name]) for row in ROWS]), UNITS[quantity]
            agrees = np.abs(right[name] - printed) <= 0.5 * unit * (1.0 + 1e-9)
            agreed += int(agrees.sum())
            assert (np.abs(measured - printed)[agrees] <= ALLOWED * unit).all(), name
    assert agreed == 467


# -- the committed report is what the code produces --------------------------------------------------------------------

REPORT = Path(__file__).parents[2] / "reports" / "audit"
# The versions of what made a report stand in its results, and are others elsewhere.
MADE_BY = ("conrod", "environment")


@pytest.fixture(scope="module")
def files() -> dict[str, str]:
    return {name: str(content) for name, content in report(REPORT).files.items()}


def without_versions(text: str) -> object:
    found = json.loads(text)
    parts = found.get("parts", {})
    for values in (found, *parts.values()):
        for name in MADE_BY:
            values.pop(name, None)
    return found


def test_the_committed_report_is_what_the_code_produces(files: dict[str, str]) -> None:
    committed = {str(path.relative_to(REPORT)): path for path in REPORT.rglob("*") if path.is_file()}
    assert sorted(committed) == sorted(files)
    for name, content in files.items():
        there = committed[name].read_text(encoding="utf-8")
        same = without_versions(there) == without_versions(content) if name.endswith(".json") else there == content
        assert same, f"{name}: make audit"


def test_audit_report_is_rendered_again_from_saved_findings(files: dict[str, str]) -> None:
    (again,) = render_again(REPORT)
    assert {name: text for name, text in again.files.items() if name.endswith(".md")} == {
        name: text for name, text in files.items() if name.endswith(".md")
    }


def test_audit_report_shows_no_trace_of_rounding(files: dict[str, str]) -> None:
    for name, content in files.items():
        if name.endswith((".md", ".json")):
            assert not re.search(r"\de-1[0-9]", content), name
