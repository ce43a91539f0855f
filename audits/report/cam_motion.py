"""Document 004's Figures 6 to 13 again: exact lines, marks of the engines, and the extremes that its text prints."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D

from audits.cam_runs import CamFamily, CamRun, mark_degrees
from audits.documents.arc_cam import QUANTITIES, ArcCam
from audits.items import shipped_items
from conrod.exact.motion import Array
from conrod.report.charts.canvas import add_legend_above, round_to_grid
from conrod.report.charts.styles import engine_title
from conrod.report.figure import Figure

UNITS = {"lift": "mm", "velocity": "mm/s", "acceleration": "mm/s²", "jerk": "mm/s³"}
# The document's figures: quantity, and radius of the base circle [mm]; Figure 6 has all of them. Figure 13 is headed
# R = 36 mm as is 12, and its text compares R = 36 with R = 76 mm.
FIGURES = {
    7: ("velocity", 56.0), 8: ("velocity", 36.0), 9: ("velocity", 76.0), 10: ("acceleration", 36.0),
    11: ("acceleration", 76.0), 12: ("jerk", 36.0), 13: ("jerk", 76.0),
}  # fmt: skip
SHADES = ("#9ecae1", "#6baed6", "#3182bd", "#08519c", "#06264d")  # of the flank radii of a base circle, from the least
MARKS = {"mujoco": "o", "pymunk": "x"}
ARC_SAMPLES = 60  # of each arc of a line
TURN = 360.0  # [deg]


class PrintedMark(NamedTuple):
    """An extreme that the document prints: of which cam and quantity, where [deg], and its value [mm, s]."""

    base: float
    flank: float
    quantity: str
    degrees: float
    value: float


# Quantity, R, rho, keys of value and angle in audits/data/cam.csv, and the sign, where the document prints a size.
PRINTED = (
    ("lift", 36.0, 118.0, "lift-36", "lift-36-angle", 1.0), ("lift", 76.0, 128.0, "lift-76", "lift-36-angle", 1.0),
    ("velocity", 36.0, 118.0, "speed-max", "speed-max-angle", 1.0),
    ("velocity", 36.0, 118.0, "speed-max", "speed-max-mirror", -1.0),
    ("velocity", 76.0, 92.5, "speed-76", "speed-76-angle", 1.0),
    ("acceleration", 36.0, 118.0, "flank-acceleration", "flank-acceleration-angle", 1.0),
    ("acceleration", 36.0, 118.0, "tip-acceleration", "tip-angle", 1.0),
    ("acceleration", 36.0, 118.0, "acceleration-max", "acceleration-max-angle", -1.0),
    ("acceleration", 36.0, 118.0, "acceleration-max", "acceleration-max-mirror", -1.0),
    ("jerk", 36.0, 118.0, "flank-jerk", "flank-jerk-angle", 1.0),
    ("jerk", 36.0, 118.0, "jerk-130", "flank-acceleration-angle", 1.0),
    ("jerk", 36.0, 118.0, "jerk-before", "joint-angle", 1.0), ("jerk", 36.0, 118.0, "jerk-after", "joint-angle", 1.0),
    ("jerk", 36.0, 118.0, "jerk-max", "jerk-max-mirror", -1.0),
)  # fmt: skip


@cache
def printed_marks() -> tuple[PrintedMark, ...]:
    """All extremes that the document prints, at each angle that it prints for them."""
    values = dict[str, list[float]]()
    for item in shipped_items("004", "cam.csv"):
        values.setdefault(item.key, []).append(item.number.value)
    found = dict.fromkeys(
        PrintedMark(base, flank, quantity, degrees, sign * values[value][0])
        for quantity, base, flank, value, angle, sign in PRINTED
        for degrees in values[angle]
    )
    return tuple(found)


def figures(family: CamFamily) -> list[Figure]:
    """The document's figures, in their order."""
    found = [Figure("figure-6", "Lift of every cam over its angle: exact, and in the engines", partial(lifts, family))]
    for number, (quantity, base) in FIGURES.items():
        engines = ", and in the engines" if quantity != "jerk" else ""
        alt = f"{quantity.capitalize()} of the follower over the cam's angle for R = {base:g} mm: exact{engines}"
        found.append(Figure(f"figure-{number}", alt, partial(rates, family, quantity, base)))
    return found


