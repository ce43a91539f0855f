"""Errors taken as a run comes are those of the whole of it, bit for bit, in memory that does not grow with it."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from catalogue import CAM, SAW

from conrod import MuJoCoSettings, PymunkSettings, compare
from conrod.comparison.compare import ComparedPiece, size_of
from conrod.comparison.plain_values import plain_values
from conrod.comparison.run_errors import (
    DrawnCurve,
    PointSizes,
    RunningSize,
    SeriesSplitter,
    pairwise_block_sizes,
    pairwise_sum,
)
from conrod.comparison.trajectory import COMPARED_QUANTITIES, Piece
from conrod.engines import engine_named
from conrod.engines.engine import Engine
from conrod.engines.run import run_in_one_piece
from conrod.execution.result import Plan
from conrod.execution.run import RunCase, measure
from conrod.studies.validation.dynamic_mode import validate_dynamic

NOISE = np.abs(np.random.default_rng(3).standard_normal(70_001)) ** 7
COUNTS = (1, 7, 8, 128, 129, 4096, 4097, 8200, 12_345, 13_147, 19_400, 65_536, 70_001)


def in_pieces_of(monkeypatch: pytest.MonkeyPatch, engine: Engine[Any], steps: int) -> None:
    run = engine.run
    monkeypatch.setattr(engine, "run", lambda *asked: run(*asked[:4], steps))


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("piece", [1000, 4096, 70_001])
def test_running_size_equals_size_of_whole_series(count: int, piece: int) -> None:
    values, running = NOISE[:count], RunningSize()
    for first in range(0, count, piece):
        running.add(values[first : first + piece], max(0, count - first - piece))
    assert running.size == size_of(values)


def test_pairwise_sum_equals_numpy_sum() -> None:
    values = np.random.default_rng(5).random(17_000)
    # Halves end at a multiple of 8: near 8192 and 16384 that decides whether there are more of them.
    for count in (4096, 4097, *range(8180, 8230), *range(16_370, 16_460, 3)):
        parts = [float(np.sum(part)) for (part,) in SeriesSplitter(pairwise_block_sizes(count)).add(values[:count])]
        assert pairwise_sum(count, iter(parts)) == float(np.sum(values[:count]))


def test_running_size_covers_run_that_ends_early() -> None:
    running, expected = RunningSize(), size_of(NOISE[:45_000])
    for k in range(5):
        running.add(NOISE[9000 * k : 9000 * (k + 1)], 90_000 - 9000 * k)
    assert (running.size.max, running.size.final) == (expected.max, expected.final)
    assert running.size.rms == pytest.approx(expected.rms, rel=1e-14)


def test_point_sizes_worst_equals_that_of_comparison() -> None:
    sizes, whole = PointSizes(), run_in_one_piece(engine_named("pymunk"), SAW, RUNS["pymunk"].settings, 0.5)
    assert sizes.worst("position") is None
    sizes.add(ComparedPiece(whole, SAW))
    assert [sizes.worst(quantity) for quantity in COMPARED_QUANTITIES] == [
        compare(whole, SAW).worst(q) for q in COMPARED_QUANTITIES
    ]


@pytest.mark.parametrize("piece", [7, 5000])
@pytest.mark.parametrize("count", [100, 1800, 1801])
def test_drawn_curve_has_largest_error_of_equal_spans(count: int, piece: int) -> None:
    curve, angles, errors = DrawnCurve(), np.arange(count) / 8.0, NOISE[:count].copy()
    errors[-1] = 2.0 * errors.max()
    for k in range(0, count, piece):
        curve.add(angles[k : k + piece], errors[k : k + piece], max(0, count - k - piece))
    middles, largest = curve.angles_and_errors
    assert len(middles) == len(largest) == min(180, count)
    assert largest[-1] == errors[-1]
    if count % 180 == 0:
        assert np.array_equal(largest, errors.reshape(180, -1).max(axis=1))
        np.testing.assert_allclose(middles, angles.reshape(180, -1).mean(axis=1), rtol=1e-12)


def test_recorders_keep_nan() -> None:
    running = RunningSize()
    for values in ([1.0, np.nan], [2.0, 3.0]):
        running.add(np.array(values), 0)
    assert np.isnan(running.size.max)


ENDLESS = 10**9
RUNS = {
    "mujoco": RunCase("saw", SAW, MuJoCoSettings.tuned(SAW, 400)),
    "pymunk": RunCase("saw", SAW, PymunkSettings.tuned(SAW, 400)),
    "signed errors at few steps": RunCase("saw", SAW, PymunkSettings.tuned(SAW, 20)),
    "a cam": RunCase("cam", CAM, PymunkSettings.tuned(CAM, 1000), revolutions=0.5),
    "that fails": RunCase("saw", SAW, PymunkSettings.tuned(SAW, 6)),
}


@pytest.mark.parametrize("name", RUNS)
def test_measurement_does_not_depend_on_pieces(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    case, found = RUNS[name], []
    for steps in (ENDLESS, 7, 333):
        with monkeypatch.context() as patch:
            in_pieces_of(patch, engine_named(case.settings.engine), steps)
            found.append(measure(case))
    assert found[0] == found[1] == found[2]
    if found[0].errors is not None:
        whole = run_in_one_piece(engine_named(case.settings.engine), case.scene, case.settings, case.revolutions)
        expected = {n: {f.name: vars(getattr(e, f.name).size) for f in fields(e)} for n, e in
                    compare(whole, case.scene).points.items()}  # fmt: skip
        assert found[0].errors == expected


@pytest.mark.parametrize(
    ("engine", "scene", "steps"), [("mujoco", SAW, 400), ("pymunk", SAW, 400), ("pymunk", CAM, 1000)]
)
def test_validation_does_not_depend_on_pieces(
    engine: str, scene: Any, steps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = []
    for length in (ENDLESS, 97):
        with monkeypatch.context() as patch:
            in_pieces_of(patch, engine_named(engine), length)
            found.append(
                plain_values(validate_dynamic("a machine", scene, engine_named(engine), "tuned", Plan(steps, 1.0)))
            )
    assert found[0] == found[1]
    assert found[0]["curves"]


def lost(piece: Piece) -> Piece:
    """A piece in which the last sample of every point's position is the one before it."""
    points = {}
    for name, tracks in piece.trajectory.points.items():
        values = tracks.position.values.copy()
        values[-1] = values[-2]
        points[name] = replace(tracks, position=replace(tracks.position, values=values))
    return replace(piece, trajectory=replace(piece.trajectory, points=points))


