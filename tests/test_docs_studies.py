"""The worked studies in docs/studies run as they are printed, are short, and find what their pages say."""

from __future__ import annotations

import re
import runpy
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

FOLDER = Path(__file__).parent.parent / "docs" / "studies"


def ran(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What a study's script leaves; its figure goes elsewhere."""
    mpl.use("Agg")
    plt.close("all")
    monkeypatch.setattr("sys.argv", [name, str(tmp_path / name)])
    left = runpy.run_path(str(FOLDER / f"{name}.py"))
    plt.close("all")
    assert (tmp_path / f"{name}.svg").read_text(encoding="utf-8").count("<path") > 10
    return left


def page(name: str) -> str:
    return " ".join((FOLDER / f"{name}.md").read_text(encoding="utf-8").split())


def test_the_flywheel_keeps_the_fluctuation_that_is_wanted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told = re.search(r"It finds ([\d.]+) kg m²", page("flywheel"))
    assert told
    # Its search takes most of the time; what it finds is held to what is wanted.
    monkeypatch.setattr("scipy.optimize.brentq", lambda *_, **__: float(told[1]))
    left = ran("flywheel", tmp_path, monkeypatch)
    found, lighter = (
        np.ptp(speed) / speed.mean() for _, speed in map(left["course"], (left["least"], 0.9 * left["least"]))
    )
    assert found == pytest.approx(left["WANTED"], rel=5e-3)
    assert lighter > 1.05 * left["WANTED"]
    assert left["least"] < left["rule"]
    assert f"{left['rule']:.1f} kg m²" in page("flywheel")


def test_the_counterweight_leaves_the_least_shaking_force(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    left = ran("balance", tmp_path, monkeypatch)
    peak, best = left["peak"], left["best"]
    assert peak(best) < min(peak(0.9 * best), peak(1.1 * best), peak(0.0), peak(left["full"]))
    assert [f"{peak(c) / 1e3:.2f} kN" in page("balance") for c in (0.0, best, left["full"])] == [True] * 3
    # The momentum of all that moves changes by the force on the frame, which over a turn comes to nothing.
    mean = left["shaking"](best)[:, :-1].mean(axis=1)
    assert np.abs(mean).max() < 1e-9 * peak(best)


def test_the_spring_is_the_softest_that_keeps_the_push_and_an_engine_agrees(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    left = ran("cam-spring", tmp_path, monkeypatch)
    push, least = left["push"], left["least"]
    assert push(least).min() == pytest.approx(left["LEAST_PUSH"], rel=1e-9)
    assert push(0.99 * least).min() < left["LEAST_PUSH"]
    assert f"{least / 1e3:.2f} N/mm" in page("cam-spring")
    kept, lost = (1e6 * float(gap.max()) for gap in left["gaps"])
    assert kept < 2.0
    assert lost > 20.0
    assert f"{kept:.1f} µm" in page("cam-spring")
    assert f"{lost:.1f} µm" in page("cam-spring")
