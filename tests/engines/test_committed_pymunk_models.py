"""The committed pymunk models are what is exported today, and run."""

from __future__ import annotations

import pytest
from modules_alone import printed_lines

from conrod.scenes import scene_named
from docs.committed_models import ROOT, Model, equal_to_rounding, models

FAST = ("saw-500rpm", "geneva", "pendulum")
MODELS = models("pymunk")
REFUSED = {"rack-and-wheel", "rolling-on-flat"}


def of_all(*slow: str) -> list[object]:
    """Every machine's model, those of the machines named as slow tests."""
    return [pytest.param(one, id=one.name, marks=[pytest.mark.slow] if one.name in slow else []) for one in MODELS]


@pytest.mark.parametrize("model", of_all("four-bar-chain-40"))
def test_committed_model_is_what_is_exported(model: Model) -> None:
    text = model.text
    assert (text is None) == (model.name in REFUSED)
    assert model.file.exists() == (text is not None)
    assert text is None or equal_to_rounding(text, model.file.read_text(encoding="utf-8"))


def test_no_other_models_are_committed() -> None:
    folder = ROOT / "pymunk_models"
    assert set(folder.rglob("*.py")) == {one.file for one in MODELS if one.name not in REFUSED}


def test_a_change_of_a_model_is_no_rounding() -> None:
    text = (ROOT / "pymunk_models" / "saw_500rpm.py").read_text(encoding="utf-8")
    assert equal_to_rounding(text.replace("0.1861817604250837", "0.18618176042508367"), text)
    for right, wrong in (("0.1861817604250837", "0.1861817605"), ("ITERATIONS = 147", "ITERATIONS = 148")):
        assert right in text
        assert not equal_to_rounding(text.replace(right, wrong), text)


@pytest.mark.parametrize("model", of_all(*{one.name for one in MODELS} - {*FAST}))
def test_committed_model_runs_alone(model: Model) -> None:
    if model.name in REFUSED:
        pytest.skip("pymunk has no joint for it")
    scene, free = scene_named(model.name), model.free
    lengths = scene.lengths
    printed = dict(line.split(": travels ") for line in printed_lines(model.file))
    assert set(printed) == set(lengths)
    for point, length in lengths.items():
        travel = 1e-3 * float(printed[point].split(" mm")[0])
        # A pass ends with its last whole step; wheels go on in a second turn; without a drive any travel will do.
        assert free or travel > 0.95 * length, point
        assert free or travel < 1.05 * length or scene.kinematics.mechanism.meshes, point
