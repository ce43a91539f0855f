# /// script
# requires-python = ">=3.10"
# dependencies = ["newton[sim]>=1.8", "numpy"]
# ///
"""SolverMuJoCo ignores the child frame of a fixed joint that closes a loop. Ends 1 while it does.

Two bars on parallel hinges to the world, z, without gravity and at rest. A fixed joint outside the articulation, whose
frame on the second bar is turned by -30 deg, holds the second bar at +30 deg to the first, and so they start: in
equilibrium, so that the exact angle between them stays 30 deg. The second way is SolverXPBD on the same model.
"""

import warnings
from collections.abc import Callable
from typing import Any

import newton
import numpy as np
import warp as wp

ANGLE, STEP, STEPS = np.radians(30.0), 1e-3, 1000


def angle_between(make: Callable[[Any], Any]) -> float:
    """Angle [deg] from the first bar to the second after a second."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    inertia = wp.mat33(1e-2, 0.0, 0.0, 0.0, 1e-2, 0.0, 0.0, 0.0, 1e-2)
    bars = [builder.add_link(mass=1.0, inertia=inertia) for _ in range(2)]
    z = wp.vec3(0.0, 0.0, 1.0)
    hinge = {"axis": wp.vec3(1.0, 0.0, 0.0)}  # the frame's x axis, which is along the world's z
    upright = wp.transform(wp.vec3(), wp.quat_from_axis_angle(wp.vec3(0.0, 1.0, 0.0), float(-np.pi / 2.0)))
    joints = [builder.add_joint_revolute(-1, bar, parent_xform=upright, child_xform=upright, **hinge) for bar in bars]
    builder.add_articulation(joints[:1])
    builder.add_articulation(joints[1:])
    held = wp.transform(wp.vec3(), wp.quat_from_axis_angle(z, float(-ANGLE)))
    builder.add_joint_fixed(bars[0], bars[1], child_xform=held)
    builder.joint_q[1] = float(ANGLE)
    model = builder.finalize(device="cpu")
    solver = make(model)
    state, other, control = model.state(), model.state(), model.control()
    newton.eval_fk(model, model.joint_q, model.joint_qd, state)
    for _ in range(STEPS):
        state.clear_forces()
        solver.step(state, other, control, None, STEP)
        state, other = other, state
    turns = [2.0 * np.arctan2(q[5], q[6]) for q in state.body_q.numpy().astype(float)]
    return float(np.degrees(np.remainder(turns[1] - turns[0] + np.pi, 2.0 * np.pi) - np.pi))


if __name__ == "__main__":
    wp.config.log_level = wp.LOG_ERROR
    warnings.simplefilter("ignore")
    mujoco = angle_between(lambda model: newton.solvers.SolverMuJoCo(model, use_mujoco_cpu=True))
    xpbd = angle_between(lambda model: newton.solvers.SolverXPBD(model, iterations=20))
    print(f"newton {newton.__version__}: angle that a fixed loop joint holds, after 1 s; exact: 30 deg")
    print(f"SolverMuJoCo: {mujoco:.1f} deg")
    print(f"SolverXPBD: {xpbd:.1f} deg")
    raise SystemExit(int(abs(mujoco - 30.0) > 1.0))
