"""pymunk (Chipmunk2D), as one of conrod's engines."""

from __future__ import annotations

from conrod.engines.engine import Engine, Machine
from conrod.engines.pymunk import (
    built,
    dynamics,
    forces,
    free_run,
    grid,
    kinematic,
    law,
    space,
    timing,
)
from conrod.engines.pymunk.settings import PRESETS, PymunkSettings
from conrod.engines.releases import read_releases


class Pymunk(Engine[PymunkSettings]):
    """pymunk by way of its `Space`, with all capabilities but ingredients."""

    name = "pymunk"
    version = built.VERSION
    presets = PRESETS
    refusal = staticmethod(space.refusal)
    run = staticmethod(dynamics.run)
    solve_kinematics = staticmethod(kinematic.solve_kinematics)
    expected_error = staticmethod(law.expected_error)
    forces = staticmethod(forces.forces)
    free_run = staticmethod(free_run.free_run)
    stepper = staticmethod(timing.started)
    reference_loop = staticmethod(timing.reference_loop)
    paste = staticmethod(grid.paste)
    stabilised = staticmethod(grid.stabilised)
    regularised = staticmethod(grid.regularised)
    grid = staticmethod(grid.rules)
    releases = read_releases("conrod.engines.pymunk")

    def probes(self, machine: Machine, steps_per_revolution: int) -> dict[str, PymunkSettings]:
        return {name: preset(machine, steps_per_revolution) for name, preset in self.presets.items()}


ENGINE = Pymunk()
