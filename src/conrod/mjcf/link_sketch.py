"""Points and shapes of the links of a compiled model: what of it a picture shows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import mujoco
import numpy as np

from conrod.engines.mujoco import compat
from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.exact.motion import Array
from conrod.mjcf.equalities import equality_kind, is_handle, ties_bodies
from conrod.mjcf.loading import FoundPoint, joint_kind, name_or_number
from conrod.report.drawing.moving_links import BAR, DISC, GEOM, GUIDE, PIN, LinkShape

MAX_LINKS, MAX_POINTS = 60, 400
MAX_GEOMS = 3  # of a link
SAME_PLACE = 1e-6  # of the extent: points of a link that are drawn as one
ORDER = (GUIDE, DISC, GEOM, BAR, PIN)  # from bottom to top
GUIDE_ENDS = 0.05  # of the machine's size, by which a guide is longer than the slide's motion at each end
SPHERE, CAPSULE, CYLINDER, PLANE, HFIELD = (
    int(getattr(mujoco.mjtGeom, f"mjGEOM_{name}")) for name in ("SPHERE", "CAPSULE", "CYLINDER", "PLANE", "HFIELD")
)


@dataclass
class LinkSketch:
    """Points of links in the frames of their bodies, and shapes between them.

    Attributes:
        bodies, offsets: body and place (3,) in its frame of each point that moves.
        ground_bodies, ground_offsets: the same of points that stand still.
        judged: indices of the judged points.
    """

    bodies: list[int] = field(default_factory=list)
    offsets: list[Array] = field(default_factory=list)
    shapes: list[LinkShape] = field(default_factory=list)
    ground_bodies: list[int] = field(default_factory=list)
    ground_offsets: list[Array] = field(default_factory=list)
    ground: list[LinkShape] = field(default_factory=list)
    labels: list[tuple[int, str]] = field(default_factory=list)
    judged: list[int] = field(default_factory=list)
    left_out: int = 0

    def places(self, model: mujoco.MjModel, coordinates: Array) -> Array:
        """Places (K, P, 3) of the moving points at coordinates (nq, K)."""
        return _places(model, coordinates, self.bodies, self.offsets)

    def ground_places(self, model: mujoco.MjModel, pose: Array) -> Array:
        """Places (G, 3) of the points that stand still."""
        return np.asarray(_places(model, pose[:, None], self.ground_bodies, self.ground_offsets)[0])


def _places(model: mujoco.MjModel, coordinates: Array, bodies: Sequence[int], offsets: Sequence[Array]) -> Array:
    """Places (K, P, 3) of points fixed to bodies at coordinates (nq, K)."""
    data, found = mujoco.MjData(model), np.zeros((coordinates.shape[1], len(bodies), 3))
    local = np.array(offsets).reshape(len(bodies), 3)
    with silence_warnings():
        for k, pose in enumerate(coordinates.T):
            data.qpos[:] = pose
            mujoco.mj_kinematics(model, data)
            turns = data.xmat[list(bodies)].reshape(-1, 3, 3)
            found[k] = data.xpos[list(bodies)] + np.einsum("pij,pj->pi", turns, local)
    return found


def sketch_links(model: mujoco.MjModel, coordinates: Array, points: Sequence[FoundPoint]) -> LinkSketch:
    """Choose the points and shapes of a model's links, in the first pose of a motion (nq, K)."""
    data = mujoco.MjData(model)
    data.qpos[:] = coordinates[:, 0]
    with silence_warnings():
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
    joined, guides = dict[int, list[_End]](), dict[int, list[_Guide]]()
    for end in (*_joint_ends(model, data), *_all_closure_ends(model, data)):
        joined.setdefault(end.link, []).append(end)
    for guide in _guides(model, data, coordinates):
        guides.setdefault(guide.link, []).append(guide)
    moving = [b for b in range(1, model.nbody) if int(model.body_weldid[b]) == b and model.body_dofnum[b]]
    made = LinkSketch(left_out=max(0, len(moving) - MAX_LINKS))
    for body in range(model.nbody):
        if int(model.body_weldid[body]) == body and not model.body_dofnum[body]:
            _add_ground(made, model, data, body, joined.get(body, []), guides.get(body, []))
    for link in moving[:MAX_LINKS]:
        if len(made.bodies) >= MAX_POINTS:
            made.left_out += 1
            continue
        judged = [point for point in points if _link_of(model, point.body) == link]
        _add_link(made, model, data, link, joined.get(link, []), guides.get(link, []), judged)
    made.shapes.sort(key=lambda shape: ORDER.index(shape.kind))
    made.ground.sort(key=lambda shape: ORDER.index(shape.kind))
    return made


