"""Closed loops of a compiled model that can be hardened, the edit that does it, as Python too, and objections to it."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import mujoco
import numpy as np

from conrod.engines.mujoco import LEAST_IMPEDANCE, MOST_IMPEDANCE, STOCK_SOLIMP, STOCK_SOLREF, older
from conrod.exact.motion import Array
from conrod.mjcf.equalities import kind_of, ties_bodies
from conrod.own.models.loading import listed, name_or_number

# What is left of the regularisation, over the inverse inertia: (1 - d) / d x factor. Softness leaves an error in
# proportion to it; Newton's one iteration at MuJoCo's stock tolerance leaves one of rounding in inverse proportion,
# and below 1e-13 the solver fails. On free swings of saw, press, Robotiq 2F-85 and Cassie the sum was least between
# 1e-8 and 1e-9 (docs/hardening.md).
RESIDUE = 1e-9
# Time constant of closures, in steps, from which on slower ones closed no better (docs/hardening.md).
STEPS = 10.0


Holder = Literal["body", "dof", "tendon"]


@dataclass(frozen=True)
class Closure:
    """One equality constraint that can be hardened.

    Attributes:
        holder, ends: whose inverse weights its regularisation is taken from, by index.
        curved: MuJoCo's acceleration of it lacks the part of the velocity: it opens with the square of its time
            constant, hardened or not.
    """

    index: int  # of the equality
    name: str
    kind: str
    holder: Holder
    ends: tuple[int, ...]
    curved: bool = False


def active_closures(model: mujoco.MjModel) -> tuple[Closure, ...]:
    """The equality constraints that act from the start, of the kinds that can be hardened."""
    if int(model.opt.disableflags) & int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT | mujoco.mjtDisableBit.mjDSBL_EQUALITY):
        return ()
    return tuple(
        closure(model, index) for index in range(model.neq) if model.eq_active0[index] and kind_of(model, index)
    )


def closure(model: mujoco.MjModel, index: int) -> Closure:
    """An equality as a closure."""
    name, kind = name_or_number(model, "equality", index), kind_of(model, index)
    if ties_bodies(model, index):
        return Closure(index, name, kind, "body", tuple(older.bodies_of(model, index)))
    ends = tuple(int(end) for end in (model.eq_obj1id[index], model.eq_obj2id[index]) if end >= 0)
    bent = len(ends) > 1 and bool(np.any(model.eq_data[index, 2:5]))
    if kind == "joint":
        return Closure(index, name, kind, "dof", tuple(int(model.jnt_dofadr[joint]) for joint in ends), bent)
    # The length of a fixed tendon is linear in joint coordinates.
    first = [int(model.tendon_adr[tendon]) for tendon in ends]
    fixed = all(model.wrap_type[first] == mujoco.mjtWrap.mjWRAP_JOINT)
    return Closure(index, name, kind, "tendon", ends, bent or not fixed)


@dataclass(frozen=True)
class Weights:
    """Inverse weights that are scaled: indices by whose they are, of a body, a degree of freedom or a tendon."""

    indices: Mapping[Holder, tuple[int, ...]]

    @classmethod
    def of(cls, closures: Sequence[Closure]) -> Weights:
        """Weights of closures; the world, body 0, has none to scale."""
        ends: dict[Holder, set[int]] = {"body": set(), "dof": set(), "tendon": set()}
        for one in closures:
            ends[one.holder].update(one.ends)
        ends["body"].discard(0)
        return cls({holder: tuple(sorted(found)) for holder, found in ends.items()})

    def values(self, model: mujoco.MjModel) -> Array:
        """Weights of a model, in a row."""
        arrays = (getattr(model, f"{holder}_invweight0")[list(chosen)] for holder, chosen in self.indices.items())
        return np.concatenate([np.ravel(array) for array in arrays])


@dataclass(frozen=True)
class Recipe:
    """An edit of a compiled model."""

    factor: float  # on the weights
    weights: Weights
    time_constants: tuple[tuple[int, float], ...] = ()  # index of an equality and its time constant [s]
    runge_kutta: bool = False  # whether the integrator is set to RK4
    newton: bool = False  # whether the solver is set to Newton


def edited(model: mujoco.MjModel, recipe: Recipe) -> mujoco.MjModel:
    """A copy of a model with a recipe applied."""
    changed = copy.copy(model)
    for holder, chosen in recipe.weights.indices.items():
        getattr(changed, f"{holder}_invweight0")[list(chosen)] *= recipe.factor
    for index, constant in recipe.time_constants:
        changed.eq_solref[index, 0] = constant
    if recipe.runge_kutta:
        changed.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    if recipe.newton:
        changed.opt.solver = mujoco.mjtSolver.mjSOL_NEWTON
    return changed


def recipe_for(model: mujoco.MjModel, closures: Sequence[Closure]) -> Recipe:
    """The edit that hardens closures, of which there is at least one."""
    stiffest = max(impedance(model.eq_solimp[one.index]) for one in closures)
    return Recipe(
        factor=float(f"{min(1.0, RESIDUE * stiffest / (1.0 - stiffest)):.3g}"),
        weights=Weights.of(closures),
        time_constants=tuple(_time_constants(model, closures)),
        runge_kutta=mujoco.mjtIntegrator(model.opt.integrator) != mujoco.mjtIntegrator.mjINT_RK4,
        newton=mujoco.mjtSolver(model.opt.solver) != mujoco.mjtSolver.mjSOL_NEWTON,
    )


def _time_constants(model: mujoco.MjModel, closures: Sequence[Closure]) -> Iterator[tuple[int, float]]:
    enough = float(f"{STEPS * float(model.opt.timestep):.6g}")
    for one in closures:
        # Stiffness and damping given as such have no time constant; a curved closure opens with the square of its own.
        if 0.0 < float(model.eq_solref[one.index, 0]) < enough and not one.curved:
            yield one.index, enough


def python_lines(model: mujoco.MjModel, recipe: Recipe, path: Path) -> str:
    """Lines that make the edit, ready to paste; with the whole path of the file they give the same model anywhere."""
    reader = "from_binary_path" if path.suffix.lower() == ".mjb" else "from_xml_path"
    lines = [
        "import mujoco",
        "",
        f"model = mujoco.MjModel.{reader}({str(path)!r})",
        "# after mj_setConst, which makes these anew: again",
    ]
    for holder, indices in recipe.weights.indices.items():
        if indices:
            kind, owners = ("joint", model.dof_jntid[list(indices)]) if holder == "dof" else (holder, indices)
            names = _comment([_called(model, kind, int(owner)) for owner in owners])
            lines.append(f"model.{holder}_invweight0[{list(indices)}] *= {recipe.factor!r}  # {names}")
    if recipe.time_constants:
        slowed = [index for index, _ in recipe.time_constants]
        names = _comment([_called(model, "equality", index) for index in slowed])
        lines.append(f"model.eq_solref[{slowed}, 0] = {recipe.time_constants[0][1]!r}  # {names}")
    if recipe.runge_kutta:
        lines.append("model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4")
    if recipe.newton:
        lines.append("model.opt.solver = mujoco.mjtSolver.mjSOL_NEWTON")
    return "\n".join(lines) + "\n"


def _comment(names: Sequence[str]) -> str:
    """Names as a comment: a line break in one would end it."""
    return " ".join(listed(names).split())


def _called(model: mujoco.MjModel, sort: str, index: int) -> str:
    """An element with its kind: "body crank", or "body 3" where it has no name."""
    name = name_or_number(model, sort, index)
    return name if name == f"{sort} {index}" else f"{sort} {name}"


# -- softness --------------------------------------------------------------------------------------------------------


def impedance(solimp: Array) -> float:
    """MuJoCo's impedance d of a closed constraint: solimp's first number, or the mean where there is no width."""
    first, last = np.clip(solimp[:2], LEAST_IMPEDANCE, MOST_IMPEDANCE)
    return float(first if solimp[2] > 0.0 else 0.5 * (first + last))


def compliance(solref: Array, solimp: Array, least_time: float) -> float:
    """Opening of a constraint [m] under a force, over the acceleration that this gives its inverse weight [s^2].

    A constraint at rest under a force f is open by f R / (k d), R = (1 - d) / d x (inverse weight),
    k = 1 / (d_max^2 x time constant^2 x damping ratio^2) (MuJoCo's documentation, "Computation", solver parameters).
    """
    d, widest = impedance(solimp), float(np.clip(solimp[1], LEAST_IMPEDANCE, MOST_IMPEDANCE))
    constant = max(float(solref[0]), least_time)
    return (1.0 - d) / d**2 * (widest * constant * float(solref[1])) ** 2


def softer_than_stock(model: mujoco.MjModel, index: int) -> bool:
    """Return True where an equality gives way more than a stock one."""
    unsafe = int(model.opt.disableflags) & int(mujoco.mjtDisableBit.mjDSBL_REFSAFE)
    least = 0.0 if unsafe else 2.0 * float(model.opt.timestep)  # the least time constant that MuJoCo admits [s]
    stock = compliance(np.array(STOCK_SOLREF), np.array(STOCK_SOLIMP), least)
    # Twelve digits: what was written as stock is stock.
    return compliance(model.eq_solref[index], model.eq_solimp[index], least) > stock * (1.0 + 1e-12)


# -- objections ------------------------------------------------------------------------------------------------------

# A weight of less than this share of what MuJoCo would give it has been scaled.
SCALED = 0.5


def nothing_to_do(model: mujoco.MjModel, closures: Sequence[Closure]) -> str:
    """Reason why a model cannot be hardened, forced or not; empty where it can."""
    if not closures:
        if off := [name_or_number(model, "equality", i) for i in range(model.neq) if kind_of(model, i)]:
            return f"none of its equality constraints is active at the start: {listed(off)}"
        return "it has no closed loop: nothing to harden (joints of its tree are exact as they are)"
    made, weights = copy.copy(model), Weights.of(closures)
    mujoco.mj_setConst(made, mujoco.MjData(made))
    stock = weights.values(made)
    there = stock > 0.0
    if not there.any():
        return "what its closures hold has no inverse weight: nothing to harden"
    share = float((weights.values(model)[there] / stock[there]).max())
    return f"it is hardened already: its weights are {share:.1e} of what they were" if share < SCALED else ""


def soft_on_purpose(model: mujoco.MjModel, closures: Sequence[Closure]) -> tuple[str, ...]:
    """Closures that seem to be meant to give way."""
    given, softer, dragged = list[str](), list[str](), list[str]()
    for one in closures:
        if one.holder == "body" and any(model.body_mocapid[body] >= 0 for body in one.ends):
            dragged.append(one.name)
        elif model.eq_solref[one.index, 0] <= 0.0:
            given.append(one.name)
        elif softer_than_stock(model, one.index):
            softer.append(one.name)
    reasons = (
        (given, "stiffness and damping are given as such (solref <= 0)"),
        (softer, "softer than MuJoCo's stock setting"),
        (dragged, "it drags a body after a mocap body"),
    )
    return tuple(f"{listed(names)}: {why}, so meant to give way" for names, why in reasons if names)


def to_know(model: mujoco.MjModel, closures: Sequence[Closure]) -> tuple[str, ...]:
    """Limits of the hardened model."""
    hardened = {one.index for one in closures}
    found = (
        (
            [one.name for one in closures if one.curved],
            "MuJoCo's acceleration of it lacks the part of the velocity: hardened or not, it opens with the square of "
            "its time constant, so that is kept; the reference has this error too, so the drift does not show it",
        ),
        (
            [name_or_number(model, "equality", index) for index in range(model.neq) if index not in hardened],
            "not active at the start, or of a flex, so not hardened",
        ),
    )
    return tuple(f"{listed(which)}: {what}" for which, what in found if which)
