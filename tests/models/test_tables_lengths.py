"""A length, a speed or columns that a table was made with by mistake are named; healthy tables name nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import conrod
from conrod.models.tables.consistency import _missed_changes, contradictory_quantities
from conrod.models.tables.errors import TableComparison
from conrod.models.tables.lengths import _LengthSearch
from conrod.report.findings import Findings
from conrod.scenes import SCENES, Scene

SAW, CRANK = SCENES["saw-500rpm"], conrod.scene("slider-crank")
ROWS = 121


def exact_table(
    scene: Scene, turns: float = 2.0, *, start: float = 0.0, rates: bool = False, rows: int = ROWS
) -> dict[str, Any]:
    """Exact positions, and velocities and accelerations if asked for, of all points at even times."""
    times = np.linspace(0.0, turns * scene.period, rows)
    motion, values = scene.motion(scene.speed * times + start, scene.speed), {"time": times}
    for point in scene.lengths:
        for letter, name in (("", "position"), ("v", "velocity"), ("a", "acceleration"))[: 3 if rates else 1]:
            series = getattr(motion.point(point), name)
            values |= {f"{point}.{letter}{axis}": series[:, k].copy() for k, axis in enumerate("xy")}
    return values


def changed(scene: Scene, name: str, by: float) -> Scene:
    return scene.with_parameters(**{name: scene.parameters[name] + by})


def check(values: dict[str, Any], scene: Scene = SAW, **arguments: Any) -> Findings[Any]:
    return conrod.check(values, scene, **{"tolerance": {"position": 1e-4}, **arguments})


def test_verdict_without_a_tolerance_says_how_far_and_why() -> None:
    longer = exact_table(changed(SAW, "rod", 3e-4))
    rod = "likely cause: rod is 0.1 % too long: 300.3 mm instead of 300 mm; "
    found = check(longer, tolerance=None)
    assert found.passed is None
    assert found.verdict == f"measured, not judged: position off by 8.1e-4 (0.16 mm); {rod}give --tolerance"
    # Negative control: without a cause none is named.
    right = check(exact_table(SAW), tolerance=None).verdict
    assert right.startswith("measured, not judged: position off by < 1e-12 (")
    assert "cause" not in right


def kinds(found: Findings[Any]) -> list[str]:
    return [cause.kind for cause in found.study.causes]


def test_a_rod_that_is_too_long_is_named_with_its_size() -> None:
    found = check(exact_table(changed(SAW, "rod", 3e-4), rates=True))
    assert kinds(found) == ["length"]
    assert found.study.causes[0].text == "rod is 0.1 % too long: 300.3 mm instead of 300 mm"
    assert set(found.study.causes[0].explains) >= {"position", "total", "velocity"}


def test_a_frame_offset_is_no_cause_where_a_length_is() -> None:
    noise = 2e-7 * np.random.default_rng(3).standard_normal(ROWS)
    values = exact_table(changed(CRANK, "bodies.rod.points.B.x", 4e-4))
    found = check(values | {name: values[name] + noise for name in values if name.endswith(".x")}, CRANK)
    assert kinds(found)[0] == "length"
    assert "frame" not in kinds(found)
    # The control: another origin is another origin.
    shifted = {name: own + (4e-4 if name.endswith(".x") else 0.0) for name, own in exact_table(CRANK).items()}
    assert "frame" in kinds(check(shifted, CRANK))
    assert "length" not in kinds(check(shifted, CRANK))


@pytest.mark.slow
def test_two_lengths_are_named_where_no_one_explains() -> None:
    found = check(exact_table(changed(changed(SAW, "rod", 3e-4), "crank", -2e-4)))
    assert "lengths" in kinds(found)
    text = next(cause.text for cause in found.study.causes if cause.kind == "lengths")
    assert "300.3 mm instead of 300 mm" in text
    assert "99.8 mm instead of 100 mm" in text


@pytest.mark.parametrize("with_angle", [False, True])
def test_a_speed_that_is_slightly_off_is_named(with_angle: bool) -> None:
    other = SAW.with_parameters(speed=SAW.speed * (1.0 + 3e-5))
    values = exact_table(other, 5.0)
    if with_angle:
        values["crank_angle"] = other.speed * values["time"]
    found = check(values)
    assert found.passed is False
    assert "crank speed" in kinds(found)
    assert any("the crank turns at 500.015 rpm, not at 500 rpm" in cause.text for cause in found.study.causes)


def test_accelerations_that_contradict_velocities_are_named() -> None:
    values = exact_table(SAW, rates=True)
    half = values | {name: 0.5 * own for name, own in values.items() if ".a" in name}
    found = check(half)
    assert found.passed is True
    assert "acceleration (off by " in found.verdict
    assert "its accelerations contradict the table's own velocities" in found.verdict
    whole = check(values)
    assert "contradict" not in whole.verdict
    assert "velocity (off by < 1e-12, <" in whole.verdict


@pytest.mark.parametrize(("rod", "found"), [(0.42, True), (0.46, False)])
def test_a_length_is_fitted_up_to_half_of_the_machines_size(rod: float, found: bool) -> None:
    # The rod of 0.3 m is its largest length.
    search = _LengthSearch(TableComparison(exact_table(changed(SAW, "rod", rod - 0.3)), SAW), "position")
    fit = search.fit(["rod"])
    assert (fit is not None) is found
    assert fit is None or fit[0] == {"rod": pytest.approx(rod, rel=1e-9)}


@pytest.mark.parametrize(("apart", "found"), [(1e-8, False), (1e-4, True)])
def test_lengths_with_one_effect_are_not_fitted_together(apart: float, found: bool) -> None:
    search = _LengthSearch(TableComparison(exact_table(changed(SAW, "rod", 3e-6)), SAW), "position")
    rod, crank = (search.slopes[name] for name in ("rod", "crank"))
    search.__dict__["slopes"] = {"rod": rod, "crank": rod + apart * crank}
    assert (search.fit(["rod", "crank"]) is not None) is found


def healthy_tables() -> dict[str, dict[str, Any]]:
    """Ten tables of the saw's right motion, as tools and sensors write it."""
    whole, random = exact_table(SAW, rates=True), np.random.default_rng(5)

    def noisy(share: float, begin: str = "") -> dict[str, Any]:
        return whole | {
            name: own + share * np.ptp(own) * random.standard_normal(len(own))
            for name, own in whole.items()
            if "." in name and name.split(".")[1].startswith(begin)
        }

    def rounded(digits: int) -> dict[str, Any]:
        return {name: np.array([float(f"{one:.{digits - 1}e}") for one in own]) for name, own in whole.items()}

    keep = np.sort(random.choice(ROWS, 80, replace=False))
    started = exact_table(SAW, start=1.0, rates=True)
    return {
        "exact": whole,
        "noise": noisy(1e-5),
        "noisy accelerations": noisy(0.05, "a"),
        "noisy velocities": noisy(0.01, "v"),
        "four digits": rounded(4),
        "five digits": rounded(5),
        "rows missing": {name: own[keep] for name, own in whole.items()},
        "few rows": {name: own[::10] for name, own in whole.items()},
        "part of a turn": exact_table(SAW, 0.3, rates=True),
        "another start": started | {"crank_angle": SAW.speed * started["time"] + 1.0},
    }


