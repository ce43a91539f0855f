"""Formulas of document 000, section IV.2: the shear press.

Lengths r (crank), a (rod) in m; t (theta) and p (phi, with r sin t = a sin p) in rad; w (omega) in rad/s.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from audits.formulas.published import Published, derivative


def root(*, t: Any, r: Any, a: Any, **_: Any) -> Any:
    """The document's (1/9 a^2 - 1/9 r^2 sin^2 t), called u there (line 75)."""
    return (a**2 - r**2 * np.sin(t) ** 2) / 9.0


def cosine_of_rod_angle(*, t: Any, r: Any, a: Any, **_: Any) -> Any:
    """Document 000, line 43: cos p = sqrt(1 - (r sin t / a)^2)."""
    return np.sqrt(1.0 - (r * np.sin(t) / a) ** 2)


def x_from_rod_as_printed(*, t: Any, a: Any, **_: Any) -> Any:
    """Document 000, line 53, first line: x_G = 2/3 a sin t (theta printed for phi)."""
    return 2.0 / 3.0 * a * np.sin(t)


def x_from_rod(*, t: Any, r: Any, a: Any, **_: Any) -> Any:
    """The same with phi: x_G = 2/3 a sin p."""
    return 2.0 / 3.0 * a * np.sin(np.arcsin(r * np.sin(t) / a))


def x(*, t: Any, r: Any, **_: Any) -> Any:
    """Document 000, line 53, last line: x_G = 2/3 r sin t."""
    return 2.0 / 3.0 * r * np.sin(t)


def x_rate_as_printed(*, t: Any, r: Any, w: Any, **_: Any) -> Any:
    """Document 000, line 57, first line: x_G' = 2/3 r theta' sin t."""
    return 2.0 / 3.0 * r * w * np.sin(t)


def x_rate_dotted(*, t: Any, r: Any, dw: Any, **_: Any) -> Any:
    """Document 000, line 57, second line: 2/3 w' r cos t, w' being printed for w (zero at constant speed)."""
    return 2.0 / 3.0 * dw * r * np.cos(t)


def x_acceleration_dotted(*, t: Any, r: Any, dw: Any, **_: Any) -> Any:
    """Document 000, line 61: -2/3 w'^2 r sin t, w' being printed for w."""
    return -2.0 / 3.0 * dw**2 * r * np.sin(t)


def x_rate(*, t: Any, r: Any, w: Any, **_: Any) -> Any:
    """The same with w: x_G' = 2/3 w r cos t."""
    return 2.0 / 3.0 * w * r * np.cos(t)


def x_acceleration(*, t: Any, r: Any, w: Any, **_: Any) -> Any:
    """The same with w: x_G'' = -2/3 w^2 r sin t."""
    return -2.0 / 3.0 * w**2 * r * np.sin(t)


def y_from_rod_as_printed(*, t: Any, r: Any, a: Any, **_: Any) -> Any:
    """Document 000, line 65, first line: y_G = r cos t + 1/3 a cos t (theta printed for phi)."""
    return r * np.cos(t) + a / 3.0 * np.cos(t)


def y_from_rod(*, t: Any, r: Any, a: Any, **_: Any) -> Any:
    """The same with phi: y_G = r cos t + 1/3 a cos p."""
    return r * np.cos(t) + a / 3.0 * cosine_of_rod_angle(t=t, r=r, a=a)


def y(*, t: Any, r: Any, a: Any, **_: Any) -> Any:
    """Document 000, line 65, last line: y_G = r cos t + 1/3 sqrt(a^2 - r^2 sin^2 t)."""
    return r * np.cos(t) + np.sqrt(a**2 - r**2 * np.sin(t) ** 2) / 3.0


def y_rate(*, t: Any, r: Any, a: Any, w: Any, **_: Any) -> Any:
    """Document 000, line 95: y_G' = w [-r sin t - 1/18 r^2 u^(-1/2) sin 2t]."""
    return w * (-r * np.sin(t) - r**2 / 18.0 * root(t=t, r=r, a=a) ** -0.5 * np.sin(2.0 * t))