class _End(NamedTuple):
    """A place (3,) of a link where a joint or closure joins it to another; `marked` if it is marked on this link."""

    link: int
    name: str
    place: Array
    marked: bool


class _Guide(NamedTuple):
    """Ends (3,) of the line on a link along which a slide moves another link."""

    link: int
    name: str
    ends: tuple[Array, Array]


def _link_of(model: mujoco.MjModel, body: int) -> int:
    return int(model.body_weldid[body])


def _joint_ends(model: mujoco.MjModel, data: mujoco.MjData) -> Iterator[_End]:
    """Yield the ends of hinges and balls on both links, and of slides on the link that they move."""
    for j in range(model.njnt):
        kind, body, name = joint_kind(model, j), int(model.jnt_bodyid[j]), name_or_number(model, "joint", j)
        link, parent = _link_of(model, body), _link_of(model, int(model.body_parentid[body]))
        if kind == "free":
            continue
        still = not model.body_dofnum[parent]
        yield _End(link, name, data.xanchor[j].copy(), not still or kind == "slide")
        if kind != "slide":
            yield _End(parent, name, data.xanchor[j].copy(), still)


def _guides(model: mujoco.MjModel, data: mujoco.MjData, coordinates: Array) -> Iterator[_Guide]:
    """Yield the lines along which slides move in a motion (nq, K), on the links that they move against."""
    for j in range(model.njnt):
        if joint_kind(model, j) == "slide":
            values, parent = coordinates[model.jnt_qposadr[j]], int(model.body_parentid[model.jnt_bodyid[j]])
            beyond = GUIDE_ENDS * machine_box(model, data)[2]
            travels = values.min() - values[0] - beyond, values.max() - values[0] + beyond
            low, high = (data.xanchor[j] + travel * data.xaxis[j] for travel in travels)
            yield _Guide(_link_of(model, parent), name_or_number(model, "joint", j), (low, high))


def _all_closure_ends(model: mujoco.MjModel, data: mujoco.MjData) -> Iterator[_End]:
    """Yield both ends of each connect and weld that acts and is no mouse handle."""
    for k in np.flatnonzero(model.eq_active0).tolist():
        if ties_bodies(model, k) and not is_handle(model, k):
            for body, place in _closure_ends(model, data, k):
                yield _End(_link_of(model, body), name_or_number(model, "equality", k), place, marked=True)


def _closure_ends(model: mujoco.MjModel, data: mujoco.MjData, k: int) -> list[tuple[int, Array]]:
    """Both bodies of a connect or weld, each with the place that it is held at."""
    bodies = compat.equality_bodies(model, k)
    if int(model.eq_objtype[k]) == int(mujoco.mjtObj.mjOBJ_SITE):
        ends = (int(model.eq_obj1id[k]), int(model.eq_obj2id[k]))
        return [(body, data.site_xpos[site].copy()) for body, site in zip(bodies, ends, strict=True)]
    first, second = model.eq_data[k, :3], model.eq_data[k, 3:6]
    if equality_kind(model, k) == "weld":  # MuJoCo keeps the anchor on body 2 first
        first, second = second, first
    turns = [data.xmat[body].reshape(3, 3) for body in bodies]
    return [
        (body, data.xpos[body] + turn @ anchor)
        for body, turn, anchor in zip(bodies, turns, (first, second), strict=True)
    ]


def _add_link(
    made: LinkSketch, model: mujoco.MjModel, data: mujoco.MjData, link: int, joined: Sequence[_End],
    guides: Sequence[_Guide], judged: Sequence[FoundPoint],
) -> None:  # fmt: skip
    """Add a link: its geoms, bars from joint to joint and to judged points, its guides and its pins."""
    name, own = name_or_number(model, "body", link), _LinkPoints(made, model, data, link)
    ends = [own.index(end.place) for end in joined]
    made.shapes += [LinkShape(PIN, end.name, (own.index(end.place),)) for end in joined if end.marked]
    made.shapes += [LinkShape(GUIDE, guide.name, tuple(map(own.index, guide.ends))) for guide in guides]
    for one in judged:
        index = own.index(one.position(data))
        made.labels.append((index, one.name))
        made.judged.append(index)
        ends.append(index)
    geoms = _geom_shapes(model, data, link)[:MAX_GEOMS]
    made.shapes += [LinkShape(kind, name, tuple(map(own.index, places)), width) for kind, places, width in geoms]
    ends = list(dict.fromkeys(ends))
    if len(ends) < 2 and not geoms:
        start = own.places[ends[0]] if ends else data.xpos[link].copy()
        ends = list(dict.fromkeys([*ends, own.index(start), own.index(_farthest_place(model, data, link, start))]))
    if len(ends) == 3:
        made.shapes.append(LinkShape(BAR, name, tuple(ends)))
    else:
        made.shapes += [LinkShape(BAR, name, (ends[0], end)) for end in ends[1:]]


