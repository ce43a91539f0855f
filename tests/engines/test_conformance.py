"""The suite for authors of engines: engines that ship keep it, and each planted mistake breaks the claim on it."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from planted_engine import LawfulEngine, PlantedSettings
from spatial_mistakes import (
    RunsInSpace,
    align_axes,
    edit_nothing,
    freeze_spin,
    ignore_closures,
    move_first_of_two_hinges,
    swap_hinges,
)

from conrod.comparison.compare import compare
from conrod.comparison.trajectory import Piece, PointTracks, Track
from conrod.engines import engine_named
from conrod.engines.capabilities import KinematicResult
from conrod.engines.engine import PIECE_STEPS, Machine
from conrod.engines.run import run_in_one_piece
from conrod.exact.motion import Array
from conrod.scenes import SCENES
from conrod.testing import EngineConformance

PAGE = Path(__file__).parents[2] / "docs" / "own-engine.md"
FAST_SAW: Any = SCENES["saw-500rpm"]
CODE = "\n".join(re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL))


class TestMuJoCo(EngineConformance):
    engine = engine_named("mujoco")
    scenes = ("saw-40rpm",)


class TestPymunk(EngineConformance):
    engine = engine_named("pymunk")
    scenes = ("saw-40rpm",)


class PlantedSuite(EngineConformance):
    engine = LawfulEngine()
    scenes = ("saw-40rpm",)

    def _allowed_at_start(self, settings: Any) -> float:
        return 10.0 * settings.lead  # its error is a lead that it has from the start


class TestPlanted(PlantedSuite):
    """The engine of the tests keeps every claim."""


# -- planted mistakes --------------------------------------------------------------------------------------------------


def edit_quantity(tracks: PointTracks, quantity: str, edit: Callable[[Array], Array]) -> PointTracks:
    track = getattr(tracks, quantity)
    return replace(tracks, **{quantity: Track(track.instants, edit(track.values))})


class Mistaken(LawfulEngine):
    """The planted engine with a mistake in a quantity of all points."""

    def __init__(self, quantity: str, edit: Callable[[Array], Array]) -> None:
        super().__init__()
        self.quantity, self.edit = quantity, edit

    def run(self, *arguments: Any, **others: Any) -> Iterator[Piece]:
        for piece in super().run(*arguments, **others):
            found = piece.trajectory.points.items()
            points = {name: edit_quantity(tracks, self.quantity, self.edit) for name, tracks in found}
            yield replace(piece, trajectory=replace(piece.trajectory, points=points))


def half_a_step_early(values: Array) -> Array:
    before = np.concatenate([2.0 * values[:1] - values[1:2], values[:-1]]) if len(values) > 1 else values
    return 0.5 * (values + before)


def add_noise(values: Array) -> Array:
    return values + 1e-12 * np.random.default_rng().standard_normal(values.shape)


class StartsElsewhere(LawfulEngine):
    def run(self, machine: Machine, settings: Any, revolutions: float, _: float = 0.0, steps: int = PIECE_STEPS) -> Any:
        return super().run(machine, settings, revolutions, 0.0, steps)


class Raises(LawfulEngine):
    def run(self, machine: Machine, settings: PlantedSettings, *arguments: Any, **others: Any) -> Iterator[Piece]:
        if settings.steps_per_revolution < 3:
            raise FloatingPointError("diverged")
        return super().run(machine, settings, *arguments, **others)


class NoReason(LawfulEngine):
    def refusal(self, machine: Machine, settings: PlantedSettings) -> str | None:
        return "" if machine.kinematics.mechanism.cam_contacts else None


class WrongPlaces(LawfulEngine):
    """Its own constraints place points a millionth of a metre off."""

    def solve_kinematics(self, machine: Any, angle: Array) -> KinematicResult:
        exact = machine.motion(angle, machine.speed)
        places = {name: (exact.point(name).position + 1e-6, None) for name in machine.lengths}
        return KinematicResult(angle, np.zeros((len(angle), 0)), places)


class NoVersion(LawfulEngine):
    version = ""


MISTAKES: dict[str, tuple[Any, ...]] = {
    "test_no_quantity_lags_its_stamp": (
        Mistaken("velocity", half_a_step_early),
        Mistaken("acceleration", half_a_step_early),
    ),
    "test_each_sample_carries_its_instant": (LawfulEngine(late=1),),
    "test_motion_follows_the_drive_in_sense_and_metres": (
        Mistaken("position", lambda values: 1e3 * values),
        Mistaken("position", lambda values: values * np.array([1.0, -1.0])),
    ),
    "test_the_same_run_has_the_same_bits_in_any_pieces": (
        Mistaken("position", add_noise),
        Mistaken("position", lambda values: values + 1e-12 * len(values)),
    ),
    "test_run_starts_exactly_at_the_given_angle": (StartsElsewhere(),),
    "test_failed_run_has_outcome_and_reason": (Raises(),),
    "test_engine_refuses_scenes_with_a_reason": (NoReason(),),
    "test_constraints_of_the_engine_place_the_machine": (WrongPlaces(),),
    "test_engine_has_name_version_and_preset_rules": (NoVersion(),),
    "test_hinge_in_space_turns_about_its_oblique_axis": (RunsInSpace(align_axes),),
    "test_both_hinges_of_a_body_in_space_are_in_place": (
        RunsInSpace(move_first_of_two_hinges),
        RunsInSpace(swap_hinges),
    ),
    "test_redundant_closure_in_space_holds_its_loop": (RunsInSpace(ignore_closures),),
    "test_free_spin_beside_a_loop_goes_on": (RunsInSpace(freeze_spin),),
}


@pytest.mark.parametrize("claim", [name for name in vars(EngineConformance) if name.startswith("test_")])
def test_conformance_fails_when_an_engine_breaks_a_claim(claim: str) -> None:
    for engine in MISTAKES[claim]:
        suite = type("Suite", (PlantedSuite,), {"engine": engine})()
        with pytest.raises((AssertionError, FloatingPointError)):
            getattr(suite, claim)()


@pytest.mark.parametrize("claim", [name for name in MISTAKES if "space" in name or "spin" in name])
def test_engine_that_is_right_in_space_keeps_the_claim(claim: str) -> None:
    getattr(type("Suite", (PlantedSuite,), {"engine": RunsInSpace(edit_nothing)})(), claim)()


# -- the engine that docs/own-engine.md walks through ------------------------------------------------------------------


def engine_of(code: str) -> Any:
    """The engine that a module of this code has."""
    module = sys.modules["shake_engine"] = ModuleType("shake_engine")
    exec(compile(code, str(PAGE), "exec"), vars(module))
    return module.ENGINE


class TestShake(EngineConformance):
    engine = engine_of(CODE)
    scenes = ("saw-500rpm",)
    steps = (100, 200)


@pytest.mark.parametrize(
    ("what", "wrong", "seen"),
    [
        ("", "", ()),
        ("np.diff(values, 2, axis=0) / h**2", "0.999 * np.diff(values, 2, axis=0) / h**2", ("acceleration",)),
        ("return x + out *", "return x + 1.001 * out *", ("position", "velocity", "acceleration")),
    ],
)
def test_error_law_bounds_errors_and_fails_on_a_mistake(what: str, wrong: str, seen: tuple[str, ...]) -> None:
    assert what in CODE
    engine = engine_of(CODE.replace(what, wrong, 1))
    settings = engine.presets["tuned"](FAST_SAW, 200)
    found, law = (
        compare(run_in_one_piece(engine, FAST_SAW, settings, 1.0), FAST_SAW),
        engine.expected_error(FAST_SAW, settings),
    )
    for quantity in ("position", "velocity", "acceleration"):
        assert (found.worst(quantity) > getattr(law, quantity)) == (quantity in seen)
