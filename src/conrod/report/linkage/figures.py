"""The figures of a linkage at a crank angle, to scale: its instant centres and its polygons."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from conrod.exact.linkage import InstantQuantities
from conrod.exact.linkage.centres import InstantCentre, instant_centres, joint_centre
from conrod.exact.linkage.points import linkage_points
from conrod.exact.linkage.polygon import Kind, Polygon
from conrod.exact.linkage.state import LinkageState, link_numbers
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Prismatic, pins_of
from conrod.report.charts.canvas import drawing_style, svg_text
from conrod.report.drawing import machine_parts as parts
from conrod.report.drawing.label_placement import LabelPlacement
from conrod.report.drawing.links import draw_joints, draw_links
from conrod.report.drawing.view import View, outline, slide_of
from conrod.studies.frame.writing import Batch

COLOURS = {"fixed": "#222222", "permanent": "#0072B2", "contact": "#009E73", "secondary": "#D55E00"}
# How much of the mechanism's extent is shown on every side of it, for the centres that lie there.
ROOM = 0.6
STEM = 0.18  # of the mechanism's extent that the rails of a cam's follower reach beyond its roller
MM = 1e3
MARGIN = 46.0  # around the drawing [pt]
LARGEST, LEAST = 400.0, 190.0  # of the drawing's sides [pt]
FONT = 8.5  # [pt]
LETTER = 0.66  # widest usual letter against the font's size
SYMBOL = 8.0  # of a joint [pt]


def centres_figure(state: LinkageState) -> Figure:
    """The mechanism in the pose of a state, and its instant centres."""
    centres = instant_centres(state)
    poses = {name: link.pose for name, link in state.links.items()}
    named = np.array([place for _, place in _points(state)]).reshape(-1, 2)
    reached = np.concatenate([outline(state.mechanism, poses), _rollers(state), named])
    own = np.concatenate([reached, _stems(state, STEM * float(np.ptp(reached, axis=0).max()))])
    low, high = own.min(axis=0), own.max(axis=0)
    room = ROOM * float((high - low).max())
    places = [np.array(c.place) for c in centres if c.place is not None]
    shown = [p for p in places if np.all(p >= low - room) and np.all(p <= high + room)]
    sheet = Sheet(np.array([*own, *shown]))
    sheet.scale_bar("mm", MM)
    view = sheet.view(state)
    draw_joints(view)
    draw_links(view)
    _centres(sheet, state, centres)
    for name, number in link_numbers(state.mechanism).items():
        if name != GROUND:
            sheet.label(_middle(view, name), str(number), "#555555")
    return sheet.finished()


def _middle(view: View, name: str) -> Array:
    """Place of a link's number: between its pins and the blocks that slide on it."""
    held = [view.place(name, point) for point in pins_of(view.mechanism, name)]
    slides = [slide_of(view.mechanism, joint) for joint in view.mechanism.joints if isinstance(joint, Prismatic)]
    held += [view.place(slide.moving, slide.point) for slide in slides if slide.guide == name]
    return np.asarray(np.mean(held, axis=0) if held else view.place(name, (0.0, 0.0)))


def _rollers(state: LinkageState) -> Array:
    """Corners around the rollers on cams; (N, 2) [m]."""
    corners = np.array([(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)])
    boxes = [state.links[c.b].place(c.roller_centre) + c.roller_radius * corners for c in state.mechanism.cam_contacts]
    return np.concatenate([np.empty((0, 2)), *boxes])


def _stems(state: LinkageState, length: float) -> Array:
    """Places beyond the rollers on cams, as far as their followers are drawn; (N, 2) [m]."""
    rolling = {contact.b: contact.roller_centre for contact in state.mechanism.cam_contacts}
    found = [np.empty((0, 2))]
    for joint in state.mechanism.joints:
        if isinstance(joint, Prismatic) and (slide := slide_of(state.mechanism, joint)).moving in rolling:
            turn = state.links[slide.guide].pose[2] + slide.direction
            found.append((state.links[slide.moving].place(rolling[slide.moving]) + length * parts.unit(turn))[None])
    return np.concatenate(found)


