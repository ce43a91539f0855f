"""Columns of links' angles, angular velocities and accelerations in a table: read, judged, and their slips named."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from table_files import csv_text, read_file, write_file

import conrod
from conrod.exact.motion import Array
from conrod.models.tables.columns import quantities, quantity_named
from conrod.models.tables.study import TableStudy, study_table
from conrod.scenes import scene_named

SAW = scene_named("saw-40rpm")
ROD = ("angle_rod", "omega_rod", "alpha_rod")
LIMITS = {"rotation": 1e-6, "angular_velocity": 1e-6, "angular_acceleration": 1e-6}


@pytest.fixture(scope="module")
def exported() -> dict[str, Array]:
    """The exact trajectory as `conrod export` writes it, by heading."""
    head, *rows = str(conrod.export("saw-40rpm", "csv", steps_per_rev=60)).splitlines()
    return dict(zip(head.split(","), np.array([row.split(",") for row in rows], dtype=float).T, strict=True))


def judge(columns: Mapping[str, Array], folder: Path, limits: Mapping[str, float] | None = None) -> TableStudy:
    reading = read_file(write_file(folder, csv_text(columns)), SAW, links=("rod",))
    return study_table("t.csv", "saw-40rpm", SAW, reading, (), limits or LIMITS)


def changed(columns: Mapping[str, Array], **factors: float) -> dict[str, Array]:
    """The columns, some multiplied by factors."""
    return {name: values * factors.get(name.split(" ")[0], 1.0) for name, values in columns.items()}


def test_exported_rotations_are_judged_and_within(exported: dict[str, Array], tmp_path: Path) -> None:
    assert [name for name in exported if name.split(" ")[0] in ROD] == [
        "angle_rod [rad]", "omega_rod [rad/s]", "alpha_rod [rad/s^2]",
    ]  # fmt: skip
    table = write_file(tmp_path, csv_text(exported))
    study: TableStudy = conrod.check_table(table, "saw-40rpm", tolerance=LIMITS)["table"]
    assert study.passed
    assert set(study.errors["rod"]) == set(LIMITS)
    assert study.unjudged == ("position", "velocity", "acceleration")
    # Another way to say the same: degrees by their unit, counted to one turn.
    degrees = np.degrees(exported["angle_rod [rad]"]) % 360.0
    alone = {"time [s]": exported["time [s]"], "theta_rod [deg]": degrees}
    assert judge(alone, tmp_path, {"rotation": 1e-6}).passed


@pytest.mark.parametrize(("factors", "exceeded"), [
    ({"omega_rod": 1.001}, {"angular_velocity"}), ({"alpha_rod": 1.001}, {"angular_acceleration"}),
])  # fmt: skip
def test_rotation_is_out_of_tolerance_when_one_rate_is_off(
    exported: dict[str, Array], tmp_path: Path, factors: dict[str, float], exceeded: set[str]
) -> None:
    assert set(judge(changed(exported, **factors), tmp_path).exceeded) == exceeded


def test_slipped_turn_is_seen_and_a_jump_of_360_deg_is_none(exported: dict[str, Array], tmp_path: Path) -> None:
    angle, rows = exported["angle_rod [rad]"], np.arange(len(exported["time [s]"]))
    jumped = exported | {"angle_rod [rad]": angle + 2.0 * math.pi * (rows > 20)}
    assert judge(jumped, tmp_path).passed
    slipped = exported | {"angle_rod [rad]": angle + 2.0 * math.pi * np.clip((rows - 20) / 10, 0.0, 1.0)}
    study, size = judge(slipped, tmp_path), 2.0 * math.pi / SAW.kinematics.rotation_ranges["rod"]
    assert study.exceeded == {"rotation": (pytest.approx(size), 1e-6)}


SLIPS = {
    "degrees": (dict.fromkeys(ROD, math.degrees(1.0)), "links' rotations are 57.2958 times too large: degrees taken"),
    "degrees of angles": ({"angle_rod": math.degrees(1.0)}, "links' angles are 57.2958 times too large"),
    "rpm": ({"omega_rod": 30.0 / math.pi}, "links' angular velocities are 9.5493 times too large: rpm taken"),
    "clockwise": (dict.fromkeys(ROD, -1.0), "links' rotations are counted clockwise"),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_slip_of_links_is_named_as_the_cause(exported: dict[str, Array], tmp_path: Path, slip: str) -> None:
    factors, words = SLIPS[slip]
    study = judge(changed(exported, **factors), tmp_path)
    assert [cause.text[: len(words)] for cause in study.causes] == [words]


def test_speeds_of_links_alone_are_told_from_rpm(exported: dict[str, Array], tmp_path: Path) -> None:
    alone = {name: own for name, own in exported.items() if name.split(" ")[0] not in ROD or "omega" in name}
    study = judge(changed(alone, omega_rod=30.0 / math.pi), tmp_path, {"angular_velocity": 1e-6})
    words = "links' angular velocities are 9.5493 times too large: rpm taken for rad/s"
    assert [cause.text for cause in study.causes] == [words]


def test_angles_alone_are_all_rotations_that_slipped(exported: dict[str, Array], tmp_path: Path) -> None:
    alone = {name: own for name, own in exported.items() if name.split(" ")[0] not in ROD or "angle_rod" in name}
    study = judge(changed(alone, angle_rod=math.degrees(1.0)), tmp_path, {"rotation": 1e-6})
    words = "links' rotations are 57.2958 times too large: degrees taken for radians"
    assert [cause.text for cause in study.causes] == [words]


def test_another_line_of_the_link_is_named_with_its_angle(exported: dict[str, Array], tmp_path: Path) -> None:
    study = judge(exported | {"angle_rod [rad]": exported["angle_rod [rad]"] + math.radians(90.0)}, tmp_path)
    assert [cause.kind for cause in study.causes] == ["link angle zero"]
    assert study.causes[0].text.endswith("rod by 90 deg")


def test_limit_on_rotation_is_refused_without_a_column(exported: dict[str, Array], tmp_path: Path) -> None:
    points = {name: values for name, values in exported.items() if name.split(" ")[0] not in ROD}
    with pytest.raises(conrod.InvalidInput, match="the table has no angular velocity column"):
        judge(points, tmp_path, {"angular_velocity": 1e-6})


@pytest.mark.parametrize(("heading", "name"), [
    ("angle_rod", "angle_rod"), ("theta rod", "angle_rod"), ("rod.angle", "angle_rod"), ("Omega Rod", "omega_rod"),
    ("angular velocity rod", "omega_rod"), ("alpha_rod", "alpha_rod"), ("omega", "crank_speed"), ("rod", None),
])  # fmt: skip
def test_heading_names_a_rotation_of_a_link(heading: str, name: str | None) -> None:
    assert quantity_named(heading, list(quantities(("C", "M"), ("rod",))), ("C", "M")) == name
