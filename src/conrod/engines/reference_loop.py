"""The slider-crank that timings are ratios to, run with each engine's defaults at 1000 steps a turn.

NEVER CHANGE IT: ratios of any date and machine relate to this very system. A driven crank of 0.1 m, a rod of 0.3 m and
a slider, in line at the start; no gravity.
"""

from __future__ import annotations

from dataclasses import dataclass

from conrod.exact.kinematics import Kinematics
from conrod.mechanism.mechanism import GROUND, Body, Driver, Mechanism, Prismatic, Revolute

SLIDER_CRANK = Mechanism(
    name="reference loop",
    bodies=(Body("crank", 4.0, 0.02), Body("rod", 1.5, 0.01125), Body("slider", 6.0, 0.06)),
    joints=(
        Revolute("shaft", GROUND, "crank", (0.0, 0.0), (0.0, 0.0)),
        Revolute("crank-pin", "crank", "rod", (0.1, 0.0), (-0.15, 0.0)),
        Revolute("slider-pin", "rod", "slider", (0.15, 0.0), (0.0, 0.0)),
        Prismatic("slide", GROUND, "slider", (0.0, 0.0), (0.0, 0.0), direction=0.0),
    ),
    driver=Driver("shaft"),
    poses={"crank": (0.0, 0.0, 0.0), "rod": (0.25, 0.0, 0.0), "slider": (0.4, 0.0, 0.0)},
    observed=(),
)


@dataclass(frozen=True)
class Driven:
    """A mechanism at a speed [rad/s]."""

    kinematics: Kinematics
    speed: float


# One turn a second.
REFERENCE = Driven(Kinematics(SLIDER_CRANK), 6.283185307179586)
