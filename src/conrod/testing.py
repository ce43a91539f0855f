"""Requirements for an engine to take part in conrod: a suite that its author runs with pytest.

    from conrod.testing import EngineConformance

    class TestMine(EngineConformance):
        engine = ENGINE

Each claim runs short stretches of the scenes; one that an engine refuses, with a reason, is left out.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import Any, ClassVar

import numpy as np
import pytest

from conrod.comparison.compare import compare
from conrod.comparison.trajectory import Outcome, Trajectory, concatenate_pieces
from conrod.engines.capabilities import KinematicMode, MissingCapability, SpatialRuns, capability
from conrod.engines.engine import Engine, judged_preset
from conrod.engines.space import SpatialRun, SpatialStart, exact_start, widest_gaps
from conrod.exact.jet import Jet
from conrod.exact.motion import QUANTITIES, Array
from conrod.exact.space import SpatialPoint
from conrod.scenes import SCENES, Scene, catalogue_names, scene_named
from conrod.scenes.space import MACHINES, SpatialMachine
from conrod.scenes.space.machine import LinkJoint, ModelLink, X, Y, Z, rotate, unit
from conrod.scenes.space.tree import exact_points, machine_laws, spatial_tree

START_ANGLE, RUN_TURNS = 0.7, 0.25  # [rad], and of a turn
# A stamp that is half a step off keeps that lag at any step; what an error of a higher order looks like falls with it.
MAX_LAG, FALL_FACTOR = 0.05, 0.7
ROUNDING = 1e-9
SPIN, OFF_AXIS = 30.0, 0.05  # rate of a free spin [rad/s], and distance [m] of the point that shows it from the axis


class EngineConformance:
    """Test suite for an engine; a subclass sets the engine, and may set more.

    Attributes:
        engine: under test.
        scenes: names of conrod's scenes that the engine is run on; empty for an engine that runs in space alone.
        steps: per revolution, the second twice the first.
        first_order: presets whose error is of first order, in which a lag cannot be told from it.
        rounding: rounding of the engine's state, over the travel: 2e-6 in single precision.
        coarse: most that a position may be off over its travel at the coarser steps, and a spin over its rate.
        spatial_steps: per revolution, of runs in space.
    """

    engine: ClassVar[Engine[Any]]
    scenes: ClassVar[tuple[str, ...]] = ("saw-40rpm", "shear-press")
    steps: ClassVar[tuple[int, int]] = (400, 800)
    first_order: ClassVar[tuple[str, ...]] = ()
    rounding: ClassVar[float] = ROUNDING
    coarse: ClassVar[float] = 0.1
    spatial_steps: ClassVar[int] = 200

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

    # -- machines in space, for engines that run them ------------------------------------------------------------------

    def test_hinge_in_space_turns_about_its_oblique_axis(self) -> None:
        self._hold_positions("oblique-bar")

    def test_both_hinges_of_a_body_in_space_are_in_place(self) -> None:
        self._hold_positions("rssr")

    def test_redundant_closure_in_space_holds_its_loop(self) -> None:
        self._hold_positions("cardan")

    def test_free_spin_beside_a_loop_goes_on(self) -> None:
        start = spinning_start()
        for preset, run in self._spatial_runs(start):
            off = float(np.abs(spin_rates(run) / SPIN - 1.0).max())
            assert off <= self.coarse, f"{preset}: a rod that spins freely at {SPIN:g} rad/s is off by {off:.2g} of it"

    def _hold_positions(self, name: str) -> None:
        """Hold the positions of a machine to its closed form, and its loops to their travel."""
        machine, start = machine_in_space(name)
        for preset, run in self._spatial_runs(start):
            exact = exact_points(machine, run.times)
            travel = max(float(np.linalg.norm(one[0] - one[0][0], axis=1).max()) for one in exact.values())
            off = max(float(np.linalg.norm(run.points[p][0] - exact[p][0], axis=1).max()) for p in exact) / travel
            gap = max(widest_gaps(start.tree, run).values(), default=0.0) / travel
            assert off <= self.coarse, f"{preset}: {machine.title}: a position is off by {off:.2g} of the travel"
            assert gap <= self.coarse, f"{preset}: {machine.title}: its loop is open by {gap:.2g} of the travel"

    def _spatial_runs(self, start: SpatialStart) -> Iterator[tuple[str, SpatialRun]]:
        """Half a revolution in each preset that is not refused; a run may break off with a reason, but not all may."""
        runs = capability(self.engine, SpatialRuns)
        if isinstance(runs, MissingCapability):
            pytest.skip(runs.reason)
        start, failures, refusals = replace(start, step=start.period / self.spatial_steps), [], []
        for name in self.engine.presets:
            if (refusal := runs.refusal_in_space(start, name)) is not None:
                assert refusal.strip(), f"{name}: a reason, or None"
                refusals.append(refusal)
                continue
            run = runs.run_in_space(start, name, self.spatial_steps // 2)
            if run.failure:
                failures.append(f"{name}: {run.failure}")
                continue
            assert len(run.times) == self.spatial_steps // 2 + 1, f"{name}: a sample at the start and after each step"
            yield name, run
        if len(refusals) == len(self.engine.presets):
            pytest.skip(refusals[0])
        assert len(failures) + len(refusals) < len(self.engine.presets), f"no preset runs to its end: {failures}"

    # -- helpers -------------------------------------------------------------------------------------------------------

    def _machines(self, preset: str) -> Iterator[Scene]:
        """The scenes that the engine does not refuse; at least one is required."""
        if not self.scenes:
            pytest.skip(f"{self.engine.name} runs machines in space alone")
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


# -- machines in space -------------------------------------------------------------------------------------------------


def oblique_bar() -> SpatialMachine:
    """A bar on one hinge, whose axis is along no axis of the world; its tip goes round on a circle."""
    axis, place, arm = unit(X + 2.0 * Y - 1.5 * Z), 0.1 * (X - Y), 0.3 * X + 0.1 * Z

    def closed_form(drives: Mapping[str, Jet]) -> dict[str, Jet]:
        return {"tip": rotate(arm, axis, drives["input"]) + place}

    link = ModelLink("bar", place, (LinkJoint("input", axis),), (place + arm,), {"tip": place + arm})
    return SpatialMachine("oblique-bar", "Bar on an oblique hinge", (link,), (), {"input": "60rpm"}, closed_form)


@cache
def machine_in_space(name: str) -> tuple[SpatialMachine, SpatialStart]:
    """A machine by its name, and its exact start."""
    machine = oblique_bar() if name == "oblique-bar" else MACHINES[name]()
    return machine, exact_start(spatial_tree(machine), machine_laws(machine), exact_points(machine, np.zeros(1)))


@cache
def spinning_start() -> SpatialStart:
    """An RSSR linkage between two balls, whose rod spins about its axis; a third point shows it.

    The rod is alike all round, and its balls lie on its axis: nothing acts on the spin, whose rate stays (Euler's
    equations of a symmetric top).
    """
    machine = MACHINES["rssr-idle-spin"]()
    tree = spatial_tree(machine)
    middle, ball = tree.points["rod_middle"], next(joint for joint in tree.joints if joint.kind == "ball")
    axis = unit(tree.points["rod_end"].offset)
    aside = unit(np.cross(axis, X))
    points = {**tree.points, "off_axis": SpatialPoint(middle.body, middle.offset + OFF_AXIS * aside)}
    tree = replace(tree, points=points)
    start = exact_start(tree, machine_laws(machine), ("rod_middle", "rod_end", "off_axis"))
    rates = start.exact.rates.copy()
    own = rates[0, ball.rates, 0]  # against the crank, which turns about Z
    more = SPIN - axis @ (own + start.machine.laws["input"].derivatives(np.zeros(1))[1, 0] * Z)
    rates[1, ball.rates, 0] += more * np.cross(own, axis)  # the spin turns what is across the axis
    rates[0, ball.rates, 0] = own + more * axis
    return replace(start, exact=replace(start.exact, rates=rates))


def spin_rates(run: SpatialRun) -> Array:
    """Rate (T,) [rad/s] at which the rod of `spinning_start` spins, by its three points."""
    (middle, middle_rate), (end, end_rate), (off, off_rate) = (
        run.points[name][:2] for name in ("rod_middle", "rod_end", "off_axis")
    )
    length = np.linalg.norm(end - middle, axis=1)[:, None]
    axis = (end - middle) / length
    along = ((off - middle) * axis).sum(axis=1)[:, None]
    arm = off - middle - along * axis
    rate = off_rate - middle_rate - along / length * (end_rate - middle_rate)
    return np.asarray((axis * np.cross(arm, rate)).sum(axis=1) / (arm * arm).sum(axis=1))
