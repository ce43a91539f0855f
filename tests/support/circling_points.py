"""A machine whose points circle about the shaft, for tables with errors that a hand can compute."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from conrod.exact.motion import Array


@dataclass(frozen=True)
class CirclingPoints:
    """Points (r cos a, r sin a) of a crank at angle a; L of each is its diameter 2 r."""

    speed: float = 2.0
    radii: dict[str, float] = field(default_factory=lambda: {"P": 0.5, "Q": 2.0})
    span: tuple[float, float] | None = None

    @property
    def lengths(self) -> dict[str, float]:
        return {name: 2.0 * radius for name, radius in self.radii.items()}

    @property
    def period(self) -> float:
        return 2.0 * math.pi / abs(self.speed)

    @property
    def kinematics(self) -> Any:
        mechanism = SimpleNamespace(driver=SimpleNamespace(span=self.span), joints=())
        return SimpleNamespace(mechanism=mechanism, size=max(self.lengths.values()))

    def with_parameters(self, speed: float) -> CirclingPoints:
        return replace(self, speed=speed)

    def motion(self, angle: Array, rate: Any, acceleration: Any = 0.0) -> Any:
        outward = np.column_stack([np.cos(angle), np.sin(angle)])
        along = np.column_stack([-np.sin(angle), np.cos(angle)])
        w, e = (np.broadcast_to(np.asarray(one), np.shape(angle))[:, None] for one in (rate, acceleration))

        def point(name: str) -> Any:
            r = self.radii[name]
            return SimpleNamespace(position=r * outward, velocity=r * w * along,
                                   acceleration=r * (e * along - w**2 * outward))  # fmt: skip

        return SimpleNamespace(point=point)

    def table(self, times: Array, *quantities: str) -> dict[str, Array]:
        """Exact columns at some times [s]."""
        found, motion = {"time": times}, self.motion(self.speed * times, self.speed)
        letters = {"position": "", "velocity": "v", "acceleration": "a"}
        for name in self.radii:
            for quantity in quantities or ("position",):
                values = getattr(motion.point(name), quantity)
                found |= {f"{name}.{letters[quantity]}{axis}": values[:, k].copy() for k, axis in enumerate("xy")}
        return found
