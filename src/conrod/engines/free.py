"""What an engine tells of a motion that nothing prescribes."""

from __future__ import annotations

from dataclasses import dataclass

from conrod.motion import Array
from conrod.trajectory import Outcome


@dataclass(frozen=True)
class FreeRun:
    """A free or torque-driven run, told at every so-many-th step from its start on.

    Attributes:
        times: (T,) [s], from 0, counted in steps.
        poses, rates: of all bodies in the order of `Mechanism.bodies` (T, 3 n) [m, m, rad], both at `times`.
        energy: kinetic, of weight and constant forces, and stored in loads that are potentials, (T,) [J].
        outcome: how the run ended; reason: its details, empty when completed.
        cpu_seconds: of stepping alone [s].
    """

    times: Array
    poses: Array
    rates: Array
    energy: Array
    outcome: Outcome
    reason: str
    cpu_seconds: float
