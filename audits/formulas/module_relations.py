"""Relations of document 001 between lengths, speeds and accelerations, each against motion that is differentiated."""

from __future__ import annotations

from typing import Any

import numpy as np

from audits.formulas.published import Formula, Published
from conrod.exact.jet import Jet, sine_cosine

# The argument names are the document's letters.
# ruff: noqa: N803


def arguments() -> dict[str, Any]:
    """Lengths, speeds and angular accelerations: arrays (40,)."""
    s = np.linspace(0.1, 6.2, 40)
    return {
        "w": 3.0 + s,
        "alpha": 5.0 * np.cos(s),
        "R": 0.5 + 0.2 * np.cos(s),
        "r": 0.1 + 0.05 * np.sin(3.0 * s),
        "o12": 0.2 + 0.1 * np.sin(s),
        "o14": 0.4 + 0.1 * np.cos(2.0 * s),
        "va": np.concatenate([np.sin(s), 2.0 + np.cos(s)]),
        "vb": np.concatenate([1.0 + s, np.cos(5.0 * s)]),
    }


def turning(order: int, part: str, arm: str = "R", at: str = "w") -> Formula:
    """Derivative of the place of a point on an arm that turns at a speed, with angular acceleration alpha.

    Args:
        order: 1 velocity, 2 acceleration.
        part: "along" the arm towards its end, "across" it, or "size".
        arm, at: names of the arm's length and of its speed.
    """

    def motion(*, alpha: Any, **k: Any) -> Any:
        sine, cosine = sine_cosine(Jet((0.0 * k[at], k[at], 0.5 * alpha)))
        along, across = (order * k[arm] * wave.coefficients[order] for wave in (cosine, sine))
        return {"along": along, "across": across, "size": np.hypot(along, across)}[part]

    return motion


def _rolling(side: int) -> Formula:
    """Size of the acceleration of a roller's centre, constant speed, on a round track: convex 1, concave -1."""
    return lambda w, R, r, **_: turning(2, "size", "reach", "pace")(
        alpha=0.0 * w, reach=R + side * r, pace=w * r / (R + side * r)
    )


def _across_way(*, w: Any, R: Any, **_: Any) -> Any:
    """Way across a line that turns at w, of a block that slides along it at R; the coefficient of the time squared."""
    sine, _cosine = sine_cosine(Jet((0.0 * w, w, 0.0 * w)))
    return (Jet((0.0 * w, R, 0.0 * w)) * sine).coefficients[2]


def _formula(
    place: str, line: int, quantity: str, text: str, function: Formula | None, truth: Formula, **more: Any
) -> Published:
    return Published("001", place, line, quantity, text, function, truth, more.pop("against", "motion, differentiated"),
                     **more)  # fmt: skip


def _relative(place: str, line: int, text: str) -> Published:
    """An equation of relative velocity with V_A or V_B on both sides: it leaves nothing for V_B/A."""
    return _formula(place, line, "V_B/A", text, lambda va, **_: va - va, lambda va, vb, **_: vb - va,
                    against="the velocity of B less that of A", mended=lambda va, vb, **_: -va + vb,
                    change="V_B = V_A + V_B/A")  # fmt: skip


def _centre_ratio(place: str, line: int, text: str, link: int) -> Published:
    """(4.4) and (4.5): a point that two links share has one velocity in both."""
    change = f"(O14O{link}4/O1{link}O{link}4) omega 4 = omega {link}"
    return _formula(place, line, f"omega {link}", text, None,
                    lambda w, o12, o14, **k: turning(1, "across", "o14")(alpha=0.0 * w, w=w, o14=o14) / o12,
                    against=f"one velocity of O{link}4 in both links", mended=lambda w, o12, o14, **_: w * o14 / o12,
                    change=change, hindrance=f"cannot be evaluated: O{link} and O4 alone are no distances")  # fmt: skip