def big_u(*, t: Any, r: Any, a: Any, **_: Any) -> Any:
    """Document 000, line 107: U = 1/18 r^2 u^(-1/2)."""
    return r**2 / 18.0 * root(t=t, r=r, a=a) ** -0.5


def big_u_rate(*, t: Any, r: Any, a: Any, w: Any, **_: Any) -> Any:
    """Document 000, line 123: U' = [1/162 r^4 u^(-3/2) 1/2 sin 2t] w."""
    return r**4 / 162.0 * root(t=t, r=r, a=a) ** -1.5 * 0.5 * np.sin(2.0 * t) * w


def big_u_rate_again_as_printed(*, t: Any, r: Any, a: Any, w: Any, **_: Any) -> Any:
    """Document 000, line 127: U' = [1/324 r^4 u^(-3/2) 1/2 sin 2t] w (the half is counted twice)."""
    return r**4 / 324.0 * root(t=t, r=r, a=a) ** -1.5 * 0.5 * np.sin(2.0 * t) * w


def y4_rate_as_printed(*, t: Any, r: Any, a: Any, w: Any, **_: Any) -> Any:
    """Document 000, lines 143-145: Y4' = w [1/324 r^4 u^(-3/2) sin 2t + 1/9 r^2 u^(-1/2) cos 2t]."""
    u = root(t=t, r=r, a=a)
    return w * (r**4 / 324.0 * u**-1.5 * np.sin(2.0 * t) + r**2 / 9.0 * u**-0.5 * np.cos(2.0 * t))


def y4_rate(*, t: Any, r: Any, a: Any, w: Any, **_: Any) -> Any:
    """The same with sin^2 2t, as line 149 has it."""
    u = root(t=t, r=r, a=a)
    return w * (r**4 / 324.0 * u**-1.5 * np.sin(2.0 * t) ** 2 + r**2 / 9.0 * u**-0.5 * np.cos(2.0 * t))


def y_acceleration(*, t: Any, r: Any, a: Any, w: Any, **_: Any) -> Any:
    """Document 000, line 149: w^2 [-r cos t - 1/324 r^4 sin^2 2t / u^(3/2) - 1/9 r^2 cos 2t / u^(1/2)]."""
    u = root(t=t, r=r, a=a)
    return w**2 * (
        -r * np.cos(t) - r**4 / 324.0 * np.sin(2.0 * t) ** 2 / u**1.5 - r**2 / 9.0 * np.cos(2.0 * t) / u**0.5
    )


def speed_as_printed(*, t: Any, r: Any, a: Any, **_: Any) -> Any:
    """Document 000, line 153: v_G = sqrt(x_G^2 + y_G^2) (the dots are missing)."""
    return np.sqrt(x(t=t, r=r) ** 2 + y(t=t, r=r, a=a) ** 2)


def speed(**k: Any) -> Any:
    """The same with dots: v_G = sqrt(x_G'^2 + y_G'^2)."""
    return np.sqrt(x_rate(**k) ** 2 + y_rate(**k) ** 2)


def acceleration(**k: Any) -> Any:
    """Document 000, line 157, dots mended: a_G = sqrt(x_G''^2 + y_G''^2)."""
    return np.sqrt(x_acceleration(**k) ** 2 + y_acceleration(**k) ** 2)


def _in_time(function: Any) -> Any:
    slope = derivative(function, "t")
    return lambda **k: k["w"] * slope(**k)


def _y4(**k: Any) -> Any:
    return big_u(**k) * np.sin(2.0 * k["t"])


def _hypot(first: Any, second: Any) -> Any:
    return lambda **k: np.hypot(_in_time(first)(**k), _in_time(second)(**k))


