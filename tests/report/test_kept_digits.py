"""Reports are the same on every machine: a number that is found again keeps its digits, and another one does not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from conrod.execution.writing import write_together
from conrod.report.folder import EXACT_FIELDS, plain_findings, restore_findings
from conrod.report.kept_digits import keep_earlier_digits
from conrod.report.kind import Reproduction
from conrod.report.numbers import round_reproducibly
from conrod.report.writer import report_batch
from conrod.studies.validation.report import VALIDATION_REPORT
from conrod.studies.validation.results import SceneStudy
from tests.report.test_frame import contents
from tests.report.test_report import COMMAND, a_result, a_study

BETWEEN = 1.234565e-6  # between two numbers of six digits: its last bit decides which
PLACES = VALIDATION_REPORT.places


def moved(values: Any, share: float) -> Any:
    """Plain findings with all measured fractions changed by a share of themselves."""
    if isinstance(values, dict):
        given = (*EXACT_FIELDS, "scene")
        return {key: part if key in given else moved(part, share) for key, part in values.items()}
    if isinstance(values, list):
        return [moved(part, share) for part in values]
    return values * (1.0 + share) if isinstance(values, float) else values


def write_moved(folder: Path, share: float, command: Reproduction = COMMAND) -> dict[str, bytes]:
    """Write a report whose values are moved by a share; return its files."""
    study = a_study("saw-40rpm", a_result("saw-40rpm", BETWEEN))
    found = restore_findings(SceneStudy, moved(plain_findings(study), share))
    write_together([report_batch(VALIDATION_REPORT, {found.name: found}, folder, command)])
    return contents(folder)


def kept(before: Any, now: Any, digits: int | None = 6) -> Any:
    return keep_earlier_digits(before, now, digits, EXACT_FIELDS, PLACES)


@pytest.fixture(autouse=True)
def without_figures(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw no figures, which are made of the saved findings alone and take seconds, but in slow tests."""
    if request.node.get_closest_marker("slow") is None:
        monkeypatch.setattr("conrod.report.figure.Figure.svg", lambda figure: figure.alt)


@pytest.mark.parametrize("figures", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_no_byte_of_a_report_changes_by_last_bits(tmp_path: Path, figures: bool) -> None:
    before = write_moved(tmp_path, 0.0)
    assert round_reproducibly(BETWEEN * (1.0 - 1e-15), 6) != round_reproducibly(BETWEEN, 6)  # else it shows nothing
    assert all(write_moved(tmp_path, share) == before for share in (-1e-15, 1e-15))


def test_a_report_changes_by_what_can_be_seen(tmp_path: Path) -> None:
    before, after = write_moved(tmp_path, 0.0), write_moved(tmp_path, 1e-4)
    changed = {name for name in before if before[name] != after[name]}
    assert {"data/saw-40rpm.json", "results.json"} <= changed


def test_digits_of_another_command_are_not_kept(tmp_path: Path) -> None:
    write_moved(tmp_path, 0.0, Reproduction("conrod validate {scene} --revolutions 3 --out reports"))
    assert (
        write_moved(tmp_path, -1e-15)["data/saw-40rpm.json"]
        != write_moved(tmp_path / "new", 0.0)["data/saw-40rpm.json"]
    )


@pytest.mark.parametrize(
    ("before", "now", "same"),
    [
        (1.23456e-4, 1.23458e-4, True),
        (1.23456e-4, 1.23459e-4, False),
        (1.0e-4, 9.99999e-5, True),
        (0.0, 1.09e-12, True),
        (0.0, 1.2e-12, False),
        (1.0e-12, 9.9e-13, True),
        (3.801e-11, 3.81e-11, True),
        (3.801e-11, 3.82e-11, False),
        (1.0, 1, False),
        (None, 0.0, False),
    ],
)
def test_two_units_of_the_last_kept_digit_are_the_same(before: Any, now: Any, same: bool) -> None:
    assert kept({"size": before}, {"size": now})["size"] is (before if same else now)


@pytest.mark.parametrize("other", [{"settings": {"step": 0.1 + 1e-9}}, {"outcome": "reset"}, {"steps": 999}])
def test_a_run_with_other_settings_keeps_no_number(other: dict[str, Any]) -> None:
    run = {"settings": {"step": 0.1}, "outcome": "completed", "steps": 1000, "errors": {"C": 1.23456e-4}}
    now = run | {"errors": {"C": 1.23457e-4}}
    assert kept(run, now) == run
    assert kept(run, now | other) == now | other


def test_arrays_keep_numbers_to_the_digits_they_have() -> None:
    errors = [[float(f"{1e-6 * 1.37**k:.2e}"), float(f"{1e-3 / (k + 1):.2e}")] for k in range(12)]
    motion = [round(0.173 * k * k, 3) for k in range(12)]
    last = errors[-1][1]
    for before, unit, index in ((errors, 1e-7, -1), (motion, 1e-3, 0)):
        for units, same in ((1, True), (3, False)):
            now = list(before)
            now[index] = [errors[-1][0], last + units * unit] if before is errors else units * unit
            assert kept(before, now) == (before if same else now)


def test_places_stay_with_the_sizes_that_are_kept() -> None:
    before = {"difference": 0.0, "allowed": 0.0, "angle": 0.4}
    assert kept(before, {"difference": 1e-14, "allowed": 0.0, "angle": 3.0}) == before
    now = {"difference": 2e-6, "allowed": 0.0, "angle": 3.0}
    assert kept(before, now) == now
    curve = {"error_angle": [k / 10.0 for k in range(20)], "error": [k / 1000.0 for k in range(20)]}
    other = {"error_angle": [k / 10.0 + 0.05 for k in range(20)], "error": [*curve["error"][:-1], 1.0]}
    assert kept(curve, other)["error_angle"] == [*curve["error_angle"][:-1], other["error_angle"][-1]]


def test_misfits_of_a_run_stay_unless_they_are_not_allowed() -> None:
    def run(difference: float, allowed: float, error: float = 1.23456e-4) -> dict[str, Any]:
        misfit = {"position": {"difference": difference, "allowed": allowed, "angle": 1e9 * allowed}}
        return {"outcome": "completed", "errors": {"C": error}, "misfit": misfit}

    before = run(1.2e-9, 2.5e-9)
    assert kept(before, run(1.1e-9, 2.3e-9)) == before
    for other in (run(2.4e-9, 2.3e-9), run(1.1e-9, 2.3e-9, 1.23465e-4)):
        assert kept(before, other) == other


def test_environment_stays_while_nothing_changes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = write_moved(tmp_path, 0.0)["results.json"]
    monkeypatch.setattr("platform.machine", lambda: "another")
    assert write_moved(tmp_path, 1e-15)["results.json"] == before
    assert b'"machine": "another"' in write_moved(tmp_path, 1e-4)["results.json"]