def _centres(sheet: Sheet, state: LinkageState, centres: tuple[InstantCentre, ...]) -> None:
    """Centres and points at one place share a mark and a label."""
    seen: list[tuple[Array, list[str], list[InstantCentre]]] = []

    def here(point: Array) -> tuple[list[str], list[InstantCentre]]:
        for there, names, group in seen:
            if float(np.linalg.norm(point - there)) < 3.0:
                return names, group
        seen.append((point, [], []))
        return seen[-1][1:]

    for centre in centres:
        if centre.place is not None and sheet.holds(np.array(centre.place)):
            here(sheet.at(np.array(centre.place)))[1].append(centre)
    for name, place in _points(state):
        here(sheet.at(place))[0].append(name)
    for point, names, group in seen:
        colour = COLOURS[group[0].kind] if group else parts.INK
        sheet.axes.plot(*np.round(point, 2), marker="o", markersize=4.0, color=colour, zorder=12)
        sheet.labels.mark(point, 3.0)
        sheet.label(point, ", ".join([*names, *(mathematical(centre.name) for centre in group)]), colour)


def _points(state: LinkageState) -> list[tuple[str, Array]]:
    """The points of the polygons, by their names there."""
    points = linkage_points(state.mechanism)
    found = [(p.name, state.links[p.carriers[0].link].place(p.carriers[0].point)) for p in points.points]
    for name, joint in points.contacts.items():
        centre = joint_centre(state, joint)
        assert centre is not None
        found.append((name, centre[:2]))
    return found


# -- velocity and acceleration polygons --------------------------------------------------------------------------------