def arguments() -> dict[str, Any]:
    """Crank angles of a turn for machines of many proportions: arrays (60,) to compare formulas on."""
    turn = np.linspace(0.1, 6.2, 60)
    return {"t": turn, "r": 0.02 + 0.01 * np.sin(7.0 * turn), "a": 0.3 + 0.1 * np.cos(5.0 * turn), "w": 5.0 + turn,
            "dw": 0.0 * turn}  # fmt: skip


def _formula(line: int, quantity: str, text: str, function: Any, truth: Any, against: str, **more: Any) -> Published:
    return Published("000", "IV.2", line, quantity, text, function, truth, against, **more)


FORMULAS = (
    _formula(43, "cos phi", "sqrt(1 - (r sin t/a)^2)", cosine_of_rod_angle,
             lambda t, r, a, **_: np.cos(np.arcsin(r * np.sin(t) / a)), "cos(arcsin(r sin t/a))"),
    _formula(53, "x_G", "2/3 a sin theta", x_from_rod_as_printed, x, "2/3 r sin t, two lines on",
             mended=x_from_rod, change="phi in place of theta"),
    _formula(53, "x_G", "2/3 r sin theta", x, x_from_rod, "2/3 a sin phi"),
    _formula(57, "velocity x_G", "2/3 r theta' sin theta", x_rate_as_printed, _in_time(x), "the derivative of x_G",
             mended=x_rate, change="cos in place of sin"),
    _formula(57, "velocity x_G (printed x_G'')", "2/3 omega' r cos theta", x_rate_dotted, _in_time(x),
             "the derivative of x_G", mended=x_rate, change="x_G' with one dot, omega without"),
    _formula(61, "acceleration x_G", "-2/3 omega'^2 r sin theta", x_acceleration_dotted, _in_time(x_rate),
             "the second derivative of x_G", mended=x_acceleration, change="omega without a dot"),
    _formula(65, "y_G", "r cos theta + 1/3 a cos theta", y_from_rod_as_printed, y,
             "the form with the root, two lines on",
             mended=y_from_rod, change="phi in place of the second theta"),
    _formula(65, "y_G", "r cos theta + 1/3 sqrt(a^2 - r^2 sin^2 theta)", y, y_from_rod, "r cos t + 1/3 a cos phi"),
    _formula(95, "velocity y_G", "omega[-r sin t - 1/18 r^2 u^(-1/2) sin 2t]", y_rate, _in_time(y),
             "the derivative of y_G"),
    _formula(123, "U'", "[1/162 r^4 u^(-3/2) 1/2 sin 2t] omega", big_u_rate, _in_time(big_u), "the derivative of U"),
    _formula(127, "U'", "[1/324 r^4 u^(-3/2) 1/2 sin 2t] omega", big_u_rate_again_as_printed, _in_time(big_u),
             "the derivative of U", mended=big_u_rate, change="1/324 without the second half"),
    _formula(143, "Y4'", "omega[1/324 r^4 u^(-3/2) sin 2t + 1/9 r^2 u^(-1/2) cos 2t]", y4_rate_as_printed,
             _in_time(_y4), "the derivative of Y4", mended=y4_rate, change="sin^2 2t in place of sin 2t"),
    _formula(149, "acceleration y_G",
             "omega^2[-R cos t - 1/324 r^4 sin^2 2t/u^(3/2) - 1/9 r^2 cos 2t/u^(1/2)]", y_acceleration,
             _in_time(y_rate), "the second derivative of y_G"),
    _formula(153, "speed of G", "sqrt(x_G^2 + y_G^2)", speed_as_printed, _hypot(x, y), "the length of the velocity",
             mended=speed, change="dots over x_G and y_G"),
    _formula(157, "acceleration of G", "sqrt(x_G^2 + y_G^2)", speed_as_printed, _hypot(x_rate, y_rate),
             "the length of the acceleration", mended=acceleration, change="two dots over x_G and y_G"),
)  # fmt: skip
