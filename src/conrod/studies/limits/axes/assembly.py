"""The order in which bodies and joints are declared.

The crank angle at which a run begins.

Nearness to a change point, where a linkage gains a freedom and may go on along either of two branches.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import ClassVar

from conrod.scenes import Saw, Scene, ShearPress
from conrod.studies.frame.scene_summary import dead_centres
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


SPACING = 5  # [deg]
SAME = 1e-6  # [deg], as close as a dead centre may lie to one of the others and not be run beside it
SCENES_KEPT = 16


class StartPose(Axis):
    """Every five degrees, and the dead centres, where the output turns back."""

    name: ClassVar[str] = "start-pose"
    title: ClassVar[str] = "Start pose"
    label: ClassVar[str] = "crank angle at the start (deg)"
    scale: ClassVar[Scale] = Scale.LISTED

    def refusal(self, case: Case) -> str | None:
        if case.one_pass:
            return f"the input of {case.scene.kind} makes one pass from its start: {self.name} does not apply"
        return None

    def values(self, case: Case) -> tuple[float, ...]:
        even = [float(angle) for angle in range(0, 360, SPACING)]
        dead = [a for a in _dead_centres(case.scene) if min(abs(a - other) for other in even) > SAME]
        return tuple(sorted([*even, *dead]))

    def cell(self, case: Case, value: float) -> LimitCell:
        return LimitCell(case.name, case.scene, case.settings(), start_angle=math.radians(value))

    def text(self, case: Case, value: float) -> str:
        dead = min((abs(value - angle) for angle in _dead_centres(case.scene)), default=math.inf) <= SAME
        return f"{value:.5g} deg" + (" (dead centre)" if dead else "")


@lru_cache(SCENES_KEPT)
def _dead_centres(scene: Scene) -> tuple[float, ...]:
    """Their crank angles [deg]."""
    return tuple(math.degrees(centre.angle) for centre in dead_centres(scene))


Values = Mapping[str, float]


def _press(p: Values, nearness: float) -> Values:
    """Crank as long as the rod: the slider could stand still on the shaft while both turn together."""
    return {"crank": nearness * p["rod"]}


def _saw(p: Values, nearness: float) -> Values:
    """Offset as large as rod - crank: the rod stands across the slide when the crank points away from it."""
    return {"offset": math.copysign(nearness * (p["rod"] - p["crank"]), p["offset"])}


# What has to change, and alone does, to bring a machine to its change point.
APPROACHES: Mapping[type[Scene], Callable[[Values, float], Values]] = {ShearPress: _press, Saw: _saw}


# Near a change point all happens within a small part of a turn: with the usual steps nothing holds as far as it could.
STEPS = 5000


class Nearness(Axis):
    """A length over its limit: of the press crank / rod, of the saw offset / (rod - crank)."""

    name: ClassVar[str] = "nearness"
    title: ClassVar[str] = "Nearness to the change point"
    label: ClassVar[str] = "length over its limit (crank : rod, or offset : rod - crank)"
    scale: ClassVar[Scale] = Scale.NEARNESS
    harmless: ClassVar[float] = 0.1
    hopeless: ClassVar[float] = 1.0 - 1e-9
    allowed: ClassVar[tuple[float, float]] = (0.01, 1.0 - 1e-9)
    near_singular: ClassVar[bool] = True

    def refusal(self, case: Case) -> str | None:
        # By what a scene is: a machine from a file may have any name.
        if type(case.scene) in APPROACHES:
            return None
        known = f"the {case.scene.kind} has no change point"
        return f"{known if case.scene.closed_form else not_known(case.scene)}: {self.name} does not apply"

    def cell(self, case: Case, value: float) -> LimitCell:
        scene = self.scene(case, value)
        return LimitCell(case.name, scene, case.settings(scene, case.steps_per_revolution or STEPS))

    def scene(self, case: Case, value: float) -> Scene:
        """The machine at a nearness."""
        return case.variant(**APPROACHES[type(case.scene)](case.scene.parameters, value))

    def text(self, case: Case, value: float) -> str:
        return f"{value:.3g}" if value < 0.99 else f"1 - {1.0 - value:.3g}"


def not_known(scene: Scene) -> str:
    """Why a machine from a file is not brought to its change point."""
    return f"which lengths bring {scene.kind}, from a file, to a change point is not known"
