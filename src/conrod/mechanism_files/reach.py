"""How far an input reaches."""

from __future__ import annotations

import math

import numpy as np

from conrod.errors import InvalidInput
from conrod.kinematics import Kinematics


def check_reach(kinematics: Kinematics) -> None:
    """Refuse an input that does not reach all crank angles of its turn, or of its pass.

    Raises:
        InvalidInput: tells how far it reaches.
    """
    span = kinematics.mechanism.driver.span
    if kinematics.turns_fully or (span is not None and _passes(kinematics, span)):
        return
    turn = 2.0 * math.pi
    low, high = (math.degrees(kinematics.reach(goal)) for goal in (-turn, turn))
    wanted = "turn fully"
    if span is not None:
        wanted = f"pass from {math.degrees(span[0]):.6g} to {math.degrees(span[1]):.6g} deg"
    raise InvalidInput(
        f"driver: the crank cannot {wanted}: from its start it reaches {low:.2f} to {high:.2f} deg on this assembly; "
        "give driver.from and driver.to within that, for one pass"
    )


def _passes(kinematics: Kinematics, span: tuple[float, float]) -> bool:
    try:
        kinematics.poses(np.array(span))
    except InvalidInput:
        return False
    return True
