"""Edits of a model file: what a fix consists of, and what two models of a paired run differ by."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np


@dataclass(frozen=True)
class SetAttribute:
    """Give an attribute of an element a value.

    Attributes:
        kind: of element, as MuJoCo names it: geom, joint, equality, sensor, key, body.
        index: of the element in the compiled model.
        name: how to speak of it.
    """

    kind: str
    index: int
    name: str
    attribute: str
    value: str

    @property
    def words(self) -> str:
        """In words."""
        return f'{_spoken(self.kind, self.name)}: {self.attribute}="{self.value}"'


@dataclass(frozen=True)
class Remove:
    """Take an element out; the attributes are as above."""

    kind: str
    index: int
    name: str

    @property
    def words(self) -> str:
        """In words."""
        return f"{_spoken(self.kind, self.name)}: removed"


@dataclass(frozen=True)
class SetOption:
    """Give an attribute of a section a value, wherever the file has the section.

    Attributes:
        path: the section and what is in it: ("option", "flag").
    """

    path: tuple[str, ...]
    attribute: str
    value: str

    @property
    def of_compiled(self) -> bool:
        """True where the edit can be made on a compiled model."""
        return self.path[0] == "option"

    @property
    def words(self) -> str:
        """In words."""
        inner = f'<{self.path[-1]} {self.attribute}="{self.value}"/>'
        return f"<{self.path[0]}>{inner}</{self.path[0]}>" if len(self.path) > 1 else inner


@dataclass(frozen=True)
class Exclude:
    """Let the geoms of two bodies not collide.

    Attributes:
        indices: of the bodies in the compiled model.
        names: how to speak of them.
    """

    indices: tuple[int, int]
    names: tuple[str, str]

    @property
    def words(self) -> str:
        """In words."""
        return f'<contact><exclude body1="{self.names[0]}" body2="{self.names[1]}"/></contact>'


def _spoken(kind: str, name: str) -> str:
    """An element without a name goes by its kind and number already."""
    return name if name.startswith(f"{kind} ") else f"{kind} {name}"


Edit = SetAttribute | Remove | SetOption | Exclude


SOLVERS = {"PGS": mujoco.mjtSolver.mjSOL_PGS, "CG": mujoco.mjtSolver.mjSOL_CG, "Newton": mujoco.mjtSolver.mjSOL_NEWTON}


def set_option(model: mujoco.MjModel, edit: SetOption) -> None:
    """Edit <option> of a compiled model in place: a mesh need not be compiled again for another step.

    Raises:
        ValueError: it is none of those that rules make.
    """
    options = model.opt
    match edit.path, edit.attribute:
        case ("option",), "timestep" | "tolerance":
            setattr(options, edit.attribute, float(edit.value))
        case ("option",), "iterations":
            options.iterations = int(edit.value)
        case ("option",), "solver":
            options.solver = SOLVERS[edit.value]
        case ("option",), "gravity":
            options.gravity[:] = np.array(edit.value.split(), dtype=float)
        case ("option", "flag"), "autoreset" if edit.value == "disable":
            options.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
        case _:
            raise ValueError(f"no edit of a compiled model: {edit.words}")
