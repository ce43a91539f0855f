"""MuJoCo, as one of conrod's engines."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any

import mujoco

from conrod.engines.cam_polygon import contact_refusal
from conrod.engines.engine import Engine, Machine, with_fields
from conrod.engines.massless_rod import form_refusal, model_form
from conrod.engines.mujoco import dynamics, ingredients, kinematic, law, older, standalone, timing
from conrod.engines.mujoco.forces import forces
from conrod.engines.mujoco.free_run import free_run
from conrod.engines.mujoco.grid import regularised, rules, stabilised
from conrod.engines.mujoco.loads import by_program
from conrod.engines.mujoco.mjcf import mjcf
from conrod.engines.mujoco.model import build
from conrod.engines.mujoco.model_edits import edit_refusal
from conrod.engines.mujoco.settings import PRESETS, MuJoCoSettings
from conrod.engines.mujoco.standalone import DescribedMachine, after_compiling, standalone_mjcf
from conrod.engines.releases import numbers_of, read_releases
from conrod.engines.tracks import ForceTracks, no_forces
from conrod.engines.tree import tree_of, tree_refusal
from conrod.errors import InvalidInput

SCRIPT = '''
import hashlib

import mujoco
import numpy as np

MODEL = r"""
{model}"""

model = mujoco.MjModel.from_xml_string(MODEL)
{after}
data = mujoco.MjData(model)
data.qpos[:] = {qpos}
data.qvel[:] = {qvel}
digest, gap = hashlib.sha256(), 0.0
for _ in range({steps}):
    mujoco.mj_step(model, data)
    digest.update(np.concatenate([data.qpos, data.qvel, data.qacc, data.sensordata]).tobytes())
    gap = max(gap, float(np.abs(data.efc_pos).max(initial=0.0)))
print(f"MuJoCo {{mujoco.__version__}}: all states and sensors {{digest.hexdigest()[:16]}}")
print(f"largest violation of a constraint: {{gap:.17g}}")
print("qpos at the end:", *(f"{{value:.17g}}" for value in data.qpos))
print("qacc at the end:", *(f"{{value:.17g}}" for value in data.qacc))
'''


def reproducer(
    machine: Machine, settings: MuJoCoSettings, versions: tuple[str, ...], revolutions: float, start_angle: float
) -> str:
    """A script that makes a run and prints what came of it, in any of some releases.

    Raises:
        InvalidInput: a machine whose loads are laws that MJCF has no words for.
    """
    made = build(machine, settings)
    if by_program(made.tree.mechanism):
        raise InvalidInput(f"{made.tree.mechanism.name} has loads that a model cannot say; name another scene")
    root = ET.fromstring(mjcf(made.tree, settings, made.tree.mechanism.name))
    older.adapt(root, min(numbers_of(version) for version in versions))
    qpos, qvel = (values.tolist() for values in made.start_state(machine, start_angle))
    return SCRIPT.format(
        model=ET.tostring(root, encoding="unicode"), after="\n".join(after_compiling(settings)), qpos=qpos, qvel=qvel,
        steps=round(settings.steps_per_revolution * revolutions),
    )  # fmt: skip


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
    reproducer = staticmethod(reproducer)

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
        reason = older.lacking(settings) or form_refusal(mechanism, settings.rod) or edit_refusal(mechanism, settings)
        return reason or tree_refusal(tree_of(machine, model_form(mechanism, settings.rod)))

    def forces(
        self, machine: Machine, settings: MuJoCoSettings, revolutions: float, start_angle: float = 0.0
    ) -> ForceTracks:
        if reason := self.refusal(machine, settings):
            return no_forces(machine.kinematics.mechanism, reason)
        return forces(machine, settings, revolutions, start_angle)


ENGINE = MuJoCo()
