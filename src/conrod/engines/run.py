"""Run a machine at constant crank speed, with the engine of its settings, whole or piece by piece."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from conrod.comparison.compare import ComparedPiece
from conrod.comparison.outcome import RunVerdict, judge_outcome
from conrod.comparison.run_errors import Recorder
from conrod.comparison.trajectory import (
    ArrayMapper,
    BodyStates,
    BodyTracks,
    Outcome,
    Piece,
    PointTracks,
    Settings,
    Track,
    Trajectory,
    concatenate_pieces,
)
from conrod.engines import Engine, engine_named
from conrod.engines.engine import STEP_TOLERANCE, Machine, step_length
from conrod.errors import InvalidInput
from conrod.exact.kinematics import ExactReference, Kinematics
from conrod.exact.motion import Array, Instants
from conrod.mechanism.mechanism import Mechanism
from conrod.mechanism.units import check_number

SPAN_TOLERANCE = 1e-9  # [rad], by which rounding may carry a run past the end of the driver's span


def run(machine: Machine, settings: Settings, revolutions: float = 2.0, start_angle: float = 0.0) -> Trajectory:
    """Drive a machine at constant crank speed and sample it at every step.

    Args:
        machine: a scene.
        settings: of the engine to use, from a preset or made by hand.
        revolutions: number of revolutions of the crank.
        start_angle: crank angle [rad] at the start, where the exact state is set.

    Returns:
        The trajectory; how it ended is in its `outcome`, never an exception.

    Raises:
        InvalidInput: settings that the engine would abort on, that have no meaning, or that are for another speed.
    """
    check_run(machine, settings, revolutions, start_angle)
    return run_in_one_piece(engine_named(settings.engine), machine, settings, float(revolutions), float(start_angle))


def run_in_one_piece(
    engine: Engine[Any], machine: Machine, settings: Settings, revolutions: float, start_angle: float = 0.0
) -> Trajectory:
    """Run a machine without checks, and return the whole trajectory."""
    steps = max(round(settings.steps_per_revolution * revolutions), 1)
    return concatenate_pieces(list(engine.run(machine, settings, revolutions, start_angle, steps))).trajectory


def run_with_recorders(
    engine: Engine[Any],
    machine: ExactReference,
    settings: Settings,
    revolutions: float,
    start_angle: float,
    *recorders: Recorder,
    on_piece: Callable[[Trajectory], None] = lambda _: None,
) -> RunVerdict:
    """Run a machine without checks, feed recorders piece by piece, and return how the run ended.

    Memory grows with the run only by what recorders keep.

    Args:
        on_piece: called with the trajectory of every piece, also after the run has failed; recorders get none then.
    """
    pieces = engine.run(machine, settings, revolutions, start_angle)
    return feed_recorders(
        pieces, round(settings.steps_per_revolution * revolutions) + 1, machine, *recorders, on_piece=on_piece
    )


def feed_recorders(
    pieces: Iterable[Piece],
    samples: int,
    machine: ExactReference,
    *recorders: Recorder,
    on_piece: Callable[[Trajectory], None] = lambda _: None,
) -> RunVerdict:
    """Feed the pieces of a run of `samples` samples to recorders, and return how the run ended."""
    for piece in pieces:
        found = piece.trajectory
        left = samples - piece.first_step - len(piece.clock)
        on_piece(found)
        if found.outcome is Outcome.COMPLETED:
            compared = ComparedPiece(found, machine, max(0, left))
            for recorder in recorders:
                recorder.add(compared)
    if found.outcome is Outcome.COMPLETED and left > 0:
        return RunVerdict(Outcome.CRASHED, f"the run ended after {samples - left} of {samples} samples")
    return RunVerdict(found.outcome, found.reason)


def check_run(machine: Machine, settings: Settings, revolutions: float, start_angle: float) -> None:
    """Refuse what `run` refuses, without loading the engine.

    Raises:
        InvalidInput: a number out of its range, or settings for another speed.
    """
    check_number("revolutions", revolutions, 1e-3, 1e6)
    check_number("start_angle", start_angle, -1e6, 1e6, "rad")
    span = machine.kinematics.mechanism.driver.span
    if span is not None:
        _check_span(machine, span, revolutions, start_angle)
    step = step_length(machine, settings.steps_per_revolution)
    # Settings made for another speed or step would put every sample at a wrong angle.
    if abs(settings.timestep / step - 1.0) > STEP_TOLERANCE:
        raise InvalidInput(
            f"timestep = {settings.timestep:g} s does not fit: {settings.steps_per_revolution} steps a revolution at "
            f"{machine.speed:g} rad/s are {step:g} s each"
        )


def _check_span(machine: Machine, span: tuple[float, float], revolutions: float, start_angle: float) -> None:
    """Refuse a run that leaves the driver's span of an input that cannot turn fully."""
    stop_angle = start_angle + math.copysign(2.0 * math.pi * revolutions, machine.speed)
    if not all(span[0] - SPAN_TOLERANCE <= angle <= span[1] + SPAN_TOLERANCE for angle in (start_angle, stop_angle)):
        start, turns = span[0] if machine.speed > 0.0 else span[1], (span[1] - span[0]) / (2.0 * math.pi)
        raise InvalidInput(
            f"start_angle = {start_angle:.9g} rad, revolutions = {revolutions:.9g}: the run leaves the one pass that "
            f"the input makes; it starts at {start:.9g} rad and takes {turns:.9g} revolutions"
        )


