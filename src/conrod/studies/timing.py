"""What a run costs, apart from what it shows."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Timing:
    """CPU time of a cell on one machine, the least of several repeats.

    Attributes:
        seconds_per_revolution: CPU time of one simulated revolution [s].
        reference_seconds: CPU time of one step of the engine's fixed reference loop, timed just before in the same
            process [s].
        ratio: the first over the second: a revolution costs as much as so many steps of the reference loop.
        steps: time steps that were timed in each repeat.
        repeats: how often it was timed.
        machine: fingerprint of the machine, for people and to tell machines apart.
    """

    seconds_per_revolution: float
    reference_seconds: float
    ratio: float
    steps: int
    repeats: int
    machine: str
