"""Sizes of errors of a model with closed loops, and how its own run ended, in words."""

from __future__ import annotations

from conrod.comparison.trajectory import Outcome
from conrod.mjcf.loop_results import LOOPS, LoopStudy, ShippedRun
from conrod.report.numbers import measured_text, quantity

PAGE_UNITS = {"position": (1e3, "mm"), "velocity": (1.0, "m/s"), "acceleration": (1.0, "m/s²")}


def in_mm(size: float) -> str:
    """Return a length [m] as text in mm."""
    return f"{measured_text(1e3 * size)} mm"


def size_text(name: str, size: float) -> str:
    """Return an error of a quantity [SI] as text, in the unit of reports."""
    factor, unit = PAGE_UNITS["position" if name == LOOPS else name]
    return f"{measured_text(factor * size)} {unit}"


def shipped_words(shipped: ShippedRun) -> str:
    """Say how the file's own run ended, to follow the word `it`."""
    if shipped.outcome is not Outcome.COMPLETED:
        return f"ended as {shipped.outcome.slug}: {shipped.reason}"
    if shipped.chatter is not None:
        joint, swing = shipped.chatter
        return f"oscillates: the rate of {joint} turns back at every step, by {100 * swing:.2g} % of its range"
    open_by = f", its loops open by up to {in_mm(shipped.gap)}"
    return f"runs through its {quantity(shipped.seconds, 3)} s{open_by}"


def with_share(study: LoopStudy, name: str, size: float) -> str:
    """Return a size with its share of the range of motion, or of the largest speed or acceleration, behind it."""
    scale = study.scales.get("position" if name == LOOPS else name, 0.0)
    return f"{size_text(name, size)} ({measured_text(size / scale)} L)" if scale else size_text(name, size)
