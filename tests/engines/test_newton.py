"""Newton, where it is installed: which of its solvers hold which machines, single precision, and what it refuses."""

from __future__ import annotations

import contextlib
import subprocess
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from command_line import refusal
from planted_engine import LawfulEngine

from conrod.engines import engine_named, installed_extras
from conrod.engines.body_readings import BodyReadings, joint_openings, motion_of_points
from conrod.engines.engine import DOUBLE_EPSILON, SINGLE_EPSILON
from conrod.engines.newton import NEWTON_PRESETS
from conrod.engines.space import SpatialRun
from conrod.errors import InvalidInput
from conrod.exact.space.motion import DrivenTree
from conrod.execution.tolerances import check_tolerance
from conrod.scenes import SCENES
from conrod.scenes.space.tree import exact_points
from conrod.studies.space.api import refuse_finer_than_precision
from conrod.studies.space.plan import motion_scales
from conrod.studies.space.results import UNITS
from conrod.testing import EngineConformance, machine_in_space

NEEDS_NEWTON = pytest.mark.skipif("newton" not in installed_extras(), reason="conrod[newton] is not installed")
slow_newton = [NEEDS_NEWTON, pytest.mark.slow]  # the first test in a process loads its kernels


def run_newton(name: str, preset: str, steps: int, turns: float = 0.5, every: int = 1) -> SpatialRun:
    _, start = machine_in_space(name)
    engine: Any = engine_named("newton")
    return engine.run_in_space(replace(start, step=start.period / steps), preset, round(steps * turns), every)  # type: ignore[no-any-return]


def errors(name: str, run: SpatialRun) -> list[float]:
    """Largest errors over the largest range, speed and acceleration of the machine's points."""
    machine, _ = machine_in_space(name)
    exact, scales = exact_points(machine, run.times), motion_scales(machine)
    return [
        max(float(np.linalg.norm(run.points[p][k] - exact[p][k], axis=1).max()) for p in exact) / size
        for k, size in enumerate(scales.values())
    ]


