"""A spatial machine whose motion is known in closed form."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.jet import Jet
from conrod.exact.motion import Array
from conrod.scenes.space.model import Closure, Link, model_text

Drives: TypeAlias = Mapping[str, Jet]  # coordinate of each driven joint, (T, 1) [rad] or [m]


@dataclass(frozen=True)
class SpatialMotion:
    """Where a machine is.

    Attributes:
        points: positions of observed points in the world, (T, 3) [m]; a site of the model has each one's name.
        joints: coordinates of the model's hinges and slides, (T, 1) [rad] or [m], each up to a constant.
    """

    points: Mapping[str, Jet]
    joints: Mapping[str, Jet]


ClosedForm: TypeAlias = Callable[[Drives], SpatialMotion]


@dataclass(frozen=True)
class SpatialMachine:
    """A machine as a MuJoCo model, and the motion of the same machine from its parameters alone.

    Attributes:
        links, closures: its model; the reference pose is assembled, on the branch of the closed form.
        drives: law of each driven joint, as text ("60rpm", "sine:20deg,1Hz"); 0 in the reference pose.
        degrees_of_freedom: of the model as it moves, idle spins of rods included.
        gruebler: Gruebler-Kutzbach count, 6 (links - 1) - sum of (6 - freedoms of a joint), of the mechanism.
    """

    name: str
    title: str
    source: str  # of the formulas: document, equation
    links: Sequence[Link]
    closures: Sequence[Closure]
    drives: Mapping[str, str]
    closed_form: ClosedForm
    degrees_of_freedom: int
    gruebler: int

    @property
    def mjcf(self) -> str:
        """The complete model: gravity, masses, no contacts."""
        return model_text(self.name, self.links, self.closures)

    def points(self, drives: Mapping[str, Array]) -> dict[str, Array]:
        """Positions of the observed points and their derivatives by time, each (K, T, 3) [m, m/s, ...].

        Args:
            drives: coordinate of each driven joint and its derivatives by time, (K, T); K = 1 gives positions alone.
        """
        motion = self.closed_form(_jets(drives))
        return {name: _derivatives(jet, drives) for name, jet in motion.points.items()}

    def joints(self, drives: Mapping[str, Array]) -> dict[str, Array]:
        """Coordinates of hinges and slides and their derivatives by time, each (K, T); 0 in the reference pose.

        Of a joint that turns fully, the angle is known up to whole turns.
        """
        start = self.closed_form({joint: Jet([np.zeros((1, 1))]) for joint in self.drives}).joints
        motion = self.closed_form(_jets(drives))
        return {
            name: _derivatives(jet - start[name].coefficients[0], drives)[..., 0] for name, jet in motion.joints.items()
        }


def start_pose(closed_form: ClosedForm, driven: Iterable[str]) -> dict[str, Array]:
    """Points (3,) [m] where all driven coordinates are 0: the reference pose, from which a model is built.

    Raises:
        InvalidInput: links of these sizes do not reach each other there.
    """
    with np.errstate(invalid="ignore"):
        points = closed_form({joint: Jet([np.zeros((1, 1))]) for joint in driven}).points
    start = {name: np.asarray(jet.coefficients[0])[0] for name, jet in points.items()}
    if apart := [name for name, point in start.items() if not np.isfinite(point).all()]:
        raise InvalidInput(
            f"links of these sizes cannot be assembled in the reference pose: they leave {apart[0]} nowhere"
        )
    return start


def _jets(drives: Mapping[str, Array]) -> dict[str, Jet]:
    return {
        joint: Jet([d[:, None] / math.factorial(k) for k, d in enumerate(values)]) for joint, values in drives.items()
    }


def _derivatives(jet: Jet, drives: Mapping[str, Array]) -> Array:
    samples = next(iter(drives.values())).shape[1]
    values = [math.factorial(k) * np.asarray(c) for k, c in enumerate(jet.coefficients)]
    return np.stack([np.broadcast_to(v, (samples, v.shape[-1])) for v in values])
