"""The engines' laws hold on the catalogue's linkages at other speeds, backwards and with long steps, too."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from conrod.comparison.compare import compare
from conrod.comparison.trajectory import Outcome
from conrod.engines import engine_named
from conrod.engines.engine import run_extent
from conrod.engines.pymunk import PymunkSettings
from conrod.engines.run import run_in_one_piece
from conrod.scenes import catalogue_names, catalogue_scene
from conrod.scenes.described_scene import DescribedScene

LINKAGES = [name for name in catalogue_names() if not name.startswith("cam-")]
QUICK = ("two-slider-linkage", "slider-crank")
SPEEDS, STEPS = (-1.0, -2.7, 0.4), 250


def at_speed(name: str, factor: float) -> DescribedScene:
    scene = catalogue_scene(name)
    return scene.with_parameters(speed=factor * scene.speed)


def over_the_law(scene: DescribedScene, engine: Any, settings: Any) -> float | None:
    """Largest error over what the engine's law allows; None where it has no law, or cannot have the machine."""
    if engine.refusal(scene, settings):
        return None
    law = engine.expected_error(scene, settings)
    if law.position is None:
        return None
    start, revolutions = run_extent(scene, settings.steps_per_revolution, 2.0)
    trajectory = run_in_one_piece(engine, scene, settings, revolutions, start)
    assert trajectory.outcome is Outcome.COMPLETED
    found = compare(trajectory, scene)
    quantities = ("position", "velocity", "acceleration")
    return max(float(found.worst(quantity) / getattr(law, quantity)) for quantity in quantities)


@pytest.mark.parametrize("factor", SPEEDS)
@pytest.mark.parametrize(
    "name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in LINKAGES]
)
def test_errors_stay_within_bound_at_another_speed(name: str, factor: float) -> None:
    scene = at_speed(name, factor)
    for engine_name in ("mujoco", "pymunk"):
        engine = engine_named(engine_name)
        for preset, rule in engine.presets.items():
            if rule.judged:
                found = over_the_law(scene, engine, rule(scene, STEPS))
                assert found is None or found < 1.0, (engine_name, preset)


def test_pymunk_exceeds_bound_with_too_few_iterations() -> None:
    """From a start without stored impulses the two loops, run backwards, do not settle in the first steps."""
    scene, engine = at_speed("two-slider-linkage", -1.0), engine_named("pymunk")
    settings = engine.presets["tuned"](scene, 1000)
    enough = over_the_law(scene, engine, settings)
    few = over_the_law(scene, engine, replace(settings, iterations=settings.iterations // 2))
    assert enough is not None
    assert few is not None
    assert enough < 1.0 < few


def test_pymunk_bound_covers_first_acceleration_after_start() -> None:
    """Backwards a Peaucellier linkage begins where it bends most: without that term it is 1.02 times its law."""
    scene, engine = at_speed("peaucellier", -1.0), engine_named("pymunk")
    found = over_the_law(scene, engine, engine.presets["tuned"](scene, 1000))
    assert found is not None
    assert 0.9 < found < 1.0


@pytest.mark.parametrize("steps", [2, 12])
def test_pymunk_bound_covers_no_more_than_the_pass(steps: int) -> None:
    """A double rocker has 1 to 3 of these steps in its pass, and cannot be assembled much beyond it."""
    for speed in (1.0, -1.0):
        scene = at_speed("double-rocker", speed)
        assert engine_named("pymunk").expected_error(scene, PymunkSettings.tuned(scene, steps)).position
