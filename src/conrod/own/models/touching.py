"""A higher pair of a user's model: which geoms touch, and where they just do."""

from __future__ import annotations

import mujoco
import numpy as np

from conrod.engines.cam_polygon import convex_hull
from conrod.engines.numerics import close_gap
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.models.assembly import Assembly
from conrod.own.models.loading import element_id, name_or_number
from conrod.own.models.model_facts import Touching

# Of the model's extent: how far the distance of two geoms is looked for, how far a follower is nudged to see it
# change (the single precision of meshes makes it rough below), and what is no distance.
FAR, NUDGE, CLOSED = 1e3, 1e-6, 1e-12


class Gap:
    """Two geoms, and the one way in which the model can move to bring them together."""

    def __init__(self, assembly: Assembly, geoms: tuple[int, int]) -> None:
        self._assembly = assembly
        self.geoms = geoms
        self._extent = float(assembly.model.stat.extent)

    def distance(self) -> float:
        """Signed, in the model's unit of length."""
        model, data = self._assembly.model, self._assembly.data
        return float(mujoco.mj_geomDistance(model, data, *self.geoms, FAR * self._extent, None))

    def close(self) -> None:
        """Move what the closures leave free until the geoms just touch."""
        assembly = self._assembly
        base, way = assembly.data.qpos.copy(), assembly.left_free()[0]

        def moved(by: float) -> float:
            assembly.data.qpos[:] = base
            mujoco.mj_integratePos(assembly.model, assembly.data.qpos, way, by)
            assembly.close()
            return self.distance()

        close_gap(moved, 0.0, NUDGE * self._extent, CLOSED * self._extent)
        if abs(self.distance()) > NUDGE * self._extent:
            names = " and ".join(name_or_number(assembly.model, "geom", g) for g in self.geoms)
            degrees = np.degrees(assembly.coordinate())
            raise InvalidInput(f"{names} cannot be brought to touch with the crank at {degrees:.6g} deg")


def find_gap(assembly: Assembly, named: tuple[str, str] | None) -> Gap:
    """The pair that is named, or else the nearest pair of a geom that turns with the crank and one that does not.

    Raises:
        InvalidInput: there is no such geom, or no pair that may collide.
    """
    model = assembly.model
    if named is not None:
        return Gap(assembly, (element_id(model, "geom", named[0]), element_id(model, "geom", named[1])))
    pairs = [Gap(assembly, pair) for pair in _candidates(model, int(model.jnt_bodyid[assembly.crank.joint]))]
    if not pairs:
        raise InvalidInput(
            "nothing that turns with the crank may collide with what it is to move; "
            "name the two geoms with --touching CAM,ROLLER"
        )
    return min(pairs, key=lambda pair: abs(pair.distance()))


def _candidates(model: mujoco.MjModel, crank: int) -> list[tuple[int, int]]:
    """Pairs of a geom that turns with the crank and a movable one that does not, which may collide."""
    turning = [g for g in range(model.ngeom) if _is_below(model, int(model.geom_bodyid[g]), crank)]
    others = [g for g in range(model.ngeom) if g not in turning and model.body_weldid[model.geom_bodyid[g]] != 0]
    paired = {frozenset(pair) for pair in zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True)}
    return [(a, b) for a in turning for b in others if frozenset((a, b)) in paired or _may_collide(model, a, b)]


def _may_collide(model: mujoco.MjModel, a: int, b: int) -> bool:
    there, back = (
        model.geom_contype[a] & model.geom_conaffinity[b],
        model.geom_contype[b] & model.geom_conaffinity[a],
    )
    return bool(there or back)


def _is_below(model: mujoco.MjModel, body: int, ancestor: int) -> bool:
    while body not in (0, ancestor):
        body = int(model.body_parentid[body])
    return body == ancestor


def touching(gap: Gap, model: mujoco.MjModel, axis: Array) -> Touching:
    """The pair in words, with the error of its shapes.

    Args:
        axis: of the crank, across which the shapes are flat.
    """
    shapes = [_shape_error(model, geom, axis) for geom in gap.geoms]
    names = tuple(name_or_number(model, "geom", geom) for geom in gap.geoms)
    return Touching((names[0], names[1]), max(e for e, _ in shapes), sum(count for _, count in shapes))


def _shape_error(model: mujoco.MjModel, geom: int, axis: Array) -> tuple[float, int]:
    """Depth of a mesh's facets under the smooth curve through its corners, seen along an axis; and their number.

    A chord of length e whose ends turn by t is e tan(t / 4) / 2 away from the arc over it.
    """
    if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_MESH:
        return 0.0, 0
    mesh = int(model.geom_dataid[geom])
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    corners = _across(np.asarray(model.mesh_vert[first : first + count], dtype=float), model, geom, axis)
    outline = convex_hull(np.column_stack([corners.real, corners.imag])) @ np.array([1.0, 1.0j])
    edges = np.roll(outline, -1) - outline
    turns = np.angle(np.roll(edges, -1) / edges)  # at the end of each edge
    share = 0.5 * (turns + np.roll(turns, 1))
    single = float(np.finfo(np.float32).eps) * float(np.abs(outline).max())
    return float((0.5 * np.abs(edges) * np.tan(share / 4.0)).max()) + single, len(outline)


def _across(vertices: Array, model: mujoco.MjModel, geom: int, axis: Array) -> Array:
    """Vertices of a geom's mesh as complex numbers in the plane across an axis that its body's start pose has."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    placed = vertices @ data.geom_xmat[geom].reshape(3, 3).T
    aside = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    aside /= np.linalg.norm(aside)
    return np.asarray(placed @ aside + 1j * (placed @ np.cross(axis, aside)))
