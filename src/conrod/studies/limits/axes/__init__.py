"""The axes along which engines are driven to their limits, and the table of them all."""

from __future__ import annotations

from conrod.errors import unknown_choice
from conrod.studies.limits.axes.assembly import DeclarationOrder, Nearness, StartPose
from conrod.studies.limits.axes.cams import FlankRadius, FollowerFloat, NoseRadius
from conrod.studies.limits.axes.machine import CrankSpeed, LengthUnit, MassRatio, RunLength
from conrod.studies.limits.axes.solver import Iterations, Regularisation, Rounding, Stabilisation, Steps
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
