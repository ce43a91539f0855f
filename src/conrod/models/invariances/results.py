"""What is found by changes to a model that must not matter, as plain values."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class InvarianceOutcome(Enum):
    """Outcome of a change that must not change the motion."""

    BITS = "identical"
    HOLDS = "holds"
    BROKEN = "broken"
    UNSUPPORTED = "unsupported"


@dataclass(frozen=True)
class Invariance:
    """A change that must not matter, and the largest difference that it made to the accelerations.

    Attributes:
        change: name of the change of the model.
        bound: how equal the accelerations must be: to bits, to rounding, or to the residual of a solver.
        difference: of the accelerations, in the norm of the kinetic energy, over their largest; None where states were
            compared bit by bit, or nothing was.
        over_bound: the difference over its bound, where that is largest.
        time: of the first state that is out of bounds, or of that where the ratio is largest [s].
        case: the model in which that is; empty where there is but one.
        broken, cases: models in which it is broken, and all that were tried.
        reason: why the change is unsupported.
    """

    change: str
    bound: str
    outcome: InvarianceOutcome
    difference: float | None = None
    over_bound: float | None = None
    time: float | None = None
    case: str = ""
    broken: int = 0
    cases: int = 1
    reason: str = ""


@dataclass(frozen=True)
class InvarianceStudy:
    """All invariances of a model file or of a scene's models.

    Attributes:
        engine_version: version of MuJoCo.
        run: run that the compared states are taken from, in words.
    """

    name: str
    engine_version: str
    run: str
    found: tuple[Invariance, ...]

    @property
    def broken(self) -> tuple[Invariance, ...]:
        """The invariances that do not hold."""
        return tuple(one for one in self.found if one.outcome is InvarianceOutcome.BROKEN)

    @property
    def passed(self) -> bool:
        """True where none is broken."""
        return not self.broken
