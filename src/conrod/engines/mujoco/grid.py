"""The grid of MuJoCo settings that a sweep varies. Imports no engine."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, fields, replace
from itertools import product
from typing import Any

from conrod.engines.engine import Machine, as_preset, step_length
from conrod.engines.massless_rod import BODY, DISTANCE_JOINT
from conrod.engines.mujoco.settings import PRESETS, STIFF_SOLIMP, STOCK_SOLIMP, STOCK_SOLREF, MuJoCoSettings
from conrod.engines.rule import Grid, Rule, distinct, texts_of

# Where a time constant stands: in seconds, in steps, or in shares of the period.
STOCK_CONSTANT = "0.02 s"
STEP_CONSTANTS = {"2 h": 2.0, "4 h": 4.0, "8 h": 8.0}
PERIOD_CONSTANTS = {"T/1000": 1e-3, "T/100": 1e-2, "T/30": 1.0 / 30.0, "T/10": 0.1, "T/3": 1.0 / 3.0}
# Impedances at no violation and at a large one, and the width in between.
CONTACT_IMPEDANCES = {
    "0.9 to 0.95": STOCK_SOLIMP,
    "0.9": (0.9, 0.9, 0.001, 0.5, 2.0),
    "0.99": (0.99, 0.99, 0.001, 0.5, 2.0),
}
STOCK_TOLERANCE = 1e-8


def time_constant(text: str, machine: Machine, steps_per_revolution: int) -> float:
    """Time constant [s] of a stabilisation such as '2 h' or 'T/10'."""
    if text in STEP_CONSTANTS:
        return STEP_CONSTANTS[text] * step_length(machine, steps_per_revolution)
    if text in PERIOD_CONSTANTS:
        return PERIOD_CONSTANTS[text] * step_length(machine, 1)
    return STOCK_SOLREF[0]


class MuJoCoRule(Rule):
    """Common part of both kinds of rules; the fields are those of the frozen dataclasses below."""

    integrator: str
    stabilisation: str
    solver: str
    iterations: int
    tolerance: float

    @property
    def softness_follows_step(self) -> bool:
        return self.stabilisation in STEP_CONSTANTS

    def knobs(self) -> dict[str, str]:
        return texts_of(self)

    def settings(self, machine: Machine, steps_per_revolution: int) -> MuJoCoSettings:
        """Settings whose armature and all that is not a knob are those of the stock preset."""
        made = replace(
            MuJoCoSettings.stock(machine, steps_per_revolution),
            preset="custom",
            integrator=self.integrator,
            solver=self.solver,
            iterations=self.iterations,
            tolerance=self.tolerance,
            **self.own_settings(time_constant(self.stabilisation, machine, steps_per_revolution)),
        )
        contact = bool(machine.kinematics.mechanism.cam_contacts)
        return as_preset(
            made, PRESETS, machine, ("solref", "solimp") if contact else ("contact_solref", "contact_solimp")
        )

    @abstractmethod
    def own_settings(self, constant: float) -> dict[str, Any]:
        """Settings that only this kind turns, with a time constant [s]."""


@dataclass(frozen=True)
class LoopRule(MuJoCoRule):
    """Settings of a machine whose loops are closed by joints."""

    integrator: str = "Euler"
    stabilisation: str = STOCK_CONSTANT  # time constant of the closure (solref)
    regularisation: str = "stock"  # impedance (solimp): stock, stiff; or hardened by a factor
    solver: str = "Newton"
    iterations: int = 100
    tolerance: float = 0.0
    rod: str = BODY

    @property
    def name(self) -> str:
        base = f"{self.integrator}, solref {self.stabilisation}, {_regularisation(self.regularisation)}"
        return ", ".join([base, *_said(self, ("solver", "iterations", "tolerance", "rod"))])

    def own_settings(self, constant: float) -> dict[str, Any]:
        hardened = self.regularisation.startswith("hardened")
        return {
            "solref": (constant, 1.0),
            "solimp": STOCK_SOLIMP if self.regularisation == "stock" else STIFF_SOLIMP,
            "hardening": float(self.regularisation.split()[1]) if hardened else None,
            "rod": self.rod,
        }


@dataclass(frozen=True)
class ContactRule(MuJoCoRule):
    """Settings of a machine with a cam that its follower is kept on by contact."""

    integrator: str = "Euler"
    stabilisation: str = "2 h"  # time constant of the contact
    impedance: str = "0.9"
    vertices: int = 4000
    solver: str = "Newton"
    iterations: int = 100
    tolerance: float = 0.0

    @property
    def name(self) -> str:
        base = f"{self.integrator}, solref {self.stabilisation}, impedance {self.impedance}"
        return ", ".join([base, *_said(self, ("vertices", "solver", "iterations", "tolerance"))])

    def own_settings(self, constant: float) -> dict[str, Any]:
        return {
            "contact_solref": (constant, 1.0),
            "contact_solimp": CONTACT_IMPEDANCES[self.impedance],
            "cam_vertices": self.vertices,
        }


def rules(machine: Machine, grid: Grid) -> tuple[Rule, ...]:
    """All rules of a grid, without repetition."""
    return _contact_rules(grid) if machine.kinematics.mechanism.cam_contacts else _loop_rules(grid)


# The presets, as rules: what the finer knobs are turned on.
STOCK = LoopRule()
TUNED = LoopRule("RK4", "8 h", "stiff")
HARDENED = LoopRule("RK4", "T/10", "hardened 1e-9")
IMPLICIT_FAST = LoopRule("implicitfast", "2 h", "stiff")


def _loop_rules(grid: Grid) -> tuple[Rule, ...]:
    bases = (STOCK, IMPLICIT_FAST, TUNED, HARDENED)
    if grid == "coarse":
        return bases
    fine = grid == "fine"
    integrators = ("Euler", "implicitfast", "RK4")
    constants = [STOCK_CONSTANT, "2 h", "8 h", "T/100", "T/10", *(("4 h", "T/1000", "T/30", "T/3") if fine else ())]
    regularisations = [
        "stock",
        "stiff",
        "hardened 1e-9",
        *(("hardened 1e-3", "hardened 1e-6", "hardened 1e-12") if fine else ()),
    ]
    found: list[Rule] = [*bases]
    found += [LoopRule(*knobs) for knobs in product(integrators, constants, regularisations)]
    counts = {"PGS": (10, 100), "CG": (10, 100), "Newton": (1, 3)}
    for base in bases:
        found += [replace(base, solver=s, iterations=k) for s, many in counts.items() for k in many]
        found += [replace(base, tolerance=STOCK_TOLERANCE), replace(base, rod=DISTANCE_JOINT)]
    for base in (IMPLICIT_FAST, HARDENED):
        found += [replace(base, integrator=i) for i in ("implicit", "discrete")]
    found += [replace(HARDENED, regularisation=f"hardened {factor}") for factor in ("1e-3", "1e-6", "1e-12")]
    return distinct(found)


def _contact_rules(grid: Grid) -> tuple[Rule, ...]:
    stock, tuned = ContactRule(stabilisation=STOCK_CONSTANT, impedance="0.9 to 0.95"), ContactRule()
    if grid == "coarse":
        return (stock, tuned)
    constants = (STOCK_CONSTANT, "2 h", "4 h", "T/1000") + (("8 h", "T/100") if grid == "fine" else ())
    found: list[Rule] = [stock, tuned]
    found += [ContactRule(*knobs) for knobs in product(("Euler", "implicitfast", "RK4"), constants, CONTACT_IMPEDANCES)]
    found += [replace(tuned, vertices=n) for n in (250, 1000)]
    found += [replace(tuned, solver=s, iterations=k) for s, k in (("PGS", 10), ("CG", 10), ("Newton", 1))]
    found += [replace(tuned, tolerance=STOCK_TOLERANCE)]
    return distinct(found)


def _regularisation(text: str) -> str:
    return {"stock": "solimp stock", "stiff": "solimp 0.9999"}.get(text, text)


def _said(rule: Any, names: tuple[str, ...]) -> list[str]:
    """Knobs that are not where they usually are."""
    usual = {field.name: field.default for field in fields(rule)}
    words = {
        "iterations": "{} iterations",
        "tolerance": "tolerance {:g}",
        "rod": "rod as {}",
        "vertices": "{} vertices",
    }
    values = {name: getattr(rule, name) for name in names}
    return [words.get(name, "{}").format(v) for name, v in values.items() if v != usual[name]]
