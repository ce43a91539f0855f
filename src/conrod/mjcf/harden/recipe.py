"""The changes to a compiled model that keep its loops closed, as an edit and as lines of Python."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np

from conrod.exact.motion import Array
from conrod.mjcf.harden.closures import Closure, Holder, called, impedance
from conrod.mjcf.harden.results import Request
from conrod.own.models.loading import listed

# What is left of the regularisation, over the inverse inertia: (1 - d) / d x factor. Softness leaves an error in
# proportion to it; Newton's one iteration at MuJoCo's stock tolerance leaves one of rounding in inverse proportion,
# and below 1e-13 the solver fails. On free swings of saw, press, Robotiq 2F-85 and Cassie the sum was least between
# 1e-8 and 1e-9 (docs/hardening.md).
RESIDUE = 1e-9
# Time constant of closures, in steps, from which on slower ones closed no better (docs/hardening.md).
STEPS = 10.0
INTEGRATORS = ("RK4", "keep")


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

    def scale(self, model: mujoco.MjModel, factor: float) -> None:
        """Multiply them, in place."""
        for holder, chosen in self.indices.items():
            getattr(model, f"{holder}_invweight0")[list(chosen)] *= factor

    def names(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of what they belong to; of a degree of freedom that of its joint."""
        return tuple(name for holder in self.indices for name in self.names_of(model, holder))

    def names_of(self, model: mujoco.MjModel, holder: Holder) -> tuple[str, ...]:
        """Names of the bodies, joints or tendons among them."""
        if holder == "dof":
            return tuple(called(model, "joint", int(model.dof_jntid[dof])) for dof in self.indices[holder])
        return tuple(called(model, holder, index) for index in self.indices[holder])


@dataclass(frozen=True)
class Recipe:
    """An edit of a compiled model.

    Attributes:
        factor: on the weights.
        time_constants: index of an equality and its time constant [s].
        integrator: MuJoCo's name; empty for the model's own.
        newton: whether the solver is set to Newton.
    """

    factor: float
    weights: Weights
    time_constants: tuple[tuple[int, float], ...] = ()
    integrator: str = ""
    newton: bool = False

    @property
    def weights_alone(self) -> Recipe:
        """Nothing but the weights."""
        return replace(self, time_constants=(), integrator="", newton=False)

    def apply(self, model: mujoco.MjModel) -> None:
        """Edit a model in place."""
        self.weights.scale(model, self.factor)
        for index, constant in self.time_constants:
            model.eq_solref[index, 0] = constant
        if self.integrator:
            model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{self.integrator}")
        if self.newton:
            model.opt.solver = mujoco.mjtSolver.mjSOL_NEWTON


def recipe_for(model: mujoco.MjModel, closures: Sequence[Closure], request: Request) -> Recipe:
    """The edit that hardens closures, of which there is at least one, as asked."""
    stiffest = max(impedance(model.eq_solimp[one.index]) for one in closures)
    newton = mujoco.mjtSolver(model.opt.solver) == mujoco.mjtSolver.mjSOL_NEWTON
    return Recipe(
        factor=float(f"{min(1.0, RESIDUE * stiffest / (1.0 - stiffest)):.3g}"),
        weights=Weights.of(closures),
        time_constants=tuple(_time_constants(model, closures, request.solref)),
        integrator="RK4"
        if request.integrator == "RK4" and mujoco.mjtIntegrator(model.opt.integrator) != mujoco.mjtIntegrator.mjINT_RK4
        else "",
        newton=not newton,
    )


def _time_constants(model: mujoco.MjModel, closures: Sequence[Closure], asked: str | float) -> list[tuple[int, float]]:
    if asked == "keep":
        return []
    changed = []
    for one in closures:
        now = float(model.eq_solref[one.index, 0])
        # Stiffness and damping given as such have no time constant; a curved closure opens with the square of its own.
        if now <= 0.0 or (one.curved and asked == "auto"):
            continue
        enough = float(f"{STEPS * float(model.opt.timestep):.6g}")
        chosen = asked if isinstance(asked, float) else max(now, enough)
        if chosen != now:
            changed.append((one.index, chosen))
    return changed


# -- as Python -------------------------------------------------------------------------------------------------------


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
            names = _on_one_line(recipe.weights.names_of(model, holder))
            lines.append(f"model.{holder}_invweight0[{list(indices)}] *= {recipe.factor!r}  # {names}")
    for constant in dict.fromkeys(constant for _, constant in recipe.time_constants):
        slowed = [index for index, value in recipe.time_constants if value == constant]
        names = _on_one_line(tuple(called(model, "equality", index) for index in slowed))
        lines.append(f"model.eq_solref[{slowed}, 0] = {constant!r}  # {names}")
    if recipe.integrator:
        lines.append(f"model.opt.integrator = mujoco.mjtIntegrator.mjINT_{recipe.integrator}")
    if recipe.newton:
        lines.append("model.opt.solver = mujoco.mjtSolver.mjSOL_NEWTON")
    return "\n".join(lines) + "\n"


def _on_one_line(names: tuple[str, ...]) -> str:
    """Names as a comment: a line break in one would end it."""
    return " ".join(listed(names).split())
