"""Formulas of document 002, section 3.1: the power hacksaw by complex numbers.

Lengths r2 (crank), r3 (rod), e = r1 - r5 (height of the slide) in m; t2, t3 (theta2, theta3) in rad; w2, w3 (omega) in
rad/s; a2, a3 (alpha) in rad/s^2. The loop: r2 sin t2 + r3 sin t3 = e.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from audits.formulas.published import Formula, Published
from conrod.exact.jet import Jet, sine_cosine, square_root


def rod_angle(*, t2: Any, r2: Any, r3: Any, e: Any, **_: Any) -> Any:
    """Document 002, listing, line 151-152: theta3b = pi - asin((r1 - r5 - r2 sin t2)/r3)."""
    return np.pi - np.arcsin((e - r2 * np.sin(t2)) / r3)


def slider(*, t2: Any, r2: Any, r3: Any, e: Any, **_: Any) -> Any:
    """Document 002, listing, line 155, less s0: r2 cos t2 + r3 cos theta3b."""
    return r2 * np.cos(t2) + r3 * np.cos(rod_angle(t2=t2, r2=r2, r3=r3, e=e))


def slider_velocity(*, t2: Any, t3: Any, r2: Any, r3: Any, w2: Any, w3: Any, **_: Any) -> Any:
    """Document 002, line 122: r_C' = -r2 w2 sin t2 - r3 w3 sin t3."""
    return -r2 * w2 * np.sin(t2) - r3 * w3 * np.sin(t3)


def rod_speed(*, t2: Any, t3: Any, r2: Any, r3: Any, w2: Any, **_: Any) -> Any:
    """Document 002, line 124: w3 = -w2 r2 cos t2/(r3 cos t3)."""
    return -w2 * r2 * np.cos(t2) / (r3 * np.cos(t3))


def slider_acceleration(*, t2: Any, t3: Any, r2: Any, r3: Any, w2: Any, w3: Any, a2: Any, a3: Any, **_: Any) -> Any:
    """Document 002, line 128: r_C'' = -r2(w2^2 cos t2 + a2 sin t2) - r3(w3^2 cos t3 + a3 sin t3)."""
    return -r2 * (w2**2 * np.cos(t2) + a2 * np.sin(t2)) - r3 * (w3**2 * np.cos(t3) + a3 * np.sin(t3))


def rod_acceleration_as_printed(*, t2: Any, t3: Any, r2: Any, r3: Any, w2: Any, w3: Any, a2: Any, **_: Any) -> Any:
    """Document 002, line 130: a3 = r2(w2^2 sin t2 + a2 cos t2)/(r3 cos t3) + w3^2 sin t3/cos t3."""
    return r2 * (w2**2 * np.sin(t2) + a2 * np.cos(t2)) / (r3 * np.cos(t3)) + w3**2 * np.sin(t3) / np.cos(t3)


def rod_acceleration(*, t2: Any, t3: Any, r2: Any, r3: Any, w2: Any, w3: Any, a2: Any, **_: Any) -> Any:
    """The same with - a2 cos t2, as the second derivative of the loop has it."""
    return rod_acceleration_as_printed(t2=t2, t3=t3, r2=r2, r3=r3, w2=w2, w3=w3, a2=-a2)


def rotating_velocity(*, r: Any, v: Any, w2: Any, **_: Any) -> Any:
    """First derivative of a vector r e^(i t), along it and across it: r' and r w."""
    return np.concatenate([v, r * w2])


def rotating_acceleration(*, r: Any, v: Any, a: Any, w2: Any, a2: Any, **_: Any) -> Any:
    """Second derivative of a vector r e^(i t), along it and across it: r'' - r w^2 and 2 r' w + r a."""
    return np.concatenate([a - r * w2**2, 2.0 * v * w2 + r * a2])


def in_time(what: str) -> Formula:
    """What the loop itself says, from its Taylor series in time: the truth for the formulas above.

    Args:
        what: "slider velocity", "slider acceleration", "rod speed" or "rod acceleration".
    """

    def motion(*, t2: Any, r2: Any, r3: Any, e: Any, w2: Any, a2: Any, **_: Any) -> Any:
        sine, cosine = sine_cosine(Jet((t2, w2, 0.5 * a2)))
        rod_sine = (e - r2 * sine) * (1.0 / r3)
        rod_cosine = -square_root(1.0 - rod_sine * rod_sine)
        v, half_a = (r2 * cosine + r3 * rod_cosine).coefficients[1:]
        # With s = sin t3 and c = cos t3: s' = c t3', and s'' = c' t3' + c t3''.
        (s1, half_s2), (c, c1) = rod_sine.coefficients[1:], rod_cosine.coefficients[:2]
        speed = s1 / c
        rates = {"slider velocity": v, "slider acceleration": 2.0 * half_a, "rod speed": speed}
        rates["rod acceleration"] = (2.0 * half_s2 - c1 * speed) / c
        return rates[what]

    return motion


def rotating(order: int) -> Formula:
    """Derivatives of r e^(i t), along the vector and across it, from Taylor series in time."""

    def rates(*, r: Any, v: Any, a: Any, w2: Any, a2: Any, **_: Any) -> Any:
        # Turned so that the vector lies along the real axis at the instant.
        sine, cosine = sine_cosine(Jet((0.0 * r, w2, 0.5 * a2)))
        length = Jet((r, v, 0.5 * a))
        return order * np.concatenate([(length * part).coefficients[order] for part in (cosine, sine)])

    return rates


def arguments() -> dict[str, Any]:
    """Saws of many proportions at many angles, sped up and slowed down: arrays (60,); t3, w3, a3 of the loop."""
    s = np.linspace(0.1, 6.2, 60)
    given = {
        "t2": s,
        "r2": 0.1 + 0.02 * np.sin(3.0 * s),
        "r3": 0.3 + 0.05 * np.cos(5.0 * s),
        "e": 0.09 + 0.02 * np.sin(7.0 * s),
        "w2": 4.0 + s,
        "a2": 10.0 * np.cos(2.0 * s),
        "r": 1.0 + s,
        "v": np.sin(s),
        "a": np.cos(3.0 * s),
    }
    rod = {"t3": rod_angle(**given), "w3": in_time("rod speed")(**given), "a3": in_time("rod acceleration")(**given)}
    return given | rod


def _formula(line: int, quantity: str, text: str, function: Formula, truth: Formula, **more: Any) -> Published:
    return Published("002", "section 3.1", line, quantity, text, function, truth,
                     "the derivative by time of the vectors", **more)  # fmt: skip


FORMULAS = (
    _formula(122, "velocity of C", "-r2 w2 sin t2 - r3 w3 sin t3", slider_velocity, in_time("slider velocity")),
    _formula(124, "w3", "-w2 r2 cos t2/(r3 cos t3)", rod_speed, in_time("rod speed")),
    _formula(128, "acceleration of C", "-r2(w2^2 cos t2 + a2 sin t2) - r3(w3^2 cos t3 + a3 sin t3)",
             slider_acceleration, in_time("slider acceleration")),
    _formula(130, "alpha3", "r2(w2^2 sin t2 + a2 cos t2)/(r3 cos t3) + w3^2 sin t3/cos t3",
             rod_acceleration_as_printed, in_time("rod acceleration"), mended=rod_acceleration,
             change="- a2 cos t2 (no difference at constant speed)"),
)  # fmt: skip
