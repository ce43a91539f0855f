"""The Rapier engine: machines in space by impulse joints; planar ones are refused."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import version

import rapier3d

from conrod.comparison.trajectory import Piece
from conrod.engines.engine import PIECE_STEPS, SINGLE_EPSILON, Engine, Machine
from conrod.engines.rapier import RAPIER_PRESETS, RapierSettings, space

SPACE_ALONE = "rapier runs machines in space alone"


class Rapier(Engine[RapierSettings]):
    """Rapier through its Python package, in single precision."""

    name = "rapier"
    version = version(rapier3d.__name__)
    presets = RAPIER_PRESETS
    epsilon = SINGLE_EPSILON
    refusal_in_space = staticmethod(space.refusal_in_space)
    run_in_space = staticmethod(space.run_in_space)
    stepper_in_space = space.RapierStepper

    def refusal(self, machine: Machine, settings: RapierSettings) -> str | None:
        """Return the reason why planar machines are refused."""
        return SPACE_ALONE

    def run(
        self,
        machine: Machine,
        settings: RapierSettings,
        revolutions: float,
        start_angle: float = 0.0,
        steps: int = PIECE_STEPS,
    ) -> Iterator[Piece]:
        """Never called, as all planar machines are refused."""
        raise NotImplementedError(SPACE_ALONE)


RAPIER_ENGINE = Rapier()
