"""Chains of parallelogram four-bars in free swing, as in the benchmark of the IFToMM library."""

from __future__ import annotations

import math

from conrod.mechanism.mechanism import GROUND, Body, Driver, Joint, Mechanism, ObservedPoint, Pose, Revolute


def chain(count: int) -> Mechanism:
    """So many four-bars one beside the other, links of 1 m and 1 kg, upright; the crank angle counts clockwise."""
    bodies, joints, poses = list[Body](), list[Joint](), dict[str, Pose]()
    for i in range(count + 1):
        bodies.append(Body(f"rocker{i}", 1.0, 1.0 / 12.0, (0.5, 0.0)))
        joints.append(Revolute(f"pivot{i}", GROUND, f"rocker{i}", (float(i), 0.0), (0.0, 0.0)))
        poses[f"rocker{i}"] = (float(i), 0.0, 0.5 * math.pi)
    for i in range(count):
        bodies.append(Body(f"bar{i}", 1.0, 1.0 / 12.0, (0.5, 0.0)))
        joints.append(Revolute(f"left{i}", f"rocker{i}", f"bar{i}", (1.0, 0.0), (0.0, 0.0)))
        joints.append(Revolute(f"right{i}", f"bar{i}", f"rocker{i + 1}", (1.0, 0.0), (1.0, 0.0)))
        poses[f"bar{i}"] = (float(i), 1.0, 0.0)
    return Mechanism(
        f"chain{count}",
        tuple(bodies),
        tuple(joints),
        Driver("pivot0", -1, 0.5 * math.pi),
        poses,
        (ObservedPoint("tip", "rocker0", (1.0, 0.0)),),
        gravity=(0.0, -9.81),
    )
