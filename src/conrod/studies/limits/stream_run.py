"""A run at an engine's limits: streamed, compared as it goes, and watched for how it fails."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from conrod.engines import engine_named
from conrod.engines.engine import PIECE
from conrod.engines.running import check_run
from conrod.errors import InvalidInput
from conrod.runs.outcome import Verdict, prevailing
from conrod.runs.trajectory import Outcome
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.run import LEAST_STEPS, as_run, too_coarse
from conrod.studies.limits.run_statistics import Seen

if TYPE_CHECKING:
    from conrod.studies.limits.cell import LimitCell

# The solver is looked at at the end of each piece: at least so often in a run, and at so many crank angles. What a look
# costs is then a small part of a long run.
LOOKS, ANGLES = 40, 20
LEAST_PIECE = 25  # steps; in a run of few, to look more often would cost more than the run
# Of a turn: steps of this size come to all parts of it, whole turns between them or not, and so do its powers.
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
# A machine that came apart may blow up yet: it is followed for so many revolutions more.
FOLLOWED = 2.0
GONE = {Outcome.RESET, Outcome.DIVERGED, Outcome.EXPLODED}


def watch(cell: LimitCell) -> Measurement:
    """Run a cell in pieces, up to its end or until nothing is left of the machine.

    A run that failed in another way is followed on, without errors, and ends as the whole of it is judged: it may yet
    blow up, and a follower that left its cam, which is followed to the end, may land.

    Raises:
        InvalidInput: as `conrod.run`; or the run is too short to have accelerations.
    """
    engine, cell = engine_named(cell.settings.engine), as_run(cell)
    refusal = engine.refusal(cell.machine, cell.settings) or too_coarse(cell)
    if refusal:
        return Measurement(Outcome.UNSUPPORTED.slug, refusal)
    check_run(cell.machine, cell.settings, cell.revolutions, cell.start_angle)
    length, seen, verdict, last = piece_length(cell), Seen(cell), Verdict(Outcome.COMPLETED), math.inf
    for piece in engine.run(cell.machine, cell.settings, cell.revolutions, cell.start_angle, length):
        seen.add(piece)
        verdict = prevailing(verdict, Verdict(piece.trajectory.outcome, piece.trajectory.reason))
        if verdict.outcome is Outcome.COMPLETED:
            seen.compare(piece)
        elif verdict.outcome is not Outcome.LOST_CONTACT:
            last = min(last, piece.first_step + FOLLOWED * cell.settings.steps_per_revolution)
        if verdict.outcome in GONE or piece.first_step >= last:
            break
    return seen.measurement(verdict)


def piece_length(cell: LimitCell) -> int:
    """Steps in each piece of a cell's run.

    Raises:
        InvalidInput: the run is too short to have accelerations.
    """
    turn = cell.settings.steps_per_revolution
    steps = round(turn * cell.revolutions)
    if steps < LEAST_STEPS:
        raise InvalidInput(
            f"revolutions = {cell.revolutions:g} at {turn} steps each are {steps} steps; "
            f"a run needs {LEAST_STEPS} to have accelerations"
        )
    most = min(max(steps // LOOKS, LEAST_PIECE), PIECE)
    if most * ANGLES <= turn:
        return most
    share = GOLDEN
    while share * turn > most:
        share *= GOLDEN
    length = max(round((int(most / turn - share) + share) * turn), LEAST_STEPS)
    while math.gcd(length, turn) > 1 and length > LEAST_STEPS:
        length -= 1
    return length
