"""A velocity or acceleration polygon, drawn to scale as a course draws it."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from conrod.exact.linkage.polygon import Kind, Polygon, PolygonVector
from conrod.exact.motion import Array
from conrod.report import numbers
from conrod.report.drawing import machine_parts as parts
from conrod.report.linkage.sheet import Sheet, mathematical

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


def polygon_figure(polygon: Polygon) -> Figure:
    """The vectors from the pole O, a scale bar, and their sizes beside."""
    unit = UNITS[polygon.quantity]
    sheet = Sheet(np.array(list(polygon.places.values())), len(polygon.vectors) + 2)
    sheet.scale_bar(unit)
    drawn = [v for v in polygon.vectors if float(np.linalg.norm(v.value)) > TOO_SHORT * polygon.size]
    for vector in drawn:
        _vector(sheet, polygon, vector)
    corners = {end for vector in polygon.vectors for end in (vector.start, vector.stop)}
    for name, place in polygon.places.items():
        point = sheet.at(place)
        sheet.labels.mark(point, 2.0)
        if name in corners and not name.endswith("'"):
            sheet.axes.plot(*point, marker="o", markersize=4.0, color=parts.INK, zorder=12)
            here = [other for other, there in polygon.places.items() if _same(sheet, place, there) and other[-1] != "'"]
            if name == here[0]:
                sheet.label(point, ", ".join(here), parts.INK)
    for vector in drawn:
        start = sheet.at(polygon.places[vector.start])
        along = vector.value / np.linalg.norm(vector.value)
        middles = start + sheet.scale * np.outer([0.5, 0.35, 0.65, 0.2, 0.8], vector.value)
        sheet.label(middles, mathematical(vector.name), COLOURS[vector.kind], np.array([along[1], -along[0]]))
    rows = [(mathematical(v.name), _size(v, polygon)) for v in polygon.vectors]
    sheet.column(f"{polygon.quantity.capitalize()} polygon [{unit}]", rows)
    return sheet.finished()


def _vector(sheet: Sheet, polygon: Polygon, vector: PolygonVector) -> None:
    start = sheet.at(polygon.places[vector.start])
    stop = start + sheet.scale * vector.value
    colour = COLOURS[vector.kind]
    parts.arrow(sheet.axes, np.round(start, 2), np.round(stop, 2), colour, width=1.3)
    sheet.labels.draw(np.array([start, stop]))


def _same(sheet: Sheet, one: Array, other: Array) -> bool:
    return float(np.linalg.norm(sheet.at(one) - sheet.at(other))) < 1.5


def _size(vector: PolygonVector, polygon: Polygon) -> str:
    size = float(np.linalg.norm(vector.value))
    # Below rounding of the longest the digits would differ from machine to machine.
    shown = "0" if size <= 1e-9 * polygon.size else numbers.quantity(size)
    return shown if vector.link is None else f"{shown}   link {vector.link}"
