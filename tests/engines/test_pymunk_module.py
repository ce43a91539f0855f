"""An exported pymunk module runs alone, and makes the bits of the engine's own run."""

from __future__ import annotations

import ast
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from modules_alone import printed_lines, run_alone

from conrod import InvalidInput, Saw
from conrod.engines import engine_named
from conrod.engines.engine import run_extent
from conrod.engines.numerics import frames_from_centres
from conrod.engines.pymunk import PymunkSettings
from conrod.engines.pymunk.space import with_crank_centred
from conrod.engines.pymunk.standalone import standalone_module
from conrod.engines.run import run_in_one_piece
from conrod.engines.tracks import Pace
from conrod.exact.motion import Array
from conrod.scenes import Scene, catalogue_tables, scene_named
from conrod.scenes.described_scene import scene_from_tables

ENGINE = engine_named("pymunk")
# Each with the steps of a revolution. Of the press the laws of loads are in the module too.
MACHINES = {
    "saw-500rpm": 1000,
    "shear-press": 1000,
    "cam-follower": 4000,
    "cam-spring-slow": 4000,
    "web-cutter": 1000,
    "geneva": 1000,
    "crank-shaper": 200,
    "six-bar": 1000,
    "planetary-gear": 1000,
    "press-cutting": 1000,
    "slider-crank-spring": 1000,
}


@cache
def settings_of(name: str, preset: str = "tuned") -> tuple[Scene, PymunkSettings]:
    scene = scene_named(name)
    return scene, ENGINE.presets[preset](scene, MACHINES[name])


@cache
def engine_states(name: str, preset: str = "tuned") -> tuple[Array, Array]:
    """Poses and rates (3 n,) at the end of the engine's own run."""
    scene, settings = settings_of(name, preset)
    start, revolutions = run_extent(scene, settings.steps_per_revolution, 2.0)
    bodies = run_in_one_piece(ENGINE, scene, settings, revolutions, start).bodies
    return bodies.position.poses[-1], bodies.position.rates[-1]


def is_of_engine(name: str, text: str, folder: Path, preset: str = "tuned") -> bool:
    """Whether a module ends its run in the engine's states, to the last bit."""
    mechanism = with_crank_centred(settings_of(name, preset)[0].kinematics.mechanism)
    found = frames_from_centres(mechanism, *run_alone(text, folder))
    return all(np.array_equal(one[0], other) for one, other in zip(found, engine_states(name, preset), strict=True))


@pytest.mark.parametrize("name", MACHINES)
def test_module_makes_the_bits_of_the_engine(name: str, tmp_path: Path) -> None:
    assert is_of_engine(name, standalone_module(name, *settings_of(name)), tmp_path)


@pytest.mark.parametrize("name", ["saw-500rpm", "cam-follower"])
def test_module_of_stock_settings_makes_their_bits(name: str, tmp_path: Path) -> None:
    assert is_of_engine(name, standalone_module(name, *settings_of(name, "stock")), tmp_path, "stock")


# Negative controls: one slip each, in the smallest unit that the text has for it.
SLIPS = {
    "length": ("saw-500rpm", "(0.1, 0.0), (-0.15, 0.0)", "(0.10000000000000002, 0.0), (-0.15, 0.0)"),
    "iterations": ("saw-500rpm", "ITERATIONS = 147", "ITERATIONS = 146"),
    "bias": ("saw-500rpm", "ERROR_BIAS = 0.0", "ERROR_BIAS = 1e-300"),
    "inertia": ("saw-500rpm", "0.01125)", "0.011250000000000001)"),
    "drive": ("saw-500rpm", "model.speed * model.time", "model.speed * model.timestep * model.steps"),
    "slop": ("cam-follower", "COLLISION_SLOP = ", "COLLISION_SLOP = 1.0000001 * "),
    "load": ("press-cutting", "_pulse(value, ", "_pulse(1e-9 + value, "),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_in_a_module_is_seen(slip: str, tmp_path: Path) -> None:
    name, right, wrong = SLIPS[slip]
    text = standalone_module(name, *settings_of(name))
    assert text.count(right) == 1
    assert not is_of_engine(name, text.replace(right, wrong), tmp_path)


def test_module_imports_pymunk_and_math_alone() -> None:
    tree = ast.parse(standalone_module("saw-500rpm", *settings_of("saw-500rpm")))
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom)]
    assert [ast.unparse(node) for node in imports] == ["import math", "import pymunk"]


