"""Document 002's vectors: in the complex plane, in Cartesian components, and the loop of its saw.

Vectors are given along the turning one and across it: its length r with v = r', a = r''; its angle t2 with w2, a2.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from audits.formulas.published import Published
from audits.formulas.saw import arguments, in_time, rotating, rotating_acceleration, rotating_velocity

__all__ = ["FORMULAS", "arguments"]


def complex_velocity_as_printed(*, r: Any, w2: Any, **_: Any) -> Any:
    """Document 002, line 55: r e^(i t) + r w e^(i(t + pi/2)), r for r'."""
    return np.concatenate([r, r * w2])


def complex_acceleration_as_printed(*, r: Any, w2: Any, a2: Any, **_: Any) -> Any:
    """Document 002, line 56: r e^(i t) + (2 r w r a) e^(i(t + pi/2)) + w^2 e^(i(t + pi))."""
    return np.concatenate([r - w2**2, 2.0 * r * w2 * r * a2])


def cartesian_velocity_as_printed(*, r: Any, t2: Any, **_: Any) -> Any:
    """Document 002, line 70: r r + theta x r."""
    return np.concatenate([r * r, t2 * r])


def cartesian_acceleration_as_printed(*, r: Any, t2: Any, **_: Any) -> Any:
    """Document 002, line 71: r r + theta x r + theta x theta x r + 2 (theta x r r)."""
    return np.concatenate([r * r - t2**2 * r, t2 * r + 2.0 * t2 * r * r])


def loop_velocity(*, t2: Any, t3: Any, r2: Any, r3: Any, w2: Any, w3: Any, **_: Any) -> Any:
    """Document 002, line 113: r2 w2 (i e^(i t2)) + r3 w3 (i e^(i t3)), its real and imaginary parts."""
    vector = 1j * (r2 * w2 * np.exp(1j * t2) + r3 * w3 * np.exp(1j * t3))
    return np.concatenate([vector.real, vector.imag])


def loop_acceleration(*, t2: Any, t3: Any, r2: Any, r3: Any, w2: Any, w3: Any, a2: Any, a3: Any, **_: Any) -> Any:
    """Document 002, line 114: r2 (i a2 - w2^2) e^(i t2) + r3 (i a3 - w3^2) e^(i t3), its two parts."""
    vector = r2 * (1j * a2 - w2**2) * np.exp(1j * t2) + r3 * (1j * a3 - w3**2) * np.exp(1j * t3)
    return np.concatenate([vector.real, vector.imag])


def _on_the_slide(what: str) -> Any:
    """C moves along the real axis alone."""
    along = in_time(what)
    return lambda **k: np.concatenate([along(**k), 0.0 * k["t2"]])


def _vector(
    place: str, line: int, quantity: str, text: str, function: Any, order: int, mended: Any, change: str
) -> Any:
    return Published("002", place, line, quantity, text, function, rotating(order),
                     "the derivative by time of the vector", mended, change)  # fmt: skip


FORMULAS = (
    _vector("section 2.1", 55, "velocity of a vector", "r e^(i t) + r w e^(i(t + pi/2))",
            complex_velocity_as_printed, 1, rotating_velocity, "r' in place of the first r"),
    _vector("section 2.1", 56, "acceleration of a vector",
            "r e^(i t) + (2 r w r a) e^(i(t + pi/2)) + w^2 e^(i(t + pi))", complex_acceleration_as_printed, 2,
            rotating_acceleration, "r'' in place of the first r, (2 r' w + r a), and r w^2 in place of w^2"),
    _vector("section 2.2", 70, "velocity of a vector", "r r + theta x r", cartesian_velocity_as_printed, 1,
            rotating_velocity, "r' u + theta' x r, u the unit vector along r"),
    _vector("section 2.2", 71, "acceleration of a vector", "r r + theta x r + theta x theta x r + 2(theta x r r)",
            cartesian_acceleration_as_printed, 2, rotating_acceleration,
            "r'' u + theta'' x r + theta' x (theta' x r) + 2 (theta' x r' u)"),
    Published("002", "section 3.1", 113, "velocity of C", "r2 w2 (i e^(i t2)) + r3 w3 (i e^(i t3))", loop_velocity,
              _on_the_slide("slider velocity"), "the derivative by time of the loop"),
    Published("002", "section 3.1", 114, "acceleration of C",
              "r2 (i a2 - w2^2) e^(i t2) + r3 (i a3 - w3^2) e^(i t3)", loop_acceleration,
              _on_the_slide("slider acceleration"), "the second derivative by time of the loop"),
)  # fmt: skip
