"""Requirements for an engine to take part in conrod: a suite that its author runs with pytest.

    from conrod.testing import EngineConformance

    class TestMine(EngineConformance):
        engine = ENGINE

Each claim runs short stretches of the scenes; one that an engine refuses, with a reason, is left out.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np
import pytest

from conrod.comparison.compare import compare
from conrod.comparison.trajectory import Outcome, Trajectory, concatenate_pieces
from conrod.engines.capabilities import KinematicMode, MissingCapability, capability
from conrod.engines.engine import Engine, judged_preset
from conrod.exact.motion import QUANTITIES, Array
from conrod.scenes import SCENES, Scene, catalogue_names, scene_named

START_ANGLE, RUN_TURNS = 0.7, 0.25  # [rad], and of a turn
# A stamp that is half a step off keeps that lag at any step; what an error of a higher order looks like falls with it.
MAX_LAG, FALL_FACTOR = 0.05, 0.7
ROUNDING = 1e-9


class EngineConformance:
    """Test suite for an engine; a subclass sets the engine, and may set more.

    Attributes:
        engine: under test.
        scenes: names of conrod's scenes that the engine is run on.
        steps: per revolution, the second twice the first.
        first_order: presets whose error is of first order, in which a lag cannot be told from it.
        rounding: rounding of the engine's state, over the travel: 2e-6 in single precision.
        coarse: most that a position may be off over its travel at the coarser steps.
    """

    engine: ClassVar[Engine[Any]]
    scenes: ClassVar[tuple[str, ...]] = ("saw-40rpm", "shear-press")
    steps: ClassVar[tuple[int, int]] = (400, 800)
    first_order: ClassVar[tuple[str, ...]] = ()
    rounding: ClassVar[float] = ROUNDING
    coarse: ClassVar[float] = 0.1

    # -- what it says of itself ------------------------------------------------------------------------------------

    def test_engine_has_name_version_and_preset_rules(self) -> None:
        assert self.engine.name
        assert self.engine.version
        assert self.engine.presets
        for name, _, settings in self._settings():
            assert settings.engine == self.engine.name
            assert settings.preset == name
            assert json.loads(json.dumps(settings.as_dict())), "settings are plain values: they are part of a run's key"
            assert hash(settings) == hash(self.engine.presets[name](_, settings.steps_per_revolution))

    def test_engine_refuses_scenes_with_a_reason(self) -> None:
        preset = judged_preset(self.engine)
        for name in (*SCENES, *catalogue_names()):
            scene = SCENES[name] if name in SCENES else scene_named(name)
            reason = self.engine.refusal(scene, self.engine.presets[preset](scene, self.steps[0]))
            assert reason is None or (isinstance(reason, str) and reason.strip()), f"{name}: a reason, or None"

    # -- the start and the stamps --------------------------------------------------------------------------------------

    def test_run_starts_exactly_at_the_given_angle(self) -> None:
        for name, scene, settings in self._settings():
            first = self._run(scene, settings, 2.0 / settings.steps_per_revolution)
            assert first.bodies is not None
            at = first.bodies.position.instants
            assert at.angle[0] == pytest.approx(START_ANGLE, abs=self.rounding), (
                f"{name}: the crank's angle at the start"
            )
            exact = scene.motion(np.array([START_ANGLE]), scene.speed)
            for point, tracks in first.points.items():
                off = np.linalg.norm(tracks.position.values[0] - exact.point(point).position[0])
                assert off <= self._allowed_at_start(settings) * scene.lengths[point], f"{name}: {point} at the start"

    def test_each_sample_carries_its_instant(self) -> None:
        for name, scene, settings in self._settings():
            run = self._run(scene, settings)
            for point, tracks in run.points.items():
                for quantity in QUANTITIES:
                    at = getattr(tracks, quantity).instants
                    late = np.abs(at.angle / scene.speed - at.times).max() / settings.timestep
                    assert late < 0.25, f"{name}: {quantity} of {point} is stamped {late:.2g} steps off its crank angle"

    def test_no_quantity_lags_its_stamp(self) -> None:
        for name in self.engine.presets:
            if not self.engine.presets[name].judged or name in self.first_order:
                continue
            for scene in self._machines(name):
                coarse, fine = (
                    self._lags(scene, self._run(scene, self.engine.presets[name](scene, n)), n) for n in self.steps
                )
                for quantity in QUANTITIES:
                    falls = fine[quantity] <= max(MAX_LAG, FALL_FACTOR * coarse[quantity])
                    assert falls, f"{name}: {quantity} lags its stamp by {fine[quantity]:.2g} steps at any step"

    # -- the motion ----------------------------------------------------------------------------------------------------

    def test_motion_follows_the_drive_in_sense_and_metres(self) -> None:
        for name, scene, settings in self._settings():
            for sense in (1.0, -1.0):
                driven = scene.with_parameters(speed=sense * scene.speed)
                run = self._run(driven, self.engine.presets[name](driven, settings.steps_per_revolution))
                assert run.outcome is Outcome.COMPLETED, f"{name}: {run.reason}"
                off = compare(run, driven).worst("position")
                assert off <= self.coarse, f"{name}: a position is off by {off:.2g} of its travel, driven {sense:+g}"

    def test_the_same_run_has_the_same_bits_in_any_pieces(self) -> None:
        for name, scene, settings in self._settings():
            whole, again, parts = (self._run(scene, settings, steps=n) for n in (4096, 4096, 7))
            for other, how in ((again, "run again"), (parts, "in other pieces")):
                for point, tracks in whole.points.items():
                    same = np.array_equal(tracks.position.values, other.points[point].position.values)
                    assert same, f"{name}: {point} has other bits {how}"

    def test_failed_run_has_outcome_and_reason(self) -> None:
        for name, scene, _ in self._settings():
            run = self._run(scene, self.engine.presets[name](scene, 2), 4.0)
            assert isinstance(run.outcome, Outcome), f"{name}: an outcome of the closed list"
            assert (run.outcome is Outcome.COMPLETED) == (not run.reason), f"{name}: the reason of an outcome"

    def test_constraints_of_the_engine_place_the_machine(self) -> None:
        solver = capability(self.engine, KinematicMode)
        if isinstance(solver, MissingCapability):
            pytest.skip(solver.reason)
        for scene in self._machines(judged_preset(self.engine)):
            angle = np.linspace(0.0, 2.0 * np.pi, 24)
            exact, found = scene.motion(angle, scene.speed), solver.solve_kinematics(scene, angle)
            for point, (position, _) in found.points.items():
                off = np.linalg.norm(position - exact.point(point).position, axis=1).max() / scene.lengths[point]
                assert off < ROUNDING, f"{point} is off by {off:.2g} of its travel in kinematic mode"

    # -- helpers -------------------------------------------------------------------------------------------------------

    def _machines(self, preset: str) -> Iterator[Scene]:
        """The scenes that the engine does not refuse; at least one is required."""
        taken = 0
        for name in self.scenes:
            if self.engine.refusal(SCENES[name], self.engine.presets[preset](SCENES[name], self.steps[0])) is None:
                taken += 1
                yield SCENES[name]
        assert taken, f"{self.engine.name} refuses all of {', '.join(self.scenes)}"

    def _settings(self) -> Iterator[tuple[str, Scene, Any]]:
        """Each preset on each scene, at the coarser steps."""
        for name, preset in self.engine.presets.items():
            for scene in self._machines(name):
                yield name, scene, preset(scene, self.steps[0])

    def _run(self, scene: Scene, settings: Any, turns: float = RUN_TURNS, steps: int = 4096) -> Trajectory:
        return concatenate_pieces(list(self.engine.run(scene, settings, turns, START_ANGLE, steps))).trajectory

    def _allowed_at_start(self, settings: Any) -> float:
        """Allowed error at the start over the travel: rounding, for an engine that starts exact."""
        return self.rounding

    def _lags(self, scene: Scene, run: Trajectory, steps: int) -> dict[str, float]:
        """Lag of each quantity behind the exact motion, in steps, the largest of all points."""
        found = dict.fromkeys(QUANTITIES, 0.0)
        step = 2.0 * np.pi / abs(scene.speed) / steps
        for point, tracks in run.points.items():
            for quantity, rate in zip(QUANTITIES, (*QUANTITIES[1:], "jerk"), strict=True):
                track = getattr(tracks, quantity)
                exact = scene.motion(np.asarray(track.instants.angle), scene.speed).point(point)
                lag = _explained_shift(track.values - getattr(exact, quantity), getattr(exact, rate)) / step
                found[quantity] = max(found[quantity], abs(lag))
        return found


def _explained_shift(error: Array, rate: Array) -> float:
    """Time shift [s] that explains an error (T, 2) of a quantity that changes at a rate (T, 2)."""
    return float((error * rate).sum() / max(float((rate * rate).sum()), 1e-300))
