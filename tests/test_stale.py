"""`make stale` finds what is planted in committed reports, and nothing in runs that are what is printed."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from conrod.report.folder import restore_findings
from conrod.studies.limits.report import LIMITS_REPORT
from conrod.studies.limits.results import LimitStudy
from conrod.studies.validation.report import VALIDATION_REPORT
from conrod.studies.validation.results import SceneStudy
from docs.studies.committed_cells import Cell, PartCells, limit_cells, validation_cells
from docs.studies.stale import REPORTS, differences, lacking_fields, set_lines


@cache
def read(place: str) -> Any:
    return json.loads((REPORTS / place).read_text(encoding="utf-8"))


@cache
def validated() -> PartCells:
    values = read("data/saw-40rpm.json")
    return validation_cells(restore_findings(SceneStudy, values), values)


@cache
def walked(axis: str) -> PartCells:
    """The probes of one walk of the hacksaw, in pymunk."""
    values = read("limits/data/saw-500rpm.json")
    walks = [
        one for one in values["walks"] if (one["axis"], one["engine"], one["preset"]) == (axis, "pymunk", "tuned")
    ][:1]
    values = values | {"walks": walks, "maps": [], "determinism": [], "floats": []}
    return limit_cells(restore_findings(LimitStudy, values), values)


def cell(name: str, cells: PartCells) -> Cell:
    return next(one for one in cells.cells if one.name.endswith(name))


def found_once(one: Cell, found: Any = None) -> Cell:
    """The same cell, whose run is made at most once."""
    return replace(one, find=cache(one.find) if found is None else lambda: found)


def test_a_validation_that_is_printed_is_found_again() -> None:
    assert differences(cell("pymunk None", validated()), VALIDATION_REPORT) == []


def test_an_error_that_is_not_todays_is_named() -> None:
    short = found_once(min(walked("steps").cells, key=lambda one: one.steps))
    printed = {**short.find(), "errors": {"position": 4e-6}, "level": "safe", "outcome": "completed"}
    today = {**printed, "errors": {"position": 4.1e-6}}
    assert differences(found_once(replace(short, printed=printed), printed), LIMITS_REPORT) == []
    assert "errors position" in " ".join(differences(found_once(replace(short, printed=printed), today), LIMITS_REPORT))


def test_a_group_that_is_contradicted_is_named() -> None:
    printed = {"value": 0.9, "level": "broken", "outcome": "flipped", "errors": None}
    today = {"value": 0.9, "level": "safe", "outcome": "completed", "errors": {"position": 4e-6}}
    said = differences(Cell("nearness", printed, 1.0, lambda: today), LIMITS_REPORT)
    assert "outcome 'flipped', today 'completed'" in said


def test_the_error_of_the_last_turn_is_not_that_of_the_run() -> None:
    short = cell("run-length pymunk tuned 1", walked("run-length"))
    whole = short.find()
    last = whole | {"errors": {name: 0.99 * size for name, size in whole["errors"].items()}}
    assert differences(replace(short, printed=whole, find=lambda: whole), LIMITS_REPORT) == []
    assert differences(replace(short, printed=last, find=lambda: whole), LIMITS_REPORT)


def test_a_field_that_the_data_lack_is_named() -> None:
    values = {"results": [{"errors": 1.0}, {"errors": 2.0}]}
    today = {"results": [{"errors": 1.0, "links": None}, {"errors": 2.0, "links": None}]}
    assert lacking_fields(values, today) == {"links"}
    assert lacking_fields(today, today) == set()
    found = differences(
        Cell(
            "run", {"outcome": "completed", "links": None}, 1.0, lambda: {"outcome": "completed", "links": {"rod": 1.0}}
        ),
        VALIDATION_REPORT,
    )
    assert [line.split()[0] for line in found] == ["links"]


@pytest.mark.parametrize(
    ("part", "said"),
    [
        (PartCells(printed=frozenset("a"), today=frozenset("ab")), "1 cells missing: b"),
        (PartCells(printed=frozenset("abc"), today=frozenset("ab")), "1 cells not of today's grid: c"),
        (PartCells(versions={"pymunk": "0.0.1"}), "pymunk 0.0.1 is not installed"),
        (PartCells(versions={"no-such-engine": "1.0"}), "no-such-engine 1.0 is not installed"),
    ],
)
def test_cells_and_engines_that_are_not_todays_are_named(part: PartCells, said: str) -> None:
    assert any(line.startswith(f"saw: {said}") for line in set_lines("saw", part))
    assert not list(set_lines("saw", validated()))
