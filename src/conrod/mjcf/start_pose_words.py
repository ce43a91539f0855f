"""Words on the pose in which a model's own run starts."""

from __future__ import annotations

from conrod.mjcf.request import OpenStart
from conrod.report.numbers import quantity

MAX_POSE_NUMBERS = 20  # coordinates of a pose in a sentence


def open_start_words(begins: OpenStart, unit: float = 1.0) -> str:
    """Say how far the loops are open at the start, and where they would be closed.

    Args:
        unit: unit of the model's lengths [m].
    """
    worst, more = begins.worst, len(begins.gaps) - 1
    others = f" ({more} more closure{'s' if more > 1 else ''} open)" if more else ""
    gap = f"{quantity(1e3 * unit * begins.gaps[worst], 3)} mm"
    if not begins.closed:
        nearest = "no pose near it closes them: look at lengths and places of the closures"
    elif len(begins.closed.split()) > MAX_POSE_NUMBERS:
        nearest = "`conrod lint` prints the nearest closed pose"
    else:
        nearest = f'the nearest closed pose is qpos="{begins.closed}"'
    return f"It begins {gap} open: {worst}, in {begins.pose}{others}; {nearest}."