def test_wrong_sample_at_end_of_piece_is_detected(monkeypatch: pytest.MonkeyPatch) -> None:
    case = RUNS["pymunk"]
    engine = engine_named("pymunk")
    right, run = measure(case), engine.run
    monkeypatch.setattr(
        engine, "run", lambda *asked: (lost(p) if p.first_step == 201 else p for p in run(*asked[:4], 100))
    )
    wrong = measure(case)
    assert wrong.largest("position") > 10.0 * right.largest("position")
    assert wrong.prediction != right.prediction


PEAK = """
import sys
from pathlib import Path
from conrod.engines import engine_named
from conrod.scenes import SCENES
from conrod.execution.run import RunCase
from conrod.execution.result import Plan
from conrod.studies.validation.study import ValidationCase
scene, (kind, engine, steps, turns) = SCENES["saw-500rpm"], sys.argv[1:]
preset = engine_named(engine).presets["tuned"]
if kind == "sweep":
    case = RunCase("saw", scene, preset(scene, int(steps)), float(turns))
else:
    case = ValidationCase("saw", scene, engine, "tuned", Plan(int(steps), float(turns)))
assert case.perform().outcome == "completed"
status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
print(float(status["VmHWM"].split()[0]) / 1024)
"""
HOG = """
import subprocess, sys
ballast = bytearray(b"1") * (300 << 20)
print(subprocess.run(sys.argv[1:], check=True, capture_output=True, text=True).stdout)
"""


def peak(kind: str, engine: str, steps: int, turns: int) -> float:
    """Largest memory [MB] of a process that makes one run: of its own address space (VmHWM), which begins with it.

    `ru_maxrss` does not: a process begins with the largest memory of the one that started it.
    """
    return printed(sys.executable, "-c", PEAK, kind, engine, str(steps), str(turns))


def printed(*command: str) -> float:
    """The number that a command prints."""
    return float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the system does not tell it")
def test_peak_memory_is_measured_in_the_child() -> None:
    alone = printed(sys.executable, "-c", PEAK, "sweep", "pymunk", "100", "1")
    assert printed(sys.executable, "-c", HOG, sys.executable, "-c", PEAK, "sweep", "pymunk", "100", "1") < alone + 20.0


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the system does not tell it")
@pytest.mark.parametrize(
    ("kind", "engine", "steps", "turns"),
    [
        ("sweep", "mujoco", 1000, 1000),
        ("sweep", "pymunk", 500_000, 2),
        ("validate", "mujoco", 500_000, 2),
        ("validate", "pymunk", 1000, 1000),
    ],
)
def test_run_of_a_million_steps_needs_little_memory(kind: str, engine: str, steps: int, turns: int) -> None:
    assert peak(kind, engine, steps, turns) < 150.0  # 1.4 to 1.7 GB as one piece
