"""What the verdict on a user's model notices of defects that are planted into its run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from own_model_edits import TEXTS, judged

from conrod.own.models.request import DrivenRun
from conrod.own.models.results import ModelStudy
from conrod.report import user_model as words
from conrod.studies.validation.results import Noticed

SAW = TEXTS["saw"]


@pytest.fixture(autouse=True)
def no_presets(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conrod.own.models.study.PRESETS", ())


def qualified(folder: Path, **tolerance: float) -> tuple[ModelStudy, dict[str, Noticed]]:
    study = judged(folder, "saw", SAW, 0.2, tolerance=tolerance, qualify=True)
    assert study.qualified is not None
    return study, {one.defect: one for one in study.qualified.motion}


def swapped(share: float) -> Any:
    """A change of runs: velocities along x or y, whichever is larger, by a share of the way to the other sign."""

    def spoil(run: DrivenRun) -> DrivenRun:
        motion = {name: quantities.copy() for name, quantities in run.motion.items()}
        for _, velocity, *_ in motion.values():
            velocity[:, int(np.ptp(velocity, axis=0).argmax())] *= 1.0 - 2.0 * share
        return replace(run, motion=motion)

    return spoil


def test_the_smallest_defect_that_is_noticed_is_where_the_verdict_on_such_a_run_changes(tmp_path: Path) -> None:
    study, found = qualified(tmp_path, position=1e-4, velocity=1e-4, acceleration=1e-2)
    assert study.passed
    least = found["sign of a velocity"].smallest
    assert least is not None
    for share, passes in ((0.9 * least, True), (1.01 * least, False)):
        run = judged(tmp_path, "saw", SAW, 0.2, tolerance={"velocity": 1e-4}, spoil=swapped(share))
        assert bool(run.own and run.exceeded(run.own)) != passes
    ended = {found[name].by for name in ("other branch", "run cut short")}
    assert ended == {("flipped",), ("crashed",)}
    assert "softness" not in found  # which takes a run of its own
    assert len(words.qualification(study).rows) == len(found)


def test_a_verdict_that_notices_nothing_is_none(tmp_path: Path) -> None:
    study, found = qualified(tmp_path, position=1e6, phase=1e6, total=1e6)
    assert not any(one.smallest for one in found.values())
    assert not study.passed
    assert "no planted defect" in words.verdict(study)


def test_a_run_that_is_not_judged_or_fails_is_not_qualified(tmp_path: Path) -> None:
    assert judged(tmp_path, "saw", SAW, 0.2, qualify=True).qualified is None
    assert judged(tmp_path, "saw", SAW, 0.2, qualify=True, tolerance={"position": 1e-9}).qualified is None
