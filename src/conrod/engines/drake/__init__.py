"""Drake, an optional engine: settings of a run, and the presets. Does not import the engine."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from conrod.engines.engine import DASHED, DOTTED, STOCK, EngineSettings, Machine, Preset, step_length
from conrod.errors import unknown_choice
from conrod.mechanism.units import check_number

# How a plant steps: Drake's discrete update, whose solver SAP takes constraints; or its integrator Radau IIA of order
# 3, which takes none: loops are then closed by bushings.
DISCRETE, RADAU = "discrete", "radau3"
INTEGRATORS = (DISCRETE, RADAU)
BUSHING_STIFFNESS = 1e5  # k h^2 / m, with the mass m of all bodies


@dataclass(frozen=True)
class DrakeSettings(EngineSettings):
    """Settings of a Drake run, in SI; inertia and stiffness as ratios, which are the same for all machines."""

    engine: ClassVar[str] = "drake"

    integrator: str = DISCRETE
    # Rotor inertia of the drives over total mass x (longest arm)^2: what the machine asks of a drive changes its
    # acceleration by one part in so many. From 1e12 on rounding of SAP costs digits.
    flywheel_ratio: float = 1e9
    bushing_stiffness: float = BUSHING_STIFFNESS  # k h^2 / m, with the machine's mass m; unused by the discrete update
    accuracy: float = 1e-10  # at which Newton's iteration of the integrator ends; unused by the discrete update

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.integrator not in INTEGRATORS:
            raise unknown_choice("integrator", self.integrator, INTEGRATORS)
        check_number("flywheel_ratio", self.flywheel_ratio, 1.0, 1e16)
        check_number("bushing_stiffness", self.bushing_stiffness, 1e-3, 1e12)
        check_number("accuracy", self.accuracy, 1e-13, 1e-1)

    def time_constant(self, contact: bool) -> float:
        """Time constant [s]: half of a gap is left after a step of the discrete update; bushings correct within one."""
        return self.timestep / math.log(2.0) if self.integrator == DISCRETE else 0.0

    @classmethod
    def tuned(cls, machine: Machine, steps_per_revolution: int) -> DrakeSettings:
        """A continuous plant with loops closed by stiff bushings, integrated by Radau IIA with fixed steps.

        Bushings are as stiff as the step allows up to 1000 steps a revolution. In finer steps they stay as stiff, or
        rounding of what they push would keep Newton's iteration from ending.
        """
        stiffness = BUSHING_STIFFNESS * min(1.0, 1000.0 / steps_per_revolution) ** 2
        h = step_length(machine, steps_per_revolution)
        return cls("tuned", steps_per_revolution, h, RADAU, bushing_stiffness=stiffness)


# Drake's documentation states no size of their errors: they are measured, and not judged.
DRAKE_PRESETS: Mapping[str, Preset[DrakeSettings]] = {
    STOCK: Preset(DrakeSettings.stock, "Drake's defaults: a discrete plant, loops by constraints", False, style=DOTTED),
    "tuned": Preset(DrakeSettings.tuned, "Radau IIA of order 3, loops by stiff bushings", False, style=DASHED),
}
