"""The Jacobian and the series of every joint kind are the derivatives of its own residual, whichever body moves."""

from __future__ import annotations

import numpy as np
import pytest
from catalogue import CAM

from conrod.exact.joint_equations import joint_jacobian, joint_residual, pose_jets
from conrod.exact.motion import Array
from conrod.mechanism.cam import DWELL, LAWS, Segment
from conrod.mechanism.cam_law import LawProfile
from conrod.mechanism.mechanism import (
    GROUND,
    Body,
    CamContact,
    Driver,
    Joint,
    Mechanism,
    Prismatic,
    Rack,
    Revolute,
    Rolling,
)

STEP = 1e-6
POSES = np.array([[0.3, -0.2, 0.7, 0.5, 0.4, -0.9]])  # of the two bodies, nothing special
# A roller near its cam, where a law's gap is a distance.
NEAR = np.array([[0.003, -0.002, 0.7, 0.02, 0.11, -0.9]])
PROFILE = CAM.mechanism().cam_contacts[0].profile


def cam_of(law: str, offset: float) -> CamContact:
    segments = (Segment(law, 2.0, 0.033), Segment(DWELL, 1.0, 0.0), Segment(law, 2.0 * np.pi - 3.0, -0.033))
    profile = LawProfile(0.076, 0.009, segments, 1.3, 1, offset)
    return CamContact("contact", "a", "b", profile, (0.01, -0.02), 0.009)


JOINTS: dict[str, Joint] = {
    "pin": Revolute("pin", "a", "b", (0.1, -0.3), (0.2, 0.4)),
    "slide on a moving link": Prismatic("slide", "a", "b", (0.1, -0.3), (0.2, 0.4), 0.6, 0.1),
    "cam of arcs": CamContact("contact", "a", "b", PROFILE, (0.2, 0.4), 0.01),
    "gears": Rolling("mesh", "a", "b", (0.1, 0.2), (-0.1, 0.3), 0.3, 0.2, 0.05),
    "ring gear": Rolling("mesh", "a", "b", (0.0, 0.0), (-0.1, 0.3), -0.3, 0.2),
    "rack": Rack("rack", "a", "b", (0.1, 0.2), (0.3, 0.1), 0.2, 0.7, 0.01),
    "track": Rack("rack", "a", GROUND, (0.0, 0.0), (0.3, 0.1), 0.2, 0.7),
    **{f"cam of law {law} {e}": cam_of(law, e) for law in LAWS if law != DWELL for e in (0.0, 0.012)},
}


def two_links(joint: Joint) -> Mechanism:
    return Mechanism("two", (Body("a", 1.0, 1.0), Body("b", 1.0, 1.0)), (joint,), Driver(joint.name), {}, ())


def coefficients(joint: Joint, *series: Array) -> Array:
    """Of the residual along Taylor coefficients of the poses; one row for each equation."""
    left = joint_residual(joint, pose_jets(two_links(joint), series))
    return np.array([[float(np.ravel(c)[0]) for c in equation.coefficients] for equation in left])


@pytest.mark.parametrize("name", JOINTS)
def test_joint_jacobian_matches_differences_of_residual(name: str) -> None:
    joint, start = JOINTS[name], NEAR if "law" in name else POSES
    rows = joint_jacobian(joint, pose_jets(two_links(joint), [start]))
    told = np.array([[float(np.ravel(value)[0]) for side in row for value in side] for row in rows])
    told[:, 3:] *= joint.b != GROUND
    shifts = STEP * np.eye(6)[:, None, :]
    ways = [coefficients(joint, start + s) - coefficients(joint, start - s) for s in shifts]
    measured = np.hstack(ways) / (2.0 * STEP)
    assert np.abs(told - measured).max() < 1e-8
    # Negative control: one sign wrong, in the column of the first body's turn, is seen.
    wrong = told * [1, 1, -1, 1, 1, 1]
    assert np.abs(wrong - measured).max() > 1e-3
    way, bend = 0.1 * np.random.default_rng(3).normal(size=(2, 1, 6))
    series, h = coefficients(joint, start, way, bend), 1e-3
    before, here, after = (coefficients(joint, start + t * way + t**2 * bend)[:, 0] for t in (-h, 0.0, h))
    np.testing.assert_allclose(series[:, 1], told @ way[0], atol=1e-12)
    np.testing.assert_allclose(series[:, 1], (after - before) / (2 * h), atol=1e-5)
    np.testing.assert_allclose(series[:, 2], (after - 2 * here + before) / (2 * h**2), atol=1e-5)
