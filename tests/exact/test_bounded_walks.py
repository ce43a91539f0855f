"""Whatever a mechanism file says, its exact motion is found or refused after a bounded number of steps."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import mutants
import numpy as np
import pytest
from described import CATALOGUE, SHIPPED, SLIDER_CRANK, tables, with_entry

from conrod.errors import InvalidInput
from conrod.exact import assembly_branch, equations
from conrod.exact.elimination import Elimination
from conrod.scenes.described_scene import DescribedScene, scene_from_tables

# Ten seconds: one takes a third of a millisecond, of a machine as large as those that ship.
MOST_SOLUTIONS = 20_000
SIX_BAR, PARALLELOGRAM, CAM = (CATALOGUE / f"{name}.toml" for name in ("six-bar", "parallelogram", "cam-3-4-5"))


class TooMany(BaseException):
    """More of them than ten seconds have room for."""


class Solutions:
    """Counter of the linear systems that the exact motion takes."""

    count, most = 0, MOST_SOLUTIONS

    def __call__(self, *arguments: Any) -> Elimination:
        self.count += 1
        if self.count > self.most:
            raise TooMany
        return Elimination(*arguments)


@pytest.fixture
def solutions(monkeypatch: pytest.MonkeyPatch) -> Solutions:
    monkeypatch.setattr(equations, "Elimination", counted := Solutions())
    return counted


def at_scale(path: Path, factor: float) -> dict[str, Any]:
    """A file with all its lengths times a factor, and the inertias that go with them."""
    whole = tables(path)
    for way in mutants.places(whole):
        found = (
            mutants.quantity(mutants.value_at(whole, way)) if "points" in way or "centre_of_gravity" in way else None
        )
        if way[-1] == "inertia" and (inertia := mutants.quantity(mutants.value_at(whole, way))):
            whole = mutants.set_value(whole, way, f"{inertia[0] * factor**2!r} {inertia[1] or 'kg*m^2'}")
        if found:
            whole = mutants.set_value(whole, way, f"{found[0] * factor!r} {found[1] or 'm'}")
    return whole


@pytest.mark.parametrize("start", ["0.001 mm", "1000 km"])
def test_distant_start_pose_needs_few_solutions(start: str, solutions: Solutions) -> None:
    whole = with_entry(CAM, "start.follower.origin", [0, start])
    assert scene_from_tables(whole).lengths["roller"] == pytest.approx(0.033, rel=1e-9)
    assert solutions.count < 200


@pytest.mark.parametrize("factor", [1e-5, 1e5])
@pytest.mark.parametrize("path", [SIX_BAR, PARALLELOGRAM], ids=lambda path: path.stem)
def test_motion_scales_with_machine_size(path: Path, factor: float, solutions: Solutions) -> None:
    scaled, usual = scene_from_tables(at_scale(path, factor)), scene_from_tables(tables(path))
    assert {name: travel / factor for name, travel in scaled.lengths.items()} == pytest.approx(usual.lengths, rel=1e-9)
    np.testing.assert_allclose(scaled.kinematics.change_angles, usual.kinematics.change_angles, atol=1e-9)
    assert solutions.count < 1000


@pytest.mark.parametrize("path", [p if p == SLIDER_CRANK else pytest.param(p, marks=pytest.mark.slow) for p in SHIPPED])
def test_extreme_dimensions_are_solved_or_refused(path: Path, solutions: Solutions) -> None:
    ends: list[DescribedScene | str] = []
    for seed in range(1000, 1025):
        solutions.count = 0
        ends.append(mutants.scene_or_refusal(mutants.out_of_scale(tables(path), random.Random(f"{path.name} {seed}"))))
    assert any(isinstance(end, str) for end in ends)
    assert any(isinstance(end, DescribedScene) for end in ends)


def test_tracking_is_refused_when_steps_run_out(monkeypatch: pytest.MonkeyPatch) -> None:
    # Negative control of the budget: with few steps left, a walk that needs single steps is refused.
    monkeypatch.setattr(assembly_branch, "MAX_STEPS_PER_REVOLUTION", 3)
    with pytest.raises(InvalidInput, match="its motion was not found beyond crank angle"):
        scene_from_tables(tables(CATALOGUE / "geneva.toml") | {"name": "other"})


def test_step_count_explodes_when_size_is_start_pose_alone(
    monkeypatch: pytest.MonkeyPatch, solutions: Solutions
) -> None:
    # Negative control of the count: the scale of a start of 0.001 mm takes more steps than there are.
    solutions.most = 1000  # five times what is enough
    monkeypatch.setattr(equations, "_extent", lambda _: 0.0)
    monkeypatch.setattr(assembly_branch, "MAX_STEPS_PER_REVOLUTION", 10**9)
    with pytest.raises(TooMany):
        scene_from_tables(with_entry(CAM, "start.follower.origin", [0, "0.001 mm"]) | {"name": "other"})
