"""A follower in flight: its gap beside the exact one, how deep it sinks in, and from which speed it flies.

One column an engine below a panel of all of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from conrod.exact.motion import Array
from conrod.report import numbers
from conrod.report.charts.canvas import on_grid, on_log_grid
from conrod.report.charts.layout import Layout, edge_note, preset_handles
from conrod.report.charts.styles import EXACT, colour, engine_title, preset_style
from conrod.report.limits.words import WHO, who
from conrod.report.table import Cell, Table, Toned, table
from conrod.studies.limits.follower_float import WITHIN, ComparedFlight, FollowerFloat, GapCurve, OnsetProbe

WIDTH, TALL, LOW = 9.5, 2.9, 2.5  # [inch]
LEFT, RIGHT, TOP, BETWEEN, GAP, BOTTOM = 0.85, 0.25, 0.62, 0.75, 0.78, 0.5  # margins [inch]
BESIDE = 15.0  # crank angle shown before and after the flight [deg]
MARKER_SPACING = 16  # spans of a curve
LEAST, MOST = 1e-9, 1.0  # gaps shown [m]
SPEEDS, LENGTHS, NONE = (0.96, 1.24), (0.05, 100.0), 0.03  # speeds and lengths [deg] shown; where there is none
SHARE_OF_EXACT = {**EXACT, "linewidth": 4.0}


def float_figure(floats: Sequence[FollowerFloat]) -> Figure:
    """Gap against crank angle, gap and penetration on a logarithmic scale, and length of flights against speed.

    At least one run must have been recorded.
    """
    drawn = [found for found in floats if found.curve is not None]
    engines = list(dict.fromkeys(found.engine for found in drawn))
    height = TOP + TALL + 2.0 * (BETWEEN + LOW) + BOTTOM
    layout = Layout(WIDTH, height)
    wide = (WIDTH - LEFT - RIGHT - GAP * (len(engines) - 1)) / len(engines)
    _flight_panel(layout.axes(LEFT, height - TOP - TALL, WIDTH - LEFT - RIGHT, TALL), drawn)
    for column, engine in enumerate(engines):
        own = [found for found in drawn if found.engine == engine]
        left = LEFT + column * (wide + GAP)
        _depth_panel(layout.axes(left, BOTTOM + LOW + BETWEEN, wide, LOW), own)
        _onset_panel(layout.axes(left, BOTTOM, wide, LOW), own)
    handles = [Line2D([], [], label="exact", **EXACT), *preset_handles((f.engine, f.preset) for f in drawn)]
    layout.legend(handles, len(handles), handlelength=3.0)
    return layout.figure


def _flight_panel(axes: Axes, drawn: Sequence[FollowerFloat]) -> None:
    exact = _exact(drawn)
    span = float(exact[:, 1].max())
    axes.plot(on_grid(exact[:, 0], 360.0), on_grid(exact[:, 1], span), **EXACT)
    for place, found in enumerate(drawn):
        angle, gap, _, _ = _shown(found)
        phase = round(MARKER_SPACING * place / len(drawn))
        style = preset_style(found.engine, found.preset) | {"linewidth": 0.8}
        axes.plot(on_grid(angle, 360.0), on_grid(1e3 * gap, span), markevery=(phase, MARKER_SPACING), **style)
    axes.set_xlim(exact[0, 0] - BESIDE, exact[-1, 0] + 2.0 * BESIDE)
    axes.set_xlabel("crank angle (deg)")
    axes.set_ylabel("gap (mm)")
    curve = _curve(drawn[0])
    axes.set_title(
        f"In flight: {curve.speed:g} times the float speed, {curve.steps_per_revolution} steps a revolution", loc="left"
    )


def _depth_panel(axes: Axes, own: Sequence[FollowerFloat]) -> None:
    """Lines upwards of what the gap is, dots of how deep the follower sinks in."""
    exact = _exact(own)
    axes.plot(on_grid(exact[:, 0], 360.0), on_log_grid(np.maximum(1e-3 * exact[:, 1], LEAST)), **SHARE_OF_EXACT)
    for found in own:
        angle, _, least, most = _shown(found)
        style = preset_style(found.engine, found.preset) | {"marker": "none", "linewidth": 1.0}
        axes.plot(on_grid(angle, 360.0), on_log_grid(np.where(most > LEAST, most, np.nan)), **style)
        dots = preset_style(found.engine, found.preset) | {"linestyle": "none", "markersize": 1.8, "alpha": 0.6}
        depth = np.where(least < -LEAST, -least, np.nan)
        axes.plot(on_grid(angle, 360.0)[::2], on_log_grid(depth)[::2], **dots)
        line = {"color": "#555555", "linestyle": style["linestyle"], "linewidth": 0.9}
        axes.axhline(float(on_log_grid(np.array([_curve(found).threshold]))[0]), **line)
    highest = on_log_grid(np.array([max(_curve(found).threshold for found in own)]))[0]
    place = (0.01, 1.5 * highest)
    edge_note(axes, "10 x static penetration", place, xycoords=("axes fraction", "data"), va="bottom")
    axes.set_yscale("log")
    axes.set_ylim(LEAST, MOST)
    axes.minorticks_off()
    axes.set_xlim(0.0, 360.0)
    axes.set_xticks(range(0, 361, 60))
    axes.set_xlabel("crank angle (deg)")
    axes.set_ylabel("gap, penetration (m)")
    axes.set_title(f"{engine_title(own[0].engine)}: gap (line) and penetration (dots)", loc="left")


def _onset_panel(axes: Axes, own: Sequence[FollowerFloat]) -> None:
    exact = np.array(own[0].exact_lengths)
    axes.plot(on_grid(exact[:, 0], 1.0), on_log_grid(np.degrees(exact[:, 1])), **SHARE_OF_EXACT)
    axes.axvline(1.0, color="#333333", linewidth=1.0)
    axes.annotate("theory ", (1.0, 0.93), xycoords=("data", "axes fraction"), ha="right", fontsize=7.5, color="#333333")
    for found in own:
        shown = [p for p in found.probes if SPEEDS[0] <= p.speed <= SPEEDS[1]]
        for finer in (0, 1):
            _plot_lengths(axes, found, shown, finer)
    axes.set_yscale("log")
    axes.set_xlim(*SPEEDS)
    axes.set_ylim(0.6 * NONE, LENGTHS[1])
    axes.set_yticks([NONE, 0.1, 1.0, 10.0, 100.0], ["none", "0.1", "1", "10", "100"])
    axes.minorticks_off()
    axes.set_xlabel("crank speed over the float speed")
    axes.set_ylabel("longest flight (deg)")
    axes.set_title(f"{engine_title(own[0].engine)}: flights with h (open) and h/2 (filled)", loc="left")


def _plot_lengths(axes: Axes, found: FollowerFloat, probes: Sequence[OnsetProbe], finer: int) -> None:
    run = [(p.speed, length) for p in probes if (length := p.lengths[finer]) is not None]
    speeds = on_grid(np.array([speed for speed, _ in run]), 1.0)
    lengths = np.maximum(np.degrees([length for _, length in run]), NONE)
    hue = colour(found.engine)
    style = preset_style(found.engine, found.preset) | {"linestyle": "none", "markersize": 4.0}
    axes.plot(speeds, on_log_grid(lengths), **(style | {"markerfacecolor": hue if finer else "none"}))


def _exact(drawn: Sequence[FollowerFloat]) -> Array:
    """Crank angle [deg] and gap [mm] of the exact flight; (T, 2)."""
    exact = np.array(_curve(drawn[0]).exact)
    return np.column_stack([np.degrees(exact[:, 0]), 1e3 * exact[:, 1]])


def _shown(found: FollowerFloat) -> tuple[Array, Array, Array, Array]:
    """Crank angle [deg], gap there, least and largest gap around it [m]."""
    gaps = np.array(_curve(found).gaps)
    return np.degrees(gaps[:, 0]), gaps[:, 1], gaps[:, 2], gaps[:, 3]


def _curve(found: FollowerFloat) -> GapCurve:
    assert found.curve is not None
    return found.curve


# -- tables ------------------------------------------------------------------------------------------------------------


def onset_table(floats: Iterable[FollowerFloat]) -> Table:
    """Return a row for each engine and preset: the speed at which the follower lets go, over the theory's."""
    head = (*WHO, "steps per revolution", "penetration (mm)", "onset / theory", "off")
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
    head = (*WHO, "speed / float speed", "steps per revolution", "ended", "exact gap (mm)", "measured, off by")
    rows = [(*who(found), *_flight(flight)) for found in floats for flight in found.flights]
    return table((*head, "exact landing (deg)", "measured minus exact"), rows)


def _flight(flight: ComparedFlight) -> tuple[str, ...]:
    exact, off = flight.exact, flight.landing_error
    return (
        numbers.quantity(flight.speed),
        str(flight.steps_per_revolution),
        flight.outcome,
        numbers.MISSING if exact is None else numbers.quantity(1e3 * exact.gap),
        _share(flight.gap_error),
        numbers.MISSING if exact is None else f"{math.degrees(exact.landing):.2f}",
        numbers.MISSING if off is None else f"{math.degrees(off):+.3f} deg",
    )


def _ratio(value: float | None) -> str:
    return numbers.MISSING if value is None else f"{value:.4f}"


def _share(value: float | None) -> str:
    return numbers.MISSING if value is None else f"{100.0 * value:+.2f} %"
