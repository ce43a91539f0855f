"""The report on ingredients: what it says, what a folder keeps of it, and that no engine is needed to make it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from ablations import SCENE, ablation_study, engine_study

from conrod.report.ablate import KIND, speed_up
from conrod.report.kind import Reproduction
from conrod.report.writer import report_batch
from conrod.studies.ablate.findings import MEANINGS

COMMAND = Reproduction("conrod ablate {scene} --out reports/ablate")


@pytest.fixture(scope="module")
def pages() -> dict[str, str]:
    """The files of a report of two engines."""
    study = ablation_study(engine_study(), engine_study("pymunk", "7.0.0"))
    batch = report_batch(KIND, {SCENE: study}, Path("/nowhere"), COMMAND)
    return {name: str(text) for name, text in batch.files.items()}


def row(page: str, start: str) -> list[str]:
    """The cells of the first line of a table that begins so."""
    line = next(line for line in page.splitlines() if line.startswith(f"| {start}"))
    return [cell.strip() for cell in line.strip("|").split("|")]


def test_the_page_has_of_every_ingredient_cost_change_verdict_and_who_needs_it(pages: dict[str, str]) -> None:
    page = pages[f"{SCENE}.md"]
    costly = row(page, "sensors")
    assert costly[1:3] == ["1.20 (1.19 .. 1.21)", "1.30 (1.29 .. 1.31)"]
    assert costly[4] == "costly"
    harmful = row(page, "noslip")
    assert harmful[3:] == ["1.0e-6", "**harmful (position)**", "wear"]
    required = row(page, "closure")
    assert "part of the minimal model" in required[0]
    assert required[4] == "required (opened)"
    assert required[5] == "drive torque, joint reactions"
    assert row(page, "looks")[4] == "free"
    assert row(page, "looks")[5] == "impact"
    for verdict, meaning in MEANINGS.items():
        assert f"**{verdict.value}**: {meaning}" in page


def test_the_page_begins_with_how_much_faster_the_minimal_model_is(pages: dict[str, str]) -> None:
    page = pages[f"{SCENE}.md"]
    assert "The minimal model is **1.80 times** as fast as the full one (1.79 .. 1.81)" in page[:600]
    assert "the observed motion of the two is equal within 1e-9." in page
    assert "Left out of it, as it does harm alone: `noslip`." in page
    assert "MuJoCo: The minimal model is **1.80 times** as fast" in pages["README.md"]
    # Negative control: a motion that is not equal is not called so.
    found = engine_study()
    changed = {**(found.variants[5].change or {}), "velocity": 2e-9}
    other = replace(found, variants=(*found.variants[:5], replace(found.variants[5], change=changed)))
    assert "differs by at most 3.0e-11 in position, 2.0e-9 in velocity" in speed_up(other)
    broken = replace(found.variants[5], outcome="opened", reason="a gap", change=None, cost=None)
    assert "did not run to its end: a gap" in speed_up(replace(found, variants=(broken,)))
    assert "no ingredient" in speed_up(replace(found, variants=found.variants[:1]))
