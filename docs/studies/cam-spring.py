"""Choose the cam's spring: the softest one that keeps the roller on the cam, tried by contact in an engine."""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from conrod import MuJoCoSettings, run
from conrod.exact.dynamics.inverse import joint_forces
from conrod.exact.motion import Instants
from conrod.scenes import Scene, scene_named

SPEED, LEAST_PUSH, PRELOAD = 20.0, 5.0, 10.0  # [rad/s], [N] left between cam and roller, [N] on the base circle
cam = scene_named("cam-spring-slow")  # or read_scene(Path("my_cam.toml"))
angle = np.union1d(np.linspace(0.0, 2.0 * np.pi, 721), np.array(cam.break_angles()) + 1e-6)
steady = Instants(angle / SPEED, angle, np.full_like(angle, SPEED), np.zeros_like(angle))


def sprung(stiffness: float) -> Scene:
    """Give the cam another spring [N/m], which is 255 mm long on the base circle."""
    rest = 0.255 + PRELOAD / stiffness
    return cam.with_parameters(**{"speed": SPEED, "springs.spring.stiffness": stiffness, "springs.spring.rest": rest})


def push(stiffness: float) -> np.ndarray:
    """Force between cam and roller (T,) [N]."""
    return joint_forces(sprung(stiffness).kinematics, steady).components["contact"]["contact"]


soft, rise = push(100.0), (push(200.0) - push(100.0)) / 100.0  # the push grows with the stiffness in proportion
lifted = rise > 1e-6  # off the base circle, where the preload alone pushes
least = 100.0 + float(np.max((LEAST_PUSH - soft)[lifted] / rise[lifted]))  # [N/m]
gaps, (above, below) = [], plt.subplots(2, 1, sharex=True, layout="constrained")[1]
for stiffness, line in ((least, "-"), (0.8 * least, "--")):
    roller = run(sprung(stiffness), MuJoCoSettings.tuned(sprung(stiffness), 7854), 1.0).points["roller"].position
    gaps.append(gap := (roller.values - cam.motion(roller.instants.angle, SPEED).points["roller"].position)[:, 1])
    above.plot(np.degrees(angle), push(stiffness), line, label=f"{stiffness / 1e3:.2f} N/mm")
    below.plot(np.degrees(roller.instants.angle), 1e6 * gap, line, label=f"at most {1e6 * gap.max():.1f} µm")
above.set(ylabel="exact push [N]"), above.legend()
below.set(xlabel="crank angle [deg]", ylabel="gap in MuJoCo's run [µm]"), below.legend()
plt.savefig(Path(sys.argv[1] if sys.argv[1:] else __file__).with_suffix(".svg"))
