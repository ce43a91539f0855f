"""Connects and welds between bodies that do not meet: the compiler took them from a pose that is no assembly."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import mujoco
import numpy as np

from conrod.exact.motion import Array
from conrod.mjcf.equalities import closure_name, equality_kind, is_handle, ties_bodies
from conrod.mjcf.loading import joint_kind, name_or_number

BODY = int(mujoco.mjtObj.mjOBJ_BODY)
# A point further than this share of the model's extent from all geoms of its part is not on the part.
DETACHED_SHARE = 0.05
# A nearer one is not on it either where it is beyond the thickness of the nearest geom, and so many times further off
# than any joint of the file is from the links that it joins: how closely these geoms show the links.
MAX_TIMES_JOINTS = 2.0
LEAST_SHARE = 1e-3  # of the extent: what is nearer is on the part
CAPSULE = int(mujoco.mjtGeom.mjGEOM_CAPSULE)


@dataclass(frozen=True)
class PartsApart:
    """A closure between bodies whose parts do not meet.

    Attributes:
        body: body whose held point, an anchor or an end of a distance, is at none of its geoms.
        distance: distance from that point to the nearest geom of the body, in the model's unit of length.
        sites: of both bodies, to connect in its place, in the order of the closure; empty where one has none.
    """

    closure: str
    kind: str
    body: str
    other: str
    distance: float
    sites: tuple[str, ...] = ()

    @property
    def words(self) -> str:
        """'pin holds rocker at a point 331 mm from its nearest geom: the parts do not meet'."""
        distance = f"{1e3 * self.distance:.3g} mm"
        if self.kind == "weld":
            return f"{self.closure} holds {self.body} {distance} apart from {self.other}: the parts do not meet"
        return f"{self.closure} holds {self.body} at a point {distance} from its nearest geom: the parts do not meet"

    @property
    def cure(self) -> str:
        """Sites to connect, whose places do not depend on the reference pose."""
        if self.sites:
            return 'connect sites: site1="{}" site2="{}"'.format(*self.sites)
        return "put a site on each of the two parts, where they meet, and connect the sites"


def parts_apart(model: mujoco.MjModel) -> Iterator[PartsApart]:
    """Find closures between bodies, acting from the start, whose parts do not meet.

    A connect's anchor on its second body, and a weld's relative pose, are made from the reference pose (MuJoCo
    documentation, XML reference, equality/connect): where that does not assemble the machine they are of no machine.
    Bodies are looked at whose geoms reach their own joints: others have no geoms of their shape.
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    detached, closely = DETACHED_SHARE * float(model.stat.extent), MAX_TIMES_JOINTS * _joint_distance(model, data)
    for k in np.flatnonzero(model.eq_active0).tolist():
        if not ties_bodies(model, k) or int(model.eq_objtype[k]) != BODY or is_handle(model, k):
            continue
        ends = [int(model.eq_obj1id[k]), int(model.eq_obj2id[k])]
        names = [name_or_number(model, "body", body) for body in ends]
        parts, kind = [_part_geoms(model, body) for body in ends], equality_kind(model, k)
        shown = [
            bool(part) and _reaches_joints(model, data, body, detached) for body, part in zip(ends, parts, strict=True)
        ]
        if kind == "weld":
            pairs = [(a, b) for a in parts[0] for b in parts[1]] if all(shown) else []
            gaps = [mujoco.mj_geomDistance(model, data, a, b, 1e3 * model.stat.extent, None) for a, b in pairs]
            if gaps and min(gaps) > detached:
                yield PartsApart(closure_name(model, k), kind, names[1], names[0], float(min(gaps)))
            continue
        anchors = [model.eq_data[k, :3], model.eq_data[k, 3:6]]
        places = [data.xpos[b] + data.xmat[b].reshape(3, 3) @ a for b, a in zip(ends, anchors, strict=True)]
        away = [_part_distance(model, data, part, place) if seen else (0.0, 0.0)
                for part, place, seen in zip(parts, places, shown, strict=True)]  # fmt: skip
        limits = [min(detached, max(thickness, closely, LEAST_SHARE * model.stat.extent)) for _, thickness in away]
        worst = int(np.argmax([distance - limit for (distance, _), limit in zip(away, limits, strict=True)]))
        if away[worst][0] > limits[worst]:
            sites = tuple(name for b, p in zip(ends, places, strict=True) if (name := _nearest_site(model, data, b, p)))
            yield PartsApart(closure_name(model, k), kind, names[worst], names[1 - worst], away[worst][0],
                             sites if len(sites) == 2 else ())  # fmt: skip


def _joint_distance(model: mujoco.MjModel, data: mujoco.MjData) -> float:
    """Largest distance of a hinge or ball from the geoms of a link that it joins, of links that have geoms."""
    found = [0.0]
    for j in range(model.njnt):
        body = int(model.jnt_bodyid[j])
        for link in (body, int(model.body_parentid[body])) if joint_kind(model, j) in ("hinge", "ball") else ():
            if part := _part_geoms(model, link):
                found.append(_part_distance(model, data, part, data.xanchor[j])[0])
    return max(found)


def _part_distance(model: mujoco.MjModel, data: mujoco.MjData, geoms: list[int], place: Array) -> tuple[float, float]:
    """Distance of a point (3,) from the nearest of some geoms, and half of that geom's thickness."""
    nearest = min(geoms, key=lambda geom: _point_distance(model, data, geom, place))
    return _point_distance(model, data, nearest, place), float(model.geom_aabb[nearest, 3:].min())


def _part_geoms(model: mujoco.MjModel, body: int) -> list[int]:
    """Geoms of a body and of all bodies fixed to it; empty for the world."""
    part = int(model.body_weldid[body])
    return [g for g in range(model.ngeom) if part and int(model.body_weldid[model.geom_bodyid[g]]) == part]


def _reaches_joints(model: mujoco.MjModel, data: mujoco.MjData, body: int, least: float) -> bool:
    """True if all joints of a part are at its geoms."""
    part = int(model.body_weldid[body])
    joints = range(model.body_jntadr[part], model.body_jntadr[part] + model.body_jntnum[part])
    geoms = _part_geoms(model, body)
    return all(min(_point_distance(model, data, geom, data.xanchor[j]) for geom in geoms) <= least for j in joints)


def _point_distance(model: mujoco.MjModel, data: mujoco.MjData, geom: int, place: Array) -> float:
    """Distance of a point (3,) from a geom: from a capsule's axis, from the box about any other; 0 within."""
    local = data.geom_xmat[geom].reshape(3, 3).T @ (place - data.geom_xpos[geom])
    centre, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:].copy()
    if int(model.geom_type[geom]) == CAPSULE:
        half = np.array([0.0, 0.0, float(model.geom_size[geom, 1])])
    return float(np.linalg.norm(np.maximum(np.abs(local - centre) - half, 0.0)))


def _nearest_site(model: mujoco.MjModel, data: mujoco.MjData, body: int, place: Array) -> str:
    """Name of the site of a part that is nearest to a point; empty where the part has none with a name."""
    part = int(model.body_weldid[body])
    sites = [s for s in range(model.nsite) if int(model.body_weldid[model.site_bodyid[s]]) == part]
    named = {s: mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SITE, s) for s in sites}
    known = [s for s, name in named.items() if name]
    return named[min(known, key=lambda s: float(np.linalg.norm(data.site_xpos[s] - place)))] if known else ""


def apart_words(model: mujoco.MjModel) -> str:
    """Say which closures hold parts that do not meet, and what to do; empty where all parts meet."""
    return "; ".join(f"{one.words}, {one.cure}" for one in parts_apart(model))
