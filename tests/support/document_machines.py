"""Links of the catalogue's machines at the printed instant, for tests."""

from __future__ import annotations

from conrod.exact.linkage import LinkMotion, instant_quantities
from conrod.scenes import Scene


def link_motion(scene: Scene, name: str) -> LinkMotion:
    """Motion of a link; crank angle 0 is the printed instant."""
    links = instant_quantities(scene.kinematics, 0.0, scene.speed).links
    return next(link for link in links if link.link == name)


def turning(scene: Scene, name: str) -> float:
    """Angular velocity of a link [rad/s], counter-clockwise positive."""
    return link_motion(scene, name).rate[2]
