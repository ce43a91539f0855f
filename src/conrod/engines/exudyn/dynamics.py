"""Dynamic mode: Exudyn steps, conrod records. Nothing is written into the engine after the start."""

from __future__ import annotations

from collections.abc import Iterator

import exudyn
import numpy as np

from conrod.engines.engine import PIECE, Machine
from conrod.engines.exudyn.settings import ExudynSettings
from conrod.engines.exudyn.stepping import BLOCK, Stepper
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism
from conrod.runs.outcome import Verdict, judge
from conrod.runs.trajectory import BodyStates, BodyTracks, Instants, Outcome, Piece, PointTracks, Track, Trajectory


def run(
    machine: Machine, settings: ExudynSettings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE
) -> Iterator[Piece]:
    """A run at constant crank speed in pieces of so many steps; the first one has the start beside its steps."""
    kinematics, begun = machine.kinematics, start_angle / machine.speed
    whole = round(settings.steps_per_revolution * revolutions)
    stepper = Stepper(machine, settings, start_angle)
    blocks, verdict = states_of(stepper, whole), Verdict(Outcome.COMPLETED)
    known = next(blocks)
    for first in (0, *range(steps + 1, whole + 1, steps)):
        last = min(max(first, 1) + steps, whole + 1)
        while len(known) < last - first:
            known = np.concatenate([known, next(blocks)])
        states, known = known[: last - first], known[last - first :]
        clock = settings.timestep * np.arange(first, last, dtype=float)  # Exudyn too has it from the step index
        at = instants_of(kinematics.mechanism, begun + clock, states)
        bodies = BodyStates(at, *states.swapaxes(0, 1))
        # A state that is not finite any more stays so; how the run ended is judged from it.
        with np.errstate(all="ignore"):
            motion = kinematics.point_derivatives([bodies.poses, bodies.rates, bodies.accelerations])
            tracks = BodyTracks(bodies, bodies, bodies)
            verdict = judge(kinematics, tracks, machine.speed, verdict)
        failed = verdict.outcome is Outcome.DIVERGED and stepper.failure
        reason = f"{stepper.failure}; {verdict.reason}" if failed else verdict.reason
        points = {name: PointTracks(*(Track(at, values) for values in of)) for name, of in motion.items()}
        trajectory = Trajectory(
            settings.engine,
            exudyn.__version__,
            settings,
            machine.speed,
            revolutions,
            verdict.outcome,
            reason,
            points,
            tracks,
        )
        yield Piece(trajectory, first, clock, warnings={}, solver=None, drive_torque=None)


def states_of(stepper: Stepper, steps: int) -> Iterator[Array]:
    """States (T, 3, 3 n) of a run, a block of the solver's at a time: poses, rates, accelerations of one instant each.

    Both solvers fulfil constraints and equations of motion at the end of a step, so all that is read there belongs to
    it: the accelerations are not those, at other instants, that generalised alpha carries along beside them.
    """
    steps = max(steps, 1)
    for done in range(0, steps, BLOCK):
        yield stepper.recorded(min(BLOCK, steps - done))[1 if done else 0 :]


def instants_of(mechanism: Mechanism, times: Array, states: Array) -> Instants:
    """Times of samples [s], and where the crank was by the engine's own account."""
    turn, rate, acceleration = states[:, :, 3 * mechanism.body_index[mechanism.crank] + 2].T
    sense = mechanism.driver.sense
    return Instants(times, sense * (turn - mechanism.driver.start), sense * rate, sense * acceleration)
