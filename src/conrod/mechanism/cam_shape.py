"""Limits of a cam that is made from a motion law: undercutting by its roller, and concave parts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from conrod.errors import InvalidInput
from conrod.mechanism.cam import CamProfile
from conrod.mechanism.cam_law import TURN, LawProfile

Profile = CamProfile | LawProfile

SAMPLES = 360
# Of the roller's radius: less than this between roller and profile is rounding.
TOUCHING = 1e-9
HALVINGS, DOUBLINGS = 50, 80


def check_cut(profile: LawProfile) -> None:
    """Refuse a profile that its roller cannot roll on.

    Raises:
        InvalidInput: names the least base radius.
    """
    if can_roll(profile):
        return
    bend = profile.least_radius + profile.roller_radius
    why = (
        f"the pitch curve bends with a radius of {bend:.4g} m"
        if profile.least_radius <= 0.0
        else "it meets the profile elsewhere, too"
    )
    raise InvalidInput(
        f"a roller of {profile.roller_radius:g} m undercuts the cam: {why}; a base_radius of at least "
        f"{least_base_radius(profile, can_roll):.6g} m or a smaller roller is needed"
    )


def can_roll(profile: LawProfile) -> bool:
    """True where the pitch curve bends less than the roller, and the roller nowhere reaches into the profile."""
    if profile.least_radius <= 0.0:
        return False
    angle = np.linspace(0.0, TURN, SAMPLES, endpoint=False)
    rim, centres = profile.points(angle), profile.pitch(angle).points
    nearest = np.hypot(*(rim[:, None, :] - centres[None, :, :]).transpose(2, 0, 1)).min()
    return bool(nearest >= profile.roller_radius * (1.0 - TOUCHING))


def concave_reason(profile: Profile) -> str | None:
    """None, or why a profile cannot be given to engines that collide convex shapes."""
    if isinstance(profile, CamProfile) or profile.is_convex:
        return None
    enough = least_base_radius(profile, lambda other: other.is_convex)
    return (
        "the cam's profile is hollow in places, and a collision shape is convex: a base_radius of at least "
        f"{enough:.6g} m makes it so"
    )


def least_base_radius(profile: LawProfile, good: Callable[[LawProfile], bool]) -> float:
    """The least base radius [m], rounded up, from which on a profile of the same law is good; it is not yet."""
    low = high = profile.base_radius
    for _ in range(DOUBLINGS):
        high *= 2.0
        if good(replace(profile, base_radius=high)):
            break
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if good(replace(profile, base_radius=middle)) else (middle, high)
    return high * (1.0 + 1e-6)
