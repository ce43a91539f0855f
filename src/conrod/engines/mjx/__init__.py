"""MuJoCo XLA (MJX), an extra of conrod: settings of a run, and the presets. Imports no engine, which `engine` does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Self

from conrod.engines.engine import DASHED, DOTTED, STOCK, LineStyle, Machine, Preset
from conrod.engines.mujoco import STIFF_SOLIMP, MuJoCoSettings
from conrod.errors import unknown_choice

PRECISIONS = ("single", "double")
# At the tolerance of 0 that the drive forces MJX makes all of its iterations in each step. Newton's method solves
# equalities in the first; more change nothing but rounding.
ITERATIONS = 1
LOOSELY_DOTTED = LineStyle((0, (1, 4)), "v", 4.0, False, 4)


@dataclass(frozen=True)
class MJXSettings(MuJoCoSettings):
    """Settings of an MJX run: those of MuJoCo, with the precision of JAX's arrays (`jax_enable_x64`)."""

    engine: ClassVar[str] = "mjx"

    precision: str = "single"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.precision not in PRECISIONS:
            raise unknown_choice("precision", self.precision, PRECISIONS)

    @classmethod
    def stock(cls, machine: Machine, steps_per_revolution: int) -> Self:
        """MuJoCo's defaults plus the drive, in JAX's own single precision."""
        return replace(super().stock(machine, steps_per_revolution), iterations=ITERATIONS)

    @classmethod
    def tuned(cls, machine: Machine, steps_per_revolution: int) -> Self:
        """The stiffest closure that MuJoCo admits, in double precision.

        A closure of MJX knows nothing of how its points curve (the term dJ/dt v): its spring has to do all of that, and
        leaves a gap of that acceleration times the square of its time constant. So that is the least, of two steps.
        """
        stock = cls.stock(machine, steps_per_revolution)
        shortest = (2.0 * stock.timestep, 1.0)
        return replace(stock, preset="tuned", precision="double", solref=shortest, solimp=STIFF_SOLIMP)

    @classmethod
    def tuned_single(cls, machine: Machine, steps_per_revolution: int) -> MJXSettings:
        """The same as `tuned`, in single precision."""
        tuned = cls.tuned(machine, steps_per_revolution)
        return replace(tuned, preset="tuned-single", precision="single")


# What is rounded to single precision at every step is measured, and not judged.
MJX_PRESETS: Mapping[str, Preset[MJXSettings]] = {
    STOCK: Preset(MJXSettings.stock, "MuJoCo's defaults, in single precision", judged=False, style=DOTTED),
    "tuned": Preset(MJXSettings.tuned, "stiffest closures, in double precision", style=DASHED),
    "tuned-single": Preset(
        MJXSettings.tuned_single, "the same in single precision", judged=False, style=LOOSELY_DOTTED
    ),
}