FIGURES = ("centres.svg", "velocities.svg", "accelerations.svg")
UNITS = {"velocity": "m/s", "acceleration": "m/s²"}
# Okabe and Ito's colours, separate to colour-blind readers.
PARTS: dict[Kind, str] = {
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
    """The vectors from the pole O, and a scale bar."""
    unit, places = UNITS[polygon.quantity], polygon.places
    sheet = Sheet(np.array(list(places.values())))
    sheet.scale_bar(unit)
    drawn = [v for v in polygon.vectors if float(np.linalg.norm(v.value)) > TOO_SHORT * polygon.size]
    for vector in drawn:
        start = sheet.at(places[vector.start])
        stop = start + sheet.scale * vector.value
        parts.arrow(sheet.axes, np.round(start, 2), np.round(stop, 2), PARTS[vector.kind], width=1.3)
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
        sheet.label(middles, mathematical(vector.name), PARTS[vector.kind], np.array([along[1], -along[0]]))
    return sheet.finished()


# -- the sheet that they are drawn on ----------------------------------------------------------------------------------


class Sheet:
    """A drawing of places in a box, to scale.

    Attributes:
        figure, axes: its own; one unit of the axes is one point on paper.
        scale: points for each unit of the places.
        labels: texts and lines that are drawn already.
    """

    def __init__(self, places: Array) -> None:
        """A sheet that holds places (N, 2)."""
        low, high = places.min(axis=0), places.max(axis=0)
        extent = float((high - low).max()) or 1.0
        self.scale = LARGEST / extent
        width, height = (max(LEAST, float(side)) for side in (high - low) * self.scale)
        self._origin = 0.5 * (low + high) - 0.5 * np.array([width, height]) / self.scale
        self.width, self.height = width + 2.0 * MARGIN, height + 2.0 * MARGIN
        self.figure = Figure(figsize=(self.width / 72.0, self.height / 72.0))
        self.axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0))
        self.axes.set_axis_off()
        self.axes.set_xlim(0.0, self.width)
        self.axes.set_ylim(0.0, self.height)
        self.labels = LabelPlacement(1.0)
        self._labels: list[tuple[Array, str, str, Array | None]] = []

    def at(self, place: Array) -> Array:
        """A place in points from the sheet's lower left corner."""
        return np.asarray((np.asarray(place) - self._origin) * self.scale + MARGIN)

    def holds(self, place: Array) -> bool:
        """True for a place on the drawing's side of the sheet."""
        x, y = self.at(place)
        edge = 0.5 * MARGIN
        return bool(edge <= x <= self.width - edge and edge <= y <= self.height - edge)

    def view(self, state: LinkageState) -> View:
        """The mechanism of a state on this sheet, whose places are in m."""
        poses = {name: link.pose for name, link in state.links.items()}
        one = np.array([poses[body.name] for body in state.mechanism.bodies]).reshape(1, -1)
        x, y = self.at(np.zeros(2))
        return View(self.axes, state.mechanism, poses, one, SYMBOL, self.labels, self.scale, (float(x), float(y)))

    def label(self, points: Array, text: str, colour: str, towards: Array | None = None) -> None:
        """A label beside one of some points (N, 2) on paper, the first if may be; placed when the sheet is finished.

        Args:
            points: where it belongs.
            text: of the label.
            colour: of the text.
            towards: the side (2,) that it had best be on; None for any.
        """
        self._labels.append((np.atleast_2d(points), text, colour, towards))

    def scale_bar(self, unit: str, factor: float = 1.0) -> None:
        """A bar of a round length in the lower left corner; `factor` turns the places' unit into the shown one."""
        longest = 110.0 / self.scale * factor
        power = 10.0 ** math.floor(math.log10(longest))
        length = next(m for m in (5.0, 2.0, 1.0) if m * power <= longest) * power
        stop = 12.0 + length / factor * self.scale
        start, end = np.array([12.0, 12.0]), np.array([stop, 12.0])
        parts.arrow(self.axes, start, end, parts.INK, "|-|,widthA=0.25,widthB=0.25", 1.0)
        self.axes.text(0.5 * (12.0 + stop), 16.0, f"{length:g} {unit}", ha="center", va="bottom", fontsize=FONT)
        right = max(stop, 60.0) + 6.0
        self.labels.take(np.array([(8.0, 6.0), (right, 6.0), (right, 30.0), (8.0, 30.0)]))

    def finished(self) -> Figure:
        """The figure, with its labels."""
        paper = np.array([self.width, self.height])
        for points, text, colour, towards in self._labels:
            x, y = self.labels.beside(points, np.array(_extent(text)), paper, towards)
            self.axes.text(float(x), float(y), text, color=colour, **TEXT)
        return self.figure


# The white ground parts a label from thin lines under it.
TEXT: dict[str, Any] = {
    "ha": "center",
    "va": "center",
    "fontsize": FONT,
    "zorder": 30,
    "bbox": {"facecolor": "white", "edgecolor": "none", "pad": 0.4, "alpha": 0.85},
}


def mathematical(name: str) -> str:
    """The name of a vector or a centre in mathematical letters: V_B/A as V with a lower B/A."""
    if name.startswith("O") and name[1:].replace(",", "").isdigit():
        return f"$O_{{{name[1:]}}}$"
    head, _, lower = name.partition("_")
    quantity, _, upper = head.partition("^")
    # Upright letters, so that they are the mechanism's names and no products.
    lower = lower.replace(" ", r"\ ").replace("_", r"\_").replace("-", r"\text{-}")
    return f"${quantity}^{{{upper}}}_{{\\mathrm{{{lower}}}}}$" if upper else f"${quantity}_{{\\mathrm{{{lower}}}}}$"


def _extent(text: str) -> tuple[float, float]:
    """Width and height [pt] that a label needs."""
    letters = len(text.translate(str.maketrans("", "", "${}^_\\")).replace("mathrm", "").replace("text", ""))
    return LETTER * FONT * letters + 3.0, 1.25 * FONT + (3.0 if "$" in text else 0.0)
