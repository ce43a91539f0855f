"""What a check of a model would notice: defects that are planted into it, with the smallest that is noticed."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from own_model_edits import TEXTS, judge_text, replace_once

from conrod.models.check import qualification
from conrod.models.check.report import qualification_table
from conrod.models.check.results import ModelStudy
from conrod.report.table import cell_text
from conrod.verification.sections import study_sections

SAW = TEXTS["saw"]


@pytest.fixture(scope="module")
def qualified(tmp_path_factory: pytest.TempPathFactory) -> ModelStudy:
    return judge_text(tmp_path_factory.mktemp("saw"), "saw", SAW, qualify=True)


def test_check_notices_lengths_beyond_its_tolerance(qualified: ModelStudy, tmp_path: Path) -> None:
    assert qualified.passed
    length, mass, *_ = qualified.qualified.motion
    assert (length.defect, length.by) == ("length", ("paths",))
    # A length is noticed where it moves a point by the tolerance, 1e-6 of its travel: some 1e-6 of itself.
    assert 2e-7 < length.smallest < 1e-5
    # What is said is so: a model whose rod is longer by as much as every length shows, and ten times that, is none.
    for factor, is_noticed in ((10.0, True), (0.01, False)):
        rod = f"{0.3 * (1.0 + factor * length.smallest):.17g}"
        wrong = replace_once(SAW, 'name="slider-pin.rod" pos="0.3 0 0"', f'name="slider-pin.rod" pos="{rod} 0 0"')
        assert judge_text(tmp_path, "saw", wrong, points=("C",)).is_machine is not is_noticed
    # Masses do not move a driven crank.
    assert (mass.defect, mass.visible, mass.by) == ("mass", False, ())


def test_planted_defects_stand_in_report_and_verification(qualified: ModelStudy) -> None:
    rows = [[cell_text(cell) for cell in row] for row in qualification_table(qualified).rows]
    assert rows[0][:2] == ["length", "0.01 %"]
    assert rows[0][2].startswith("noticed, from ")
    assert rows[1] == ["mass", "1 %", "cannot be seen"]
    sections, _ = study_sections(qualified)
    assert any(table.headings[0] == "defect" for table in sections["code"].tables)
    plain, _ = study_sections(replace(qualified, qualified=None))
    assert not any(table.headings[0] == "defect" for table in plain["code"].tables)


def test_check_that_notices_nothing_is_no_verdict(tmp_path: Path) -> None:
    loose = judge_text(tmp_path, "saw", SAW, tolerance={"position": 1e6, "total": 1e6, "phase": 1e6}, qualify=True)
    assert all(one.smallest is None for one in loose.qualified.motion if one.defect != "speed of its own run")
    blind = replace(loose.qualified, motion=loose.qualified.motion[:2])
    assert replace(loose, qualified=None).passed
    assert not replace(loose, qualified=blind).passed
    _, deviations = study_sections(loose)
    assert "check of the model: a planted defect is not noticed: length 0.01 %" in deviations


def test_model_that_fails_has_no_planted_defects(tmp_path: Path) -> None:
    wrong = replace_once(SAW, 'name="slider-pin.rod" pos="0.3 0 0"', 'name="slider-pin.rod" pos="0.31 0 0"')
    assert judge_text(tmp_path, "saw", wrong, qualify=True).qualified is None


def test_of_several_places_the_least_noticed_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    def places(**sizes: float) -> Any:
        return lambda *_: [(name, partial(noticed_from, size)) for name, size in sizes.items()]

    def noticed_from(size: float, share: float) -> tuple[str, ...]:
        return ("paths",) if abs(share) >= size else ()

    monkeypatch.setattr(qualification, "_length_places", places(rod=1e-6, crank=2e-5, offset=3e-6))
    monkeypatch.setattr(qualification, "_mass_places", places(rod=1e-3, crank=0.2, slider=1e-4))
    monkeypatch.setattr(qualification, "_speed_places", places())
    found: Any = None
    length, mass = qualification.qualify_check(found, found, found, found).motion
    assert (length.defect, length.unit, length.where, length.size, length.by) == (
        "length", "%", "crank", 1e-4, ("paths",),
    )  # fmt: skip
    assert length.smallest == pytest.approx(2e-5, rel=0.5)
    # A mass of the crank that is a hundredth off is not noticed.
    assert (mass.defect, mass.where, mass.size, mass.by, mass.visible) == ("mass", "crank", 1e-2, (), True)
    assert mass.smallest == pytest.approx(0.2, rel=0.5)