@NEEDS_NEWTON
@pytest.mark.slow
class TestConformance(EngineConformance):
    scenes = ()
    rounding = 20.0 * SINGLE_EPSILON

    @pytest.fixture(autouse=True)
    def installed(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Newton, loaded where it is tested alone."""
        monkeypatch.setattr(type(self), "engine", engine_named("newton"), raising=False)


@NEEDS_NEWTON
@pytest.mark.slow
@pytest.mark.parametrize("preset", ["mujoco", "xpbd"])
def test_newton_holds_a_hinge_about_an_oblique_axis(preset: str) -> None:
    assert errors("oblique-bar", run_newton("oblique-bar", preset, 100))[0] < 1e-6


@NEEDS_NEWTON
@pytest.mark.slow
@pytest.mark.parametrize(("name", "most"), [("cardan", 2e-6), ("bennett", 1e-5), ("tilted-slider-crank", 2e-5)])
def test_stiff_loops_stay_closed_in_newtons_mujoco(name: str, most: float) -> None:
    stiff, stock = (errors(name, run_newton(name, preset, 200)) for preset in ("mujoco", "stock"))
    assert stiff[0] < most
    assert stiff[2] < 1e-3
    assert stock[0] > 100.0 * stiff[0]


@NEEDS_NEWTON
@pytest.mark.slow
def test_driven_coordinate_does_not_drift_as_it_is_written(monkeypatch: pytest.MonkeyPatch) -> None:
    assert errors("cardan", run_newton("cardan", "mujoco", 200, 2.0))[0] < 2e-6
    stepper: Any = engine_named("newton").stepper_in_space  # type: ignore[attr-defined] # it has it
    drive = stepper._drive
    begun = set[int]()

    def drive_once(self: Any, *values: Any) -> None:
        """Drive the first step alone; after it the flywheel keeps its rate."""
        if id(self) not in begun:
            begun.add(id(self))
            drive(self, *values)

    monkeypatch.setattr(stepper, "_drive", drive_once)
    assert errors("cardan", run_newton("cardan", "mujoco", 200, 2.0))[0] > 1e-5


@NEEDS_NEWTON
@pytest.mark.slow
def test_xpbd_run_ends_where_a_joint_comes_apart() -> None:
    found = run_newton("rssr", "xpbd", 200)
    assert len(found.times) < 101
    assert found.failure.startswith("the joint output is open by")
    assert run_newton("cardan", "xpbd", 200).failure == ""


@NEEDS_NEWTON
@pytest.mark.slow
def test_every_second_sample_of_newton_is_one_of_all() -> None:
    for preset in ("mujoco", "xpbd"):
        every, second = (run_newton("cardan", preset, 60, every=n) for n in (1, 2))
        assert np.array_equal(every.times[::2], second.times)
        assert all(np.array_equal(moved[:, ::2], second.points[name]) for name, moved in every.points.items())


def test_openings_see_a_hinge_that_has_tilted() -> None:
    _, start = machine_in_space("oblique-bar")
    bar = start.tree.bodies[1]
    upright = np.array([[*bar.place, 0.0, 0.0, 0.0, 1.0]])
    axis = bar.joints[0].axis
    about = [
        np.array([[*bar.place, *np.sin(0.1) * one, np.cos(0.1)]]) for one in (axis, np.cross(axis, [1.0, 0.0, 0.0]))
    ]
    held, turned, tilted = (
        joint_openings(start.tree, BodyReadings(poses, np.zeros((1, 6)), None))["input"] for poses in (upright, *about)
    )
    assert held < 1e-12
    assert turned < 1e-12
    assert tilted > 0.1 * start.tree.extent


@pytest.mark.parametrize("own", [False, True])
def test_run_that_breaks_off_at_once_has_no_samples(own: bool) -> None:
    _, start = machine_in_space("oblique-bar")
    readings = BodyReadings(np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]]), np.zeros((1, 6)), None)
    points = motion_of_points(start, {0: readings}, [], own)
    assert {name: moved.shape for name, moved in points.items()} == dict.fromkeys(start.points, (3, 0, 3))


# -- what is refused ---------------------------------------------------------------------------------------------------


@NEEDS_NEWTON
@pytest.mark.slow
def test_newton_refuses_planar_machines_in_a_line() -> None:
    engine, saw = engine_named("newton"), SCENES["saw-40rpm"]
    for name in NEWTON_PRESETS:
        assert engine.refusal(saw, NEWTON_PRESETS[name](saw, 100)) == "newton runs machines in space alone"


@NEEDS_NEWTON
@pytest.mark.slow
def test_xpbd_refuses_a_driven_joint_between_two_bodies() -> None:
    _, start = machine_in_space("cardan")
    engine: Any = engine_named("newton")
    laws = {"cross": start.machine.laws["input"]}
    other = replace(start, machine=DrivenTree(start.tree, laws))
    assert "drives bodies whose joints to the ground are all driven, not cross" in engine.refusal_in_space(
        other, "xpbd"
    )
    assert engine.refusal_in_space(other, "mujoco") is None
    assert engine.refusal_in_space(start, "xpbd") is None


@NEEDS_NEWTON
@pytest.mark.slow
def test_kernels_that_cannot_be_compiled_are_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    from conrod.engines.newton import space

    def fail(*_: Any, **__: Any) -> None:
        raise RuntimeError("Module xpbd failed to build\nclang: error")

    monkeypatch.setattr(space.newton.solvers.SolverXPBD, "step", fail)
    with pytest.raises(InvalidInput, match=r"^newton cannot make a step: Module xpbd failed to build$"):
        run_newton("cardan", "xpbd", 50)


@pytest.mark.parametrize(
    ("epsilon", "asked", "said"),
    [
        (SINGLE_EPSILON, "1e-9L", "position=1e-09L: planted computes in single precision, which tells 1.2e-07 of it"),
        (SINGLE_EPSILON, "1nm", "ask for 1e-06L or more"),
        (SINGLE_EPSILON, "1.1e-6L", ""),
        (DOUBLE_EPSILON, "1e-9L", ""),
    ],
)
def test_tolerance_below_single_precision_is_refused(epsilon: float, asked: str, said: str) -> None:
    engine = LawfulEngine()
    engine.epsilon = epsilon
    machine, _ = machine_in_space("cardan")
    limits = check_tolerance({"position": asked}, UNITS)
    found = refuse_finer_than_precision([engine], "all", limits, [motion_scales(machine)])
    assert said in found.get(engine.name, "")
    assert bool(found) == bool(said)


@NEEDS_NEWTON
@pytest.mark.slow
def test_command_refuses_what_single_precision_cannot_tell() -> None:
    said = refusal("validate", "cardan", "--engine", "newton", "--tolerance", "position=1e-9L")
    assert "newton computes in single precision" in said


def test_newton_not_installed_is_refused_with_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    engine_named.cache_clear()
    with contextlib.ExitStack() as undo, monkeypatch.context() as patch:
        undo.callback(engine_named.cache_clear)
        patch.setattr("conrod.engines.find_spec", lambda _: None)
        with pytest.raises(InvalidInput, match=r"pip install 'conrod\[newton\]'$"):
            engine_named("newton")


@NEEDS_NEWTON
def test_newton_starts_without_a_word_on_standard_error() -> None:
    done = subprocess.run(
        [sys.executable, "-c", "import conrod.engines.newton.engine"], capture_output=True, text=True, check=True
    )
    assert (done.stdout, done.stderr) == ("", "")
