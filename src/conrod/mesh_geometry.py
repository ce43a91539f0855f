"""Whether the wheels of rolling pairs are held where they touch, and how their turns belong together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from conrod.errors import InvalidInput
from conrod.joint_equations import joint_residual, pose_jets
from conrod.mechanism import GROUND, Body, Driver, Mechanism, Pose
from conrod.motion import Array
from conrod.rolling import Mesh, Rack, Rolling

# Of the distance; lengths are given in six digits or more.
OFF = 1e-6


def offset_in(mesh: Mesh, poses: Mapping[str, Pose]) -> float:
    """The offset [m] with which a rolling pair fits given poses, as told where two wheels' marks stand at the start."""
    bodies = tuple(Body(name, 1.0, 1.0) for name in dict.fromkeys((mesh.a, mesh.b)) if name != GROUND)
    pair = Mechanism(mesh.name, bodies, (), Driver(""), {}, ())
    stacked = np.array([poses[body.name] for body in bodies], dtype=float).reshape(1, -1)
    left = joint_residual(replace(mesh, offset=0.0), pose_jets(pair, [stacked]))[0].coefficients[0]
    return float(np.ravel(left)[0])


def check_meshes(mechanism: Mechanism, poses: Array) -> None:
    """Refuse rolling pairs whose other joints do not keep the wheels touching, in poses (T, 3 n).

    Raises:
        InvalidInput: names the pair, how far its centres are apart, and how far its radii ask for.
    """
    for mesh in mechanism.meshes:
        wanted = mesh.radius if isinstance(mesh, Rack) else mesh.distance
        found = _distances(mechanism, mesh, poses)
        worst = float(found[np.argmax(np.abs(found - wanted))])
        if abs(worst - wanted) > OFF * wanted:
            what = {
                Rolling: f"the centres are {worst:.9g} m apart, the radii ask for {wanted:.9g} m",
                Rack: f"the wheel's centre is {worst:.9g} m left of the line, the radius asks for {wanted:.9g} m",
            }
            raise InvalidInput(f"{mechanism.name}: {mesh.name}: {what[type(mesh)]}; other joints must hold them so")


def _distances(mechanism: Mechanism, mesh: Mesh, poses: Array) -> Array:
    """Of the centres, or of the wheel's centre from the rack's line (T,) [m]."""
    bodies = pose_jets(mechanism, [poses])
    (ax, ay), (bx, by) = bodies[mesh.a].point(mesh.point_a), bodies[mesh.b].point(mesh.point_b)
    dx, dy = (np.broadcast_to((q - p).coefficients[0], len(poses)) for p, q in ((ax, bx), (ay, by)))
    if isinstance(mesh, Rolling):
        return np.asarray(np.hypot(dx, dy))
    line = np.broadcast_to(bodies[mesh.b].phi.coefficients[0], len(poses)) + mesh.direction
    return np.asarray(dx * np.sin(line) - dy * np.cos(line))
