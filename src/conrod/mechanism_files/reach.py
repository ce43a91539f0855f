"""How far an input reaches, and what it moves."""

from __future__ import annotations

import math

import numpy as np

from conrod.errors import InvalidInput
from conrod.kinematics import Kinematics

# Errors are told over the travel of a point: over less than this part of the machine's size, rounding alone is 1e-10.
LEAST_TRAVEL = 1e-6


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


def check_travel(kinematics: Kinematics) -> None:
    """Refuse an observed point that stands still.

    Raises:
        InvalidInput: names it.
    """
    for name, travel in kinematics.lengths.items():
        if travel < LEAST_TRAVEL * kinematics.size:
            raise InvalidInput(
                f"observed.{name}: the point moves {travel:.3g} m in all, which errors cannot be told over: observe "
                f"points that move by a millionth of the machine's size, {kinematics.size:.3g} m, at least"
            )
