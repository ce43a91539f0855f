"""Balance the saw's slider: the counterweight on the crank that leaves the least shaking force on the frame."""

import sys
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import minimize_scalar

from conrod.exact.dynamics.inverse import joint_forces
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Instants
from conrod.scenes import scene_named

saw = scene_named("saw-coasting")  # or read_scene(Path("my_saw.toml"))
angle = np.linspace(0.0, 2.0 * np.pi, 721)
steady = Instants(angle / saw.speed, angle, np.full_like(angle, saw.speed), np.zeros_like(angle))


def shaking(counterweight: float) -> np.ndarray:
    """Force of the machine on its frame (2, T) [N], with a counterweight [kg m] opposite to the crank pin."""
    place = -counterweight / saw.parameters["bodies.crank.mass"]  # of the crank's centre of gravity
    weighted = saw.with_parameters(**{"bodies.crank.centre_of_gravity.x": place}).mechanism()
    bare = replace(weighted, gravity=(0.0, 0.0), loads=())  # neither weight nor friction shakes a frame
    joints = joint_forces(Kinematics(bare), steady).components
    return -np.array([joints["shaft"]["x"], joints["shaft"]["y"] + joints["slide"]["normal"]])


def peak(counterweight: float) -> float:
    """Largest shaking force of a turn [N]."""
    return float(np.hypot(*shaking(counterweight)).max())


best = minimize_scalar(peak, bounds=(0.0, 1.5), method="bounded", options={"xatol": 1e-4}).x
full = 0.1 * (1.5 + 6.0)  # [kg m], crank radius x (rod and slider): all of it balanced along the slide
for counterweight, line in ((0.0, ":"), (best, "-"), (full, "--")):
    plt.plot(*shaking(counterweight) / 1e3, line, label=f"{counterweight:.2f} kg m")
plt.gca().set(aspect="equal", xlabel="force on the frame along the slide [kN]", ylabel="across it [kN]")
plt.legend(title="counterweight", loc="lower left", bbox_to_anchor=(1.02, 0.0))
plt.savefig(Path(sys.argv[1] if sys.argv[1:] else __file__).with_suffix(".svg"), bbox_inches="tight")
