"""What a baseline keeps of a judged model and of a judged table, number by number."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from handmade_studies import judged_run, model_study, table_study

from conrod.comparison.trajectory import Outcome
from conrod.errors import InvalidInput
from conrod.execution.baseline import BandedNumber
from conrod.models.check.baseline_lines import model_lines
from conrod.models.check.dispatch import NEW_KEYWORDS, refuse_old_keywords
from conrod.models.tables.baseline_lines import table_lines
from conrod.models.tables.errors import ERRORS


def test_model_has_a_line_on_its_paths_and_one_on_each_run() -> None:
    study = model_study()
    lines = model_lines([study])
    assert list(lines) == ["paths", "as it is", "hardened"]
    paths = lines["paths"]
    assert (paths.outcome, paths.passed, paths.settings) == ("completed", study.is_machine, {})
    assert paths.numbers == {"position": BandedNumber(study.identity.largest, 0.0)}
    assert study.judged
    for label, run in study.runs.items():
        line = lines[label]
        assert (line.outcome, line.passed) == ("completed", True if run in study.judged else None)
        expected = {"position": 3e-4, "velocity": 4e-4, "acceleration": 5e-4, "phase": 2e-9}
        assert line.numbers == {name: BandedNumber(size, 0.0) for name, size in expected.items()}


def test_own_run_has_a_line_and_an_unjudged_one_has_no_verdict() -> None:
    own = judged_run("the file's own run", outcome=Outcome.EXPLODED, reason="it blew up", errors=None, phase=math.nan)
    lines = model_lines([model_study(own_run=own)])
    assert list(lines) == ["paths", "as it is", "hardened", "the file's own run"]
    line = lines["the file's own run"]
    assert (line.outcome, line.numbers) == ("exploded", {})


def test_model_out_of_tolerance_has_a_failed_line() -> None:
    # Negative control of the lines above.
    strict = model_study(tolerance={"velocity": 1e-6})
    lines = model_lines([strict])
    assert {lines[run.label].passed for run in strict.judged} == {False}


def test_table_has_one_line_of_all_its_errors() -> None:
    study = table_study()
    lines = table_lines([study])
    assert list(lines) == ["table"]
    line = lines["table"]
    assert (line.outcome, line.passed, line.settings) == ("completed", study.passed, {})
    sizes = {name: study.largest(name) for name in (*ERRORS, "phase")}
    known = {name: BandedNumber(size, 0.0) for name, size in sizes.items() if size is not None and math.isfinite(size)}
    assert known
    assert line.numbers == known
    assert table_lines([replace(study, tolerance={"position": 1e-12})])["table"].passed is False


@pytest.mark.parametrize(("old", "new"), NEW_KEYWORDS.items())
def test_a_keyword_of_before_is_answered_with_the_new_one(old: str, new: str) -> None:
    with pytest.raises(InvalidInput, match=rf"^{old}=\.\.\. is now {new}=\.\.\.$"):
        refuse_old_keywords(["scene", old])
    refuse_old_keywords(["scene", new])


def test_parameters_by_set_are_answered_with_a_scene() -> None:
    with pytest.raises(InvalidInput) as told:
        refuse_old_keywords(["engines", "set"])
    assert str(told.value) == "set=... is gone: make the scene with its parameters, conrod.scene(NAME, crank='80 mm')"
