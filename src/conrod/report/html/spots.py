"""Places of a figure that say what is there: to the pointer, and by a slider to the keyboard."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Iterable, Sequence
from itertools import zip_longest

from matplotlib.axes import Axes
from matplotlib.figure import Figure

# Parts of the figure's width and height from its upper left corner, and the words; further lines are to be copied.
Spot = tuple[float, float, str]


def spots_in(figure: Figure, axes: Axes, places: Iterable[Spot]) -> list[Spot]:
    """Spots from places in the units of some axes; those outside of these are left out."""
    width, height = figure.bbox.width, figure.bbox.height
    found = []
    for x, y, words in places:
        across, up = axes.transData.transform((x, y))
        if axes.bbox.contains(across, up):
            found.append((round(across / width, 4), round(1.0 - up / height, 4), words))
    return found


def with_spots(figure: str, spots: Sequence[Spot]) -> str:
    """A figure's markup with its spots, from left to right: lists of places and of words between commas, compressed."""
    columns = list(zip_longest(*((x, y, *words.split(", ")) for x, y, words in sorted(spots))))
    data = base64.b64encode(zlib.compress(json.dumps(columns, separators=(",", ":")).encode(), 9)).decode()
    return f'<span class="spots">{figure}<script type="application/octet-stream">{data}</script></span>'