class _LinkPoints:
    """Points of a link that are added to a sketch, each place once."""

    def __init__(self, made: LinkSketch, model: mujoco.MjModel, data: mujoco.MjData, link: int) -> None:
        self.places = dict[int, Array]()
        self._made, self._data, self._link, self._near = made, data, link, SAME_PLACE * float(model.stat.extent)

    def index(self, place: Array) -> int:
        """Index of the point at a place (3,) of the link; a new one is added."""
        for index, other in self.places.items():
            if float(np.linalg.norm(place - other)) <= self._near:
                return index
        index = len(self._made.bodies)
        self._made.bodies.append(self._link)
        self._made.offsets.append(_in_body_frame(self._data, self._link, place))
        self.places[index] = place.copy()
        return index


def _in_body_frame(data: mujoco.MjData, body: int, place: Array) -> Array:
    return np.asarray(data.xmat[body].reshape(3, 3).T @ (place - data.xpos[body]))


def _farthest_place(model: mujoco.MjModel, data: mujoco.MjData, link: int, start: Array) -> Array:
    """The site or centre of gravity of a link that is farthest from a place (3,)."""
    sites = [data.site_xpos[s] for s in range(model.nsite) if _link_of(model, int(model.site_bodyid[s])) == link]
    return np.array(max([data.xipos[link], *sites], key=lambda place: float(np.linalg.norm(place - start))))


def _add_ground(
    made: LinkSketch, model: mujoco.MjModel, data: mujoco.MjData, body: int, joined: Sequence[_End],
    guides: Sequence[_Guide],
) -> None:  # fmt: skip
    """Add joints, guides and geoms of a body that stands still; geoms far beyond the machine are no part of it."""

    def index(place: Array) -> int:
        made.ground_bodies.append(body)
        made.ground_offsets.append(_in_body_frame(data, body, place))
        return len(made.ground_bodies) - 1

    name, (low, high, size) = name_or_number(model, "body", body), machine_box(model, data)
    for kind, places, width in _geom_shapes(model, data, body)[: 4 * MAX_GEOMS]:
        if np.all(low - size <= places) and np.all(places <= high + size):
            made.ground.append(LinkShape(kind, name, tuple(map(index, places)), width))
    made.ground += [LinkShape(GUIDE, guide.name, tuple(map(index, guide.ends))) for guide in guides]
    made.ground += [LinkShape(PIN, end.name, (index(end.place),)) for end in joined if end.marked]


def machine_box(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[Array, Array, float]:
    """Corners (3,) of the box about all moving bodies and their joints, and its diagonal."""
    moving = np.flatnonzero(model.body_dofnum[model.body_weldid])
    places = np.concatenate([data.xpos[moving], data.xipos[moving], data.xanchor])
    low, high = places.min(axis=0), places.max(axis=0)
    return low, high, float(np.linalg.norm(high - low)) or float(model.stat.extent)


def _geom_shapes(model: mujoco.MjModel, data: mujoco.MjData, link: int) -> list[tuple[str, list[Array], float]]:
    """Kind, places and width [m] of the geoms of a link, the largest first."""
    found = list[tuple[float, str, list[Array], float]]()
    for g in range(model.ngeom):
        kind = int(model.geom_type[g])
        if _link_of(model, int(model.geom_bodyid[g])) != link or kind in (PLANE, HFIELD) or not model.geom_rgba[g, 3]:
            continue
        turn, (centre, half) = data.geom_xmat[g].reshape(3, 3), (model.geom_aabb[g, :3], model.geom_aabb[g, 3:])
        middle = data.geom_xpos[g] + turn @ centre
        if kind == SPHERE:
            found.append((2.0 * float(half[0]), DISC, [middle], 2.0 * float(half[0])))
            continue
        radius = float(model.geom_size[g, 0])
        if kind == CYLINDER and radius > half[2]:
            found.append((2.0 * radius, DISC, [middle], 2.0 * radius))
            continue
        along = 2 if kind in (CAPSULE, CYLINDER) else int(np.argmax(half))
        length = float(model.geom_size[g, 1]) if kind == CAPSULE else float(half[along])
        width = 2.0 * (radius if kind in (CAPSULE, CYLINDER) else float(np.sort(half)[1]))
        ends = [middle - turn[:, along] * length, middle + turn[:, along] * length]
        found.append((2.0 * length, GEOM, ends, width))
    found.sort(key=lambda one: -one[0])
    return [(kind, places, width) for _, kind, places, width in found]
