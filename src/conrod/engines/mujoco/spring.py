"""The spring and damper that MuJoCo closes a soft constraint with, and its impedance."""

from __future__ import annotations

import math
from dataclasses import dataclass

# MuJoCo keeps impedances, and the midpoint, within these (mjMINIMP, mjMAXIMP).
LEAST_IMPEDANCE, MOST_IMPEDANCE = 1e-4, 0.9999
LEAST_STEPS = 2.0  # a time constant is raised to this many steps


@dataclass(frozen=True)
class Spring:
    """a = -damping x rate - stiffness x d x gap, with the impedance d a function of the gap.

    MuJoCo documentation, Computation, 'Solver parameters': for a positive solref = (tc, z), stiffness 1 / (dmax tc z)^2
    and damping 2 / (dmax tc); a negative one gives them as -solref / dmax^2 and -solref / dmax. The impedance grows
    from solimp's first to its second number over a width, along two powers that meet at a midpoint.
    """

    stiffness: float  # [1/s^2]
    damping: float  # [1/s]
    solimp: tuple[float, float, float, float, float]

    @classmethod
    def of(
        cls,
        solref: tuple[float, float],
        solimp: tuple[float, float, float, float, float],
        timestep: float,
        refsafe: bool = True,
    ) -> Spring:
        """The spring that MuJoCo makes of these parameters at a time step [s], by which it raises short constants."""
        least, most, midpoint = (min(max(solimp[k], LEAST_IMPEDANCE), MOST_IMPEDANCE) for k in (0, 1, 3))
        kept = (least, most, max(solimp[2], 0.0), midpoint, max(solimp[4], 1.0))
        constant, ratio = solref
        if constant > 0.0:
            constant = max(constant, LEAST_STEPS * timestep) if refsafe else constant
            return cls(1.0 / (most * constant * ratio) ** 2, 2.0 / (most * constant), kept)
        return cls(-constant / most**2, -ratio / most, kept)

    def impedance(self, gap: float) -> float:
        """d of a gap [m]."""
        least, most, width, midpoint, power = self.solimp
        if least == most or width <= 0.0:
            return 0.5 * (least + most)
        x = min(abs(gap) / width, 1.0)
        if x <= midpoint:
            rise = math.pow(x, power) / math.pow(midpoint, power - 1.0)
        else:
            rise = 1.0 - math.pow(1.0 - x, power) / math.pow(1.0 - midpoint, power - 1.0)
        return least + rise * (most - least)
