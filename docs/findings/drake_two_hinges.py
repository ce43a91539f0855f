# /// script
# requires-python = ">=3.11"
# dependencies = ["drake==1.51.1", "numpy"]
# ///
"""Drake's MJCF parser moves the first of two hinges of a body to the origin of the parent body.

A rod hangs on a body by two hinges, both at the rod's own origin, 80 mm from the parent's. Turned a quarter about the
first, it has to stay with its origin where the hinges are. In Drake it goes round the parent's origin. The same hinges
in two nested bodies, one each, are placed rightly: the two documents describe one machine.

Ends with status 1 while the defect is there, else with 0.
"""

import sys

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

INERTIA = '<inertial pos="0.1 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>'
PITCH, YAW = '<joint name="pitch" type="hinge" axis="0 1 0"/>', '<joint name="yaw" type="hinge" axis="0 0 1"/>'
MODEL = (
    '<mujoco model="machine"><compiler angle="radian"/><worldbody><body name="crank">{inertia}'
    '<joint name="crank" type="hinge" axis="0 0 1"/>{rod}</body></worldbody></mujoco>'
)
TOGETHER = f'<body name="rod" pos="0.08 0 0">{PITCH}{YAW}{INERTIA}</body>'
NESTED = f'<body name="fork" pos="0.08 0 0">{PITCH}{INERTIA}<body name="rod">{YAW}{INERTIA}</body></body>'
TIP = np.array([0.2, 0.0, 0.0])  # of the rod, in its own frame [m]


def rod_points(rod: str) -> np.ndarray:
    """Place (2, 3) [m] of the rod's origin and tip in Drake, turned a quarter about the hinge `pitch`."""
    plant = MultibodyPlant(0.001)
    Parser(plant).AddModelsFromString(MODEL.format(inertia=INERTIA, rod=rod), "xml")
    plant.Finalize()
    context = plant.CreateDefaultContext()
    plant.GetJointByName("pitch").set_angle(context, np.pi / 2)
    pose = plant.GetBodyByName("rod").EvalPoseInWorld(context)
    return np.array([pose.translation(), pose @ TIP])


def exact_points() -> np.ndarray:
    """The same by MuJoCo's documentation: origin + R (point - origin), the hinge's anchor being the rod's origin."""
    anchor = np.array([0.08, 0.0, 0.0])
    quarter = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])  # about y
    return np.array([anchor, anchor + quarter @ TIP])


def text(points: np.ndarray) -> str:
    """Places in millimetres."""
    return "; ".join(", ".join(f"{1e3 * value + 0.0:6.1f}" for value in np.round(point, 9)) for point in points)


exact, together, nested = exact_points(), rod_points(TOGETHER), rod_points(NESTED)
off = 1e3 * np.linalg.norm(together - exact, axis=1).max()
print("Drake 1.51.1, MJCF parser: a body with two hinges, both at its origin (80, 0, 0) mm in the parent.")
print("Turned 90 deg about the first hinge (axis y); rod's origin and tip, x, y, z in mm:")
print(f"  exact                         {text(exact)}")
print(f"  Drake, two hinges of one body {text(together)}")
print(f"  Drake, one hinge of each body {text(nested)}")
print(f"Two hinges of one body: off by {off:.1f} mm. The first is at the parent's origin, without a warning.")
sys.exit(1 if off > 1e-6 else 0)
