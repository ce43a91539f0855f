"""What an engine tells of the forces in a machine whose crank turns at constant speed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from conrod.motion import Array
from conrod.trajectory import Instants, Outcome


@dataclass(frozen=True)
class ForceTracks:
    """Drive torque and joint reactions of a run, with the instants that they belong to.

    Attributes:
        instants: (T,), of all values.
        drive_torque: (T,) [N m] on the crank, in the sense of the crank angle; None where it is not told.
        joints: by joint name, then by component, (T,) each; names, signs and units as in
            `conrod.dynamics.inverse.JointForces`.
        unsupported: by quantity ("drive torque", or a joint's name), why it is not told.
        outcome: of the run; of one that did not come to its end nothing is told.
    """

    instants: Instants
    drive_torque: Array | None
    joints: Mapping[str, Mapping[str, Array]]
    unsupported: Mapping[str, str]
    outcome: Outcome = Outcome.COMPLETED
