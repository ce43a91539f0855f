"""MuJoCo, as one of conrod's engines."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco

from conrod.engines.engine import PIECE, Engine, ExpectedError, KinematicResult, Machine, Softness
from conrod.engines.ingredient import Ingredient
from conrod.engines.left_out_rod import form_refusal
from conrod.engines.mobility_count import MobilityCount
from conrod.engines.mujoco import dynamics, kinematic, law, softness
from conrod.engines.mujoco.bare import BareRun, started
from conrod.engines.mujoco.dressing import dressing_refusal
from conrod.engines.mujoco.grid import rules
from conrod.engines.mujoco.ingredients import ingredients, minimal
from conrod.engines.mujoco.mobility import model_mobility
from conrod.engines.mujoco.paste import paste
from conrod.engines.mujoco.reference_loop import reference_loop
from conrod.engines.mujoco.settings import PRESETS, MuJoCoSettings
from conrod.engines.mujoco.variations import MuJoCoVariations
from conrod.engines.rule import Grid, Rule
from conrod.motion import Array
from conrod.trajectory import Piece, Trajectory


class MuJoCo(Engine[MuJoCoSettings]):
    """MuJoCo by way of MJCF."""

    name = "mujoco"
    presets = PRESETS
    variations = MuJoCoVariations()

    @property
    def version(self) -> str:
        return str(mujoco.__version__)

    def refusal(self, machine: Machine, settings: MuJoCoSettings) -> str | None:
        if settings.hardening is not None and machine.kinematics.mechanism.cam_contacts:
            return "hardening does not apply to contact"
        mechanism = machine.kinematics.mechanism
        return form_refusal(mechanism, settings.rod) or dressing_refusal(mechanism, settings)

    def run(
        self, machine: Machine, settings: MuJoCoSettings, revolutions: float, start_angle: float = 0.0
    ) -> Trajectory:
        return dynamics.run(machine, settings, revolutions, start_angle)

    def pieces(
        self,
        machine: Machine,
        settings: MuJoCoSettings,
        revolutions: float,
        start_angle: float = 0.0,
        steps: int = PIECE,
    ) -> Iterator[Piece]:
        return dynamics.pieces(machine, settings, revolutions, start_angle, steps)

    def solve_kinematics(self, machine: Machine, angle: Array) -> KinematicResult:
        return kinematic.solve(machine, MuJoCoSettings.tuned(machine, 1000), angle)

    def expected_error(self, machine: Machine, settings: MuJoCoSettings) -> ExpectedError:
        return law.expected_error(machine, settings)

    def predicted_softness(self, machine: Machine, settings: MuJoCoSettings) -> Softness | None:
        return softness.predicted_softness(machine, settings)

    def stepper(self, machine: Machine, settings: MuJoCoSettings) -> BareRun:
        return started(machine, settings)

    def reference_loop(self) -> BareRun:
        return reference_loop()

    def grid(self, machine: Machine, grid: Grid) -> tuple[Rule, ...]:
        return rules(machine, grid)

    def minimal(self, machine: Machine, steps_per_revolution: int) -> MuJoCoSettings:
        return minimal(machine, steps_per_revolution)

    def ingredients(self, machine: Machine, minimal: MuJoCoSettings) -> tuple[Ingredient[MuJoCoSettings], ...]:
        return ingredients(machine, minimal)

    def mobility(self, machine: Machine, settings: MuJoCoSettings, angle: Array) -> MobilityCount:
        return model_mobility(machine, settings, angle)

    def paste(self, machine: Machine, settings: MuJoCoSettings) -> str:
        return paste(machine, settings)


ENGINE = MuJoCo()
