"""The report of `make batch`: errors of many saws, by engine, and what they cost."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from conrod.report import numbers
from conrod.report.kind import Kind
from conrod.report.table import Table, table
from conrod.report.terminal import PrintedPart

DIGITS = 3  # that are saved


@dataclass(frozen=True)
class Spread:
    """Values of many machines."""

    least: float
    median: float
    most: float  # of 95 %
    largest: float


@dataclass(frozen=True)
class EngineBatch:
    """An engine on all saws.

    Attributes:
        errors: position errors over L.
        shares: errors over the bounds of the engine's law; None where no law is stated.
        kept: number of saws within that bound.
        compiling: CPU time [s].
        step: CPU time of a step of a saw [s].
    """

    name: str
    errors: Spread
    shares: Spread | None
    kept: int
    compiling: float
    step: float


@dataclass(frozen=True)
class BatchFindings:
    """All engines on all saws.

    Attributes:
        count, steps: number of saws, and of steps of each.
        stroke: of the drawing [m].
        off: by how much the exact strokes are off it [m].
    """

    count: int
    steps: int
    stroke: float
    off: Spread
    engines: tuple[EngineBatch, ...]
    processor: str
    cores: str


def verdict_text(found: BatchFindings) -> str:
    """Say how many runs are within their bounds, and what the tolerances move."""
    lawful = [one for one in found.engines if one.shares]
    first = found.engines[0].errors
    return (
        f"{sum(one.kept for one in lawful)} of {len(lawful) * found.count} runs are within the bound of their engine's "
        f"law. The drawing's tolerances move the stroke of {found.stroke * 1e3:.1f} mm by up to "
        f"{found.off.largest * 1e3:.2g} mm; {found.engines[0].name.split()[0]}'s error moves with them by "
        f"{(first.largest - first.least) / first.median:.1%}."
    )


def spreads_table(found: BatchFindings) -> Table:
    """Return a row for each quantity, with its spread over the saws."""
    off = Spread(*(1e3 * value for value in vars(found.off).values()))
    spreads = [("exact stroke off the drawing's [mm]", off)]
    spreads += [(f"{one.name}: position error / L", one.errors) for one in found.engines]
    spreads += [(f"{one.name}: error / bound of its law", one.shares) for one in found.engines if one.shares]
    headings = ("quantity", "least", "median", "95 %", "largest")
    rows = [(name, *(numbers.quantity(value, DIGITS) for value in vars(one).values())) for name, one in spreads]
    return table(headings, rows, headings[1:])


def costs_table(found: BatchFindings) -> Table:
    """Return a row for each engine, with its costs."""
    rows = [(one.name, f"{one.compiling:.2g}", f"{one.step * 1e6:.2g}") for one in found.engines]
    return table(("engine", "compiling [CPU s]", "a step of a saw [CPU µs]"), rows, ("compiling [CPU s]",))


def _summary(found: BatchFindings) -> Mapping[str, Any]:
    return {"verdict": verdict_text(found)}


def _printed(findings: Sequence[BatchFindings]) -> Iterator[PrintedPart]:
    for found in findings:
        yield spreads_table(found)
        yield costs_table(found)
        yield verdict_text(found)


BATCH_REPORT = Kind(
    name="batch",
    findings=BatchFindings,
    title=lambda found: "Saws as they may be made",
    summary=_summary,
    printed=_printed,
    verdict=verdict_text,
    one_part=True,
    digits=DIGITS,
)