def test_module_says_source_frame_and_parameters_with_units() -> None:
    scene, settings = settings_of("saw-500rpm")
    header = " ".join(str(ast.get_docstring(ast.parse(standalone_module("saw-500rpm", scene, settings)))).split())
    for words in (scene.title, scene.source, " ".join(scene.frame.split()), "'tuned' at 1000 steps a revolution"):
        assert words in header
    for words in ("crank = 0.1 m crank, shaft", "rod_inertia = 0.01125 kg m² connecting", "speed = 52.3598776 rad/s"):
        assert words in header


def test_module_prints_the_travel_of_each_point(tmp_path: Path) -> None:
    scene, settings = settings_of("saw-500rpm")
    file = tmp_path / "saw.py"
    file.write_text(standalone_module("saw-500rpm", scene, settings), encoding="utf-8")
    assert printed_lines(file)[0] == "C: travels 211.1418 mm in two turns"
    # The engine's own error is in it.
    assert 1e3 * scene.lengths["C"] == pytest.approx(211.1418, rel=1e-4)


def test_module_at_another_speed_is_the_engine_at_that_speed(tmp_path: Path) -> None:
    scene, settings = settings_of("saw-500rpm")
    other = Saw(speed=-3.0)
    ends = replace(PymunkSettings.tuned(other, 1000), iterations=settings.iterations)
    poses = run_in_one_piece(ENGINE, other, ends, 2.0).bodies.position.poses[-1]
    text = standalone_module("saw-500rpm", scene, settings)
    found = frames_from_centres(other.kinematics.mechanism, *run_alone(text, tmp_path, speed=-3.0))[0]
    assert found[0] == pytest.approx(poses, abs=1e-12)
    with pytest.raises(AssertionError, match="must be a number other than 0"):
        run_alone(text, tmp_path, speed=0.0)


def test_undriven_crank_is_that_of_the_free_engine(tmp_path: Path) -> None:
    scene, settings = settings_of("web-cutter")
    mechanism = scene.kinematics.mechanism
    free = PymunkSettings.for_free_motion(mechanism, "tuned", settings.timestep)
    text = standalone_module("web-cutter", scene, settings)
    right = f"ITERATIONS = {settings.iterations} "
    assert text.count(right) == 1
    centres, rates = run_alone(text.replace(right, f"ITERATIONS = {free.iterations} "), tmp_path, drive=False)
    poses, slopes = scene.kinematics.derivatives(np.zeros(1), 1)
    run = ENGINE.free_run(
        mechanism, "tuned", settings.timestep, 2000, poses[0], slopes[0] * scene.speed, Pace(1.0, False)
    )
    assert np.array_equal(frames_from_centres(mechanism, centres, rates)[0][0], run.poses[-1])


def test_names_in_a_machine_file_cannot_become_code(tmp_path: Path) -> None:
    tables = catalogue_tables("web-cutter")
    title = '"""\nraise SystemExit("planted")\n"""\\'
    text = standalone_module("web\\", scene_from_tables(tables | {"title": title}))
    assert "planted" in str(ast.get_docstring(ast.parse(text)))
    run_alone(text, tmp_path)


def test_module_of_a_rack_is_refused_with_the_reason() -> None:
    with pytest.raises(
        InvalidInput, match="rolling-on-flat: track: pymunk has no joint that ties the way along a line"
    ):
        standalone_module("rolling-on-flat", scene_named("rolling-on-flat"))
