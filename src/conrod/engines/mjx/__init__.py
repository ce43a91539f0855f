"""MuJoCo XLA (MJX), an optional engine: settings of a run, and the presets. Does not import the engine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Self

from conrod.engines.engine import DASHED, DOTTED, STOCK, LineStyle, Machine, Preset
from conrod.engines.mujoco import STIFF_SOLIMP, MuJoCoSettings
from conrod.errors import unknown_choice

PRECISIONS = ("single", "double")
# At the tolerance of 0 that the drive requires MJX makes all of its iterations in each step. Newton's method solves
# equalities in the first; more change only rounding.
NEWTON_ITERATIONS = 1
LOOSELY_DOTTED = LineStyle((0, (1, 4)), "v", 4.0, False, 4)


@dataclass(frozen=True)
class MJXSettings(MuJoCoSettings):
    """Settings of an MJX run: MuJoCo's, and the precision of JAX's arrays (`jax_enable_x64`)."""

    engine: ClassVar[str] = "mjx"

    precision: str = "single"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.precision not in PRECISIONS:
            raise unknown_choice("precision", self.precision, PRECISIONS)

    @classmethod
    def stock(cls, machine: Machine, steps_per_revolution: int) -> Self:
        """MuJoCo's defaults plus the drive, in JAX's default single precision."""
        return replace(super().stock(machine, steps_per_revolution), iterations=NEWTON_ITERATIONS)

    @classmethod
    def tuned(cls, machine: Machine, steps_per_revolution: int) -> Self:
        """The stiffest closure that MuJoCo admits, in double precision.

        An MJX closure lacks the term dJ/dt v: its spring has to supply that acceleration, with a gap of the
        acceleration times the square of the time constant. So the time constant is the least possible, two steps.
        """
        stock = cls.stock(machine, steps_per_revolution)
        shortest = (2.0 * stock.timestep, 1.0)
        return replace(stock, preset="tuned", precision="double", solref=shortest, solimp=STIFF_SOLIMP)

    @classmethod
    def tuned_single(cls, machine: Machine, steps_per_revolution: int) -> MJXSettings:
        """The same as `tuned`, in single precision."""
        tuned = cls.tuned(machine, steps_per_revolution)
        return replace(tuned, preset="tuned-single", precision="single")


# Runs in single precision are measured, and not judged.
MJX_PRESETS: Mapping[str, Preset[MJXSettings]] = {
    STOCK: Preset(MJXSettings.stock, "MuJoCo's defaults, in single precision", judged=False, style=DOTTED),
    "tuned": Preset(MJXSettings.tuned, "stiffest closures, in double precision", style=DASHED),
    "tuned-single": Preset(
        MJXSettings.tuned_single, "the same in single precision", judged=False, style=LOOSELY_DOTTED
    ),
}
