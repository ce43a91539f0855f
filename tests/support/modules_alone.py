"""Exported pymunk modules in a process of their own, which has pymunk and no conrod."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np

from conrod.exact.motion import Array

# Prints positions with angles, and rates, of all bodies after a run.
RUN = """
import importlib.util, json, sys
for name in ("conrod", "numpy", "scipy", "mujoco"):
    sys.modules[name] = None
found = importlib.util.spec_from_file_location("machine", sys.argv[1])
machine = importlib.util.module_from_spec(found)
found.loader.exec_module(machine)
model = machine.build(**json.loads(sys.argv[2]))
for _ in range(machine.RUN_STEPS):
    machine.step(model)
bodies = model.bodies.values()
print(json.dumps([[[*b.position, b.angle] for b in bodies], [[*b.velocity, b.angular_velocity] for b in bodies]]))
"""
TIMEOUT = 120.0  # [s]


def run_alone(text: str, folder: Path, **arguments: float) -> tuple[Array, Array]:
    """States of all centres of gravity, (1, 3 n) each, after a module's run; arguments as for its `build`."""
    file = folder / "machine.py"
    file.write_text(text, encoding="utf-8")
    command = [sys.executable, "-I", "-c", RUN, str(file), json.dumps(arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=TIMEOUT)
    assert done.returncode == 0, done.stderr
    centres, rates = json.loads(done.stdout)
    return np.array(centres).reshape(1, -1), np.array(rates).reshape(1, -1)


def printed_lines(file: Path) -> list[str]:
    """Lines that a module prints as a program."""
    command = [sys.executable, "-I", str(file)]
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=TIMEOUT).stdout.splitlines()
