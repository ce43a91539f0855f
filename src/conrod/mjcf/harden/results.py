"""Request and findings of `conrod harden`, as plain values."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from conrod.own.models.request import Controls
from conrod.runs.plain import plain
from conrod.studies.frame.paired_timing import PairedTiming

SCHEMA = 3


@dataclass(frozen=True)
class Request:
    """Way in which a model is to be hardened, and the motion on which that is shown.

    Attributes:
        keyframe: name or number of the keyframe that the runs start from; None for the first, or the model's own pose.
    """

    keyframe: str | None = None
    seconds: float = 1.0  # how long the runs are [s]
    force: bool = False  # harden what seems to be soft on purpose
    content: bool = True  # whether the hardened model is asked for, not only its figures
    controls: Controls = ()  # inputs of actuators in place of the keyframe's, held through the runs


@dataclass(frozen=True)
class Variant:
    """The model as it is, or hardened; where its run broke off, nothing but the first three is known."""

    name: str
    steps: int  # that it completed at the model's own step, of those asked for
    broke: str = ""  # the engine's warning that ended it
    openings: tuple[float, ...] | None = None  # largest [m] of each loop; an angle by what it is at the model's size
    drift: float | None = None  # largest distance of a body from where the reference has it [m]


@dataclass(frozen=True)
class HardenedModel:
    """Findings on one model.

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
    variants: tuple[Variant, ...] = ()  # as it is, hardened
    travel: float | None = None  # the longest way of a body in the reference [m]
    reference_known_to: float | None = None
    cost: PairedTiming | None = None  # of a hardened step over one as it is; None where one of them broke
    content: bytes | None = None  # the binary model; None where none was asked for or it was refused

    def document(self) -> dict[str, Any]:
        """All but the binary model, as values that JSON has."""
        values = plain(replace(self, content=None))
        del values["content"]
        return {"schema": SCHEMA, **values}
