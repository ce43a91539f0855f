"""A run as a script of its own, which needs MuJoCo and numpy alone."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from conrod.engines.engine import Machine
from conrod.engines.mujoco import older
from conrod.engines.mujoco.loads import by_program
from conrod.engines.mujoco.mjcf import mjcf
from conrod.engines.mujoco.model import build
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.mujoco.standalone import after_compiling
from conrod.engines.releases import numbers_of
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