# -- what an engine records --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class RecordedPiece:
    """Tracks of consecutive samples of a run; the last samples of the piece before may come first.

    Attributes:
        clock: the engine's clock at the samples of this piece [s]; None if it has no clock.
        finish_verdict: returns the verdict on the run so far, given the verdict on its motion alone; engines with
            warnings of their own add these.
    """

    bodies: BodyTracks
    points: Mapping[str, PointTracks]
    clock: Array | None = None
    warnings: Mapping[str, int] = field(default_factory=dict)
    drive_torque: Array | None = None
    finish_verdict: Callable[[RunVerdict], RunVerdict] = lambda judged: judged


def record_pieces(
    machine: Machine,
    settings: Settings,
    version: str,
    revolutions: float,
    start_angle: float,
    steps: int,
    record: Callable[[int, Array], RecordedPiece],
    preceding: int = 0,
) -> Iterator[Piece]:
    """Record a run in pieces of `steps` steps; the first piece has the start sample too.

    Args:
        version: version of the engine.
        record: advances the engine to the last of T samples and returns their tracks; its arguments are the number in
            the run of the first sample and the nominal times (T,) [s].
        preceding: number of samples of the piece before that come first again, at most.
    """
    begun, samples = start_angle / machine.speed, round(settings.steps_per_revolution * revolutions) + 1
    clock, judged = begun, RunVerdict(Outcome.COMPLETED)
    for first in (0, *range(steps + 1, samples, steps)):
        last = min(max(first, 1) + steps, samples)
        # From the step index: a clock that sums its steps drifts.
        known = max(0, first - preceding)
        times = np.asarray(begun + settings.timestep * np.arange(known, last), dtype=float)
        # A state that is not finite any more stays so; how the run ended is judged from it.
        with np.errstate(all="ignore"):
            found = record(known, times)
            new = _keep_last(last - first)
            bodies, points = new(found.bodies), {name: new(tracks) for name, tracks in found.points.items()}
            judged = judge_outcome(machine.kinematics, bodies, machine.speed, judged)
        verdict = found.finish_verdict(judged)
        ticks = found.clock
        if ticks is None:
            # The clock that a user keeps of an engine that has none: step by step, with its rounding.
            ticks = np.full(last - first + (first > 0), settings.timestep)
            ticks[0] = clock
            ticks = np.add.accumulate(ticks)[first - last :]
        clock = float(ticks[-1])
        trajectory = Trajectory(
            settings.engine, version, settings, machine.speed, revolutions,
            verdict.outcome, verdict.reason, points, bodies,
        )  # fmt: skip
        yield Piece(trajectory, first, ticks, found.warnings, found.drive_torque)


def _keep_last(samples: int) -> ArrayMapper:
    """Return a mapper of dataclasses that keeps the last samples of each array."""
    return ArrayMapper(lambda parts: parts[0][-samples:])


def stamped_states(mechanism: Mechanism, times: Array, poses: Array, rates: Array, accelerations: Array) -> BodyStates:
    """States of all bodies (T, 3 n) with their times (T,) [s] and the crank motion that the engine reached."""
    driver, k = mechanism.driver, 3 * mechanism.body_index[mechanism.crank] + 2
    turn, rate, acceleration = poses[:, k] - driver.start, rates[:, k], accelerations[:, k]
    at = Instants(times, driver.sense * turn, driver.sense * rate, driver.sense * acceleration)
    return BodyStates(at, poses, rates, accelerations)


def observed_tracks(kinematics: Kinematics, states: BodyStates) -> dict[str, PointTracks]:
    """Motion of the observed points, for body states whose poses, rates and accelerations share one instant."""
    motion = kinematics.point_derivatives([states.poses, states.rates, states.accelerations])
    return {name: PointTracks(*(Track(states.instants, values) for values in of)) for name, of in motion.items()}
