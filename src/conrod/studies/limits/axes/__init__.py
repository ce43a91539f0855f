"""The axes along which engines are driven to their limits, and the table of them all."""

from __future__ import annotations

from conrod.errors import unknown_choice
from conrod.studies.limits.axes.crank_speed import CrankSpeed
from conrod.studies.limits.axes.declaration_order import DeclarationOrder
from conrod.studies.limits.axes.flank_radius import FlankRadius
from conrod.studies.limits.axes.follower_float import FollowerFloat
from conrod.studies.limits.axes.iterations import Iterations
from conrod.studies.limits.axes.length_unit import LengthUnit
from conrod.studies.limits.axes.mass_ratio import MassRatio
from conrod.studies.limits.axes.nearness import Nearness
from conrod.studies.limits.axes.nose_radius import NoseRadius
from conrod.studies.limits.axes.regularisation import Regularisation
from conrod.studies.limits.axes.rounding import Rounding
from conrod.studies.limits.axes.run_length import RunLength
from conrod.studies.limits.axes.stabilisation import Stabilisation
from conrod.studies.limits.axes.start_pose import StartPose
from conrod.studies.limits.axes.steps import Steps
from conrod.studies.limits.axis import Axis

AXES: dict[str, Axis] = {
    axis.name: axis
    for axis in (
        Steps(),
        CrankSpeed(),
        MassRatio(),
        Nearness(),
        Stabilisation(),
        Regularisation(),
        Iterations(),
        RunLength(),
        LengthUnit(),
        Rounding(),
        StartPose(),
        DeclarationOrder(),
        FollowerFloat(),
        FlankRadius(),
        NoseRadius(),
    )
}
# One run of it shows all shorter ones, so it is not walked as the others are.
LENGTH_AXIS = RunLength.name


def axis_named(name: str) -> Axis:
    """The axis of a name.

    Raises:
        InvalidInput: there is none; names the choices.
    """
    if name not in AXES:
        raise unknown_choice("axis", name, AXES)
    return AXES[name]


__all__ = ["AXES", "LENGTH_AXIS", "axis_named"]
