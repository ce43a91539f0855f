"""Settings by which releases of MuJoCo are told apart: the presets, and parts of the solver that they do not use."""

from __future__ import annotations

from conrod.engines.engine import Machine, with_fields
from conrod.engines.mujoco.settings import PRESETS, MuJoCoSettings


def probes(machine: Machine, steps_per_revolution: int) -> dict[str, MuJoCoSettings]:
    """Settings by name; those that do not apply to a machine are left out."""
    contact = bool(machine.kinematics.mechanism.cam_contacts)
    found = {name: preset(machine, steps_per_revolution) for name, preset in PRESETS.items()}
    if contact:
        del found["hardened"]
    tuned = found["tuned"]
    return found | {
        "tuned, CG": with_fields(tuned, solver="CG"),
        "tuned, PGS": with_fields(tuned, solver="PGS"),
        "tuned, sparse": with_fields(tuned, dressing=("sparse-jacobian",)),
        "tuned, implicitfast": with_fields(tuned, integrator="implicitfast"),
    }
