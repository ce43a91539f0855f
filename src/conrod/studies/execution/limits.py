"""What a cell may take, and what it is called when it ends for want of it."""

from __future__ import annotations

from dataclasses import dataclass

from conrod.errors import InvalidInput
from conrod.runs.trajectory import Outcome

LEAST_TIMEOUT, MOST_TIMEOUT = 0.1, 1e7


@dataclass(frozen=True)
class Limits:
    """What one cell may take; None is no limit.

    Attributes:
        timeout: wall time [s], from the moment a process begins with it.
        memory: address space of the process that runs it [bytes], the libraries it has loaded included.
    """

    timeout: float | None = None
    memory: int | None = None

    def __post_init__(self) -> None:
        """Refuse limits that no run could keep.

        Raises:
            InvalidInput: names the limit and its range.
        """
        if self.timeout is not None and not LEAST_TIMEOUT <= self.timeout <= MOST_TIMEOUT:
            raise InvalidInput(
                f"a cell's time limit of {self.timeout:g} s is not in {LEAST_TIMEOUT:g}..{MOST_TIMEOUT:g} s"
            )
        if self.memory is not None and self.memory < 1:
            raise InvalidInput(f"a cell's memory limit of {self.memory} bytes is no memory at all")

    def of(self, outcome: str) -> float | None:
        """The limit at which a run with this outcome ended: [s] or [bytes]; None if it did not end at one."""
        return {Outcome.TIMED_OUT.slug: self.timeout, Outcome.OUT_OF_MEMORY.slug: self.memory}.get(outcome)

    def allow_more(self, outcome: str, allowed: float) -> bool:
        """Whether a run that ended at a limit would now get further."""
        now = self.of(outcome)
        return now is None or now > allowed
