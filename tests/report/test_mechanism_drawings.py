"""Drawings of machines of all kinds: what hangs together is drawn so, and texts stand clear of each other."""

from __future__ import annotations

import pathlib
import re
from itertools import permutations

import matplotlib
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.path import Path
from matplotlib.transforms import Affine2D

from conrod.mechanism.mechanism import pin_points
from conrod.report.charts.canvas import drawing_style
from conrod.report.drawing import machine_parts as parts
from conrod.report.drawing.drawing import crank_direction, mechanism_figure, mechanism_svg, telling_angle, view_at
from conrod.report.html.parts import drawing_of
from conrod.scenes import SCENES, catalogue_names, catalogue_scene, scene_named

FIGURES = pathlib.Path(__file__).parents[2] / "reports" / "figures"
CROWDED = ("geneva", "jansen-leg", "planetary-gear", "peaucellier", "six-bar", "two-slider-linkage")


@pytest.mark.parametrize("name", [*SCENES, *catalogue_names()])
def test_every_body_has_shapes_that_move_with_it(name: str) -> None:
    bodies = drawing_of(scene_named(name)).bodies
    assert [body for body, drawn in bodies.items() if "<path" not in drawn and "<circle" not in drawn] == []


def test_a_slot_lies_under_the_block_in_it() -> None:
    names = [body.name for body in catalogue_scene("geneva").mechanism().bodies]
    drawn = [names[k] for k in drawing_of(catalogue_scene("geneva")).order]
    assert sorted(drawn) == sorted(names)
    assert drawn.index("wheel") < drawn.index("follower")


def test_a_moving_figure_shows_the_links_of_the_committed_run() -> None:
    moving = (FIGURES / "saw-500rpm-moving.svg").read_text(encoding="utf-8")
    drawn = drawing_of(SCENES["saw-500rpm"]).bodies
    assert [body for body, shapes in drawn.items() if shapes not in moving] == []


@pytest.mark.parametrize("name", ["six-bar", "saw-500rpm"])
def test_angle_of_the_crank_is_drawn_along_the_crank(name: str) -> None:
    scene = scene_named(name)
    with drawing_style():
        view = view_at(scene, telling_angle(scene))
    shaft, pin = (view.place_of(view.mechanism.crank, at) for at in pin_points(view.mechanism, view.mechanism.crank))
    along = crank_direction(view, shaft, telling_angle(scene))
    assert np.linalg.norm(pin - shaft) * parts.unit_vector(along) == pytest.approx(pin - shaft)
    # The frame of the six-bar's crank is turned against it: its rotation is another angle.
    turned = parts.unit_vector(view.mechanism.crank_turn(telling_angle(scene)))
    assert (np.abs(turned - parts.unit_vector(along)).max() > 0.1) == (name == "six-bar")


@pytest.mark.parametrize(("scene", "body", "discs", "slots"), [("geneva", "wheel", 1, 4), ("whitworth", "lever", 0, 1)])
def test_wheel_is_a_disc_with_all_the_slots_it_needs(scene: str, body: str, discs: int, slots: int) -> None:
    drawn = drawing_of(scene_named(scene)).bodies[body]
    outlines = re.findall(r'<path d="([^"]*)" fill="var\(--ground\)" stroke="currentColor"', drawn)
    assert "".join(outlines).count("M") == slots
    assert drawn.count('fill="var(--part)" stroke="currentColor"') == discs


@pytest.mark.parametrize("name", ["saw-500rpm", "shear-press"])
def test_name_of_a_slider_stands_clear_of_hatched_rails(name: str) -> None:
    with drawing_style():
        axes = mechanism_figure(scene_named(name)).axes[0]
        (label,) = (text for text in axes.texts if text.get_text() in ("A", "C"))
        renderer = FigureCanvasAgg(label.figure).get_renderer()  # type: ignore[arg-type]  # of the library
        label.set_bbox(None)
        box = label.get_window_extent(renderer)
        hatching = [line for line in axes.lines if line.get_color() == parts.FRAME]
        paths = [line.get_path().transformed(line.get_transform()) for line in hatching]
    assert len(paths) > 20
    assert not any(path.intersects_bbox(box, filled=False) for path in paths)
    # Negative control: there is hatching about the block.
    assert any(path.intersects_bbox(box.expanded(6.0, 6.0), filled=False) for path in paths)


# -- texts -----------------------------------------------------------------------------------------------------------

LETTERS, MIDDLE = (
    Path.unit_rectangle().transformed(Affine2D().translate(-0.5, -0.5).scale(0.9)),
    [[-0.48, 0], [0.48, 0]],
)


def overlaps(drawn: Figure) -> list[set[str]]:
    """Texts of which one has its middle line within the letters of the other."""
    renderer = FigureCanvasAgg(drawn).get_renderer()  # type: ignore[no-untyped-call]  # of the library
    shapes = []
    for text in (text for text in drawn.axes[0].texts if text.get_text()):
        turned = text.get_rotation()
        text.set(rotation=0.0, bbox=None)
        box = text.get_window_extent(renderer)
        text.set_rotation(turned)
        centre = 0.5 * (box.min + box.max)
        place = Affine2D().scale(box.width, box.height).rotate_deg(turned).translate(*centre)
        shapes.append((text.get_text(), LETTERS.transformed(place), Path(MIDDLE).transformed(place)))
    return [{a[0], b[0]} for a, b in permutations(shapes, 2) if a[1].intersects_path(b[2])]


@pytest.mark.parametrize("name", [*CROWDED[:2], *(pytest.param(name, marks=pytest.mark.slow) for name in CROWDED[2:])])
def test_texts_of_a_drawing_stand_clear_of_each_other(name: str) -> None:
    with drawing_style():
        drawn = mechanism_figure(catalogue_scene(name))
        assert overlaps(drawn) == []
        # Negative control of the look at overlaps.
        at = np.array(drawn.axes[0].texts[0].get_position())
        parts.draw_note(drawn.axes[0], at, "one", parts.INK)
        parts.draw_note(drawn.axes[0], at, "other", parts.INK, 30.0)
    assert {"one", "other"} in overlaps(drawn)


@pytest.mark.parametrize("name", ["cam-follower", "saw-40rpm"])
def test_drawings_equal_committed_ones_under_any_rc_settings(name: str) -> None:
    committed = (FIGURES / f"{name}-mechanism.svg").read_text(encoding="utf-8")
    with matplotlib.rc_context({"font.size": 31.0, "svg.fonttype": "none", "axes.grid": False}):
        assert mechanism_svg(SCENES[name]) == committed
