"""Mechanisms whose motion is known in closed form, and the table of those that ship."""

from __future__ import annotations

from conrod.errors import unknown_choice
from conrod.scenes.cam_follower import CamFollower
from conrod.scenes.saw import RPM, Saw
from conrod.scenes.scene import Scene
from conrod.scenes.shear_press import ShearPress

SCENES: dict[str, Scene] = {
    "shear-press": ShearPress(),
    "saw-40rpm": Saw(speed=40.0 * RPM),
    "saw-500rpm": Saw(speed=500.0 * RPM),
    "cam-follower": CamFollower(),
}


def scene_named(name: str) -> Scene:
    """The scene of a name that ships.

    Raises:
        InvalidInput: there is none; names the choices.
    """
    if name not in SCENES:
        raise unknown_choice("scene", name, SCENES)
    return SCENES[name]


__all__ = ["RPM", "SCENES", "CamFollower", "Saw", "Scene", "ShearPress", "scene_named"]
