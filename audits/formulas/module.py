"""Formulas of document 001: instant centres, normal and Coriolis acceleration, rolling contact.

Speeds v in m/s, w (omega) in rad/s, radii R (track) and r (roller) in m.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from audits.formulas.published import Formula, Published
from conrod.exact.jet import Jet, sine_cosine

# The argument names are the document's letters.
# ruff: noqa: N803


def eq_1_2(*, n: Any, j: Any, h: Any, **_: Any) -> Any:
    """Document 001, (1.2): x = 3(n-1) - 2j - h."""
    return 3 * (n - 1) - 2 * j - h


def eq_2_8(*, rpm: Any, **_: Any) -> Any:
    """Document 001, (2.8): w = 2 pi/60 n."""
    return 2.0 * np.pi / 60.0 * rpm


def eq_2_21(*, v: Any, r: Any, **_: Any) -> Any:
    """Document 001, line 371, (2.21): A^n = V^2/R."""
    return v**2 / r


def eq_3_1(*, n: Any, **_: Any) -> Any:
    """Document 001, (3.1): N = n(n-1)/2."""
    return n * (n - 1) / 2


def eq_4_3_as_printed(*, w: Any, o12: Any, **_: Any) -> Any:
    """Document 001, (4.3), as printed: (O12O23/O12O23) w3 = w2."""
    return w * o12 / o12


def eq_4_3(*, w: Any, o12: Any, o13: Any, **_: Any) -> Any:
    """The same mended: w3 = w2 O12O23/O13O23."""
    return w * o12 / o13


def eq_4_2_as_printed(*, w3: Any, o12: Any, **_: Any) -> Any:
    """Document 001, (4.2): V_O23 = w3 O12O23."""
    return w3 * o12


def eq_4_2(*, w3: Any, o13: Any, **_: Any) -> Any:
    """The same mended: V_O23 = w3 O13O23."""
    return w3 * o13


def turn_of_3_as_printed(*, v: Any, o12_o13: Any, **_: Any) -> Any:
    """Document 001, line 666: w (printed with the index 2) = V_A/O12O13."""
    return v / o12_o13


def turn_of_3(*, v: Any, o13: Any, **_: Any) -> Any:
    """The same mended, as Example 4.10 has it (line 744): w3 = V_A/O13O23."""
    return v / o13


def speed_of_34_as_printed(*, w3: Any, o12_o34: Any, **_: Any) -> Any:
    """Document 001, line 670: V_B = w3 O12O34."""
    return w3 * o12_o34


def speed_of_34(*, w3: Any, o13_o34: Any, **_: Any) -> Any:
    """The same mended, as Example 4.10 has it (line 754): V_B = w3 O13O34."""
    return w3 * o13_o34


def arm_of_b_as_printed(*, w: Any, o24: Any, **_: Any) -> Any:
    """Document 001, line 702: V_B = w4 O24O14."""
    return w * o24


def arm_of_b(*, w: Any, o34: Any, **_: Any) -> Any:
    """The same mended: V_B = w4 O34O14."""
    return w * o34


def speed_of_pin_as_printed(*, w: Any, r: Any, **_: Any) -> Any:
    """Document 001, line 907: V_A = w^2 O12A."""
    return w**2 * r


def speed_of_pin(*, w: Any, r: Any, **_: Any) -> Any:
    """Document 001, (2.7), and line 907 mended: V_A = w O12A."""
    return w * r


def normal_as_printed(*, v: Any, r: Any, **_: Any) -> Any:
    """Document 001, line 1282: A_A = V_A^2/O12A^2."""
    return v**2 / r**2


def coriolis(*, v: Any, w: Any, **_: Any) -> Any:
    """Document 001, line 1106: A^c = 2 V w."""
    return 2.0 * v * w


def rolling_convex(*, w: Any, R: Any, r: Any, **_: Any) -> Any:
    """Document 001, line 1138: A = w^2 r R/(R+r)."""
    return w**2 * r * R / (R + r)


def rolling_concave(*, w: Any, R: Any, r: Any, **_: Any) -> Any:
    """Document 001, line 1159: A = w^2 r R/(R-r)."""
    return w**2 * r * R / (R - r)


def rolling_flat(*, w: Any, r: Any, **_: Any) -> Any:
    """Document 001, line 1175: A = r w^2."""
    return r * w**2


def _second(function: Any) -> Formula:
    """Size of the acceleration at time 0 of a place (x, y) given as jets of the time."""

    def acceleration(**k: Any) -> Any:
        time = Jet((0.0 * k["w"], 1.0, 0.0))
        return np.hypot(*(2.0 * part.coefficients[2] for part in function(time, **k)))

    return acceleration


def _contact(turns: Any, reach: Any, side: int) -> Formula:
    """The roller's point that touches the track at time 0: its centre circles at `reach`, the roller turns at w."""

    def place(time: Jet, **k: Any) -> Any:
        (s, c), (s2, c2) = sine_cosine(time * turns(**k)), sine_cosine(time * k["w"])
        return reach(**k) * c + side * k["r"] * c2, reach(**k) * s + side * k["r"] * s2

    return _second(place)


def _flat_contact(time: Jet, **k: Any) -> Any:
    s, c = sine_cosine(time * k["w"])
    return time * (k["r"] * k["w"]) - k["r"] * s, k["r"] - k["r"] * c


def _circle(time: Jet, **k: Any) -> Any:
    s, c = sine_cosine(time * k["w"])
    return k["r"] * c, k["r"] * s


