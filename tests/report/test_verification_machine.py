"""The machine in a verification report: title, drawing and parameters; a criterion in all its digits."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from handmade_studies import SCENE, scene_study, validation_result
from html_pages import found_in

from conrod.errors import InvalidInput
from conrod.report.drawing.drawing import mechanism_svg
from conrod.report.table import Table
from conrod.scenes import Saw
from conrod.studies.validation.verb import ValidateOptions
from conrod.verification.page import (
    Verification,
    VerificationSection,
    read_verification,
    sealed_page,
    statement_changes,
    valid_seal,
)
from conrod.verification.sections import criterion_cells
from conrod.verification.supporting_sections import machine_section
from conrod.verification.verb import Dossier

NAMES = (
    "criteria", "code", "solution", "validation", "inputs", "software", "settings", "validity", "invariances",
    "parameters",
)  # fmt: skip
FASTER = Saw(speed=320.0 * 3.141592653589793 / 30.0, crank=0.11)


def report(title: str = "", **sections: VerificationSection) -> Verification:
    own = {name: VerificationSection((), ("nothing",)) for name in NAMES} | sections
    return Verification("saw-500rpm", "within", "2026-01-01 00:00 UTC", "conrod", own, (), title=title)


def test_report_shows_the_machine_with_speed_and_masses() -> None:
    section = machine_section(FASTER, ["speed=320rpm", "crank=110mm"])
    page = sealed_page(report(machine=section), mechanism_svg(FASTER)).decode()
    text = page[page.index("<main>") :].replace("\n", "")
    assert "at 320 rpm, with speed=320rpm, crank=110mm." in text
    for name, value, unit in (("speed", "320", "rpm"), ("crank", "110", "mm"), ("rod_mass", "1.5", "kg")):
        assert f'<td><code>{name}</code></td><td class="right">{value}</td><td>{unit}</td>' in text
    assert page.count("data:image/svg+xml") == 1
    assert [a["alt"] for tag, a in found_in(page).elements if tag == "img"] == ["The mechanism with its dimensions"]
    assert valid_seal(page.encode())
    # Negative control: a model without a scene has neither.
    bare = sealed_page(report()).decode()
    assert "data:image" not in bare
    assert "The machine" not in bare


def test_title_is_the_heading_and_its_change_is_recorded() -> None:
    titled = report("Saw 7, order 41 <b>")
    page = sealed_page(titled).decode()
    assert page.count("Verification report: Saw 7, order 41 &lt;b&gt;") == 2
    assert read_verification(page.encode()) == titled
    assert statement_changes(report(), titled) == ("report, title: absent -> Saw 7, order 41 <b>",)
    assert "<title>Verification report: saw-500rpm</title>" in sealed_page(report()).decode()


@pytest.mark.parametrize("title", ["", "  ", "two\nlines", "a\u202eb", "x" * 121])
def test_title_that_is_no_line_is_refused(title: str) -> None:
    with pytest.raises(InvalidInput, match=r"^--title"):
        Dossier.prepare("validate", ["saw-500rpm"], ValidateOptions(verification="r.html", title=title), {})


@pytest.mark.parametrize(
    ("allowed", "size", "cells"),
    [
        (4.57074e-7, 4.4e-7, ("4.57e-7 (9.14e-5 mm)", "4.40e-7 (8.80e-5 mm)", "yes")),
        (1e-3, 2e-3, ("0.00100 (0.200 mm)", "0.00200 (0.400 mm)", "NO")),
        (1e-3, 2e-4, ("1.00e-3 (0.200 mm)", "2.00e-4 (0.0400 mm)", "yes")),
        # Equal in three digits, and not within.
        (4.57074e-7, 4.57080e-7, ("4.57e-7 (9.14e-5 mm)", "4.57e-7 (9.14e-5 mm)", "NO")),
        (1e-8, 1e-14, ("1.00e-8 (2.00e-6 mm)", "< 1e-12 (< 2e-10 mm)", "yes")),
        (1e-8, None, ("1.00e-8 (2.00e-6 mm)", "n/a", "n/a")),
    ],
)
def test_criterion_and_result_have_equal_digits(allowed: float, size: float | None, cells: tuple[str, ...]) -> None:
    found = criterion_cells("position", allowed, size, {"C": 0.2})
    assert tuple(getattr(cell, "text", cell) for cell in found) == cells


def test_criterion_loosened_below_its_shown_digits_is_marked() -> None:
    def with_criterion(full: str) -> Verification:
        row: Any = (("own", "position", "4.57e-7", "4.40e-7", "yes"),)
        shown = Table(("run", "quantity", "criterion", "found", "within"), row, names=2)
        return report(criteria=VerificationSection((shown,), (), {"own position": full}))

    before, after = with_criterion("4.57074e-07"), with_criterion("4.57075e-07")
    (change,) = statement_changes(before, after)
    assert change == "criteria, own position: 4.57074e-07; 4.40e-7; yes -> 4.57075e-07; 4.40e-7; yes (LOOSENED)"
    assert "LOOSENED" not in statement_changes(after, before)[0]
    assert statement_changes(before, replace(before)) == ()


@pytest.mark.parametrize(
    ("title", "changed", "heading"),
    [
        (None, (), "saw-500rpm"),
        (None, ("crank=110mm", "speed=320rpm"), "saw-500rpm with crank=110mm, speed=320rpm"),
        ("Saw 7", ("crank=110mm",), "Saw 7"),
    ],
)
def test_heading_names_the_machine_and_what_was_changed(
    title: str | None, changed: tuple[str, ...], heading: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(Dossier, "_invariances", lambda *_: "left out")
    monkeypatch.setattr("conrod.verification.supporting_sections.software_section", lambda _: VerificationSection())
    file = tmp_path / "r.html"
    asked = ValidateOptions(verification=str(file), title=title, assignments=changed)
    study = scene_study(validation_result("tuned"))
    Dossier.prepare("validate", ["saw-500rpm"], asked, {"saw-500rpm": SCENE}).write(
        SimpleNamespace(study=study, verdict="within")  # type: ignore[arg-type]
    )
    assert read_verification(file.read_bytes()).heading == f"Verification report: {heading}"
