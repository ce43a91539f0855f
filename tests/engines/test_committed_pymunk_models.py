"""The committed pymunk models are what is exported today, and run."""

from __future__ import annotations

from pathlib import Path

import pytest
from modules_alone import printed_lines

from benchmarks.pymunk_models import MODELS, equal_to_rounding, machines, model_text
from conrod.scenes import scene_named

FAST = ("saw-500rpm", "geneva", "pendulum")
REFUSED = {"rack-and-wheel", "rolling-on-flat"}


def of_all(*slow: str) -> list[object]:
    """Every machine's file, name and kind of model, those named as slow tests."""
    return [
        pytest.param(file, *machine, id=machine[0], marks=[pytest.mark.slow] if machine[0] in slow else [])
        for file, machine in machines().items()
    ]


@pytest.mark.parametrize(("file", "name", "free"), of_all("four-bar-chain-40"))
def test_committed_model_is_what_is_exported(file: Path, name: str, free: bool) -> None:
    text = model_text(name, free)
    assert (text is None) == (name in REFUSED)
    assert file.exists() == (text is not None)
    assert text is None or equal_to_rounding(text, file.read_text(encoding="utf-8"))


def test_no_other_models_are_committed() -> None:
    assert set(MODELS.rglob("*.py")) == {file for file, (name, _) in machines().items() if name not in REFUSED}


def test_a_change_of_a_model_is_no_rounding() -> None:
    text = (MODELS / "saw_500rpm.py").read_text(encoding="utf-8")
    assert equal_to_rounding(text.replace("0.1861817604250837", "0.18618176042508367"), text)
    for right, wrong in (("0.1861817604250837", "0.1861817605"), ("ITERATIONS = 147", "ITERATIONS = 148")):
        assert right in text
        assert not equal_to_rounding(text.replace(right, wrong), text)


@pytest.mark.parametrize(("file", "name", "free"), of_all(*{name for name, _ in machines().values()} - {*FAST}))
def test_committed_model_runs_alone(file: Path, name: str, free: bool) -> None:
    if name in REFUSED:
        pytest.skip("pymunk has no joint for it")
    scene = scene_named(name)
    lengths = scene.lengths
    printed = dict(line.split(": travels ") for line in printed_lines(file))
    assert set(printed) == set(lengths)
    for point, length in lengths.items():
        travel = 1e-3 * float(printed[point].split(" mm")[0])
        # A pass ends with its last whole step; wheels go on in a second turn; without a drive any travel will do.
        assert free or travel > 0.95 * length, point
        assert free or travel < 1.05 * length or scene.kinematics.mechanism.meshes, point