FORMULAS = (
    _formula("(2.7)", 279, "velocity", "R x omega", lambda w, R, **_: R * w, turning(1, "size")),
    _formula("(2.9)", 297, "V_A/V_B", "R_A/R_B", lambda R, r, **_: R / r,
             lambda **k: turning(1, "size")(**k) / turning(1, "size", "r")(**k)),
    _formula("(2.18)", 359, "tangential acceleration", "R alpha", lambda R, alpha, **_: R * alpha,
             turning(2, "across")),
    _formula("section 2.4", 375, "acceleration", "sqrt((A^n)^2 + (A^t)^2)",
             lambda R, w, alpha, **_: np.sqrt((w**2 * R) ** 2 + (R * alpha) ** 2), turning(2, "size")),
    _formula("(4.1)", 597, "V_O23", "omega 2 x O12O23", lambda w, o12, **_: w * o12, turning(1, "size", "o12")),
    _centre_ratio("(4.4)", 621, "(O2/O4) omega 4 = omega 2", 2),
    _centre_ratio("(4.5)", 633, "(O3/O4) omega 4 = omega 3", 3),
    _formula("section 4.3", 648, "V_A", "omega 2 x O12O23", lambda w, o12, **_: w * o12, turning(1, "size", "o12")),
    _formula("section 4.3", 675, "omega 4", "V_B/O34O14",
             lambda o14, **k: turning(1, "size", "o14")(o14=o14, **k) / o14, lambda w, **_: w),
    _formula("section 4.3", 679, "V_C", "omega 3 x OC, O read as O13", lambda w, R, **_: w * R, turning(1, "size")),
    _formula("section 4.3", 698, "omega 4", "V_O24/O24O14",
             lambda o14, **k: turning(1, "size", "o14")(o14=o14, **k) / o14, lambda w, **_: w),
    _formula("section 4.3", 694, "V_O24", "omega 2 x O12O24", lambda w, o12, **_: w * o12, turning(1, "size", "o12")),
    _formula("(5.1)", 866, "omega of a link", "V_B/A / AB",
             lambda R, **k: turning(1, "size")(R=R, **k) / R, lambda w, **_: w),
    _relative("Example 5.6", 911, "V_A = V_A + V_B/A"),
    _formula("section 6.3", 965, "normal acceleration", "V^2/O2A = omega 2^2 x O2A", lambda w, R, **_: w**2 * R,
             lambda **k: -turning(2, "along")(**k)),
    _formula("section 6.3", 969, "tangential acceleration", "alpha 2 x O2A", lambda alpha, R, **_: alpha * R,
             turning(2, "across")),
    _formula("(6.4)", 1000, "normal acceleration of A", "V_A^2/O12A",
             lambda R, **k: turning(1, "size")(R=R, **k) ** 2 / R, lambda **k: -turning(2, "along")(**k)),
    _formula("section 6.3", 1031, "normal acceleration of B against A", "V_B/A^2/R",
             lambda R, **k: turning(1, "size")(R=R, **k) ** 2 / R, lambda **k: -turning(2, "along")(**k)),
    _formula("(6.5)", 1092, "way across, by dt^2", "V omega", lambda w, R, **_: R * w, _across_way,
             against="the second-order way across of sliding along a turning line"),
    _formula("section 6.7", 1124, "tangential acceleration of the roller's centre", "CD2 alpha 2",
             lambda alpha, r, **_: r * alpha,
             lambda w, alpha, R, r, **_: turning(2, "across", "reach", "pace")(
                 alpha=alpha * r / (R + r), reach=R + r, pace=w * r / (R + r))),
    _formula("section 6.7", 1126, "normal acceleration of D2 against C", "CD2 omega 2^2", lambda w, r, **_: r * w**2,
             lambda **k: -turning(2, "along", "r")(**k)),
    _formula("section 6.7", 1128, "tangential acceleration of D2 against C", "CD2 alpha 2",
             lambda alpha, r, **_: r * alpha, turning(2, "across", "r")),
    _formula("section 6.7", 1134, "acceleration of the contact point, convex", "CD2 omega 2^2 - (omega 2 r)^2/(R+r)",
             lambda w, R, r, **_: r * w**2 - (w * r) ** 2 / (R + r), lambda w, R, r, **_: w**2 * r * R / (R + r),
             against="line 1138"),
    _formula("section 6.7", 1155, "acceleration of the contact point, concave", "CD2 omega 2^2 + (omega 2 r)^2/(R-r)",
             lambda w, R, r, **_: r * w**2 + (w * r) ** 2 / (R - r), lambda w, R, r, **_: w**2 * r * R / (R - r),
             against="line 1159"),
    _formula("section 6.7", 1173, "acceleration of the contact point, flat", "CD2 omega 2^2",
             lambda w, r, **_: r * w**2, lambda **k: -turning(2, "along", "r")(**k)),
    _formula("section 6.7", 1122, "normal acceleration of the roller's centre, convex", "(omega 2 r)^2/(R+r)",
             lambda w, R, r, **_: (w * r) ** 2 / (R + r), _rolling(1)),
    _formula("section 6.7", 1136, "acceleration of the contact point, convex", "omega 2^2 r (1 - r/(R+r))",
             lambda w, R, r, **_: w**2 * r * (1.0 - r / (R + r)), lambda w, R, r, **_: w**2 * r * R / (R + r),
             against="line 1138"),
    _formula("section 6.7", 1147, "normal acceleration of the roller's centre, concave", "(omega 2 r)^2/(R-r)",
             lambda w, R, r, **_: (w * r) ** 2 / (R - r), _rolling(-1)),
    _formula("section 6.7", 1157, "acceleration of the contact point, concave", "omega 2^2 r (1 + r/(R-r))",
             lambda w, R, r, **_: w**2 * r * (1.0 + r / (R - r)), lambda w, R, r, **_: w**2 * r * R / (R - r),
             against="line 1159"),
    _relative("(6.7)", 1197, "V_B = V_B + V_B/A"),
)  # fmt: skip
