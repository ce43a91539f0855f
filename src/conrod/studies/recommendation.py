"""What `conrod recommend` finds: plain, frozen data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from conrod.studies.cell import Cell
from conrod.studies.groups import Groups
from conrod.studies.stock_comparison import StockComparison
from conrod.studies.timing import Timing


@dataclass(frozen=True)
class Confirmation:
    """A run that the grid does not contain: what is other about it, and its errors (None unless it completed)."""

    what: str
    outcome: str
    errors: Mapping[str, float] | None
    held: bool


@dataclass(frozen=True)
class Rejected:
    """A cheaper setting that the grid's runs allow and a confirming run does not."""

    rule: str
    steps_per_revolution: int
    why: str


@dataclass(frozen=True)
class Recommendation:
    """The cheapest confirmed setting of one engine.

    Attributes:
        errors: largest error of each quantity that a tolerance was given for.
        margin: least of allowed over found.
        paste: the setting as lines for a model or a program.
    """

    engine: str
    rule: str
    preset: str | None
    cell: Cell
    errors: Mapping[str, float]
    margin: float
    timing: Timing
    confirmations: tuple[Confirmation, ...]
    rejected: tuple[Rejected, ...]
    stock: StockComparison
    groups: Groups
    paste: str


@dataclass(frozen=True)
class Refusal:
    """Nothing of one engine qualifies: the nearest setting, and how far each quantity is out.

    Attributes:
        excess: quantity -> found over allowed, of those that are out.
        why: a line for people where there is no nearest setting.
    """

    engine: str
    rule: str
    steps_per_revolution: int
    errors: Mapping[str, float]
    excess: Mapping[str, float]
    rejected: tuple[Rejected, ...]
    why: str = ""
