"""A watched run: the errors of a measured one, how it ends and its last bit, whatever its pieces."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from catalogue import CAM, PRESS, SAW

from conrod import MuJoCoSettings, Outcome, PymunkSettings
from conrod.comparison.trajectory import Piece
from conrod.engines import ENGINES, engine_named
from conrod.engines.run import run_in_one_piece
from conrod.exact.dynamics.inverse import steady_joint_forces
from conrod.execution.run import RunCase, measure
from conrod.scenes import SCENES
from conrod.studies.limits import stream_run as watching
from conrod.studies.limits.case import LimitCase
from conrod.studies.limits.recorders import ExactTorque
from conrod.studies.limits.records import LimitResult
from conrod.studies.limits.stream_run import piece_length, stream_run

LINKAGE_STEPS, CONTACT_STEPS = 100, 500


def watched(scene: Any, settings: Any, revolutions: float = 2.0) -> LimitResult:
    return stream_run(LimitCase("a machine", scene, settings, revolutions))


def planted_in(monkeypatch: pytest.MonkeyPatch, engine: str, defect: Callable[[int, Piece], Piece]) -> None:
    """A defect in the pieces of every run of an engine, by their numbers."""
    pieces = engine_named(engine).run
    monkeypatch.setattr(engine_named(engine), "run", lambda *run: (defect(*one) for one in enumerate(pieces(*run))))


EVERY_PRESET = [(engine, preset) for engine in ENGINES for preset in engine_named(engine).presets]


@pytest.mark.parametrize("name", ["shear-press", "saw-40rpm", "cam-follower"])
@pytest.mark.parametrize(("engine", "preset"), EVERY_PRESET)
def test_the_errors_are_those_of_a_measured_run(name: str, engine: str, preset: str) -> None:
    scene: Any = SCENES[name]
    steps = CONTACT_STEPS if scene is CAM else LINKAGE_STEPS
    # A cam of few facets is made sooner.
    settings = replace(engine_named(engine).presets[preset](scene, steps), cam_vertices=400)
    told, measured = watched(scene, settings), measure(RunCase(name, scene, settings))
    assert told.outcome == measured.outcome
    if measured.outcome == Outcome.UNSUPPORTED.slug:
        assert told == LimitResult(told.outcome, told.reason)
        return
    assert measured.outcome == Outcome.COMPLETED.slug
    assert told.errors is not None
    for part in ("errors", "closure", "phase", "drive"):
        assert getattr(told, part) == getattr(measured, part)
    assert told.samples == 2 * steps + 1
    assert told.finite


def ended(outcome: Outcome, first: int) -> Callable[[int, Piece], Piece]:
    """Judged so from a piece on."""
    judged = {"outcome": outcome, "reason": outcome.slug}
    return lambda k, piece: piece if k < first else replace(piece, trajectory=replace(piece.trajectory, **judged))


def test_run_ends_when_exploded_or_two_turns_after_opening(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    planted = LimitCase("a machine", SAW, PymunkSettings.tuned(SAW, LINKAGE_STEPS), 10.0)
    planted_in(monkeypatch, "pymunk", ended(Outcome.OPENED, 1))
    opened = stream_run(planted)
    assert (opened.outcome, opened.errors) == ("opened", None)
    assert 200 <= opened.samples <= 200 + 3 * piece_length(planted)
    planted_in(monkeypatch, "pymunk", ended(Outcome.EXPLODED, 3))
    failed = stream_run(planted)
    assert (failed.outcome, failed.reason, failed.errors) == ("exploded", "exploded", None)
    assert failed.samples == 4 * piece_length(planted) + 1


@pytest.mark.parametrize(
    ("engine", "preset", "steps"), [("mujoco", "tuned", 4), ("mujoco", "stock", 6), ("pymunk", "tuned", 6)]
)
def test_a_run_ends_as_the_whole_of_it_is_judged(
    engine: str, preset: str, steps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    saw: Any = SCENES["saw-500rpm"]
    settings = engine_named(engine).presets[preset](saw, steps)
    whole = run_in_one_piece(engine_named(engine), saw, settings, 2.0)
    assert whole.outcome is not Outcome.COMPLETED
    for length in (3, 5, 1000):
        monkeypatch.setattr(watching, "piece_length", lambda _, length=length: length)
        assert watched(saw, settings).outcome == whole.outcome.slug
        # Where and how far, too: a gap of a later piece may be larger than that of the first one which shows it.
        *_, last = engine_named(engine).run(saw, settings, 2.0, 0.0, length)
        assert (last.trajectory.outcome, last.trajectory.reason) == (whole.outcome, whole.reason)


def test_warnings_are_told() -> None:
    saw: Any = SCENES["saw-500rpm"]
    failed = watched(saw, MuJoCoSettings.tuned(saw, 4), 10.0)
    assert failed.outcome == "exploded"
    assert failed.warnings == {"BADQACC": 1}
    assert watched(SAW, MuJoCoSettings.tuned(SAW, 100)).warnings == {}


def last_bit_moved(k: int, piece: Piece) -> Piece:
    """The first piece with its last position of point C moved by 1e-16."""
    if k > 0:
        return piece
    tracks = piece.trajectory.points["C"]
    values = tracks.position.values.copy()
    values[-1, 0] += 1e-16
    points = piece.trajectory.points | {"C": replace(tracks, position=replace(tracks.position, values=values))}
    return replace(piece, trajectory=replace(piece.trajectory, points=points))


@pytest.mark.parametrize("settings", [MuJoCoSettings.tuned(SAW, 100), PymunkSettings.tuned(SAW, 100)])
def test_the_fingerprint_depends_on_every_bit_and_on_no_pieces(settings: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    known = watched(SAW, settings).fingerprint
    for steps in (7, 64, 1000):
        monkeypatch.setattr(watching, "piece_length", lambda _, steps=steps: steps)
        assert watched(SAW, settings).fingerprint == known
    planted_in(monkeypatch, settings.engine, last_bit_moved)
    assert watched(SAW, settings).fingerprint != known


@pytest.mark.parametrize("gravity", [True, False])
@pytest.mark.parametrize("name", ["saw-500rpm", "shear-press"])
def test_hardened_drive_gives_exact_torque_as_drivers_reaction(name: str, gravity: bool) -> None:
    scene: Any = SCENES[name]
    exact, angle = ExactTorque(scene.kinematics, scene.speed, gravity=gravity), np.linspace(0.0, 2.0 * math.pi, 720)
    told = steady_joint_forces(scene.kinematics, angle, scene.speed).drive_torque
    assert exact.peak == pytest.approx(np.abs(exact.evaluate(angle)).max(), rel=1e-3)
    assert bool(np.abs(exact.evaluate(angle) - told).max() < 1e-12 * exact.peak) is gravity
    hardened = replace(MuJoCoSettings.hardened(scene, 400), gravity=gravity)
    error, soft = (watched(scene, one).torque for one in (hardened, replace(hardened, hardening=None)))
    assert error < min(1e-6, 0.05 * soft)


def test_a_torque_that_is_off_by_a_part_in_a_billion_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    scene: Any = PRESS
    exact = ExactTorque(scene.kinematics, scene.speed, gravity=True)

    def told(_: int, piece: Piece) -> Piece:
        torque = exact.evaluate(piece.trajectory.bodies.acceleration.instants.angle)
        torque[-1] += off * exact.peak
        return replace(piece, drive_torque=torque)

    planted_in(monkeypatch, "pymunk", told)
    for off in (0.0, 1e-9, -1e-9):
        error = watched(PRESS, PymunkSettings.tuned(PRESS, LINKAGE_STEPS)).torque
        assert error == pytest.approx(abs(off), abs=1e-15)
