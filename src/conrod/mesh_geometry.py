"""Whether the wheels of rolling pairs are held where they touch."""

from __future__ import annotations

import numpy as np

from conrod.errors import InvalidInput
from conrod.joint_equations import pose_jets
from conrod.mechanism import Mechanism
from conrod.motion import Array
from conrod.rolling import Mesh, Rack, Rolling

# Of the distance; lengths are given in six digits or more.
OFF = 1e-6


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
