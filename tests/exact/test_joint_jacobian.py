"""The Jacobian of every joint kind is the derivative of its own residual, whichever of its bodies moves."""

from __future__ import annotations

import numpy as np
import pytest
from catalogue import CAM

from conrod.exact.joint_equations import joint_jacobian, joint_residual, pose_jets
from conrod.mechanism.mechanism import Body, Driver, Joint, Mechanism, Prismatic, Revolute

STEP = 1e-6
POSES = np.array([[0.3, -0.2, 0.7, 0.5, 0.4, -0.9]])  # of the two bodies, nothing special
JOINTS: dict[str, Joint] = {
    "pin": Revolute("pin", "a", "b", (0.1, -0.3), (0.2, 0.4)),
    "slide on a moving link": Prismatic("slide", "a", "b", (0.1, -0.3), (0.2, 0.4), 0.6, 0.1),
    "cam contact": CAM.mechanism()
    .cam_contacts[0]
    .__class__("contact", "a", "b", CAM.mechanism().cam_contacts[0].profile, (0.2, 0.4), 0.01),
}


def mechanism(joint: Joint) -> Mechanism:
    bodies = (Body("a", 1.0, 1.0), Body("b", 1.0, 1.0))
    return Mechanism("two links", bodies, (joint,), Driver(joint.name), {"a": (0, 0, 0), "b": (0, 0, 0)}, ())


def residual(joint: Joint, poses: np.ndarray) -> np.ndarray:
    left = joint_residual(joint, pose_jets(mechanism(joint), [poses]))
    return np.array([float(np.squeeze(entry.coefficients[0])) for entry in left])


@pytest.mark.parametrize("name", sorted(JOINTS))
def test_a_joints_jacobian_is_the_derivative_of_its_residual(name: str) -> None:
    joint = JOINTS[name]
    rows = joint_jacobian(joint, pose_jets(mechanism(joint), [POSES]))
    told = np.array([[float(np.squeeze(value)) for side in row for value in side] for row in rows])
    measured = np.empty_like(told)
    for column in range(POSES.shape[1]):
        shift = np.zeros_like(POSES)
        shift[0, column] = STEP
        measured[:, column] = (residual(joint, POSES + shift) - residual(joint, POSES - shift)) / (2.0 * STEP)
    assert np.abs(told - measured).max() < 1e-8
    # Negative control: one sign wrong, in the column of the first body's turn, is seen.
    wrong = told.copy()
    wrong[0, 2] *= -1.0
    assert np.abs(wrong - measured).max() > 1e-2
