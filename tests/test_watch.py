"""A watched run: the errors of a measured one, and all that shows how an engine fails, whatever its pieces."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from catalogue import CAM, PRESS, SAW, VARIATIONS
from conrod import InvalidInput, MuJoCoSettings, Outcome, PymunkSettings
from conrod.engines import ENGINES, engine_named
from conrod.engines.left_out_rod import DISTANCE_JOINT
from conrod.motion import Array
from conrod.reactions import reactions
from conrod.scenes import SCENES, CamFollower
from conrod.studies.cell import Cell
from conrod.studies.limits import watch as watching
from conrod.studies.limits.cell import LimitCell
from conrod.studies.limits.exact_torque import ExactTorque
from conrod.studies.limits.extremes import Extremes, Flight
from conrod.studies.limits.flights import KEPT, LEAST_DEPTH, TIMES, Flights
from conrod.studies.limits.history import History, marked
from conrod.studies.limits.watch import watch
from conrod.studies.measurement import Measurement, measure
from conrod.trajectory import Piece

TURN = 2.0 * math.pi
LINKAGE_STEPS, CONTACT_STEPS = 100, 500


def cell(scene: Any, settings: Any, revolutions: float = 2.0, start_angle: float = 0.0) -> LimitCell:
    return LimitCell("a machine", scene, settings, revolutions, start_angle)


@cache
def watched(scene: Any, settings: Any, revolutions: float = 2.0) -> Measurement:
    return watch(cell(scene, settings, revolutions))


def extremes(measurement: Measurement) -> Extremes:
    found = Extremes.of(measurement)
    assert found is not None
    return found


def every_preset() -> Iterator[Any]:
    for name in ("shear-press", "saw-40rpm", "cam-follower"):
        for engine, preset in ((e, p) for e in ENGINES for p in engine_named(e).presets):
            yield pytest.param(name, engine, preset, id=f"{name}, {engine} {preset}")


def coarse_cam(settings: Any) -> Any:
    """A cam of few facets is made sooner."""
    return replace(settings, cam_vertices=400)


def in_pieces_of(monkeypatch: pytest.MonkeyPatch, steps: int) -> None:
    monkeypatch.setattr(watching, "piece_length", lambda cell: steps)


# -- errors ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "engine", "preset"), list(every_preset()))
def test_the_errors_are_those_of_a_measured_run(name: str, engine: str, preset: str) -> None:
    scene: Any = SCENES[name]
    steps = CONTACT_STEPS if scene is CAM else LINKAGE_STEPS
    settings = coarse_cam(engine_named(engine).presets[preset](scene, steps))
    told, measured = watched(scene, settings), measure(Cell(name, scene, settings))
    assert told.outcome == measured.outcome
    if measured.outcome == Outcome.UNSUPPORTED.slug:
        assert told.extremes is None
        return
    assert measured.outcome == Outcome.COMPLETED.slug
    assert told.errors is not None
    assert told.errors.keys() == measured.errors.keys()
    assert flat(told) == pytest.approx(flat(measured), rel=1e-12)
    assert extremes(told).samples == 2 * steps + 1
    assert extremes(told).finite


def flat(measurement: Measurement) -> dict[str, float]:
    found: dict[str, float] = {}

    def put(name: str, values: Mapping[str, Any]) -> None:
        for key, value in values.items():
            put(f"{name} {key}", value) if isinstance(value, Mapping) else found.update({f"{name} {key}": value})

    for part in ("errors", "closure", "phase", "drive"):
        put(part, getattr(measurement, part))
    return found


def test_an_error_in_one_sample_of_one_piece_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    settings = PymunkSettings.tuned(SAW, LINKAGE_STEPS)
    unharmed = watched(SAW, settings).largest("position")
    assert unharmed is not None
    planted_in(monkeypatch, "pymunk", 7, lambda piece: moved(piece, 0.01))
    largest = watch(cell(SAW, settings)).largest("position")
    assert largest is not None
    assert largest > 0.9 * 0.01 / SAW.lengths["C"]
    assert largest > 10.0 * unharmed


def planted_in(monkeypatch: pytest.MonkeyPatch, engine: str, number: int, defect: Callable[[Piece], Piece]) -> None:
    """A defect in one piece of every run of an engine."""
    pieces = engine_named(engine).pieces

    def planted(*args: Any) -> Iterator[Piece]:
        for k, piece in enumerate(pieces(*args)):
            yield defect(piece) if k == number else piece

    monkeypatch.setattr(engine_named(engine), "pieces", planted)


def moved(piece: Piece, distance: float) -> Piece:
    """With the last position of point C moved."""
    tracks = piece.trajectory.points["C"]
    values = tracks.position.values.copy()
    values[-1, 0] += distance
    position = replace(tracks.position, values=values)
    points = {**piece.trajectory.points, "C": replace(tracks, position=position)}
    return replace(piece, trajectory=replace(piece.trajectory, points=points))


# -- how it ends -----------------------------------------------------------------------------------------------------


def ended(outcome: Outcome) -> Callable[[Piece], Piece]:
    return lambda piece: replace(piece, trajectory=replace(piece.trajectory, outcome=outcome, reason=outcome.slug))


def test_a_run_ends_where_nothing_is_left_of_the_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    planted_in(monkeypatch, "pymunk", 5, ended(Outcome.DIVERGED))
    failed = watch(cell(SAW, PymunkSettings.tuned(SAW, 400)))
    assert (failed.outcome, failed.reason, failed.errors) == ("diverged", "diverged", None)
    assert extremes(failed).samples == 6 * 20 + 1


def test_a_machine_that_came_apart_is_followed_for_two_revolutions_and_may_blow_up(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    settings = PymunkSettings.tuned(SAW, 40)
    planted_in(monkeypatch, "pymunk", 1, ended(Outcome.OPENED))
    opened = watch(cell(SAW, settings, 10.0))
    assert (opened.outcome, opened.errors) == ("opened", None)
    assert extremes(opened).samples == pytest.approx(2 * 40, abs=40)
    planted_in(monkeypatch, "pymunk", 3, ended(Outcome.EXPLODED))
    assert watch(cell(SAW, settings, 10.0)).outcome == "exploded"


@pytest.mark.parametrize(
    ("engine", "preset", "steps"), [("mujoco", "tuned", 4), ("mujoco", "stock", 6), ("pymunk", "tuned", 6)]
)
def test_a_run_ends_as_the_whole_of_it_is_judged(
    engine: str, preset: str, steps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    saw: Any = SCENES["saw-500rpm"]
    settings = engine_named(engine).presets[preset](saw, steps)
    whole = engine_named(engine).run(saw, settings, 2.0).outcome
    assert whole is not Outcome.COMPLETED
    for length in (3, 5, 1000):
        in_pieces_of(monkeypatch, length)
        assert watch(cell(saw, settings)).outcome == whole.slug


def test_numbers_that_are_not_finite_and_warnings_are_told() -> None:
    saw: Any = SCENES["saw-500rpm"]
    failed = watched(saw, MuJoCoSettings.tuned(saw, 4), 10.0)
    assert failed.outcome == "exploded"
    assert extremes(failed).warnings == {"BADQACC": 1}
    assert extremes(watched(SAW, MuJoCoSettings.tuned(SAW, 100))).warnings == {}


def test_infinity_in_a_last_sample_is_not_finite(monkeypatch: pytest.MonkeyPatch) -> None:
    planted_in(monkeypatch, "pymunk", 0, lambda piece: ended(Outcome.DIVERGED)(moved(piece, math.inf)))
    assert not extremes(watch(cell(SAW, PymunkSettings.tuned(SAW, LINKAGE_STEPS)))).finite


def test_what_cannot_be_run_is_said_in_one_line() -> None:
    settings = PymunkSettings.tuned(SAW, 4)
    with pytest.raises(InvalidInput, match="a run needs 3 to have accelerations"):
        watch(cell(SAW, settings, 0.5))
    with pytest.raises(InvalidInput, match="does not fit"):
        watch(cell(SCENES["saw-500rpm"], settings))
    refused = watch(cell(CAM, MuJoCoSettings.hardened(CAM, 100)))
    assert (refused.outcome, refused.extremes) == ("unsupported", None)


@pytest.mark.parametrize("steps", [3, 4, 100, 101, 102, 103])
def test_the_last_piece_may_be_as_short_as_it_is(steps: int, monkeypatch: pytest.MonkeyPatch) -> None:
    settings = PymunkSettings.tuned(SAW, LINKAGE_STEPS)
    usual = flat(watched(SAW, settings))
    in_pieces_of(monkeypatch, steps)
    assert flat(watch(cell(SAW, settings))) == pytest.approx(usual, rel=1e-12)


# -- the last bit ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("settings", [MuJoCoSettings.tuned(SAW, 100), PymunkSettings.tuned(SAW, 100)])
def test_the_fingerprint_depends_on_every_bit_and_on_no_pieces(settings: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    known = extremes(watched(SAW, settings)).fingerprint
    planted_in(monkeypatch, settings.engine, 0, lambda piece: piece)
    for steps in (7, 64, 1000):
        in_pieces_of(monkeypatch, steps)
        assert extremes(watch(cell(SAW, settings))).fingerprint == known
    planted_in(monkeypatch, settings.engine, 0, lambda piece: moved(piece, 1e-16))
    assert extremes(watch(cell(SAW, settings))).fingerprint != known


# -- the solver ------------------------------------------------------------------------------------------------------


def test_a_solver_that_stopped_before_it_began_has_a_residual() -> None:
    tuned = MuJoCoSettings.tuned(SAW, 200)
    done, trapped = (extremes(watched(SAW, s)).solver for s in (tuned, replace(tuned, tolerance=1e-8)))
    assert done is not None
    assert trapped is not None
    assert (done.looked_at, done.allowed, trapped.looked_at) == (40, tuned.iterations, 40)
    assert done.least is not None
    assert done.least > 0
    assert trapped.most == 0
    assert done.residual is not None
    assert trapped.residual is not None
    assert done.residual < 1e-12
    assert trapped.residual > 1e-6


def test_an_iteration_cut_short_has_a_residual() -> None:
    tuned = PymunkSettings.tuned(SAW, 200)
    done, short = (extremes(watched(SAW, s)).solver for s in (tuned, replace(tuned, iterations=3)))
    assert done is not None
    assert short is not None
    assert (short.allowed, short.least, short.most) == (3, 3, 3)
    assert done.residual is not None
    assert short.residual is not None
    assert done.residual < 1e-11
    assert short.residual > 1e-4


def test_residuals_are_normalised_by_what_they_are() -> None:
    """The same machine in another unit, and ten times as fast, leaves the same."""
    from conrod.studies.limits.solver_look import SolverLook
    from conrod.trajectory import SolverState

    for of_rates, residual in ((True, 6.0), (False, 12.0)):
        look = SolverLook(10, -2.0, 3.0)
        look.add(None)
        assert look.found() is None
        look.add(SolverState(None, residual, of_rates))
        look.add(SolverState(4, math.nan, of_rates))
        found = look.found()
        assert found is not None
        assert (found.looked_at, found.least, found.most, found.residual) == (2, 4, 4, 1.0)


# -- drive torque ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scene", [SAW, PRESS, VARIATIONS["saw-reversed"]], ids=["saw", "press", "saw reversed"])
def test_the_exact_torque_is_the_drivers_reaction(scene: Any) -> None:
    exact = ExactTorque(scene.kinematics, scene.speed, gravity=True, rod="body")
    angle = np.linspace(0.0, TURN, 720)
    told = scene.kinematics.mechanism.driver.sense * reactions(scene.kinematics, angle, scene.speed).drive_torque
    np.testing.assert_allclose(exact.at(angle), told, atol=1e-12 * exact.peak)
    assert exact.peak == pytest.approx(np.abs(told).max(), rel=1e-3)
    light = ExactTorque(scene.kinematics, scene.speed, gravity=False, rod="body")
    assert np.abs(light.at(angle) - told).max() > 1e-3 * exact.peak


@pytest.mark.parametrize("gravity", [True, False])
@pytest.mark.parametrize("scene", [SCENES["saw-500rpm"], PRESS], ids=["saw", "press"])
def test_a_hardened_drive_gives_the_exact_torque(scene: Any, gravity: bool) -> None:
    hardened = replace(MuJoCoSettings.hardened(scene, 400), gravity=gravity)
    error = extremes(watched(scene, hardened)).torque
    assert error is not None
    assert error < 1e-6
    soft = extremes(watched(scene, replace(hardened, hardening=None))).torque
    assert soft is not None
    assert soft > 20.0 * error


def test_the_mass_of_a_rod_that_is_left_out_is_not_in_the_exact_torque() -> None:
    saw: Any = SCENES["saw-500rpm"]
    angle = np.linspace(0.0, TURN, 100)
    without = ExactTorque(saw.kinematics, saw.speed, gravity=True, rod=DISTANCE_JOINT)
    light = saw.with_parameters(rod_mass=1e-6, rod_inertia=1e-8)
    told = ExactTorque(light.kinematics, saw.speed, gravity=True, rod="body").at(angle)
    np.testing.assert_allclose(without.at(angle), told, atol=1e-5 * without.peak)
    whole = ExactTorque(saw.kinematics, saw.speed, gravity=True, rod="body").at(angle)
    assert np.abs(whole - told).max() > 0.01 * without.peak


def test_what_no_engine_tells_is_none() -> None:
    assert extremes(watched(SAW, PymunkSettings.tuned(SAW, LINKAGE_STEPS))).torque is None
    assert extremes(watched(CAM, coarse_cam(MuJoCoSettings.tuned(CAM, CONTACT_STEPS)))).torque is None


def test_a_torque_that_is_off_by_a_part_in_a_billion_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    scene: Any = PRESS
    exact = ExactTorque(scene.kinematics, scene.speed, gravity=True, rod="body")
    pieces = engine_named("pymunk").pieces

    def told(*args: Any) -> Iterator[Piece]:
        for piece in pieces(*args):
            bodies = piece.trajectory.bodies
            assert bodies is not None
            torque = exact.at(bodies.acceleration.instants.angle)
            torque[-1] += off * exact.peak
            yield replace(piece, drive_torque=torque)

    monkeypatch.setattr(engine_named("pymunk"), "pieces", told)
    for off in (0.0, 1e-9, -1e-9):
        error = extremes(watch(cell(PRESS, PymunkSettings.tuned(PRESS, LINKAGE_STEPS)))).torque
        assert error == pytest.approx(abs(off), abs=1e-15)


# -- history ---------------------------------------------------------------------------------------------------------


def test_the_marks_are_1_2_5_and_the_last_revolution() -> None:
    assert marked(2.0) == ()
    assert marked(2.5) == (1, 2)
    assert marked(5.0) == (1, 2, 5)
    assert marked(37.9) == (1, 2, 5, 10, 20, 37)
    assert marked(1e6)[-4:] == (100_000, 200_000, 500_000, 1_000_000)


@pytest.mark.parametrize("length", [1, 3, 10, 17, 1000])
def test_samples_belong_to_their_mark_wherever_a_run_is_cut(length: int) -> None:
    steps, revolutions = 10, 12.5
    index = np.arange(126.0)
    history = History(revolutions, steps)
    for begin in range(0, len(index), length):
        part = index[begin : begin + length]
        history.add(begin, part, 1000.0 - part, -part, 2.0 * part)
    assert [mark.revolution for mark in history.marks] == [1, 2, 5, 10, 12]
    assert [mark.position for mark in history.marks] == [10.0, 20.0, 50.0, 100.0, 120.0]
    assert [mark.closure for mark in history.marks] == [1000.0, 989.0, 979.0, 949.0, 899.0]
    assert [mark.phase for mark in history.marks] == [-10.0, -20.0, -50.0, -100.0, -120.0]
    assert [mark.clock for mark in history.marks] == [20.0, 40.0, 100.0, 200.0, 240.0]


@pytest.mark.parametrize("settings", [MuJoCoSettings.tuned(SAW, 50), PymunkSettings.tuned(SAW, 50)])
def test_a_long_run_keeps_its_loops_closed_and_its_clock_drifts(settings: Any) -> None:
    history = extremes(watched(SAW, settings, 100.0)).history
    assert [mark.revolution for mark in history] == [1, 2, 5, 10, 20, 50, 100]
    later = [mark.closure for mark in history[1:]]
    assert max(later) < 1.001 * min(later)
    assert abs(history[-1].clock) == pytest.approx(clock_drift(settings, 100), rel=1e-6)
    assert abs(history[-1].phase) < 1e-8
    if settings.engine == "pymunk":
        assert abs(history[-1].phase) < 0.1 * abs(history[-1].clock), "its crank is written by counted steps"


def clock_drift(settings: Any, revolutions: int) -> float:
    """Of a loop that sums its steps [rad]."""
    time = 0.0
    for _ in range(50 * revolutions):
        time += settings.timestep
    return abs(SAW.speed * (time - 50 * revolutions * settings.timestep))


def test_a_short_run_has_no_history() -> None:
    assert extremes(watched(SAW, PymunkSettings.tuned(SAW, LINKAGE_STEPS))).history == ()


# -- flights ---------------------------------------------------------------------------------------------------------

STEP = 1e-3  # [rad]
HELD = 500
DEPTH = 1e-6  # [m], of the synthetic follower


def gaps(*flights: Flight) -> tuple[Array, Array]:
    """A follower that sinks in by a depth, but for parabolic flights."""
    angle = STEP * np.arange(6001)
    gap = np.full_like(angle, -DEPTH)
    for flight in flights:
        across = (angle - flight.start) / (flight.landing - flight.start)
        gap = np.maximum(gap, 4.0 * flight.gap * across * (1.0 - across))
    return angle, gap


def followed(angle: Array, gap: Array, length: int, travel: float = 1.0) -> Flights:
    flights = Flights(HELD, travel)
    for begin in range(0, len(angle), length):
        flights.add(angle[begin : begin + length], gap[begin : begin + length])
    return flights


@pytest.mark.parametrize("length", [1, 7, 499, 10_000])
def test_flights_are_found_across_the_borders_of_pieces(length: int) -> None:
    planted = Flight(1.5, 3.0, 0.01), Flight(4.0, 4.2, 1e-3)
    flights = followed(*gaps(*planted), length)
    assert flights.penetration == DEPTH
    found = flights.found()
    assert len(found) == 2
    for flight, exact in zip(found, planted, strict=True):
        # A parabola passes the threshold a little later than it leaves the ground.
        late = TIMES * DEPTH / (4.0 * exact.gap) * (exact.landing - exact.start)
        assert flight.start == pytest.approx(exact.start + late, abs=0.1 * late + 1e-5)
        assert flight.landing == pytest.approx(exact.landing - late, abs=0.1 * late + 1e-5)
        assert flight.gap == pytest.approx(exact.gap, rel=1e-4)
    assert found == followed(*gaps(*planted), 100).found()


def test_a_hop_below_ten_depths_is_no_flight() -> None:
    hop = gaps(Flight(2.0, 2.1, 0.9 * TIMES * DEPTH))
    assert followed(*hop, 100).found() == ()
    leap = gaps(Flight(2.0, 2.1, 1.1 * TIMES * DEPTH))
    assert len(followed(*leap, 100).found()) == 1


def test_without_a_depth_the_travel_sets_the_threshold() -> None:
    angle, gap = gaps(Flight(2.0, 2.1, 1e-3))
    held = np.where(gap < 0.0, 0.0, gap)
    flights = followed(angle, held, 100)
    assert flights.penetration == 0.0
    assert flights.threshold == TIMES * LEAST_DEPTH
    assert len(flights.found()) == 1
    assert followed(angle, held, 100, travel=2e3).found() == ()


def test_a_flight_at_the_start_and_one_at_the_end_are_flights() -> None:
    angle, gap = gaps(Flight(-0.5, 0.2, 0.01), Flight(5.5, 7.0, 0.01))
    last, first = followed(angle, gap, 100).found()
    assert (first.start, last.landing) == (angle[0], angle[-1])
    assert first.landing == pytest.approx(0.2, abs=1e-3)
    assert last.start == pytest.approx(5.5, abs=1e-3)


def test_the_longest_are_kept_and_the_longest_comes_first() -> None:
    planted = [Flight(0.6 + 0.04 * k, 0.6 + 0.04 * k + 0.002 * (k % 15 + 2), 1e-3) for k in range(130)]
    angle, gap = gaps(*planted)
    found = followed(angle, gap, 100).found()
    lengths = [flight.landing - flight.start for flight in found]
    assert len(found) == KEPT
    assert lengths == sorted(lengths, reverse=True)
    assert min(lengths) > 0.028


@pytest.mark.parametrize("settings", [MuJoCoSettings.tuned, PymunkSettings.tuned], ids=["mujoco", "pymunk"])
def test_a_follower_that_lost_its_cam_is_followed_until_it_lands(settings: Any) -> None:
    cam: Any = CamFollower(preload=0.3)
    lost = watched(cam, coarse_cam(settings(cam, 1000)), 1.0)
    assert (lost.outcome, lost.errors) == ("lost-contact", None)
    seen = extremes(lost)
    assert seen.samples == 1001
    assert seen.penetration is not None
    assert 0.0 < seen.penetration < 1e-3
    flight = seen.flights[0]
    assert flight.landing - flight.start > 1.5
    assert 0.04 < flight.gap < 0.06
    held = extremes(watched(CAM, coarse_cam(settings(CAM, 1000)), 1.0))
    assert held.flights == ()


def test_a_linkage_has_no_follower() -> None:
    seen = extremes(watched(SAW, PymunkSettings.tuned(SAW, LINKAGE_STEPS)))
    assert (seen.penetration, seen.flights) == (None, ())


# -- kept ------------------------------------------------------------------------------------------------------------


def test_what_was_watched_survives_the_ledger() -> None:
    import json

    cam: Any = CamFollower(preload=0.3)
    for measurement in (
        watched(cam, coarse_cam(PymunkSettings.tuned(cam, 1000)), 1.0),
        watched(SAW, MuJoCoSettings.tuned(SAW, 50), 100.0),
    ):
        text = json.dumps(measurement.as_dict(), allow_nan=False)
        assert extremes(Measurement.of(json.loads(text))) == extremes(measurement)
