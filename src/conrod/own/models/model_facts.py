"""Facts about a user's model that its report names: joints, closures, contact, settings, limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Wiring:
    """Joints and closures of a model, and the freedom that they leave.

    Attributes:
        joints: number of joints by kind: hinge, slide, ball, free.
        closures: number of active equality constraints by kind: connect, weld, joint, tendon, ...
        inactive: names of those that are switched off.
        coordinates: degrees of freedom that the joints give.
        rows: scalar equations of the closures.
        rank: least and largest rank of their Jacobian along the turn.
        idle: closures that close nothing which those before them do not.
    """

    joints: Mapping[str, int]
    closures: Mapping[str, int]
    inactive: tuple[str, ...]
    coordinates: int
    rows: int
    rank: tuple[int, int]
    idle: tuple[str, ...]

    @property
    def loops(self) -> int:
        """Closures that close something."""
        return sum(self.closures.values()) - len(self.idle)


@dataclass(frozen=True)
class Touching:
    """Two geoms that make a higher pair.

    Attributes:
        shape_error: largest distance of the collision shape from the curve that its corners lie on.
    """

    geoms: tuple[str, str]
    shape_error: float
    corners: int


@dataclass(frozen=True)
class OwnSettings:
    """Settings that a model comes with."""

    timestep: float  # [s]
    integrator: str
    solver: str
    iterations: int
    tolerance: float
    gravity: tuple[float, float, float]
    closure_solref: tuple[tuple[float, float], ...]  # all that occur
    closure_impedance: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class ModelFacts:
    """A model by the account of its compiled file and of one turn of its crank.

    Attributes:
        gap: largest violation that the closures keep, in their own units.
        open_closure: name of that closure.
        stops: joints whose limits the turn leaves, with both.
        remarks: deviations of the treatment from the file, and what else acts on the crank.
    """

    name: str
    engine_version: str
    wiring: Wiring
    touching: Touching | None
    settings: OwnSettings
    gap: float
    open_closure: str
    stops: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
