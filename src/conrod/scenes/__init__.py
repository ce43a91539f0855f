"""Mechanisms whose motion is known in closed form, and the table of those that ship."""

from __future__ import annotations

from conrod.errors import Named
from conrod.scenes.cam_follower import CamFollower
from conrod.scenes.scene import Scene
from conrod.scenes.slider_cranks import RPM, Saw, ShearPress

SCENES: dict[str, Scene] = Named(
    {
        "shear-press": ShearPress(),
        "saw-40rpm": Saw(speed=40.0 * RPM),
        "saw-500rpm": Saw(speed=500.0 * RPM),
        "cam-follower": CamFollower(),
    },
    "scene",
)

__all__ = ["RPM", "SCENES", "CamFollower", "Saw", "Scene", "ShearPress"]
