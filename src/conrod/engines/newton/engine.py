"""The Newton engine: machines in space in SolverMuJoCo and SolverXPBD; planar ones are refused."""

from __future__ import annotations

import os
from collections.abc import Iterator

import newton
import warp

from conrod.comparison.trajectory import Piece
from conrod.engines.engine import PIECE_STEPS, SINGLE_EPSILON, Engine, Machine
from conrod.engines.newton import MUJOCO_WARP, NEWTON_PRESETS, NewtonSettings, space

STDERR = 2  # file descriptor
warp.config.log_level = warp.LOG_ERROR  # it would print each kernel that it loads


def start_warp() -> None:
    """Start Warp without the line that it prints, past Python, where there is no driver of a GPU."""
    kept, nowhere = os.dup(STDERR), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, STDERR)
        warp.init()
    finally:
        os.dup2(kept, STDERR)
        os.close(kept)
        os.close(nowhere)


start_warp()
SPACE_ALONE = "newton runs machines in space alone"


class Newton(Engine[NewtonSettings]):
    """Newton through its ModelBuilder and solvers, in single precision."""

    name = "newton"
    presets = NEWTON_PRESETS
    epsilon = SINGLE_EPSILON
    refusal_in_space = staticmethod(space.refusal_in_space)
    run_in_space = staticmethod(space.run_in_space)
    stepper_in_space = space.NewtonStepper

    @property
    def version(self) -> str:  # type: ignore[override] # found when it is first asked for, as Warp looks for devices
        """Versions of Newton and Warp, and the device that its kernels run on."""
        device = warp.get_device(space.solving_device(MUJOCO_WARP))
        return f"{newton.__version__}, Warp {warp.__version__} on {device.name}"

    def refusal(self, machine: Machine, settings: NewtonSettings) -> str | None:
        """Return the reason why planar machines are refused."""
        return SPACE_ALONE

    def run(
        self,
        machine: Machine,
        settings: NewtonSettings,
        revolutions: float,
        start_angle: float = 0.0,
        steps: int = PIECE_STEPS,
    ) -> Iterator[Piece]:
        """Never called, as all planar machines are refused."""
        raise NotImplementedError(SPACE_ALONE)


NEWTON_ENGINE = Newton()
