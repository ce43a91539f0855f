"""Drawings of machines of all kinds: what hangs together is drawn so, and texts stand clear of each other."""

from __future__ import annotations

from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from conrod.report.charts.canvas import drawing_style
from conrod.report.drawing import machine_parts as parts
from conrod.report.drawing.drawing import mechanism_figure, mechanism_svg
from conrod.report.html.parts import drawing_of
from conrod.scenes import SCENES, catalogue_names, catalogue_scene, scene_named

FIGURES = Path(__file__).parents[2] / "reports" / "figures"
CROWDED = ("geneva", "jansen-leg", "planetary-gear", "peaucellier", "six-bar", "two-slider-linkage")


@cache
def figure(name: str) -> Figure:
    with drawing_style():
        return mechanism_figure(catalogue_scene(name))


# -- slides ----------------------------------------------------------------------------------------------------------


def overlaps(drawn: Figure, apart: float = 0.45) -> list[tuple[str, str]]:
    """Texts whose letters overlap, tried with points along their middle lines.

    Args:
        apart: so many heights of a text a middle line may come near its own.
    """
    renderer = FigureCanvasAgg(drawn).get_renderer()  # type: ignore[no-untyped-call]  # of the library
    boxes = []
    for text in (text for text in drawn.axes[0].texts if text.get_text()):
        turned = text.get_rotation()
        text.set_rotation(0.0)
        text.set_bbox(None)
        boxes.append((text.get_text(), text.get_window_extent(renderer), np.radians(turned)))
        text.set_rotation(turned)
    return [(a[0], b[0]) for a, b in combinations(boxes, 2) if _touch(a, b, apart) or _touch(b, a, apart)]


def _touch(one: tuple[str, Bbox, float], other: tuple[str, Bbox, float], apart: float) -> bool:
    middles = [np.array([(b.x0 + b.x1) / 2.0, (b.y0 + b.y1) / 2.0]) for b in (one[1], other[1])]
    along = np.array([np.cos(one[2]), np.sin(one[2])])
    points = middles[0] + np.outer(np.linspace(-0.48, 0.48, 60) * one[1].width, along)
    turn = np.array([[np.cos(other[2]), np.sin(other[2])], [-np.sin(other[2]), np.cos(other[2])]])
    inside = np.abs((points - middles[1]) @ turn.T) < np.array([0.45 * other[1].width, apart * other[1].height])
    return bool(inside.all(axis=1).any())


# -- in motion -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [*SCENES, *catalogue_names()])
def test_every_body_takes_what_is_drawn_of_it_along(name: str) -> None:
    bodies = drawing_of(scene_named(name)).bodies
    assert [body for body, drawn in bodies.items() if "<path" not in drawn and "<circle" not in drawn] == []


def test_a_moving_figure_shows_the_links_of_the_committed_run() -> None:
    moving = (FIGURES / "saw-500rpm-moving.svg").read_text(encoding="utf-8")
    drawn = drawing_of(SCENES["saw-500rpm"]).bodies
    assert [body for body, shapes in drawn.items() if shapes not in moving] == []


# -- texts -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [*CROWDED[:2], *(pytest.param(name, marks=pytest.mark.slow) for name in CROWDED[2:])])
def test_texts_of_a_drawing_stand_clear_of_each_other(name: str) -> None:
    assert overlaps(figure(name)) == []


def test_texts_over_each_other_are_told() -> None:
    # Negative control of the look at overlaps.
    with drawing_style():
        drawn = mechanism_figure(catalogue_scene("geneva"))
        at = drawn.axes[0].texts[0].get_position()
        parts.note(drawn.axes[0], np.array(at), "one", parts.INK)
        parts.note(drawn.axes[0], np.array(at), "other", parts.INK, 30.0)
    assert ("one", "other") in overlaps(drawn)


@pytest.mark.parametrize("name", ["cam-follower", "saw-40rpm"])
def test_the_committed_drawings_are_what_the_code_draws(name: str) -> None:
    committed = (FIGURES / f"{name}-mechanism.svg").read_text(encoding="utf-8")
    assert mechanism_svg(SCENES[name]) == committed
