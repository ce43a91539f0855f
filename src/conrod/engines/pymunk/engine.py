"""pymunk (Chipmunk2D), as one of conrod's engines."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pymunk

from conrod.engines.cam_polygon import contact_refusal
from conrod.engines.capabilities import ExpectedError, KinematicResult, Softness
from conrod.engines.engine import PIECE, Engine, Machine
from conrod.engines.forces import ForceTracks, nothing_told
from conrod.engines.free_run import FreeRun
from conrod.engines.ingredients import Ingredient
from conrod.engines.massless_rod import form_refusal
from conrod.engines.mobility import MobilityCount
from conrod.engines.pymunk import drift, kinematic, law
from conrod.engines.pymunk.forces import forces
from conrod.engines.pymunk.free_run import free_run
from conrod.engines.pymunk.gears import gears_refusal
from conrod.engines.pymunk.grid import rules
from conrod.engines.pymunk.ingredients import ingredients, minimal
from conrod.engines.pymunk.mobility import space_mobility
from conrod.engines.pymunk.pieces import pieces
from conrod.engines.pymunk.settings import PRESETS, PymunkSettings
from conrod.engines.pymunk.timing import BareRun, reference_loop, started
from conrod.engines.pymunk.variations import PymunkVariations, paste
from conrod.engines.rule import Grid, Rule
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism
from conrod.runs.trajectory import Piece


class Pymunk(Engine[PymunkSettings]):
    """pymunk by way of its `Space`."""

    name = "pymunk"
    presets = PRESETS
    variations = PymunkVariations()

    @property
    def version(self) -> str:
        return str(pymunk.version)

    def refusal(self, machine: Machine, settings: PymunkSettings) -> str | None:
        mechanism = machine.kinematics.mechanism
        if reason := contact_refusal(mechanism):
            return reason
        return form_refusal(mechanism, settings.rod) or gears_refusal(mechanism)

    def run(
        self,
        machine: Machine,
        settings: PymunkSettings,
        revolutions: float,
        start_angle: float = 0.0,
        steps: int = PIECE,
    ) -> Iterator[Piece]:
        return pieces(machine, settings, revolutions, start_angle, steps)

    def solve_kinematics(self, machine: Machine, angle: Array) -> KinematicResult:
        return kinematic.solve(machine, PymunkSettings.tuned(machine, 1000), angle)

    def expected_error(self, machine: Machine, settings: PymunkSettings) -> ExpectedError:
        return law.expected_error(machine, settings)

    def predicted_softness(self, machine: Machine, settings: PymunkSettings) -> Softness | None:
        return drift.predicted_softness(machine, settings)

    def stepper(self, machine: Machine, settings: PymunkSettings) -> Callable[[int], None]:
        return started(machine, settings)

    def forces(
        self, machine: Machine, settings: PymunkSettings, revolutions: float, start_angle: float = 0.0
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
        return free_run(mechanism, PymunkSettings.free(mechanism, preset, timestep), steps, poses, rates, every)

    def reference_loop(self) -> BareRun:
        return reference_loop()

    def grid(self, machine: Machine, grid: Grid) -> tuple[Rule, ...]:
        return rules(machine, grid)

    def minimal(self, machine: Machine, steps_per_revolution: int) -> PymunkSettings:
        return minimal(machine, steps_per_revolution)

    def ingredients(self, machine: Machine, minimal: PymunkSettings) -> tuple[Ingredient[PymunkSettings], ...]:
        return ingredients(machine, minimal)

    def mobility(self, machine: Machine, settings: PymunkSettings, angle: Array) -> MobilityCount:
        return space_mobility(machine, settings, angle)

    def paste(self, machine: Machine, settings: PymunkSettings) -> str:
        return paste(machine, settings)


ENGINE = Pymunk()
