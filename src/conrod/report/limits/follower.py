"""From which speed a follower flies off its cam, beside the theory's."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.figure import Figure

from conrod.report import numbers
from conrod.report.charts.canvas import Layout, on_grid, on_log_grid, preset_handles
from conrod.report.charts.styles import colour, preset_style
from conrod.report.limits.tables import WHO, who
from conrod.report.table import Cell, Table, Toned, table
from conrod.studies.limits.follower_float import WITHIN, FollowerFloat

WIDTH, HEIGHT = 9.5, 3.8  # [inch]
LEFT, RIGHT, TOP, BOTTOM = 0.85, 0.25, 0.4, 0.5  # margins [inch]
SPEEDS, LENGTHS, NONE = (0.96, 1.24), (0.05, 100.0), 0.03  # speeds and lengths [deg] shown; where there is none


def float_figure(floats: Sequence[FollowerFloat]) -> Figure:
    """The longest flight of each speed with the finer step, filled where it is none that shrinks with the step."""
    layout = Layout(WIDTH, HEIGHT)
    axes = layout.axes(LEFT, BOTTOM, WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM)
    axes.axvline(1.0, color="#333333", linewidth=1.0)
    for found in floats:
        style = preset_style(found.engine, found.preset) | {"linestyle": "none", "markersize": 5.0}
        for flies in (False, True):
            shown = [p for p in found.probes if SPEEDS[0] <= p.speed <= SPEEDS[1] and p.flies is flies]
            lengths = np.maximum(np.degrees([p.lengths[1] or 0.0 for p in shown]), NONE)
            fill = {"markerfacecolor": colour(found.engine) if flies else "none"}
            axes.plot(on_grid(np.array([p.speed for p in shown]), 1.0), on_log_grid(lengths), **(style | fill))
    axes.set(xlim=SPEEDS, yscale="log", ylim=(0.6 * NONE, LENGTHS[1]))
    axes.set_yticks([NONE, 0.1, 1.0, 10.0, 100.0], ["none", "0.1", "1", "10", "100"])
    axes.minorticks_off()
    axes.set_xlabel("crank speed over the float speed: it flies (filled), or does not (open)")
    axes.set_ylabel("longest flight [deg]")
    handles = preset_handles((found.engine, found.preset) for found in floats)
    layout.legend(handles, len(handles), handlelength=3.0)
    return layout.figure


def onset_table(floats: Iterable[FollowerFloat]) -> Table:
    """Return a row for each engine and preset: the speed at which the follower lets go, over the theory's."""
    rows = [
        (
            *who(found),
            numbers.measured(None if found.penetration is None else 1e3 * found.penetration),
            numbers.MISSING if found.onset is None else f"{found.onset:.4f}",
            _verdict(found),
        )
        for found in floats
    ]
    return table((*WHO, "penetration [mm]", "onset / theory", ""), rows)


def _verdict(found: FollowerFloat) -> Cell:
    within = f"within {100 * WITHIN:g} %"
    return within if found.onset and abs(found.onset - 1.0) <= WITHIN else Toned(f"not {within}", "bad")
