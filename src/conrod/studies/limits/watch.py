"""A run at an engine's limits: streamed, compared as it goes, and watched for how it fails."""

from __future__ import annotations

from conrod.engines import engine_named
from conrod.engines.engine import PIECE
from conrod.errors import InvalidInput
from conrod.outcome import Verdict
from conrod.running import check_run
from conrod.studies.limits.cell import LimitCell
from conrod.studies.limits.seen import Seen
from conrod.studies.measurement import Measurement
from conrod.trajectory import Outcome

# The solver is looked at at the end of each piece: so often in a run of any length, twenty times a turn in one of two.
# What a look costs is then a small part of a long run.
LOOKS = 40
LEAST_STEPS = 3  # before the first acceleration that is a difference of velocities
# What a follower that has left its cam may do next without the run as a whole being judged otherwise.
IN_FLIGHT = {Outcome.COMPLETED, Outcome.LOST_CONTACT, Outcome.OPENED, Outcome.FLIPPED}


def watch(cell: LimitCell) -> Measurement:
    """Run a cell in pieces, up to its end or to the piece in which it failed.

    A follower that has left its cam is followed to the end of the run, since it may land; its errors are not.

    Raises:
        InvalidInput: as `conrod.run`; or the run is too short to have accelerations.
    """
    engine = engine_named(cell.settings.engine)
    refusal = engine.refusal(cell.machine, cell.settings)
    if refusal:
        return Measurement(Outcome.UNSUPPORTED.slug, refusal)
    check_run(cell.machine, cell.settings, cell.revolutions, cell.start_angle)
    length, seen, verdict = piece_length(cell), Seen(cell), Verdict(Outcome.COMPLETED)
    for piece in engine.pieces(cell.machine, cell.settings, cell.revolutions, cell.start_angle, length):
        seen.add(piece)
        here = Verdict(piece.trajectory.outcome, piece.trajectory.reason)
        if verdict.outcome is Outcome.COMPLETED or here.outcome not in IN_FLIGHT:
            verdict = here
        if verdict.outcome is Outcome.COMPLETED:
            seen.compare(piece)
        elif verdict.outcome is not Outcome.LOST_CONTACT:
            break
    return seen.measurement(verdict)


def piece_length(cell: LimitCell) -> int:
    """Steps in each piece of a cell's run.

    Raises:
        InvalidInput: the run is too short to have accelerations.
    """
    steps = round(cell.settings.steps_per_revolution * cell.revolutions)
    if steps < LEAST_STEPS:
        raise InvalidInput(
            f"revolutions = {cell.revolutions:g} at {cell.settings.steps_per_revolution} steps each are {steps} steps; "
            f"a run needs {LEAST_STEPS} to have accelerations"
        )
    return min(max(steps // LOOKS, LEAST_STEPS), PIECE)
