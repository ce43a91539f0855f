"""A machine's drawing as shapes that its bodies carry: of the static drawing at two crank angles, what moves alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.colors import to_hex, to_rgba
from matplotlib.patches import Circle, Polygon

from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Pose, to_world
from conrod.report.drawing.drawing import POINTS, telling_angle, view_at
from conrod.report.drawing.links import draw_joints, draw_links
from conrod.report.drawing.view import View
from conrod.scenes import Scene

UNITS = 1000.0  # of the drawing, for the extent of the machine
OTHER_ANGLE = 0.37  # of the span, from the first: links move otherwise than each other, and a slide has gone some way
ALIKE = 1e-4  # of places, in the drawing's units
MOST_POINTS, MOST_CORNERS = 120, 12  # of an outline; of a shape that may begin at any of its corners


@dataclass(frozen=True)
class Shape:
    """A line, a surface or a circle of the drawing.

    Attributes:
        places: (N, 2) in the drawing's units, y up; of a circle its centre.
        look: attributes of SVG.
        radius: of a circle.
        above: what is drawn later has more.
    """

    places: Array
    look: Mapping[str, str]
    radius: float = 0.0
    above: float = 0.0

    @property
    def kin(self) -> tuple[int, bool]:
        """The same of all shapes that this may become as it moves: a corner in line comes and goes with rounding."""
        count = len(self.places)
        return MOST_CORNERS if 2 < count < MOST_CORNERS else count, self.radius > 0.0

    @property
    def corners(self) -> Array:
        """The places, as many as `kin` says."""
        return np.pad(self.places, ((0, self.kin[0] - len(self.places)), (0, 0)), mode="edge")

    def outline(self, pose: Pose) -> str:
        """The shape's path, or a circle's place and size, in the frame of a body that has a pose in the drawing."""
        places = _local(pose, self.places)
        if self.radius:
            return f'cx="{places[0, 0]:.5g}" cy="{-places[0, 1]:.5g}" r="{self.radius:.4g}"'
        some = places[:: -(-len(places) // MOST_POINTS)]
        return "M" + " ".join(f"{x:.1f},{-y:.1f}" for x, y in (places if some is places else [*some, places[-1]]))


def _svg(shapes: Sequence[Shape], pose: Pose) -> str:
    """Shapes as elements of SVG, the lowest first; lines that look alike are one path."""
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
    """Takes what is drawn on matplotlib's axes, as shapes."""

    def __init__(self, scale: float, point: float) -> None:
        self.shapes, self._scale, self._point = list[Shape](), scale, point

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
        self.shapes.append(Shape(self._scale * places, look, self._scale * radius, style.get("zorder", 2.0)))


# Colours of the drawing on paper, as a page has them in the light and in the dark.
INKS = {
    "#222222": "var(--ink)", "#777777": "var(--faint)", "#7d97ab": "currentColor", "#dde6ec": "var(--part)",
    "#ffffff": "var(--ground)", "white": "var(--ground)", "#f2f2f2": "var(--raised)",
}  # fmt: skip


@dataclass(frozen=True)
class Drawing:
    """A machine's drawing.

    Attributes:
        bodies: SVG of what each body carries, in its own frame; the ground last.
        scale: of the drawing, units for a metre.
        box: left, top, width and height of what the machine reaches, in SVG's sense.
    """

    bodies: Mapping[str, str]
    scale: float
    box: tuple[float, float, float, float]

    def poses(self, stacked: Array) -> Array:
        """Poses or their errors (K, 3 n) [m, m, rad] as SVG has them: units and degrees, y down."""
        factors = [self.scale, -self.scale, -180.0 / np.pi]
        return np.asarray(stacked * np.tile(factors, stacked.shape[1] // 3))


def drawing_of(scene: Scene) -> Drawing:
    """The drawing of a scene's machine."""
    angle, (start, stop) = telling_angle(scene), scene.kinematics.span
    other = start + (angle - start + OTHER_ANGLE * (stop - start)) % (stop - start)
    view = view_at(scene, angle)
    later = replace(view, poses=view_at(scene, other).poses)
    scale = UNITS / view.extent
    shapes, moved = _sketched(view), _sketched(later)
    before, after = (_scaled(one.poses, 1e3 * scale) for one in (view, later))
    carried: dict[str, list[Shape]] = {name: [] for name in before}
    others: dict[tuple[int, bool], list[Array]] = {}
    for shape in moved:
        others.setdefault(shape.kin, []).append(shape.corners)
    for shape in shapes:
        for name in _owners(shape, np.array(others.get(shape.kin, ())), before, after):
            carried[name].append(shape)
    bodies = {name: _svg(some, before[name]) for name, some in carried.items()}
    turn = scene.kinematics.poses(np.linspace(start, stop, 24)).reshape(24, -1, 3) * [1e3 * scale, 1e3 * scale, 1.0]
    everywhere = [dict(zip(before, (*map(tuple, poses), before[GROUND]), strict=True)) for poses in turn]
    reached = [
        np.array([to_world(poses[name], one) for one in _local(before[name], shape.places[::12])])
        for poses in everywhere
        for name, some in carried.items()
        for shape in (some if name != GROUND else some if poses is everywhere[0] else ())
    ]
    return Drawing(bodies, 1e3 * scale, _box([*reached, *(scale * path for path in view.paths.values())]))


def _sketched(view: View) -> list[Shape]:
    sketch: Any = _Sketch(UNITS / view.extent, UNITS / POINTS)
    draw_joints(replace(view, axes=sketch))
    draw_links(replace(view, axes=sketch))
    shapes: list[Shape] = sketch.shapes
    return shapes


def _scaled(poses: Mapping[str, Pose], scale: float) -> dict[str, Pose]:
    return {name: (scale * x, scale * y, turn) for name, (x, y, turn) in poses.items()}


def _local(pose: Pose, places: Array) -> Array:
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    return np.asarray((places - np.array(pose[:2])) @ np.array([[cos, -sin], [sin, cos]]))


def _owners(shape: Shape, moved: Array, before: Mapping[str, Pose], after: Mapping[str, Pose]) -> list[str]:
    """Bodies that a shape moves with: all whose pin it is, else one; what changes its length stays where it begins.

    Args:
        moved: places (M, N, 2) of the shapes that it may have become.
    """
    for part in (slice(None), slice(1)):
        alike = [
            name
            for name in before
            if len(moved) and _some_same(_local(before[name], shape.corners[part]), _local(after[name], moved[:, part]))
        ]
        moving = [name for name in alike if name != GROUND]
        if alike:
            # What stays where it is may look like something of a body that happens to be there.
            still = GROUND in alike and not shape.radius
            return [GROUND] if still or not moving else moving if shape.radius else moving[:1]
    return [GROUND]


def _some_same(one: Array, others: Array) -> bool:
    """True where each place (N, 2) is one of those of a shape among others (M, N, 2): a hull begins anywhere."""
    if len(one) > MOST_CORNERS:
        off = np.abs(others - one).max(axis=2)
    else:
        off = np.abs(others[:, None] - one[:, None]).max(axis=3).min(axis=2)
    return bool((off.max(axis=1) < ALIKE * UNITS).any())


def _box(reached: Sequence[Array]) -> tuple[float, float, float, float]:
    places = np.concatenate(reached)
    low, high = places.min(axis=0) - 0.04 * UNITS, places.max(axis=0) + 0.04 * UNITS
    return float(low[0]), float(-high[1]), float(high[0] - low[0]), float(high[1] - low[1])
