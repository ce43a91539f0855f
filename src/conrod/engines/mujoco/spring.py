"""The spring and damper that MuJoCo closes a soft constraint with, and its impedance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from conrod.motion import Array

# MuJoCo keeps impedances within these (mjMINIMP, mjMAXIMP).
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
        cls, solref: tuple[float, float], solimp: tuple[float, float, float, float, float], timestep: float
    ) -> Spring:
        """The spring that MuJoCo makes of these parameters at a time step [s]."""
        least, most, width, midpoint, power = solimp
        least, most = (min(max(d, LEAST_IMPEDANCE), MOST_IMPEDANCE) for d in (least, most))
        kept = (least, most, width, midpoint, power)
        constant, ratio = solref
        if constant > 0.0:
            constant = max(constant, LEAST_STEPS * timestep)
            return cls(1.0 / (most * constant * ratio) ** 2, 2.0 / (most * constant), kept)
        return cls(-constant / most**2, -ratio / most, kept)

    def impedance(self, gap: Array) -> Array:
        """d of gaps [m]."""
        least, most, width, midpoint, power = self.solimp
        if least == most or width <= 0.0:
            return np.full_like(gap, 0.5 * (least + most))
        x = np.minimum(np.abs(gap) / width, 1.0)
        rising = x**power / midpoint ** (power - 1.0) if midpoint > 0.0 else np.zeros_like(x)
        falling = 1.0 - (1.0 - x) ** power / (1.0 - midpoint) ** (power - 1.0) if midpoint < 1.0 else rising
        return np.asarray(least + np.where(x <= midpoint, rising, falling) * (most - least))
