"""Kinematic mode: MuJoCo's own kinematics at the exact coordinates, and what is met on the way."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.engines.mujoco.dynamics import warnings_kept_quiet
from conrod.exact.space.motion import DrivenTree, SpatialMotion
from conrod.mjcf.loops.driving import gaps_of, start_state
from conrod.mjcf.loops.results import QUANTITIES
from conrod.own.models.loading import FoundPoint, listed, name_or_number


def kinematic_mode(
    model: mujoco.MjModel, machine: DrivenTree, points: tuple[FoundPoint, ...], motion: SpatialMotion
) -> tuple[dict[str, float], tuple[str, ...]]:
    """Distance of MuJoCo's kinematics from the exact motion, over its largest values; and what is met on the way."""
    off, sizes = dict.fromkeys(QUANTITIES, 0.0), dict.fromkeys(QUANTITIES, 0.0)
    data, opened, touching = mujoco.MjData(model), 0.0, dict[str, None]()
    start = {p.name: motion.points[p.name].position[0] for p in points}
    for k in range(len(motion.times)):
        start_state(data, motion, k)
        with warnings_kept_quiet():
            mujoco.mj_forward(model, data)
        data.qacc[:] = motion.rates[1, :, k]
        mujoco.mj_rnePostConstraint(model, data)
        opened = max([opened, *gaps_of(machine.tree, model, data).values()])
        for contact in data.contact[: data.ncon]:
            if contact.dist < 0.0:
                touching[" and ".join(_part(model, int(g)) for g in contact.geom)] = None
        for point in points:
            exact = motion.points[point.name]
            for name, found in zip(QUANTITIES, point.motion(model, data), strict=True):
                truth = getattr(exact, name)[k]
                size = truth - start[point.name] if name == "position" else truth
                sizes[name] = max(sizes[name], float(np.linalg.norm(size)))
                off[name] = max(off[name], float(np.linalg.norm(found - truth)))
    shares = {name: off[name] / max(sizes[name], 1e-300) for name in QUANTITIES if sizes[name] > 1e-12}
    # Loops that contradict each other stay open; two bodies' rows may each have the misfit.
    shares["closures"] = max(opened - 2.0 * machine.misfit, 0.0) / sizes["position"] if sizes["position"] else 0.0
    return shares, tuple(_met(machine, motion, list(touching)))


def _met(machine: DrivenTree, motion: SpatialMotion, touching: list[str]) -> Iterator[str]:
    if touching:
        yield f"parts touch on the way: {listed(touching)}; the runs have these contacts, the exact motion has none"
    for joint in machine.tree.joints:
        if joint.range is not None and joint.kind in ("hinge", "slide"):
            factor, unit = (np.degrees(1.0), "deg") if joint.unit == "rad" else (1e3, "mm")
            values = motion.coordinates[joint.coordinate]
            over = max(joint.range[0] - values.min(), values.max() - joint.range[1])
            if over > 1e-6:
                limits = f"{factor * joint.range[0]:.4g} to {factor * joint.range[1]:.4g}"
                yield (
                    f"{joint.name} is up to {factor * over:.3g} {unit} beyond its limits, {limits}: "
                    "the runs have these limits, the exact motion has none"
                )


def _part(model: mujoco.MjModel, geom: int) -> str:
    """A geom's name, or its body's."""
    own = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_GEOM, geom)
    return own or name_or_number(model, "body", int(model.geom_bodyid[geom]))