def _sliding(time: Jet, **k: Any) -> Any:
    s, c = sine_cosine(time * k["w"])
    along = time * k["v"] + 0.0
    return along * c, along * s


def _turning(arm: str) -> Formula:
    """Speed of a point on a link that turns at w3 about its instant centre, as the derivative of its place."""

    def speed(**k: Any) -> Any:
        time = Jet((0.0 * k[arm], 1.0, 0.0))
        s, c = sine_cosine(time * k["w3"])
        return np.hypot((k[arm] * c).coefficients[1], (k[arm] * s).coefficients[1])

    return speed


def arguments() -> dict[str, Any]:
    """Many speeds and radii: arrays (40,); counts of links as whole numbers."""
    s = np.linspace(0.1, 6.2, 40)
    radii = {"R": 0.5 + 0.2 * np.cos(s), "r": 0.1 + 0.05 * np.sin(3.0 * s)}
    arms = {"o12": 0.2 + 0.1 * np.sin(s), "o13": 0.5 + 0.1 * np.cos(2.0 * s), "o24": 0.4 + 0.1 * np.sin(5.0 * s)}
    arms |= {"o12_o13": 0.7 + 0.1 * np.cos(s), "o12_o34": 0.6 + 0.1 * np.sin(s), "o13_o34": 0.3 + 0.1 * np.cos(3.0 * s)}
    counts = {"n": np.arange(4, 44), "j": np.arange(4, 44) + 1, "h": np.arange(40) % 3}
    return {
        "w": 3.0 + s,
        "w3": 2.0 + s,
        "v": 1.0 + s,
        "rpm": 100.0 * s,
        "o34": 0.3 + 0.1 * np.cos(7.0 * s),
        **radii,
        **arms,
        **counts,
    }


def _formula(
    place: str, line: int, quantity: str, text: str, function: Formula, truth: Formula, against: str, **more: Any
) -> Published:
    return Published("001", place, line, quantity, text, function, truth, against, **more)


FORMULAS = (
    _formula("(1.2)", 169, "degrees of freedom", "3(n-1) - 2j - h", eq_1_2,
             lambda n, j, h, **_: 3 * n - 3 - (j * 2 + h), "three a moving link, less what the pairs take"),
    _formula("(2.8)", 283, "omega", "2 pi/60 n", eq_2_8, lambda rpm, **_: math.tau * rpm / 60.0,
             "a turn in rad, a minute"),
    _formula("(2.21)", 371, "normal acceleration", "V^2/R", eq_2_21,
             lambda v, r, **_: _second(_circle)(w=v / r, r=r), "the second derivative of motion on a circle"),
    _formula("(3.1)", 488, "number of instant centres", "n(n-1)/2", eq_3_1,
             lambda n, **_: np.array([math.comb(int(k), 2) for k in n]), "pairs of n links, counted"),
    _formula("(4.3)", 605, "omega 3", "(O12O23/O12O23) omega 3 = omega 2", eq_4_3_as_printed,
             lambda w, o12, o13, **_: (w * o12) / o13, "one velocity of O23 in both links", mended=eq_4_3,
             change="omega 3 = omega 2 O12O23/O13O23"),
    _formula("(4.2)", 601, "V_O23", "omega 3 x O12O23", eq_4_2_as_printed, _turning("o13"), "link 3 turning about O13",
             mended=eq_4_2, change="O13O23 in place of O12O23"),
    _formula("section 4.3", 666, "omega 3", "V_A/O12O13 (printed omega 2)", turn_of_3_as_printed,
             lambda v, o13, **_: v / _turning("o13")(w3=1.0, o13=o13), "link 3 turning about O13", mended=turn_of_3,
             change="omega 3 = V_A/O13O23"),
    _formula("section 4.3", 670, "V_B", "omega 3 x O12O34", speed_of_34_as_printed, _turning("o13_o34"),
             "link 3 turning about O13", mended=speed_of_34, change="O13O34 in place of O12O34"),
    _formula("section 4.3", 702, "V_B", "omega 4 x O24O14", arm_of_b_as_printed, lambda w, o34, **_: w * o34,
             "link 4 turning about O14, B being O34", mended=arm_of_b, change="O34O14 in place of O24O14"),
    _formula("Example 5.6", 907, "V_A", "omega^2 x O12A", speed_of_pin_as_printed, lambda w, r, **_: w * r,
             "(2.7)", mended=speed_of_pin, change="omega in place of omega^2"),
    _formula("Example 6.15", 1282, "A_A", "V_A^2/O12A^2", normal_as_printed, eq_2_21, "(2.21)", mended=eq_2_21,
             change="O12A in place of O12A^2"),
    _formula("section 6.6", 1106, "Coriolis acceleration", "2 V omega", coriolis, _second(_sliding),
             "the second derivative of sliding along a turning line, at its centre"),
    _formula("Figure 6.12", 1138, "acceleration of the contact point, convex", "omega^2 r R/(R+r)", rolling_convex,
             _contact(lambda w, R, r, **_: w * r / (R + r), lambda R, r, **_: R + r, -1), "rolling, differentiated"),
    _formula("Figure 6.13", 1159, "acceleration of the contact point, concave", "omega^2 r R/(R-r)", rolling_concave,
             _contact(lambda w, R, r, **_: -w * r / (R - r), lambda R, r, **_: R - r, 1), "rolling, differentiated"),
    _formula("Figure 6.14", 1175, "acceleration of the contact point, flat", "r omega^2", rolling_flat,
             _second(_flat_contact), "rolling, differentiated"),
)  # fmt: skip
