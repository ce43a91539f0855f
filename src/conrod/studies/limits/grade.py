"""What a user gets from a run: a motion to rely on, a rough one, a wrong one, or none; and whether anything says so."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from conrod.runs.trajectory import Outcome
from conrod.studies.frame.measurement import Measurement
from conrod.studies.limits.extremes import Extremes

SAFE_ERROR, ROUGH_ERROR = 0.01, 0.1  # of the travel, largest position error

# Ends that nobody overlooks: there is no trajectory, or none was begun.
LOUD = {o.slug for o in (Outcome.CRASHED, Outcome.TIMED_OUT, Outcome.OUT_OF_MEMORY, Outcome.UNSUPPORTED)}
# Ends after which the state is nowhere near the machine any more, or no state at all.
UNBOUNDED = LOUD | {o.slug for o in (Outcome.DIVERGED, Outcome.EXPLODED, Outcome.RESET)}


class Level(Enum):
    """From good to bad; the texts are for people."""

    SAFE = ("safe", f"position within {100 * SAFE_ERROR:g} % of the travel")
    ROUGH = ("rough", f"position within {100 * ROUGH_ERROR:g} % of the travel")
    WRONG = ("wrong", "in one piece, but further off than that")
    BROKEN = ("broken", "no longer the machine: it came apart, flipped, let go of its cam, ..")
    UNBOUNDED = ("unbounded", "blown up, reset, crashed or never ended")

    def __init__(self, slug: str, meaning: str) -> None:
        self.slug = slug
        self.meaning = meaning


@dataclass(frozen=True)
class Grade:
    """The level of a run, and whether it is quiet: wrong, and nothing in its numbers or from its engine says so."""

    level: Level
    outcome: str
    quiet: bool


def grade_of(measurement: Measurement) -> Grade:
    """The grade of a measured run."""
    level = _level(measurement)
    bad = level not in (Level.SAFE, Level.ROUGH)
    return Grade(level, measurement.outcome, bad and _quiet(measurement))


def _level(measurement: Measurement) -> Level:
    if measurement.outcome in UNBOUNDED:
        return Level.UNBOUNDED
    error = measurement.largest("position")
    if error is None:
        return Level.BROKEN
    return Level.SAFE if error <= SAFE_ERROR else Level.ROUGH if error <= ROUGH_ERROR else Level.WRONG


def _quiet(measurement: Measurement) -> bool:
    if measurement.outcome in LOUD:
        return False
    watched = Extremes.of(measurement)
    return watched is not None and watched.finite and not watched.warnings
