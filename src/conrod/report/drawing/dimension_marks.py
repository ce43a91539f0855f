"""The dimensions on a drawing, each on that side of its link, and at that distance, where its text has room."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from conrod.exact.motion import Array
from conrod.report.drawing import machine_parts as parts
from conrod.report.drawing.dimensions import Length, dimensions
from conrod.report.drawing.view import MM, View

# Of the usual distance of a dimension line from its link; negative on the other side.
DISTANCES = (1.0, -1.0, 1.8, -1.8, 2.6, -2.6)
ALONG = (0.5, 0.35, 0.65)  # where a text may stand on its line


def draw_dimensions(view: View) -> None:
    """Lengths of links and offsets, and radii of cams."""
    for dimension in dimensions(view.mechanism, view.poses):
        if isinstance(dimension, Length):
            start, stop = MM * np.array(dimension.start), MM * np.array(dimension.stop)
            if np.linalg.norm(stop - start) > 1e-6 * view.extent:
                _length(view, dimension, start, stop)
        else:
            parts.radius_line(view.axes, dimension, MM * np.array(dimension.centre), MM * dimension.radius)


def _length(view: View, dimension: Length, start: Array, stop: Array) -> None:
    wishes = [
        replace(dimension, aside=distance * dimension.aside, text_at=along) for distance in DISTANCES for along in ALONG
    ]
    places = []
    for wish in wishes:
        centre, turned = parts.length_text(wish, start, stop, view.extent)
        box = view.labels.box(centre, wish.text, parts.TEXT["fontsize"], turned)
        places.append((box, parts.length_lines(wish, start, stop, view.extent)))
    best = view.labels.best(places)
    box, lines = places[best]
    view.labels.take(box)
    for line in lines:
        view.labels.draw(line)
    parts.length_line(view.axes, wishes[best], start, stop, view.extent)
