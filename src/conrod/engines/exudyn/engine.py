"""Exudyn, as one of conrod's engines."""

from __future__ import annotations

import exudyn

from conrod.engines.engine import Engine
from conrod.engines.exudyn import dynamics, kinematic, model, stepping
from conrod.engines.exudyn.settings import PRESETS, ExudynSettings


class Exudyn(Engine[ExudynSettings]):
    """Exudyn by way of its `MainSystem` of planar bodies, with hard constraints and implicit integrators."""

    name = "exudyn"
    version = exudyn.__version__
    presets = PRESETS
    refusal = staticmethod(model.refusal)
    run = staticmethod(dynamics.run)
    solve_kinematics = staticmethod(kinematic.solve_kinematics)
    stepper = staticmethod(stepping.stepper)
    reference_loop = staticmethod(stepping.reference_loop)


ENGINE = Exudyn()
