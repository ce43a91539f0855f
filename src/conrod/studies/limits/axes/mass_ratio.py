"""Mass of the output link over that of the rod that drives it."""

from __future__ import annotations

from typing import ClassVar

from conrod.errors import InvalidInput
from conrod.mechanism import GROUND, Mechanism, Revolute
from conrod.scenes import Scene
from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell
from conrod.studies.sensitivity import output_mass


class MassRatio(Axis):
    """Equal masses are harmless; a heavy slider and a light one are two ways into trouble.

    The exact motion depends on no mass. The rod keeps its mass; a preset's rule sees the new ones.
    """

    name: ClassVar[str] = "mass-ratio"
    title: ClassVar[str] = "Mass of the slider over that of the rod"
    label: ClassVar[str] = "mass of slider : rod"
    scale: ClassVar[Scale] = Scale.LOG
    harmless: ClassVar[float] = 1.0
    hopeless: ClassVar[float] = 1e6
    allowed: ClassVar[tuple[float, float]] = (1e-6, 1e6)

    def refusal(self, case: Case) -> str | None:
        if _driving_rod(case.scene) is None:
            return f"the {case.scene.kind} has no connecting rod: {self.name} does not apply"
        try:
            output_mass(case.scene)
        except InvalidInput as unfit:
            return str(unfit)
        return None

    def spans(self, case: Case) -> tuple[tuple[float, float], ...]:
        return ((self.harmless, self.hopeless), (self.harmless, 1.0 / self.hopeless))

    def cell(self, case: Case, value: float) -> LimitCell:
        rod = _driving_rod(case.scene)
        assert rod is not None
        mass = value * case.scene.kinematics.mechanism.body(rod).mass
        scene = case.variant(**{output_mass(case.scene): mass})
        return LimitCell(case.name, scene, case.settings(scene))


def _driving_rod(scene: Scene) -> str | None:
    """The link that is pinned to the one with the output point, and is neither crank nor ground."""
    mechanism = scene.kinematics.mechanism
    link = next(observed.body for observed in mechanism.observed if observed.name == scene.output)
    return next((name for name in _partners(mechanism, link) if name not in (GROUND, mechanism.crank)), None)


def _partners(mechanism: Mechanism, link: str) -> list[str]:
    pins = [joint for joint in mechanism.joints if isinstance(joint, Revolute) and link in (joint.a, joint.b)]
    return [joint.b if joint.a == link else joint.a for joint in pins]
