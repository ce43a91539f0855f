"""The strip above a work-precision diagram: runs that did not complete, a lane for each way of ending."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from conrod.report.canvas import on_log_grid
from conrod.report.styles import colour
from conrod.report.sweep.placing import Placed
from conrod.trajectory import Outcome

# A marker for each way in which runs end that do not complete; any other end gets the last one.
MARKERS = {
    Outcome.DIVERGED.slug: "x",
    Outcome.EXPLODED.slug: "*",
    Outcome.OPENED.slug: "v",
    Outcome.FLIPPED.slug: ">",
    Outcome.LOCKED.slug: "s",
    Outcome.RESET.slug: "P",
    Outcome.TIMED_OUT.slug: "h",
}
OTHER = "X"
APART = (0.0, 0.24, -0.24)  # runs of one cost, in lanes


def ends_of(placed: Sequence[Placed]) -> tuple[str, ...]:
    """The ways in which runs ended that did not complete, in the order of the outcomes."""
    found = {p.point.measurement.outcome for p in placed if not p.point.completed}
    known = [outcome.slug for outcome in Outcome if outcome.slug in found]
    return (*known, *sorted(found.difference(known)))


def draw_strip(axes: Axes, placed: Sequence[Placed], ends: Sequence[str]) -> None:
    """A marker for each run, in the lane of its end."""
    for lane, end in enumerate(ends):
        failed = [p for p in placed if p.point.measurement.outcome == end]
        for k, one in enumerate(failed):
            axes.plot(
                on_log_grid(np.array([one.cost])),
                [lane + APART[k % len(APART)]],
                linestyle="none",
                marker=MARKERS.get(end, OTHER),
                markersize=4.0,
                color=colour(one.point.engine),
                alpha=0.7,
                markeredgewidth=0.6,
            )
    axes.set_ylim(len(ends) - 0.4, -0.6)
    axes.set_yticks(range(len(ends)), ends)
    axes.yaxis.tick_right()
    axes.tick_params(axis="y", length=0, labelsize=8.0)
    axes.tick_params(axis="x", length=0, labelbottom=False)
    axes.set_ylabel("did not\ncomplete", fontsize=8.0)
    axes.set_facecolor("#f6f6f6")
    for side in ("left", "bottom"):
        axes.spines[side].set_visible(False)
