"""The figures of a linkage at a crank angle: instant centres, velocity and acceleration polygons, drawn to scale."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from conrod.exact.linkage import InstantQuantities
from conrod.exact.linkage.polygon import Kind, Polygon
from conrod.report import numbers
from conrod.report.charts.canvas import drawing_style, svg_text
from conrod.report.drawing import machine_parts as parts
from conrod.report.linkage.mechanism_figure import centres_figure
from conrod.report.linkage.sheet import Sheet, mathematical
from conrod.studies.frame.files import Batch

FIGURES = ("centres.svg", "velocities.svg", "accelerations.svg")
UNITS = {"velocity": "m/s", "acceleration": "m/s²"}
# Okabe and Ito's colours, separate to colour-blind readers.
COLOURS: dict[Kind, str] = {
    "absolute": "#222222",
    "relative": "#0072B2",
    "normal": "#0072B2",
    "tangential": "#D55E00",
    "coriolis": "#CC3399",
    "sliding": "#009E73",
}
# A vector that is shorter than this share of the longest is a dot on paper.
TOO_SHORT = 4e-3
SAME = 1.5  # how near [pt] points share a mark


def figures_batch(instant: InstantQuantities, folder: Path) -> Batch:
    """The mechanism with its instant centres and the two polygons, in a folder of their own."""
    with drawing_style():
        polygons = [polygon_figure(polygon) for polygon in (instant.velocities, instant.accelerations)]
        drawn = [svg_text(figure) for figure in (centres_figure(instant.state), *polygons)]
    return Batch(folder, dict(zip(FIGURES, drawn, strict=True)))


def polygon_figure(polygon: Polygon) -> Figure:
    """The vectors from the pole O, a scale bar, and their sizes beside."""
    unit, places = UNITS[polygon.quantity], polygon.places
    sheet = Sheet(np.array(list(places.values())), len(polygon.vectors) + 2)
    sheet.scale_bar(unit)
    drawn = [v for v in polygon.vectors if float(np.linalg.norm(v.value)) > TOO_SHORT * polygon.size]
    for vector in drawn:
        start = sheet.at(places[vector.start])
        stop = start + sheet.scale * vector.value
        parts.arrow(sheet.axes, np.round(start, 2), np.round(stop, 2), COLOURS[vector.kind], width=1.3)
        sheet.labels.draw(np.array([start, stop]))
    corners = {end for vector in polygon.vectors for end in (vector.start, vector.stop)}
    for name, place in places.items():
        point = sheet.at(place)
        sheet.labels.mark(point, 2.0)
        if name in corners and not name.endswith("'"):
            sheet.axes.plot(*point, marker="o", markersize=4.0, color=parts.INK, zorder=12)
            near = [other for other, there in places.items() if np.linalg.norm(sheet.at(there) - point) < SAME]
            here = [other for other in near if not other.endswith("'")]
            if name == here[0]:
                sheet.label(point, ", ".join(here), parts.INK)
    for vector in drawn:
        start = sheet.at(places[vector.start])
        along = vector.value / np.linalg.norm(vector.value)
        middles = start + sheet.scale * np.outer([0.5, 0.35, 0.65, 0.2, 0.8], vector.value)
        sheet.label(middles, mathematical(vector.name), COLOURS[vector.kind], np.array([along[1], -along[0]]))
    rows = []
    for vector in polygon.vectors:
        size = float(np.linalg.norm(vector.value))
        # Below rounding of the longest the digits would differ from machine to machine.
        shown = "0" if size <= 1e-9 * polygon.size else numbers.quantity(size)
        rows.append((mathematical(vector.name), shown if vector.link is None else f"{shown}   link {vector.link}"))
    sheet.column(f"{polygon.quantity.capitalize()} polygon [{unit}]", rows)
    return sheet.finished()
