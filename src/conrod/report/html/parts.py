"""A machine's drawing as movable shapes of its bodies, taken from the static drawing."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.colors import to_hex, to_rgba
from matplotlib.patches import Circle, Polygon

from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Pose, Prismatic, to_world
from conrod.mechanism.slide import guide_and_block
from conrod.report.drawing.drawing import EXTENT_POINTS, telling_angle, view_at
from conrod.report.drawing.links import draw_joints, draw_links
from conrod.report.drawing.view import View
from conrod.scenes import Scene

DRAWING_UNITS = 1000.0  # SVG units for the extent of the machine
MAX_OUTLINE_POINTS = 120  # of an outline


def svg_number(value: float, decimals: int = 1) -> str:
    """Return a coordinate with fixed decimals, and zero without a sign, which would be rounding noise."""
    # Adding zero makes -0.0 a plain zero.
    return f"{round(float(value), decimals) + 0.0:.{decimals}f}"


def points_text(points: Iterable[Sequence[float] | Array]) -> str:
    """Return points as SVG has them: `1.0,2.0 3.0,4.0`."""
    return " ".join(f"{svg_number(x)},{svg_number(y)}" for x, y in points)


@dataclass(frozen=True)
class Shape:
    """A line, a surface or a circle of the drawing.

    Attributes:
        places: points (N, 2) in drawing units, y up; of a circle its centre.
        look: SVG attributes.
        radius: radius of a circle; 0 for other shapes.
        above: height in the stack of shapes.
    """

    places: Array
    look: Mapping[str, str]
    radius: float = 0.0
    above: float = 0.0

    def outline(self, pose: Pose) -> str:
        """Return SVG path data, or a circle's attributes, in the frame of a body with a pose."""
        places = _to_body_frame(pose, self.places)
        if self.radius:
            x, y = places[0]
            return f'cx="{svg_number(x)}" cy="{svg_number(-y)}" r="{svg_number(self.radius, 2)}"'
        some = places[:: -(-len(places) // MAX_OUTLINE_POINTS)]
        return "M" + points_text((x, -y) for x, y in (places if some is places else [*some, places[-1]]))


def _shapes_svg(shapes: Sequence[Shape], pose: Pose) -> str:
    """Return shapes as SVG elements, the lowest first; lines of equal style are joined."""
    ordered = sorted(shapes, key=lambda one: one.above)
    found = []
    for (look, radius, _), some in groupby(ordered, key=lambda one: (one.look, one.radius, one.above)):
        outlines = [one.outline(pose) for one in some]
        style = "".join(f' {name}="{value}"' for name, value in look.items())
        found += (
            [f"<circle {one}{style}/>" for one in outlines] if radius else [f'<path d="{"".join(outlines)}"{style}/>']
        )
    return "".join(found)


class _Sketch:
    """A substitute for matplotlib's axes that records drawn shapes as parts of bodies."""

    def __init__(self, carried: Sequence[list[Shape]], scale: float, point: float) -> None:
        self._carried, self._scale, self._point = carried, scale, point

    def plot(self, x: Array, y: Array, color: str = "", **style: Any) -> None:
        self._add(np.column_stack([x, y]), "none", color, style)

    def fill(self, x: Array, y: Array, **style: Any) -> None:
        self._add(np.column_stack([x, y]), style["facecolor"], style["edgecolor"], style)

    def add_patch(self, patch: Polygon | Circle) -> None:
        face, edge = (
            to_hex(colour) if to_rgba(colour)[3] else "none"
            for colour in (patch.get_facecolor(), patch.get_edgecolor())
        )
        style = {"linewidth": patch.get_linewidth(), "zorder": patch.get_zorder(), "alpha": patch.get_alpha()}
        places = np.array([patch.center]) if isinstance(patch, Circle) else patch.get_xy()
        self._add(places, face, edge, style, patch.radius if isinstance(patch, Circle) else 0.0)

    def _add(self, places: Array, face: str, edge: str, style: Mapping[str, Any], radius: float = 0.0) -> None:
        look = {"fill": INKS.get(face, face)}
        if edge != "none":
            look |= {"stroke": INKS.get(edge, edge), "stroke-width": f"{style['linewidth'] * self._point:.3g}"}
        if style.get("alpha"):
            look["opacity"] = str(style["alpha"])
        if style.get("linestyle") == "-.":
            look["stroke-dasharray"] = f"{6 * self._point:.3g} {3 * self._point:.3g}"
        shape = Shape(self._scale * places, look, self._scale * radius, style.get("zorder", 2.0))
        for shapes in self._carried:
            shapes.append(shape)


@dataclass(frozen=True)
class _PartedView(View):
    """A view that records the shapes of each body; a pin belongs to all its bodies."""

    carried: Mapping[str, list[Shape]]

    def axes_of(self, *bodies: str) -> Any:
        moving = [self.carried[name] for name in bodies if name != GROUND]
        return _Sketch(moving or [self.carried[GROUND]], DRAWING_UNITS / self.extent, DRAWING_UNITS / EXTENT_POINTS)


# CSS colours for a light and a dark page, by the colour on paper.
INKS = {
    "#222222": "var(--ink)", "#777777": "var(--faint)", "#7d97ab": "currentColor", "#dde6ec": "var(--part)",
    "#ffffff": "var(--ground)", "white": "var(--ground)", "#f2f2f2": "var(--raised)",
}  # fmt: skip


@dataclass(frozen=True)
class MachineDrawing:
    """A machine's drawing.

    Attributes:
        bodies: SVG of each body in its own frame; the ground last.
        order: numbers of the moving bodies from bottom to top: a slot lies under its block.
        scale: drawing units per metre.
        box: left, top, width and height of the area that the machine reaches, y down.
    """

    bodies: Mapping[str, str]
    order: tuple[int, ...]
    scale: float
    box: tuple[float, float, float, float]

    def poses(self, stacked: Array) -> Array:
        """Convert poses or errors (K, 3 n) from [m, m, rad] to drawing units and degrees, y down."""
        factors = [self.scale, -self.scale, -180.0 / np.pi]
        return np.asarray(stacked * np.tile(factors, stacked.shape[1] // 3))


def drawing_of(scene: Scene) -> MachineDrawing:
    """Draw a scene's machine as movable shapes."""
    view = view_at(scene, telling_angle(scene))
    scale = 1e3 * DRAWING_UNITS / view.extent
    before = {name: (scale * x, scale * y, turn) for name, (x, y, turn) in view.poses.items()}
    parted = _PartedView(**vars(view), carried={name: [] for name in before})
    draw_joints(parted)
    draw_links(parted)
    bodies = {name: _shapes_svg(some, before[name]) for name, some in parted.carried.items()}
    turn = scene.kinematics.poses(np.linspace(*scene.kinematics.span, 24)).reshape(24, -1, 3) * [scale, scale, 1.0]
    everywhere = [dict(zip(before, (*map(tuple, poses), before[GROUND]), strict=True)) for poses in turn]
    reached = [
        np.array([to_world(poses[name], one) for one in _to_body_frame(before[name], shape.places[::12])])
        for poses in everywhere
        for name, some in parted.carried.items()
        for shape in some
    ]
    slotted = {
        guide_and_block(view.mechanism, one).guide for one in view.mechanism.joints if isinstance(one, Prismatic)
    }
    names = [body.name for body in view.mechanism.bodies]
    order = tuple(sorted(range(len(names)), key=lambda k: names[k] not in slotted))
    return MachineDrawing(
        bodies, order, scale, _drawing_box([*reached, *(1e-3 * scale * path for path in view.paths.values())])
    )


def _to_body_frame(pose: Pose, places: Array) -> Array:
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    return np.asarray((places - np.array(pose[:2])) @ np.array([[cos, -sin], [sin, cos]]))


def _drawing_box(reached: Sequence[Array]) -> tuple[float, float, float, float]:
    places = np.concatenate(reached)
    low, high = places.min(axis=0) - 0.04 * DRAWING_UNITS, places.max(axis=0) + 0.04 * DRAWING_UNITS
    return float(low[0]), float(-high[1]), float(high[0] - low[0]), float(high[1] - low[1])
