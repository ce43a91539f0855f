"""Names, colours, lines and marks of engines, presets and outcomes; no drawing library is loaded."""

from __future__ import annotations

from operator import attrgetter
from typing import Any

from conrod.comparison.trajectory import Outcome
from conrod.engines import ENGINES, PLUGIN_COLOURS, engine_style, line_style
from conrod.execution.result import JudgedResult

CURVE_COLOURS = (*map(attrgetter("colour"), ENGINES.values()), *PLUGIN_COLOURS)  # of curves that belong to no engine

# Dashes and gaps of matplotlib's named lines, in line widths, as in its `lines.*_pattern`.
NAMED_DASHES: dict[str, tuple[float, ...]] = {"-": (), "--": (3.7, 1.6), "-.": (6.4, 1.6, 1.0, 1.6), ":": (1.0, 1.65)}
DASH_UNIT = 1.5  # line width of curves in a page, in SVG units

# Marker of each outcome.
OUTCOME_MARKS = {
    Outcome.DIVERGED.slug: "x",
    Outcome.EXPLODED.slug: "*",
    Outcome.RESET.slug: "P",
    Outcome.FLIPPED.slug: ">",
    Outcome.LOCKED.slug: "s",
    Outcome.OPENED.slug: "v",
    Outcome.LOST_CONTACT.slug: "^",
    Outcome.TUNNELLED.slug: "D",
    Outcome.STALLED.slug: "d",
    Outcome.CRASHED.slug: "X",
    Outcome.TIMED_OUT.slug: "h",
    Outcome.OUT_OF_MEMORY.slug: "p",
    Outcome.UNSUPPORTED.slug: "+",
}


def engine_title(engine: str) -> str:
    """Return an engine's name as its makers write it."""
    return engine_style(engine).title


def preset_title(engine: str, preset: str | None) -> str:
    """Return engine and preset as a legend's text."""
    return f"{engine_title(engine)} {preset or ''}".strip()


def label(result: JudgedResult) -> str:
    """Return engine and preset of a result as a legend's text."""
    return preset_title(result.engine, result.preset)


def colour(engine: str) -> str:
    """Return the colour of an engine."""
    return engine_style(engine).colour


def curve_style(result: JudgedResult) -> dict[str, Any]:
    """Return arguments of `Axes.plot` for a result's curve."""
    return preset_style(result.engine, result.preset)


def svg_stroke(engine: str, name: str | None) -> str:
    """Return SVG attributes for the curve of an engine's preset: colour and dashes of `preset_style`."""
    line = line_style(engine, name).line
    dashes = NAMED_DASHES[line] if isinstance(line, str) else line[1]
    pattern = " ".join(f"{DASH_UNIT * one:g}" for one in dashes)
    return f'stroke="{colour(engine)}"' + (f' stroke-dasharray="{pattern}"' if pattern else "")


def preset_style(engine: str, name: str | None) -> dict[str, Any]:
    """Return arguments of `Axes.plot` for the curve of an engine's preset."""
    preset = line_style(engine, name)
    hue = colour(engine)
    return {
        "color": hue,
        "linestyle": preset.line,
        "linewidth": 1.2,
        "marker": preset.marker,
        "markersize": preset.size,
        "markerfacecolor": hue if preset.filled else "none",
        "markeredgewidth": 1.0,
        "zorder": preset.above,
    }