@pytest.mark.parametrize("name", healthy_tables())
def test_a_healthy_table_contradicts_nothing(name: str) -> None:
    values = healthy_tables()[name]
    table = TableComparison({one: np.asarray(own) for one, own in values.items()}, SAW)
    assert contradictory_quantities(table) == ()


@pytest.mark.parametrize("rows", [13, 25])
def test_integrals_of_exact_rates_miss_nothing_in_coarse_rows(rows: int) -> None:
    values = exact_table(SAW, rates=True, rows=rows)
    for of, rate in (("position", "velocity"), ("velocity", "acceleration")):
        assert [missed for missed, _ in _missed_changes(TableComparison(values, SAW), of, rate)] == [0.0] * 4
    # The control: half of each acceleration is missed.
    half = values | {name: 0.5 * own for name, own in values.items() if ".a" in name}
    missed = [size for size, _ in _missed_changes(TableComparison(half, SAW), "velocity", "acceleration")]
    assert min(missed[0], missed[2], missed[3]) > 0.1  # C goes along x


@pytest.mark.slow
@pytest.mark.parametrize("name", healthy_tables())
def test_no_length_or_speed_is_blamed_in_a_healthy_table(name: str) -> None:
    tolerance = {"position": 1e-9} if name != "exact" else {"position": 1e-4}
    blamed = {"length", "lengths", "crank speed", "frame"}
    assert not blamed & set(kinds(check(healthy_tables()[name], tolerance=tolerance)))
