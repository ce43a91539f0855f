"""pymunk (Chipmunk2D), as one of conrod's engines."""

from __future__ import annotations

import pymunk

from conrod.engines.cam_polygon import contact_refusal
from conrod.engines.engine import Engine, Machine
from conrod.engines.forces import ForceTracks, nothing_told
from conrod.engines.free_run import FreeRun
from conrod.engines.massless_rod import form_refusal
from conrod.engines.pymunk import drift, dynamics, grid, ingredients, kinematic, law, mobility, timing, variations
from conrod.engines.pymunk.forces import forces
from conrod.engines.pymunk.free_run import free_run
from conrod.engines.pymunk.gears import gears_refusal
from conrod.engines.pymunk.settings import PRESETS, PymunkSettings
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism


class Pymunk(Engine[PymunkSettings]):
    """pymunk by way of its `Space`, with all capabilities."""

    name = "pymunk"
    presets = PRESETS
    run = staticmethod(dynamics.run)
    solve_kinematics = staticmethod(kinematic.solve_kinematics)
    expected_error = staticmethod(law.expected_error)
    predicted_softness = staticmethod(drift.predicted_softness)
    stepper = staticmethod(timing.started)
    reference_loop = staticmethod(timing.reference_loop)
    grid = staticmethod(grid.rules)
    paste = staticmethod(variations.paste)
    variations = variations.PymunkVariations()
    minimal = staticmethod(ingredients.minimal)
    ingredients = staticmethod(ingredients.ingredients)
    mobility = staticmethod(mobility.space_mobility)

    @property
    def version(self) -> str:
        return str(pymunk.version)

    def refusal(self, machine: Machine, settings: PymunkSettings) -> str | None:
        mechanism = machine.kinematics.mechanism
        return contact_refusal(mechanism) or form_refusal(mechanism, settings.rod) or gears_refusal(mechanism)

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


ENGINE = Pymunk()
