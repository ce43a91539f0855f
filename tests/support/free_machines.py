"""Machines that swing freely."""

from __future__ import annotations

import math
from dataclasses import replace

from linkages import four_bar, slider_crank

from conrod.mechanism.mechanism import GROUND, Body, Driver, Joint, Mechanism, ObservedPoint, Revolute

GRAVITY = (0.0, -9.81)

# Released at rest, crank and rocker swing without either turning all the way round.
SWINGING_FOUR_BAR = replace(four_bar(0.1, 0.3, 0.25, 0.32), gravity=GRAVITY)
SWINGING_SLIDER_CRANK = replace(slider_crank(0.1, 0.3), gravity=GRAVITY)


def chain(four_bars: int) -> Mechanism:
    """Four-bars side by side, all bars of 1 m and 1 kg: rockers that stand upright, with a bar from tip to tip.

    All lie flat along each other at two angles of the rockers, where the branches of every four-bar meet.
    """
    bodies, joints, poses = [], list[Joint](), {}
    for i in range(four_bars + 1):
        bodies.append(Body(f"rocker{i}", 1.0, 1.0 / 12.0, (0.5, 0.0)))
        joints.append(Revolute(f"pivot{i}", GROUND, f"rocker{i}", (float(i), 0.0), (0.0, 0.0)))
        poses[f"rocker{i}"] = (float(i), 0.0, 0.5 * math.pi)
    for i in range(four_bars):
        bodies.append(Body(f"bar{i}", 1.0, 1.0 / 12.0, (0.5, 0.0)))
        joints.append(Revolute(f"left{i}", f"rocker{i}", f"bar{i}", (1.0, 0.0), (0.0, 0.0)))
        joints.append(Revolute(f"right{i}", f"bar{i}", f"rocker{i + 1}", (1.0, 0.0), (1.0, 0.0)))
        poses[f"bar{i}"] = (float(i), 1.0, 0.0)
    driver = Driver("pivot0", -1, 0.5 * math.pi)
    tip = (ObservedPoint("tip", "rocker0", (1.0, 0.0)),)
    return Mechanism(f"chain-{four_bars}", tuple(bodies), tuple(joints), driver, poses, tip, gravity=GRAVITY)
