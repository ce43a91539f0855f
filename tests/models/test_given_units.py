"""A model in millimetres against a scene: a unit that is given is taken, right or wrong."""

from __future__ import annotations

from pathlib import Path

import pytest
from four_bars import in_millimetres

from conrod.execution.resolve_arguments import select_scene
from conrod.models.check.api import question_on_model
from conrod.models.check.frame import GivenFrame
from conrod.models.check.identity import Identity, identify
from conrod.models.check.scanning import scan
from conrod.models.check.turning import prepare_turning

CASES = Path(__file__).parents[1] / "data" / "cases"
TEXT = (CASES / "four-bar-open.xml").read_text(encoding="utf-8")
_, MEANT = select_scene(str(CASES / "anchor-apart-meant.toml"), ())


def identity_of(folder: Path, unit: str | None) -> Identity:
    file = folder / "bar.xml"
    file.write_text(in_millimetres(TEXT), encoding="utf-8")
    question = question_on_model(MEANT, "crank", {"P": "site:P"}, None, {}, unit)
    found = scan(prepare_turning(file, question), question)
    return identify(MEANT, found, GivenFrame(unit=None if unit is None else 1.0))[0]


@pytest.mark.parametrize(("unit", "found"), [("mm", 1.0), (None, 1e-3)])
def test_model_in_millimetres_is_the_machine(unit: str | None, found: float, tmp_path: Path) -> None:
    identity = identity_of(tmp_path, unit)
    assert identity.largest < 1e-9
    assert identity.frame.unit == found


@pytest.mark.slow
def test_model_in_a_wrong_unit_is_ten_times_too_large(tmp_path: Path) -> None:
    # Negative control.
    (explanation, *_) = identity_of(tmp_path, "cm").explanations
    (length,) = explanation.lengths
    assert length.found == pytest.approx(10.0)
