"""Places of a figure that say what is there: to the pointer, and by a slider to the keyboard."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence

from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure

PHRASE = re.compile(r".+?(?:[,:;] |position |velocity |acceleration |$)", re.DOTALL)
Spot = tuple[float, float, str]  # parts of the figure's width and height from its upper left corner, and the words


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
    """A figure's markup with its spots, from left to right."""
    texts = list(dict.fromkeys(text for *_, text in spots))
    number = {text: k for k, text in enumerate(texts)}
    places = [(x, y, number[text]) for x, y, text in sorted(spots)]
    # Thousands of texts that say much the same: each is the numbers of its phrases.
    phrases = {phrase: k for k, phrase in enumerate(dict.fromkeys(p for text in texts for p in PHRASE.findall(text)))}
    told = [[phrases[phrase] for phrase in PHRASE.findall(text)] for text in texts]
    given = {"phrases": list(phrases), "words": told, "places": places}
    data = json.dumps(given, separators=(",", ":")).replace("<", "\\u003c")
    return str(
        Markup('<span class="spots">{}<script type="application/json">{}</script></span>').format(
            Markup(figure), Markup(data)
        )
    )
