"""The order in which bodies and joints are declared."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell
from conrod.studies.limits.declaration import Declaration

MOST = 24


class DeclarationOrder(Axis):
    """Permutations of bodies and joints, numbered as by place (factorial number system); 0 is the scene's own order.

    All of them where they are few; else evenly spread, the order of everything reversed, which is the last, included.
    """

    name: ClassVar[str] = "declaration"
    title: ClassVar[str] = "Order of declaration"
    label: ClassVar[str] = "number of the permutation"
    scale: ClassVar[Scale] = Scale.LISTED

    def refusal(self, case: Case) -> str | None:
        return None

    def values(self, case: Case) -> tuple[float, ...]:
        mechanism = case.scene.kinematics.mechanism
        last = math.factorial(len(mechanism.bodies)) * math.factorial(len(mechanism.joints)) - 1
        count = min(MOST, last + 1)
        return tuple(dict.fromkeys(float(round(k * last / max(count - 1, 1))) for k in range(count)))

    def cell(self, case: Case, value: float) -> LimitCell:
        return LimitCell(case.name, case.scene, case.settings(), declaration=_declaration(case, value))

    def text(self, case: Case, value: float) -> str:
        order = _declaration(case, value)
        return f"{', '.join(order.bodies)}; {', '.join(order.joints)}"


def _declaration(case: Case, value: float) -> Declaration:
    mechanism = case.scene.kinematics.mechanism
    joints = math.factorial(len(mechanism.joints))
    return Declaration(
        bodies=permutation([body.name for body in mechanism.bodies], round(value) // joints),
        joints=permutation([joint.name for joint in mechanism.joints], round(value) % joints),
    )


def permutation(names: Sequence[str], number: int) -> tuple[str, ...]:
    """The permutation of a number: 0 leaves all in place, the last reverses them (factorial number system)."""
    left, chosen = list(names), []
    for size in range(len(names), 0, -1):
        place, number = divmod(number, math.factorial(size - 1))
        chosen.append(left.pop(place))
    return tuple(chosen)