def lifts(family: CamFamily) -> Canvas:
    """Figure 6: a panel for each base circle."""
    bases = list(dict.fromkeys(cam.base for cam in family.cams))
    canvas = Canvas(figsize=(10.5, 6.6))
    panels = canvas.subplots(2, -(-len(bases) // 2), sharex=True, sharey=True, squeeze=False).ravel()
    for axes, base in zip(panels, bases, strict=False):
        _draw(axes, family, "lift", base)
        axes.set_title(f"R = {base:g} mm")
        axes.tick_params(labelbottom=True)
    for axes in panels[len(bases) :]:
        axes.set_visible(False)
    _add_legend(canvas, family, bases[-1])
    return canvas


def rates(family: CamFamily, quantity: str, base: float) -> Canvas:
    """One of Figures 7 to 13: a quantity for the cams of a base circle."""
    canvas = Canvas(figsize=(10.5, 4.6))
    _draw(canvas.subplots(), family, quantity, base)
    _add_legend(canvas, family, base)
    return canvas


def _draw(axes: Axes, family: CamFamily, quantity: str, base: float) -> None:
    k, cams = QUANTITIES.index(quantity), _of_base(family, base)
    curves = [exact_curve(ArcCam(cam.base, cam.flank), k) for cam in cams]
    span = max(float(np.ptp(values)) for _, values in curves)
    for shade, cam, (degrees, values) in zip(_shades(cams), cams, curves, strict=True):
        axes.plot(round_to_grid(degrees, TURN), round_to_grid(values, span), color=shade, linewidth=1.2)
        for engine, marks in cam.marks.items() if k < 3 else ():
            at = round_to_grid(mark_degrees(engine), TURN)
            axes.plot(at, round_to_grid(marks[k], span), color=shade, **_mark_style(engine))
    named = set[tuple[float, float]]()
    for mark in (one for one in printed_marks() if (one.quantity, one.base) == (quantity, base)):
        axes.plot([mark.degrees], [mark.value], **PRINTED_STYLE)
        if (
            place := (round(mark.degrees, -1), mark.value)
        ) not in named:  # two angles of one value are next to each other
            axes.annotate(
                f"{mark.value:g}", (mark.degrees, mark.value), (6, 4), textcoords="offset points", **LABEL_STYLE
            )
        named.add(place)
    axes.set_xlim(0.0, TURN)
    axes.set_xticks(np.arange(0.0, TURN + 1.0, 60.0))
    axes.set_xlabel("cam angle [deg]")
    axes.set_ylabel(f"{quantity} [{UNITS[quantity]}]")


PRINTED_STYLE: dict[str, Any] = {
    "linestyle": "none", "marker": "D", "markersize": 5.5, "markerfacecolor": "none", "color": "#c0392b", "zorder": 5,
}  # fmt: skip

LABEL_STYLE: dict[str, Any] = {
    "fontsize": 8, "color": PRINTED_STYLE["color"], "zorder": 6,
    "bbox": {"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 0.6},
}  # fmt: skip


def _mark_style(engine: str) -> dict[str, Any]:
    return {"linestyle": "none", "marker": MARKS.get(engine, "+"), "markersize": 4.5, "markerfacecolor": "none"}


def _of_base(family: CamFamily, base: float) -> Sequence[CamRun]:
    return sorted((cam for cam in family.cams if cam.base == base), key=lambda cam: cam.flank)


def _shades(cams: Sequence[CamRun]) -> Sequence[str]:
    return SHADES[-len(cams) :]


def exact_curve(cam: ArcCam, quantity: int) -> tuple[Array, Array]:
    """Angles [deg] and exact values over a turn, arc by arc: at a joint both values stand, where they differ."""
    joints = [] if cam.scene.is_one_circle else [cam.joint_b, cam.joint_c, TURN - cam.joint_c, TURN - cam.joint_b]
    edges, degrees, values = [0.0, *joints, TURN], [], []
    for first, last in itertools.pairwise(edges):
        arc = np.linspace(first, last, ARC_SAMPLES if joints else 5 * ARC_SAMPLES)
        found = cam.exact(arc, "left")[quantity]
        found[0] = cam.exact(first, "right")[quantity, 0]
        degrees.append(arc)
        values.append(found)
    return np.concatenate(degrees), np.concatenate(values)


def _add_legend(canvas: Canvas, family: CamFamily, base: float) -> None:
    cams = _of_base(family, base)
    named = {shade: f"rho = {cam.flank:g} mm" for shade, cam in zip(_shades(cams), cams, strict=True)}
    if len(canvas.axes) > 1:  # the radii of each panel differ, the order of their shades does not
        named = {SHADES[0]: "least rho", SHADES[-1]: "largest rho"}
    lines = [Line2D([], [], color=shade, label=name) for shade, name in named.items()]
    engines = [
        Line2D([], [], color=SHADES[-1], label=engine_title(name), **_mark_style(name)) for name in family.engines
    ]
    add_legend_above(canvas, [*lines, *engines, Line2D([], [], label="printed", **PRINTED_STYLE)], handlelength=1.6)
