"""What is found by hardening a MuJoCo model, as plain values."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from conrod.comparison.other_forces import OtherForce
from conrod.comparison.plain_values import plain_values
from conrod.execution.paired_timing import PairedTiming
from conrod.mechanism.units import MM
from conrod.report import numbers
from conrod.report.notebook import NotebookResult
from conrod.report.table import Cell, ColouredCell, Table, table

HARDEN_SCHEMA = 3


@dataclass(frozen=True)
class HardeningRun:
    """A run of the model as it is or hardened; only the first three fields are known if it broke off."""

    name: str
    steps: int  # number of steps completed at the model's own step
    broke: str = ""  # the engine's warning that ended it
    openings: tuple[float, ...] | None = None  # largest [m] of each loop; an angle by what it is at the model's size
    drift: float | None = None  # largest distance of a body from where the reference has it [m]


@dataclass(frozen=True)
class HardenedModel(NotebookResult):
    """The result of hardening one model.

    Attributes:
        timestep, seconds: time step and length of the runs [s].
        reference_known_to: error of the reference [m], or the rounding of a position where that is more;
            None where one of them broke.
    """

    path: str
    mujoco: str
    refusals: tuple[str, ...] = ()  # why it is not hardened; empty where it is
    warnings: tuple[str, ...] = ()  # warnings for the user, a sentence each
    size: float = 0.0  # of the model, MuJoCo's `stat.extent` [m]
    timestep: float = 0.0
    seconds: float = 0.0
    start: str = ""  # start pose of the runs, in words
    start_opening: float = 0.0  # largest opening of the start pose as given [m]
    start_closed: bool = True  # whether the runs start with the loops closed; where no near pose closes them, as given
    loops: tuple[str, ...] = ()  # kinds and names of the closures
    factor: float | None = None  # on the inverse weights
    lines: str = ""  # Python that does it
    variants: tuple[HardeningRun, ...] = ()  # the run as it is, and the hardened one
    travel: float | None = None  # the longest way of a body in the reference [m]
    reference_known_to: float | None = None
    reference_extrapolated: bool = False  # to a step of zero; else the run at a sixteenth of the step is the reference
    acting: tuple[OtherForce, ...] = ()  # in the runs, besides weight, inertia and the loops
    cost: PairedTiming | None = None  # time of a hardened step over that of a step as it is; None if a run broke off
    content: bytes | None = None  # the binary model; None where none was asked for or it was refused

    @property
    def verdict(self) -> str:
        """Whether the model is hardened, and if not, why."""
        return f"not hardened: {'; '.join(self.refusals)}" if self.refusals else "hardened"

    def tables(self) -> list[Table]:
        """Figures of the model and of the hardened model, side by side; no table without runs."""
        names = tuple(variant.name for variant in self.variants)
        return [table(("", *names), self._rows(), names, "largest in the run")] if self.variants else []

    def _rows(self) -> Iterator[list[Cell]]:
        """Yield the rows of the table, a cell for each variant."""
        broken = (
            ColouredCell(f"{one.steps}, then {one.broke}", "bad") if one.broke else str(one.steps)
            for one in self.variants
        )
        yield ["steps completed", *broken]
        for k, loop in enumerate(self.loops):
            values = (None if one.openings is None else one.openings[k] for one in self.variants)
            yield [f"opening of {loop} [mm]", *map(in_mm, values)]
        known = math.inf if self.reference_known_to is None else self.reference_known_to
        drifts = (None if (drift := one.drift) is None or drift <= known else drift for one in self.variants)
        yield ["drift from the reference [mm]", *map(in_mm, drifts)]

    def document(self) -> dict[str, Any]:
        """All but the binary model, as values that JSON has."""
        values = plain_values(replace(self, content=None))
        del values["content"]
        return {"schema": HARDEN_SCHEMA, **values}


def in_mm(size: float | None) -> str:
    """Return a length [m] as text in mm; a dash for None."""
    return "-" if size is None else numbers.measured_text(MM * size)
