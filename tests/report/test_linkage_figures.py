"""Figures of linkages: all vectors and centres are there, labels stand clear, files are the same each time."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest
from catalogue import SCENES
from drawn_texts import overlaps
from linkages import RPM, example_4_10, example_5_6, example_6_15, inverted_slider_crank, slider_crank
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch

from conrod.exact.kinematics import Kinematics
from conrod.exact.linkage.centres import instant_centres
from conrod.exact.linkage.polygon import Polygon, acceleration_polygon, velocity_polygon
from conrod.exact.linkage.state import LinkageState, linkage_state
from conrod.report.charts.canvas import drawing_style
from conrod.report.linkage.figures import Sheet, centres_figure, mathematical, polygon_figure

STATES = {
    "example 4.10": lambda: linkage_state(Kinematics(example_4_10()), 0.0, 104.72),
    "example 5.6": lambda: linkage_state(Kinematics(example_5_6()), 0.0, 60.0),
    "example 6.15": lambda: linkage_state(Kinematics(example_6_15()), 0.0, -600.0 * RPM),
    "inverted": lambda: linkage_state(Kinematics(inverted_slider_crank(0.1, 0.25)), 0.3, 12.0),
    "slider-crank": lambda: linkage_state(Kinematics(slider_crank(0.3, 0.56)), 0.5, 30.0, 200.0),
    "cam": lambda: linkage_state(SCENES["cam-follower"].kinematics, 2.6, 5.0),
}


# The largest, a slide on a turning link, a cam.
QUICK = ("example 6.15", "inverted", "cam")


@pytest.fixture(
    scope="module",
    params=[name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in STATES],
)
def state(request: pytest.FixtureRequest) -> LinkageState:
    return STATES[request.param]()


def texts(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.axes[0].texts]


def within(figure: Figure) -> bool:
    """Whether all text is on the paper."""
    renderer = FigureCanvasAgg(figure).get_renderer()
    boxes = [t.get_window_extent(renderer) for t in figure.axes[0].texts if t.get_text()]
    width, height = figure.bbox.width, figure.bbox.height
    return all(b.x0 >= 0.0 and b.y0 >= 0.0 and b.x1 <= width and b.y1 <= height for b in boxes)


@pytest.fixture(scope="module")
def centres(state: LinkageState) -> Figure:
    with drawing_style():
        return centres_figure(state)


@pytest.fixture(scope="module")
def polygons(state: LinkageState) -> list[tuple[Polygon, Figure]]:
    with drawing_style():
        return [
            (polygon, polygon_figure(polygon)) for polygon in (velocity_polygon(state), acceleration_polygon(state))
        ]


def test_labels_stand_clear_of_each_other_and_on_the_paper(
    centres: Figure, polygons: list[tuple[Polygon, Figure]]
) -> None:
    with drawing_style():
        for figure in (centres, *(figure for _, figure in polygons)):
            assert overlaps(figure, 0.9) == []
            assert within(figure)


def test_labels_that_have_no_room_are_told() -> None:
    # Negative control of the look at overlaps.
    with drawing_style():
        sheet = Sheet(np.array([[0.0, 0.0], [1.0, 1.0]]))
        for text in ("first", "second"):
            sheet.axes.text(100.0, 100.0, text)
        assert overlaps(sheet.finished(), 0.9) == [("first", "second")]


def test_every_vector_is_named_and_drawn_to_scale(polygons: list[tuple[Polygon, Figure]]) -> None:
    for polygon, figure in polygons:
        written = texts(figure)
        for vector in polygon.vectors:
            if math.hypot(*vector.value) > 0.01 * polygon.size:
                assert mathematical(vector.name) in written
        dots = [np.ravel(line.get_xydata()) for line in figure.axes[0].lines if line.get_marker() == "o"]
        wide = max(math.dist(a, b) for a, b in combinations(dots, 2))
        points = [place for name, place in polygon.places.items() if not name.endswith("'")]
        scale = wide / max(math.dist(a, b) for a, b in combinations(points, 2))
        arrows = [patch for patch in figure.axes[0].patches if isinstance(patch, FancyArrowPatch)]
        # A head's tip stands out by less than a line's width.
        lengths = [max(math.dist(end, other) for end, other in combinations(corners(a), 2)) for a in arrows]
        assert max(lengths) == pytest.approx(scale * polygon.size, abs=1.5)
        bar = next(text for text in written if text.endswith(("m/s", "m/s²")) and text[0].isdigit())
        assert lengths[0] == pytest.approx(scale * float(bar.split()[0]), abs=1.5)


def corners(arrow: FancyArrowPatch) -> list[tuple[float, float]]:
    path = arrow.get_path()
    codes = path.codes if path.codes is not None else []
    # The vertex that closes an outline is no place.
    return [(float(x), float(y)) for (x, y), code in zip(path.vertices, codes, strict=True) if code != path.CLOSEPOLY]


def test_the_centres_of_all_pins_are_marked(state: LinkageState, centres: Figure) -> None:
    written = " ".join(texts(centres))
    for centre in instant_centres(state):
        if centre.place is not None and centre.kind in {"fixed", "permanent"}:
            assert mathematical(centre.name) in written
