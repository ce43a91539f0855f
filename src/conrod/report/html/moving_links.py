"""A user's model in motion as HTML: its links over the exact ones, with magnified difference, and curves of that."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from markupsafe import Markup, escape

from conrod.exact.motion import Array
from conrod.report import numbers
from conrod.report.charts.styles import svg_stroke
from conrod.report.drawing.moving_links import DISC, GEOM, PIN, LinkShape, MovingLinks
from conrod.report.html.page import html_template
from conrod.report.html.panels import PanelCurve, panel_svg
from conrod.report.html.parts import points_text, svg_number

ENGINE = "mujoco"
VISIBLE_SHARE = 0.06  # of the picture's larger side: greatest size of a magnified difference
MAX_POWER = 12
PIN_RADIUS, SMALL_PIN, MANY = 7.0, 4.0, 60  # [drawing units], and shapes from which on pins are small
LABEL_OFFSET = 12.0  # of a name from its point [drawing units]; links.js knows it too
STILL_SHARE = 1.0 / 6.0  # of a run, at which the picture begins, and stands still where nothing moves
TIME = ("the time in seconds", "s")


def links_html(drawn: MovingLinks | None, anchor: str, title: str) -> str:
    """Return the HTML of moving links with controls and curves; empty if nothing is drawn.

    Args:
        anchor: prefix of the ids of its elements.
        title: name of the model.
    """
    if drawn is None or not all(len(run.rows) for run in drawn.runs):
        return ""
    power, first = magnifying_power(drawn), drawn.runs[0]
    rows = drawn.exact if drawn.has_exact else first.rows
    frame = round(STILL_SHARE * (len(rows) - 1))
    begin, found = rows[frame], first.rows[min(frame, len(first.rows) - 1)]
    moved = begin + 10.0**power * found if drawn.has_exact else begin
    below, above = (
        [shape for shape in drawn.ground if (shape.kind == PIN) is pinned] for pinned in (False, True)
    )  # fmt: skip
    still = drawn.ground_points.ravel()
    return html_template("links.html.jinja").render(
        anchor=anchor, title=title, drawn=drawn, power=power, powers=range(MAX_POWER + 1),
        magnification=numbers.magnification, box=" ".join(f"{one:g}" for one in drawn.box),
        below=_shapes(below, still), above=_shapes(above, still),
        layers=[*([("ghost", _shapes(drawn.shapes, begin))] if drawn.has_exact else []),
                ("engine", _shapes(drawn.shapes, moved))],
        labels=[(k, name, *_label_place(drawn, begin[2 * k : 2 * k + 2])) for k, name in drawn.labels],
        runs=[(_run_title(drawn, k), _legend_sample(drawn, k)) for k in range(len(drawn.runs))],
        still=round(360 * STILL_SHARE), panel=_error_panel(drawn),
        data=Markup(json.dumps(_script_data(drawn, power), separators=(",", ":"))),
    )  # fmt: skip


def magnifying_power(drawn: MovingLinks) -> int:
    """Return the power of ten that makes the largest difference of all runs that went to their end visible."""
    if not drawn.has_exact:
        return 0
    ended = [run.rows for run in drawn.runs if not run.ended and run.rows.size] or [run.rows for run in drawn.runs]
    largest = max((float(np.abs(rows).max(initial=0.0)) for rows in ended), default=0.0)
    size = VISIBLE_SHARE * max(drawn.box[2:])
    return int(np.clip(math.floor(math.log10(size / largest)), 0, MAX_POWER)) if largest else 0


def _label_place(drawn: MovingLinks, place: Array) -> tuple[str, str, str]:
    """Return where a point's name stands, and which of its ends is there: it must not leave the picture."""
    left, _, width, _ = drawn.box
    right = bool(place[0] > left + 0.75 * width)
    x = place[0] + (-LABEL_OFFSET if right else LABEL_OFFSET)
    return svg_number(x), svg_number(place[1] - LABEL_OFFSET), "end" if right else "start"


def _run_title(drawn: MovingLinks, number: int) -> str:
    run = drawn.runs[number]
    off = f": up to {numbers.measured_text(max(run.off))} mm off" if run.off and not run.ended else ""
    return f"{run.name}{off}{f': {run.ended}' if run.ended else ''}"


def _script_data(drawn: MovingLinks, power: int) -> dict[str, Any]:
    """Return the numbers by which the page's script moves the picture."""
    return {
        "power": power,
        "exact": drawn.exact.tolist() if drawn.has_exact else [],
        "frames": max(len(run.rows) for run in drawn.runs),
        "runs": [{"seconds": run.seconds, "rows": run.rows.tolist(), "off": run.off} for run in drawn.runs],
    }


def _shapes(shapes: Sequence[LinkShape], row: Array) -> Markup:
    """Draw shapes as SVG at the places (2 P,) of the points."""
    pin = PIN_RADIUS if len(shapes) < MANY else SMALL_PIN
    return Markup("").join(_shape(shape, row.reshape(-1, 2), pin) for shape in shapes)


def _shape(shape: LinkShape, places: Array, pin: float) -> Markup:
    name, at = escape(shape.link), ",".join(map(str, shape.points))
    if shape.kind in (PIN, DISC):
        x, y = map(svg_number, places[shape.points[0]])
        radius = svg_number(0.5 * shape.width if shape.kind == DISC else pin)
        return Markup('<circle class="{}" data-at="{}" cx="{}" cy="{}" r="{}"><title>{}</title></circle>').format(
            shape.kind, at, x, y, radius, name
        )
    end = "Z" if len(shape.points) > 2 else ""
    width = Markup(' stroke-width="{}"').format(svg_number(shape.width)) if shape.kind == GEOM else ""
    path = f"M{points_text(places[list(shape.points)])}{end}"
    return Markup('<path class="{}" data-at="{}" d="{}"{}><title>{}</title></path>').format(
        shape.kind, at, path, width, name
    )


def _legend_sample(drawn: MovingLinks, number: int) -> Markup:
    stroke = svg_stroke(ENGINE, drawn.runs[number].preset)
    return Markup(f'<svg viewBox="0 0 30 8" aria-hidden="true"><path d="M0 4H30" {stroke}/></svg>')


def _error_panel(drawn: MovingLinks) -> Markup:
    """Draw how far the judged points are off against the time; empty without an exact motion."""
    curves = list[PanelCurve]()
    for number, run in enumerate(drawn.runs):
        along = np.arange(len(run.off)) / max(1, len(drawn.exact) - 1)
        if len(run.off) > 1:
            curves.append(PanelCurve(along, np.array(run.off), number, svg_stroke(ENGINE, run.preset)))
    if not drawn.has_exact or not curves:
        return Markup("")
    seconds = max(run.seconds for run in drawn.runs)
    return panel_svg("judged points: off by [mm]", curves, (0.0, seconds), STILL_SHARE, log=True, axis=TIME)
