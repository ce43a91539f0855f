"""Newton, an optional engine: settings of a run, and the presets. Does not import the engine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from conrod.engines.engine import DASHED, DOTTED, SOLID, STOCK, EngineSettings, LineStyle, Machine, Preset, step_length
from conrod.errors import unknown_choice
from conrod.mechanism.units import check_count

# Newton's solvers that hold loops: SolverMuJoCo on MuJoCo's C code or on MuJoCo Warp, and SolverXPBD.
MUJOCO, MUJOCO_WARP, XPBD = "mujoco", "mujoco-warp", "xpbd"
SOLVERS = (MUJOCO, MUJOCO_WARP, XPBD)
MUJOCO_TIME_CONSTANT = 0.02  # of closures [s], MuJoCo's default
STIFF_STEPS = 8.0  # time constant of a stiff closure, in steps
STIFF_SOLIMP = (0.9999, 0.9999, 0.001, 0.5, 2.0)  # MuJoCo's largest impedance, constant
XPBD_ITERATIONS = 20  # Newton's default is 2
DASH_DOTTED = LineStyle((0, (5, 1.5, 1, 1.5)), "v", 4.0, False, 4)


@dataclass(frozen=True)
class NewtonSettings(EngineSettings):
    """Settings of a Newton run, in SI.

    Attributes:
        solver: one of `SOLVERS`.
        stiff: whether SolverMuJoCo integrates by RK4 and has closures as stiff as the step allows, or its defaults.
        iterations: of SolverXPBD in a step.
    """

    engine: ClassVar[str] = "newton"

    solver: str = MUJOCO
    stiff: bool = False
    iterations: int = XPBD_ITERATIONS

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.solver not in SOLVERS:
            raise unknown_choice("solver", self.solver, SOLVERS)
        check_count("iterations", self.iterations, 1, 10_000)

    def time_constant(self, contact: bool) -> float:
        """Time constant [s] of closures in SolverMuJoCo; 0 in SolverXPBD, which closes them within a step."""
        if self.solver == XPBD:
            return 0.0
        return STIFF_STEPS * self.timestep if self.stiff else MUJOCO_TIME_CONSTANT


def _preset(name: str, solver: str, stiff: bool, meaning: str, style: LineStyle) -> Preset[NewtonSettings]:
    """A preset that is not judged, as Newton's documentation states no size of its errors."""

    def rule(machine: Machine, steps_per_revolution: int, /) -> NewtonSettings:
        return NewtonSettings(name, steps_per_revolution, step_length(machine, steps_per_revolution), solver, stiff)

    return Preset(rule, meaning, judged=False, style=style)


NEWTON_PRESETS: Mapping[str, Preset[NewtonSettings]] = {
    STOCK: _preset(STOCK, MUJOCO, False, "SolverMuJoCo's defaults, on MuJoCo's C code", DOTTED),
    MUJOCO: _preset(MUJOCO, MUJOCO, True, "SolverMuJoCo on MuJoCo's C code: RK4, stiff closures", SOLID),
    MUJOCO_WARP: _preset(MUJOCO_WARP, MUJOCO_WARP, True, "the same on MuJoCo Warp", DASH_DOTTED),
    XPBD: _preset(XPBD, XPBD, False, f"SolverXPBD, {XPBD_ITERATIONS} iterations", DASHED),
}
