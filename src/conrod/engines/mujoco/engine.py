"""MuJoCo, as one of conrod's engines."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import mujoco

from conrod.engines.cam_polygon import contact_refusal
from conrod.engines.capabilities import ExpectedError, KinematicResult, Softness
from conrod.engines.engine import PIECE, Engine, Machine
from conrod.engines.forces import ForceTracks, nothing_told
from conrod.engines.free_run import FreeRun
from conrod.engines.ingredients import Ingredient
from conrod.engines.massless_rod import form_refusal, model_form
from conrod.engines.mesh_rows import tree_refusal
from conrod.engines.mobility import MobilityCount
from conrod.engines.mujoco import dynamics, kinematic, law, softness
from conrod.engines.mujoco.forces import forces
from conrod.engines.mujoco.free_run import free_run, free_settings
from conrod.engines.mujoco.grid import rules
from conrod.engines.mujoco.ingredients import ingredients, minimal
from conrod.engines.mujoco.mobility import model_mobility
from conrod.engines.mujoco.model_edits import dressing_refusal
from conrod.engines.mujoco.settings import PRESETS, MuJoCoSettings
from conrod.engines.mujoco.timing import BareRun, reference_loop, started
from conrod.engines.mujoco.variations import MuJoCoVariations, paste
from conrod.engines.rule import Grid, Rule
from conrod.engines.tree import tree_of
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism
from conrod.runs.trajectory import Piece


class MuJoCo(Engine[MuJoCoSettings]):
    """MuJoCo by way of MJCF."""

    name = "mujoco"
    presets = PRESETS
    variations = MuJoCoVariations()

    @property
    def version(self) -> str:
        return str(mujoco.__version__)

    def refusal(self, machine: Machine, settings: MuJoCoSettings) -> str | None:
        mechanism = machine.kinematics.mechanism
        if reason := contact_refusal(mechanism):
            return reason
        if settings.hardening is not None and mechanism.cam_contacts:
            return "hardening does not apply to contact"
        reason = form_refusal(mechanism, settings.rod) or dressing_refusal(mechanism, settings)
        return reason or tree_refusal(tree_of(machine, model_form(mechanism, settings.rod)))

    def run(
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

    def stepper(self, machine: Machine, settings: MuJoCoSettings) -> Callable[[int], None]:
        return started(machine, settings)

    def forces(
        self, machine: Machine, settings: MuJoCoSettings, revolutions: float, start_angle: float = 0.0
    ) -> ForceTracks:
        if reason := self.refusal(machine, settings):
            return nothing_told(machine.kinematics.mechanism, reason)
        return forces(machine, settings, revolutions, start_angle)

    def free_run(
        self,
        mechanism: Mechanism,
        preset: str,
        timestep: float,
        steps: int,
        poses: Array,
        rates: Array,
        every: int = 1,
    ) -> FreeRun:
        return free_run(mechanism, free_settings(mechanism, preset, timestep), steps, poses, rates, every)

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
