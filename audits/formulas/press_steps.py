"""The steps of document 000's derivation, section IV.2: each against the derivative that it is meant to be.

Letters as in `press`; u = (a^2 - r^2 sin^2 t)/9, in the document also as a function of v = sin t.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from audits.formulas import press
from audits.formulas.published import Formula, Published, derivative


def in_time(formula: Formula) -> Formula:
    """The derivative by time at constant speed w."""
    slope = derivative(formula, "t")
    return lambda **k: k["w"] * slope(**k)


def root_of_sine(*, v: Any, r: Any, a: Any, **_: Any) -> Any:
    """Document 000, line 77: u = 1/9 a^2 - 1/9 r^2 v^2."""
    return a**2 / 9.0 - r**2 * v**2 / 9.0


def y2(**k: Any) -> Any:
    """Document 000, line 73: y2 = u^(1/2)."""
    return press.root(**k) ** 0.5


def y2_rate(*, t: Any, r: Any, w: Any, **k: Any) -> Any:
    """Document 000, line 89: y2' = [-1/9 r^2 u^(-1/2) 1/2 sin 2t] w."""
    return -(r**2) / 9.0 * press.root(t=t, r=r, **k) ** -0.5 * 0.5 * np.sin(2.0 * t) * w


def y4(**k: Any) -> Any:
    """Document 000, line 105: Y4 = 1/18 r^2 u^(-1/2) sin 2t."""
    return press.big_u(**k) * np.sin(2.0 * k["t"])


def y4_rate_as_products(*, t: Any, r: Any, w: Any, **k: Any) -> Any:
    """Document 000, lines 137-141: [1/324 r^4 u^(-3/2) 1/2 sin 2t] w sin 2t + 1/18 r^2 u^(-1/2) w (2 cos 2t)."""
    u = press.root(t=t, r=r, **k)
    first = r**4 / 324.0 * u**-1.5 * 0.5 * np.sin(2.0 * t) * w * np.sin(2.0 * t)
    return first + r**2 / 18.0 * u**-0.5 * w * 2.0 * np.cos(2.0 * t)


def arguments() -> dict[str, Any]:
    """Those of the other formulas, with v = sin t, and u as an argument of its own."""
    given = press.arguments()
    return given | {"v": np.sin(given["t"]), "u": press.root(**given)}


def _step(
    line: int, quantity: str, text: str, function: Formula, truth: Formula, against: str, **more: Any
) -> Published:
    return Published("000", "IV.2", line, quantity, text, function, truth, against, **more)


FORMULAS = (
    _step(35, "sin phi", "r sin t/a", lambda t, r, a, **_: r * np.sin(t) / a,
          lambda t, r, a, **_: np.sqrt(1.0 - press.cosine_of_rod_angle(t=t, r=r, a=a) ** 2) * np.sign(np.sin(t)),
          "the sine to the cosine of line 43"),
    _step(69, "y_G", "r cos t + sqrt(1/9 a^2 - 1/9 r^2 sin^2 t)",
          lambda t, r, **k: r * np.cos(t) + y2(t=t, r=r, **k), press.y, "y_G of line 65"),
    _step(73, "y1'", "-omega r sin t", lambda t, r, w, **_: -w * r * np.sin(t),
          in_time(lambda t, r, **_: r * np.cos(t)), "the derivative of y1 = r cos t"),
    _step(79, "dy2/du", "1/2 u^(-1/2)", lambda u, **_: 0.5 * u**-0.5, derivative(lambda u, **_: u**0.5, "u"),
          "the derivative of y2 = u^(1/2) by u"),
    _step(79, "du/dv", "-2/9 r^2 v", lambda v, r, **_: -2.0 / 9.0 * r**2 * v, derivative(root_of_sine, "v"),
          "the derivative of u by v"),
    _step(79, "dv/dtheta", "cos theta", lambda t, **_: np.cos(t), derivative(lambda t, **_: np.sin(t), "t"),
          "the derivative of v = sin t by t"),
    _step(83, "y2'", "1/2 u^(-1/2) (-2/9 r^2 v) cos theta omega",
          lambda t, u, v, r, w, **_: 0.5 * u**-0.5 * (-2.0 / 9.0 * r**2 * v) * np.cos(t) * w, in_time(y2),
          "the derivative of y2"),
    _step(85, "y2'", "[1/2 u^(-1/2) (-2/9 r^2)] sin theta cos theta omega",
          lambda t, r, w, **k: 0.5 * press.root(t=t, r=r, **k) ** -0.5 * (-2.0 / 9.0 * r**2)
          * np.sin(t) * np.cos(t) * w, in_time(y2), "the derivative of y2"),
    _step(89, "y2'", "[-1/9 r^2 u^(-1/2) 1/2 sin 2t] omega", y2_rate, in_time(y2), "the derivative of y2"),
    _step(93, "velocity y_G", "y1' + y2'", lambda t, r, w, **k: -w * r * np.sin(t) + y2_rate(t=t, r=r, w=w, **k),
          in_time(press.y), "the derivative of y_G"),
    _step(99, "Y_G", "Y_G = omega[-r sin t - 1/18 r^2 u^(-1/2) sin 2t]", press.y, press.y_rate,
          "what it is set equal to", mended=in_time(press.y), change="a dot over Y_G, as on line 95"),
    _step(103, "Y3'", "-omega(r cos t)", lambda t, r, w, **_: -w * r * np.cos(t),
          in_time(lambda t, r, **_: -r * np.sin(t)), "the derivative of Y3 = -r sin t"),
    _step(115, "dU/du", "-1/36 r^2 u^(-3/2)", lambda u, r, **_: -(r**2) / 36.0 * u**-1.5,
          derivative(lambda u, r, **_: r**2 / 18.0 * u**-0.5, "u"), "the derivative of U by u"),
    _step(119, "U'", "-1/36 r^2 u^(-3/2) (-2/9 r^2) sin t cos t omega",
          lambda t, r, w, **k: r**4 / 162.0 * press.root(t=t, r=r, **k) ** -1.5 * np.sin(t) * np.cos(t) * w,
          in_time(press.big_u), "the derivative of U"),
    _step(133, "V'", "omega(2 cos 2t)", lambda t, w, **_: w * 2.0 * np.cos(2.0 * t),
          in_time(lambda t, **_: np.sin(2.0 * t)), "the derivative of V = sin 2t"),
    _step(135, "Y4'", "U' V + U V'",
          lambda **k: in_time(press.big_u)(**k) * np.sin(2.0 * k["t"]) + press.big_u(**k) * k["w"] * 2.0
          * np.cos(2.0 * k["t"]), in_time(y4), "the derivative of Y4 = U V"),
    _step(137, "Y4'", "[1/324 r^4 u^(-3/2) 1/2 sin 2t] omega sin 2t + 1/18 r^2 u^(-1/2) omega(2 cos 2t)",
          y4_rate_as_products, in_time(y4), "the derivative of Y4", mended=press.y4_rate,
          change="1/324 without the half, which line 127 counts twice"),
    _step(147, "acceleration y_G", "(Y3' - Y4') omega",
          lambda w, **k: (in_time(lambda t, r, **_: -r * np.sin(t))(w=w, **k) - in_time(y4)(w=w, **k)) * w,
          in_time(press.y_rate), "the second derivative of y_G"),
)  # fmt: skip
