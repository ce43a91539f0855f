"""Runs of a study of ingredients: what a variant's motion differs by, and what it costs over another one."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from conrod.studies.cell import Cell
from conrod.studies.paired_clock import ROUNDS
from conrod.trajectory import Settings

# Raised when what is kept of the same run comes out otherwise, or means something else, than before.
CHANGE_VERSION, COST_VERSION = 1, 1


def _plain(settings: Settings) -> dict[str, Any]:
    values = settings.as_dict()
    del values["preset"]
    return values


@dataclass(frozen=True)
class ChangeCell(Cell):
    """A run of which it is kept by how much it differs from another one; see `change`.

    Attributes:
        against: settings of the other one.
    """

    signed_angles: int = 0
    against: Settings = field(kw_only=True)

    def _identity(self, parameters: dict[str, float] | None) -> dict[str, Any]:
        return super()._identity(parameters) | {"change": CHANGE_VERSION, "against": _plain(self.against)}


@dataclass(frozen=True)
class CostCell(Cell):
    """What a revolution costs over one with other settings; see `conrod.studies.paired_clock`.

    Attributes:
        against: the other settings.
        machine: fingerprint of the machine that it is timed on: figures of different machines do not mix.
        rounds: how often both are timed.
    """

    signed_angles: int = 0
    against: Settings = field(kw_only=True)
    machine: str = field(kw_only=True)
    rounds: int = field(kw_only=True, default=ROUNDS)

    def _identity(self, parameters: dict[str, float] | None) -> dict[str, Any]:
        paired = {"cost": COST_VERSION, "machine": self.machine, "rounds": self.rounds}
        return super()._identity(parameters) | paired | {"against": _plain(self.against)}
