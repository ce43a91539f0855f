"""MuJoCo, as one of conrod's engines."""

from __future__ import annotations

from typing import Any

import mujoco

from conrod.engines.cam_polygon import contact_refusal
from conrod.engines.engine import Engine, Machine, with_fields
from conrod.engines.mujoco import dynamics, ingredients, kinematic, law, older, standalone, timing
from conrod.engines.mujoco.forces import forces
from conrod.engines.mujoco.free_run import free_run
from conrod.engines.mujoco.grid import regularised, rules, stabilised
from conrod.engines.mujoco.model_edits import edit_refusal
from conrod.engines.mujoco.settings import PRESETS, MuJoCoSettings
from conrod.engines.mujoco.standalone import DescribedMachine, standalone_mjcf
from conrod.engines.releases import read_releases
from conrod.engines.tracks import ForceTracks, no_forces
from conrod.engines.tree import tree_of, tree_refusal


class MuJoCo(Engine[MuJoCoSettings]):
    """MuJoCo by way of MJCF, with all capabilities."""

    name = "mujoco"
    version = str(mujoco.__version__)
    presets = PRESETS
    run = staticmethod(dynamics.run)
    solve_kinematics = staticmethod(kinematic.solve_kinematics)
    expected_error = staticmethod(law.expected_error)
    stepper = staticmethod(timing.started)
    reference_loop = staticmethod(timing.reference_loop)
    grid = staticmethod(rules)
    free_run = staticmethod(free_run)
    paste = staticmethod(standalone.paste)
    stabilised = staticmethod(stabilised)
    regularised = staticmethod(regularised)
    minimal = staticmethod(ingredients.minimal)
    ingredients = staticmethod(ingredients.ingredients)
    releases = read_releases("conrod.engines.mujoco")

    def model(self, name: str, machine: DescribedMachine, settings: MuJoCoSettings) -> str:
        return standalone_mjcf(name, machine, settings=settings)

    def probes(self, machine: Machine, steps_per_revolution: int) -> dict[str, MuJoCoSettings]:
        """The presets that apply to a machine, and parts of the solver that they do not use."""
        found = {name: preset(machine, steps_per_revolution) for name, preset in PRESETS.items()}
        if machine.kinematics.mechanism.cam_contacts:
            del found["hardened"]
        others: dict[str, dict[str, Any]] = {
            "CG": {"solver": "CG"},
            "PGS": {"solver": "PGS"},
            "sparse": {"dressing": ("sparse-jacobian",)},
            "implicitfast": {"integrator": "implicitfast"},
        }
        return found | {f"tuned, {name}": with_fields(found["tuned"], **values) for name, values in others.items()}

    def refusal(self, machine: Machine, settings: MuJoCoSettings) -> str | None:
        mechanism = machine.kinematics.mechanism
        if reason := contact_refusal(mechanism):
            return reason
        if settings.hardening is not None and mechanism.cam_contacts:
            return "hardening does not apply to contact"
        reason = older.lacking(settings) or edit_refusal(mechanism, settings)
        return reason or tree_refusal(tree_of(machine))

    def forces(
        self, machine: Machine, settings: MuJoCoSettings, revolutions: float, start_angle: float = 0.0
    ) -> ForceTracks:
        if reason := self.refusal(machine, settings):
            return no_forces(machine.kinematics.mechanism, reason)
        return forces(machine, settings, revolutions, start_angle)


ENGINE = MuJoCo()
