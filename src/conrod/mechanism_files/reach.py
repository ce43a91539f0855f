"""How far an input reaches."""

from __future__ import annotations

import math

import numpy as np

from conrod.errors import InvalidInput
from conrod.kinematics import Kinematics

HALVINGS = 14  # of a turn: to 0.02 deg


def check_reach(kinematics: Kinematics) -> None:
    """Refuse an input that does not reach all crank angles of its turn, or of its pass.

    Raises:
        InvalidInput: tells how far it reaches.
    """
    span = kinematics.mechanism.driver.span
    if (kinematics.turns_fully) if span is None else all(_reached(kinematics, angle) for angle in span):
        return
    low, high = (math.degrees(_farthest(kinematics, side)) for side in (-1.0, 1.0))
    wanted = (
        "turn fully" if span is None else f"pass from {math.degrees(span[0]):.6g} to {math.degrees(span[1]):.6g} deg"
    )
    raise InvalidInput(
        f"driver: the crank cannot {wanted}: from its start it reaches {low:.2f} to {high:.2f} deg on this assembly; "
        "give driver.from and driver.to within that, for one pass"
    )


def _reached(kinematics: Kinematics, angle: float) -> bool:
    try:
        return bool(np.all(np.isfinite(kinematics.poses(np.array([angle])))))
    except InvalidInput:
        return False


def _farthest(kinematics: Kinematics, side: float) -> float:
    near, far = 0.0, side * 2.0 * math.pi
    for _ in range(HALVINGS):
        middle = 0.5 * (near + far)
        near, far = (middle, far) if _reached(kinematics, middle) else (near, middle)
    return near
