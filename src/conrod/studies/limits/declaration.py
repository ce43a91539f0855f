"""The same machine with its bodies and joints declared in another order: nothing in its motion may depend on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from numpy.typing import ArrayLike

from conrod.exact.motion import Motion, Side
from conrod.exact.reference import ExactReference
from conrod.mechanism.mechanism import Mechanism
from conrod.scenes import Scene


@dataclass(frozen=True)
class Declaration:
    """Names of the bodies and of the joints in the order in which they are declared."""

    bodies: tuple[str, ...]
    joints: tuple[str, ...]

    def of(self, mechanism: Mechanism) -> Mechanism:
        """A mechanism declared in this order.

        Raises:
            KeyError: a name that the mechanism does not have.
            ValueError: not all of its bodies or joints.
        """
        joints = {joint.name: joint for joint in mechanism.joints}
        if len(set(self.bodies)) != len(mechanism.bodies) or len(set(self.joints)) != len(joints):
            raise ValueError(f"{mechanism.name}: an order must name every body and every joint once")
        return replace(
            mechanism,
            bodies=tuple(mechanism.body(name) for name in self.bodies),
            joints=tuple(joints[name] for name in self.joints),
        )


@dataclass(frozen=True)
class Redeclared(ExactReference):
    """A scene whose mechanism is declared in another order; it is run, and compared with the same closed form."""

    scene: Scene = field(repr=False)
    declaration: Declaration
    speed: float = field(init=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "speed", self.scene.speed)

    @property
    def lengths(self) -> Mapping[str, float]:
        """Normalising lengths [m]; they depend on no order."""
        return self.scene.lengths

    def mechanism(self) -> Mechanism:
        """The mechanism in its new order."""
        return self.declaration.of(self.scene.mechanism())

    def motion(self, angle: ArrayLike, speed: ArrayLike, acceleration: ArrayLike = 0.0, side: Side = "right") -> Motion:
        """The exact motion, which depends on no order."""
        return self.scene.motion(angle, speed, acceleration, side)

    def break_angles(self) -> tuple[float, ...]:
        """Those of the scene."""
        return self.scene.break_angles()
