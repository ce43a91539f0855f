"""Size the flywheel of the press: the least one that keeps its speed within a given fluctuation."""

import sys
from functools import cache
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

from conrod.exact.dynamics.forward import ForwardDynamics
from conrod.scenes import scene_named

WANTED = 0.05  # (fastest - slowest) / mean speed, over a turn
CUT = 100.0  # [J], what the blade takes in a turn
press = scene_named("press-cutting")  # or read_scene(Path("my_press.toml"))
times = np.linspace(0.0, 3.4, 341)  # [s], three turns, of which the first ones settle


@cache
def course(flywheel: float) -> tuple[np.ndarray, np.ndarray]:
    """Crank angle [deg] and speed [rad/s] of the last turn, with a flywheel [kg m^2] on the crankshaft."""
    fitted = press.with_parameters(**{"bodies.crank.inertia": press.parameters["bodies.crank.inertia"] + flywheel})
    motion = ForwardDynamics(fitted.mechanism()).motion(times, rates=fitted.start_rates)
    at = 3 * fitted.mechanism().body_index["crank"] + 2
    angle, speed = np.degrees(np.pi / 2 - motion.poses[:, at]), -motion.rates[:, at]
    order = np.argsort(angle[last := angle > angle[-1] - 360.0] % 360.0)
    return angle[last][order] % 360.0, speed[last][order]


least = brentq(lambda flywheel: np.ptp(speed := course(flywheel)[1]) / speed.mean() - WANTED, 40.0, 60.0, xtol=0.1)
rule = CUT / (WANTED * course(least)[1].mean() ** 2)  # [kg m^2], as if the flywheel alone did the cut
for flywheel, line in ((5.0, ":"), (15.0, "--"), (least, "-")):
    plt.plot(*course(flywheel), line, label=f"flywheel of {flywheel:.1f} kg m²")
plt.xlabel("crank angle [deg]")
plt.ylabel("crank speed [rad/s]")
plt.legend()
plt.savefig(Path(sys.argv[1] if sys.argv[1:] else __file__).with_suffix(".svg"), bbox_inches="tight")
