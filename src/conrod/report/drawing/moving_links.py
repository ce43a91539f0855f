"""A user's model in motion, as plain data: lines of its links in a picture, exact and as runs have them."""

from __future__ import annotations

from dataclasses import dataclass

from conrod.exact.motion import Array

BAR, GEOM, GUIDE, PIN, DISC = "bar", "geom", "guide", "pin", "disc"  # kinds of shapes


@dataclass(frozen=True)
class LinkShape:
    """A shape of a link, between some of the picture's points.

    Attributes:
        kind: `BAR` from pin to pin, `GEOM` along the axis of a geom, `GUIDE` of a slide, `PIN`, or `DISC`.
        link: name of the link, or of the joint of a pin.
        points: indices of its points: one of a pin or disc, two of a line, three of a triangle.
        width: width of a line, or diameter of a disc, in drawing units; 0 for that of all bars and pins.
    """

    kind: str
    link: str
    points: tuple[int, ...]
    width: float = 0.0


@dataclass(frozen=True)
class DrawnRun:
    """A run as it is drawn, at K instants that are equally apart.

    Attributes:
        name: its name in lists, such as 'hardened'.
        preset: preset whose line its curve has; empty for none.
        rows: places (K, 2 P) of the points in drawing units, y down; their differences from the exact places where
            there is an exact motion.
        off: largest distance (K,) [mm] of a judged point from its exact place; empty without an exact motion.
        ended: why it shows no more, in words; empty if it went to its end.
    """

    name: str
    preset: str
    seconds: float
    rows: Array
    off: tuple[float, ...] = ()
    ended: str = ""


@dataclass(frozen=True)
class MovingLinks:
    """Links of a model that move in a picture of it.

    Attributes:
        view: the plane or the projection that it is drawn in, in words.
        reference: what is drawn in grey, in words; empty where nothing is.
        box: left, top, width and height of the picture, in drawing units, y down.
        shapes: shapes of the links, the lowest first.
        ground: the same of what stands still, whose points are `ground_points` (G, 2).
        labels: names of points, with their indices.
        exact: places (K, 2 P) of the points in the exact motion; empty where there is none.
        runs: runs, at least one.
        left_out: number of moving links that are not drawn.
    """

    view: str
    reference: str
    box: tuple[int, int, int, int]
    shapes: tuple[LinkShape, ...]
    ground: tuple[LinkShape, ...]
    ground_points: Array
    labels: tuple[tuple[int, str], ...]
    exact: Array
    runs: tuple[DrawnRun, ...]
    left_out: int = 0

    @property
    def has_exact(self) -> bool:
        """True if runs are drawn over an exact motion."""
        return self.exact.size > 0
