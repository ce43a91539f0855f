"""A follower in flight: its gap beside the exact one, and from which speed it flies."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from conrod.report import numbers
from conrod.report.charts.canvas import Layout, on_grid, on_log_grid, preset_handles
from conrod.report.charts.styles import EXACT, colour, engine_title, preset_style
from conrod.report.limits.tables import WHO, who
from conrod.report.table import Cell, Table, Toned, table
from conrod.studies.limits.float_results import WITHIN, ComparedFlight, FollowerFloat, GapCurve

WIDTH, TALL, LOW = 9.5, 2.9, 2.9  # [inch]
LEFT, RIGHT, TOP, BETWEEN, GAP, BOTTOM = 0.85, 0.25, 0.62, 0.75, 0.78, 0.5  # margins [inch]
BESIDE = 15.0  # crank angle shown before and after the flight [deg]
MARKER_SPACING = 16  # spans of a curve
SPEEDS, LENGTHS, NONE = (0.96, 1.24), (0.05, 100.0), 0.03  # speeds and lengths [deg] shown; where there is none


def float_figure(floats: Sequence[FollowerFloat]) -> Figure:
    """Gap against crank angle of all, above the length of flights against speed, a panel an engine.

    At least one run must have been recorded.
    """
    drawn = [(found, found.curve) for found in floats if found.curve is not None]
    engines = list(dict.fromkeys(found.engine for found, _ in drawn))
    height = TOP + TALL + BETWEEN + LOW + BOTTOM
    layout = Layout(WIDTH, height)
    wide = (WIDTH - LEFT - RIGHT - GAP * (len(engines) - 1)) / len(engines)
    _flight_panel(layout.axes(LEFT, height - TOP - TALL, WIDTH - LEFT - RIGHT, TALL), drawn)
    for column, engine in enumerate(engines):
        own = [found for found, _ in drawn if found.engine == engine]
        _onset_panel(layout.axes(LEFT + column * (wide + GAP), BOTTOM, wide, LOW), own)
    handles = [Line2D([], [], label="exact", **EXACT), *preset_handles((f.engine, f.preset) for f, _ in drawn)]
    layout.legend(handles, len(handles), handlelength=3.0)
    return layout.figure


def _flight_panel(axes: Axes, drawn: Sequence[tuple[FollowerFloat, GapCurve]]) -> None:
    curve = drawn[0][1]
    angle, gap = np.degrees(np.array(curve.exact)[:, 0]), 1e3 * np.array(curve.exact)[:, 1]
    span = float(gap.max())
    axes.plot(on_grid(angle, 360.0), on_grid(gap, span), **EXACT)
    for place, (found, shown) in enumerate(drawn):
        gaps = np.array(shown.gaps)
        style = preset_style(found.engine, found.preset) | {"linewidth": 0.8}
        phase = round(MARKER_SPACING * place / len(drawn))
        at, height = on_grid(np.degrees(gaps[:, 0]), 360.0), on_grid(1e3 * gaps[:, 1], span)
        axes.plot(at, height, markevery=(phase, MARKER_SPACING), **style)
    axes.set_xlim(angle[0] - BESIDE, angle[-1] + 2.0 * BESIDE)
    axes.set_xlabel("crank angle [deg]")
    axes.set_ylabel("gap between roller and cam [mm]")
    title = f"In flight: {curve.speed:g} times the float speed, {curve.steps_per_revolution} steps per revolution"
    axes.set_title(title, loc="left")


def _onset_panel(axes: Axes, own: Sequence[FollowerFloat]) -> None:
    """The longest flight of each speed with the finer step, filled where it is none that shrinks with the step."""
    exact = np.array(own[0].exact_lengths)
    axes.plot(on_grid(exact[:, 0], 1.0), on_log_grid(np.degrees(exact[:, 1])), **EXACT)
    axes.axvline(1.0, color="#333333", linewidth=1.0)
    ground = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
    at = ("data", "axes fraction")
    axes.annotate("float speed", (1.0, 0.93), xycoords=at, ha="center", fontsize=7.5, bbox=ground)
    for found in own:
        style = preset_style(found.engine, found.preset) | {"linestyle": "none", "markersize": 5.0}
        for flies in (False, True):
            shown = [p for p in found.probes if SPEEDS[0] <= p.speed <= SPEEDS[1] and p.flies is flies]
            lengths = np.maximum(np.degrees([p.lengths[1] or 0.0 for p in shown]), NONE)
            fill = {"markerfacecolor": colour(found.engine) if flies else "none"}
            axes.plot(on_grid(np.array([p.speed for p in shown]), 1.0), on_log_grid(lengths), **(style | fill))
    axes.set_yscale("log")
    axes.set_xlim(*SPEEDS)
    axes.set_ylim(0.6 * NONE, LENGTHS[1])
    axes.set_yticks([NONE, 0.1, 1.0, 10.0, 100.0], ["none", "0.1", "1", "10", "100"])
    axes.minorticks_off()
    axes.set_xlabel("crank speed over the float speed")
    axes.set_ylabel("longest flight [deg]")
    axes.set_title(f"{engine_title(own[0].engine)}: it flies (filled), or does not (open)", loc="left")


# -- tables ------------------------------------------------------------------------------------------------------------


def onset_table(floats: Iterable[FollowerFloat]) -> Table:
    """Return a row for each engine and preset: the speed at which the follower lets go, over the theory's."""
    head = (*WHO, "steps per revolution", "penetration [mm]", "onset / theory", "off")
    rows = [
        (
            *who(found),
            ", ".join(str(steps) for steps in found.steps_per_revolution),
            numbers.measured(None if found.penetration is None else 1e3 * found.penetration),
            _ratio(found.onset),
            _share(None if found.onset is None else found.onset - 1.0),
            _ratio(found.visible),
            _ratio(found.from_length),
            _onset_verdict(found),
        )
        for found in floats
        if not found.refusal
    ]
    return table((*head, "visible by the exact flight from", "predicted from a flight's length", ""), rows)


def _onset_verdict(found: FollowerFloat) -> Cell:
    within = f"within {100 * WITHIN:g} %"
    if found.onset is not None and abs(found.onset - 1.0) <= WITHIN:
        return within
    if not found.fit:
        return f"too soft: {100 * WITHIN:g} % above the onset the exact flight is lower than ten penetrations"
    return Toned(f"not {within}", "bad")


def flight_table(floats: Iterable[FollowerFloat]) -> Table:
    """Return a row for each flight beside the exact one."""
    head = (*WHO, "speed / float speed", "steps per revolution", "ended", "exact gap [mm]", "measured, off by")
    rows = [(*who(found), *_flight(flight)) for found in floats for flight in found.flights]
    return table((*head, "exact landing [deg]", "measured minus exact [deg]"), rows)


def _flight(flight: ComparedFlight) -> tuple[str, ...]:
    exact, off = flight.exact, flight.landing_error
    return (
        numbers.quantity(flight.speed),
        str(flight.steps_per_revolution),
        flight.outcome,
        numbers.MISSING if exact is None else numbers.quantity(1e3 * exact.gap),
        _share(flight.gap_error),
        numbers.MISSING if exact is None else f"{math.degrees(exact.landing):.2f}",
        numbers.MISSING if off is None else f"{math.degrees(off):+.3f}",
    )


def _ratio(value: float | None) -> str:
    return numbers.MISSING if value is None else f"{value:.4f}"


def _share(value: float | None) -> str:
    return numbers.MISSING if value is None else f"{100.0 * value:+.2f} %"
