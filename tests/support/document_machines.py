"""Links of the catalogue's machines at a crank angle, for tests."""

from __future__ import annotations

from conrod.exact.linkage.state import LinkageState, linkage_state
from conrod.scenes import Scene


def state(scene: Scene, angle: float = 0.0) -> LinkageState:
    """Motion of all links; crank angle 0 is the printed instant."""
    return linkage_state(scene.kinematics, angle, scene.speed)


def turning(scene: Scene, link: str) -> float:
    """Angular velocity of a link [rad/s], counter-clockwise positive."""
    return state(scene).links[link].angular_velocity
