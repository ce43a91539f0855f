"""What is found of a user's MuJoCo model, as plain values: by hardening it, and by changes that must not matter."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

from conrod.runs.other_forces import OtherForce
from conrod.runs.plain_values import plain_values
from conrod.studies.frame.paired_timing import PairedTiming

SCHEMA = 3


@dataclass(frozen=True)
class HardeningRun:
    """A run of the model as it is or hardened; only the first three fields are known if it broke off."""

    name: str
    steps: int  # that it completed at the model's own step, of those asked for
    broke: str = ""  # the engine's warning that ended it
    openings: tuple[float, ...] | None = None  # largest [m] of each loop; an angle by what it is at the model's size
    drift: float | None = None  # largest distance of a body from where the reference has it [m]


@dataclass(frozen=True)
class HardenedModel:
    """The result of hardening one model.

    Attributes:
        timestep, seconds: of the runs [s].
        reference_known_to: how far the two references are apart [m], or the rounding of a position where that is more;
            None where one of them broke.
    """

    path: str
    mujoco: str
    refusals: tuple[str, ...] = ()  # why it is not hardened; empty where it is
    warnings: tuple[str, ...] = ()  # what a user should know
    size: float = 0.0  # of the model, MuJoCo's `stat.extent` [m]
    timestep: float = 0.0
    seconds: float = 0.0
    start: str = ""  # what they started from
    start_opening: float = 0.0  # largest opening of the start pose as given [m]
    start_closed: bool = True  # whether the runs start with the loops closed; where no near pose closes them, as given
    loops: tuple[str, ...] = ()  # kinds and names of the closures
    factor: float | None = None  # on the inverse weights
    lines: str = ""  # Python that does it
    variants: tuple[HardeningRun, ...] = ()  # as it is, hardened
    travel: float | None = None  # the longest way of a body in the reference [m]
    reference_known_to: float | None = None
    acting: tuple[OtherForce, ...] = ()  # in the runs, besides weight, inertia and the loops
    cost: PairedTiming | None = None  # of a hardened step over one as it is; None where one of them broke
    content: bytes | None = None  # the binary model; None where none was asked for or it was refused

    def document(self) -> dict[str, Any]:
        """All but the binary model, as values that JSON has."""
        values = plain_values(replace(self, content=None))
        del values["content"]
        return {"schema": SCHEMA, **values}


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
        change: what was changed.
        bound: what it must hold to: bits or rounding.
        difference: of the accelerations, in the norm of the kinetic energy, over their largest; None where states were
            compared bit by bit, or nothing was.
        over_bound: the difference over its bound, where that is largest.
        time: of the first state that is out of bounds, or of that where the ratio is largest [s].
        case: the model in which that is; empty where there is but one.
        broken, cases: models in which it is broken, and all that were tried.
        reason: of what is unsupported.
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
        engine_version: of MuJoCo.
        run: how the states that are compared were made, in words.
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
