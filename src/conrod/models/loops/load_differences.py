"""Differences of a model's masses, damping and gravity from those of the machine that it is to be, by name.

They do not show in the exact motion of a machine whose inputs are prescribed, but in its forces and in engines' errors.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from conrod.exact.space import SpatialBody, SpatialTree

LOAD_TOLERANCE = 1e-5  # share by which numbers of a file with six digits, and products of them, may differ


def list_load_differences(model: SpatialTree, machine: SpatialTree) -> Iterator[str]:
    """List masses, centres of gravity, inertias, damping and gravity that differ from the machine's, in words."""
    if _differs(model.gravity, machine.gravity):
        own, theirs = (" ".join(f"{value:.6g}" for value in tree.gravity) for tree in (model, machine))
        yield f"gravity is ({own}) instead of ({theirs}) m/s²"
    own_bodies = {body.name: body for body in model.bodies[1:]}
    for body in machine.bodies[1:]:
        if (mine := own_bodies.get(body.name)) is not None:
            yield from _body_changes(mine, body, machine.extent)
    own_joints = {joint.name: joint for joint in model.joints}
    for joint in machine.joints:
        found = own_joints.get(joint.name)
        if found is None or found.kind != joint.kind:
            continue
        unit = "N m s/rad" if joint.unit == "rad" else "N s/m"
        if _differs(found.damping, joint.damping):
            yield f"the damping of {joint.name} is {found.damping:.6g} instead of {joint.damping:.6g} {unit}"


def _body_changes(body: SpatialBody, theirs: SpatialBody, extent: float) -> Iterator[str]:
    if _differs(body.mass, theirs.mass):
        yield f"{body.name} has {body.mass:.6g} kg instead of {theirs.mass:.6g} kg"
    if (off := float(np.linalg.norm(body.centre - theirs.centre))) > LOAD_TOLERANCE * extent:
        yield f"the centre of gravity of {body.name} is {1e3 * off:.3g} mm off"
    if _differs(body.inertia, theirs.inertia):
        yield f"{body.name} has another inertia about its centre of gravity"


def _differs(one: object, other: object) -> bool:
    """True if numbers, or arrays of one shape, differ by more than rounding of the largest."""
    a, b = np.asarray(one, dtype=float), np.asarray(other, dtype=float)
    return bool(np.abs(a - b).max() > LOAD_TOLERANCE * max(np.abs(a).max(), np.abs(b).max()))
