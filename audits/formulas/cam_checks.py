"""The formulas of document 004 as formulas: each against the derivative of its function or the cam's geometry."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from audits.formulas import cam
from audits.formulas.published import Formula, Published, derivative
from conrod.models.printed.verdicts import VerdictKind


def arguments() -> dict[str, Any]:
    """Cams of many proportions at many angles: arrays (60,) to compare formulas on."""
    s = np.linspace(0.1, 6.2, 60)
    return {
        # About the tip: far from it the roller does not reach the nose.
        "t": np.linspace(np.pi - 0.35, np.pi + 0.35, 60),
        "b": 1.0 + 0.3 * np.sin(3.0 * s),
        "R": 0.05 + 0.01 * np.cos(5.0 * s),
        "rho": 0.11 + 0.02 * np.sin(7.0 * s),
        "R1": 0.029 + 0.004 * np.cos(11.0 * s),
        "C": 0.08 + 0.01 * np.sin(13.0 * s),
        "r": 0.009 + 0.001 * np.cos(2.0 * s),
        "w": 1.0 + s,
        "h": 0.03 + 0.01 * np.sin(s),
        "phi": s,
        "n": np.arange(2, 62),
        "f1": np.arange(60) % 7,
        "f2": np.arange(60) % 3,
    }


def in_time(formula: Formula) -> Formula:
    """The derivative by time at constant speed w."""
    slope = derivative(formula, "t")
    return lambda **k: k["w"] * slope(**k)


def exact_lift(distance: Callable[..., Any], arc: str, lag: int) -> Formula:
    """The lift on one arc: its centre lies at a distance d from the shaft, the roller's at arc + r from that.

    h = -d cos(t + lag b) + sqrt((arc + r)^2 - d^2 sin^2(t + lag b)) - (R + r); `keep` scales the radical's term.
    """

    def lift(keep: Any = 1.0, **k: Any) -> Any:
        d, reach, turn = distance(**k), k[arc] + k["r"], k["t"] + lag * k["b"]
        return -d * np.cos(turn) + reach * np.sqrt(1.0 - keep * (d * np.sin(turn) / reach) ** 2) - (k["R"] + k["r"])

    return lift


def first_terms(lift: Formula) -> Formula:
    """The lift with its root cut after the first term: the series in `keep` up to order 1, at keep = 1."""
    slope = derivative(lift, "keep")
    return lambda **k: lift(keep=0.0, **k) + slope(keep=0.0, **k)


def _flank(**k: Any) -> Any:
    return k["rho"] - k["R"]


def _nose(**k: Any) -> Any:
    return k["C"]


RISE, FALL = exact_lift(_flank, "rho", -1), exact_lift(_flank, "rho", 1)
TIP = exact_lift(_nose, "R1", 0)


def _pressure_angle(**k: Any) -> Any:
    """Between the follower's axis and the line of centres of flank and roller: sin = (rho-R) sin(t-b)/(rho+r)."""
    return np.arcsin(_flank(**k) * np.sin(k["t"] - k["b"]) / (k["rho"] + k["r"]))


def _pressure_angle_from(axis: Callable[..., Any]) -> Formula:
    """Equation (6), tan = (ds/dt) / distance of the pitch curve from the shaft, with the exact lift as s."""
    slope = derivative(RISE, "t")
    return lambda **k: np.arctan(slope(**k) / (axis(**k) + RISE(**k)))


def _lift(number: int, line: int, text: str, function: Formula, exact: Formula) -> Published:
    """A lift formula: short of the geometry, and the same as the geometry with its root cut."""
    return Published(
        "004",
        f"({number})",
        line,
        "lift",
        text,
        function,
        exact,
        "the cam's geometry",
        mended=_completed(function, exact),
        change="the terms after the first of the root",
        kind=VerdictKind.EXPLAINED,
    )


def _completed(function: Formula, exact: Formula) -> Formula:
    """The formula plus what the cut of the root drops: it is the exact lift only if nothing else is missing."""
    short = first_terms(exact)
    return lambda **k: function(**k) + (exact(**k) - short(**k))


def _rate(number: int, line: int, quantity: str, text: str, function: Formula, of: Formula, name: str) -> Published:
    return Published(
        "004", f"({number})", line, quantity, text, function, in_time(of), f"the derivative of ({name}) by time"
    )


def _nose_rate(
    number: int, line: int, quantity: str, text: str, printed: Formula, mended: Formula, of: Formula, name: str
) -> Published:
    return Published(
        "004",
        f"({number})",
        line,
        quantity,
        text,
        printed,
        in_time(of),
        f"the derivative of ({name}) by time",
        mended,
        f"R1 + r in place of R1 - R, as in ({number + 1})",
    )


FORMULAS = (
    Published("004", "(1)", 36, "mobility", "3(n - 1) - 2 f1 - f2", lambda n, f1, f2, **_: 3 * (n - 1) - 2 * f1 - f2,
              lambda n, f1, f2, **_: 3 * n - 3 - (2 * f1 + f2), "three a moving link, less what the pairs take"),
    Published("004", "(2)", 76, "harmonic lift", "h/2 - h/2 cos phi = h/2 (1 - cos phi)", cam.eq_2,
              lambda h, phi, **_: h * np.sin(phi / 2.0) ** 2, "the projection of a turning radius h/2"),
    Published("004", "(3)", 86, "harmonic lift", "h/2 (1 - cos(pi t/b))", cam.eq_3,
              lambda **k: cam.eq_2(h=k["h"], phi=np.pi * k["t"] / k["b"]), "(2) with phi = pi t/b"),
    _rate(4, 90, "harmonic velocity", "pi h w/(2b) sin(pi t/b)", cam.eq_4, cam.eq_3, "3"),
    _rate(5, 94, "harmonic acceleration", "pi^2 h w^2/(2b^2) cos(pi t/b)", cam.eq_5, cam.eq_4, "4"),
    Published("004", "(6), (7)", 114, "pressure angle", "tan phi = ds/(r dtheta), r = R_b + s, R_b the base circle",
              _pressure_angle_from(lambda **k: k["R"]), _pressure_angle, "the line of centres of flank and roller",
              _pressure_angle_from(lambda **k: k["R"] + k["r"]),
              "R_b = base circle + roller radius, the pitch curve's least distance, as line 110 wants it"),
    _lift(8, 159, "(rho-R) - (rho-R)^2/(2(rho+r)) sin^2(t-b) - (rho-R) cos(t-b)", cam.eq_8, RISE),
    _lift(9, 163, "(R1-R) - C^2 sin^2 t/(2(R1+r)) - C cos t", cam.eq_9, TIP),
    _lift(10, 167, "(R1+r) - C^2 sin^2 t/(2(R1+r)) - C cos t - (R+r)", cam.eq_10, TIP),
    _lift(11, 171, "(rho-R) - (rho-R)^2/(2(rho+r)) sin^2(t+b) - (rho-R) cos(t+b)", cam.eq_11, FALL),
    _rate(12, 175, "velocity", "-(rho-R)^2 w/(2(rho+r)) sin 2(t-b) + (rho-R) w sin(t-b)", cam.eq_12, cam.eq_8, "8"),
    _nose_rate(13, 179, "velocity", "-C^2 w sin 2t/(2(R1-R)) + C w sin t", cam.eq_13_as_printed, cam.eq_14, cam.eq_9,
               "9"),
    _rate(14, 183, "velocity", "-C^2 w sin 2t/(2(R1+r)) + C w sin t", cam.eq_14, cam.eq_10, "10"),
    _rate(15, 187, "velocity", "-(rho-R)^2 w sin 2(t+b)/(2(rho+r)) + (rho-R) w sin(t+b)", cam.eq_15, cam.eq_11, "11"),
    _rate(16, 191, "acceleration", "-(rho-R)^2 w^2/(rho+r) cos 2(t-b) + (rho-R) w^2 cos(t-b)", cam.eq_16, cam.eq_12,
          "12"),
    _nose_rate(17, 195, "acceleration", "-C^2 w^2 cos 2t/(R1-R) + C w^2 cos t", cam.eq_17_as_printed, cam.eq_18,
               cam.eq_14, "13 mended"),
    _rate(18, 199, "acceleration", "-C^2 w^2 cos 2t/(R1+r) + C w^2 cos t", cam.eq_18, cam.eq_14, "14"),
    _rate(19, 203, "acceleration", "-(rho-R)^2 w^2 cos 2(t+b)/(rho+r) + (rho-R) w^2 cos(t+b)", cam.eq_19, cam.eq_15,
          "15"),
    _rate(20, 207, "jerk", "2(rho-R)^2 w^3 sin 2(t-b)/(rho+r) - (rho-R) w^3 sin(t-b)", cam.eq_20, cam.eq_16, "16"),
    _nose_rate(21, 211, "jerk", "2C^2 w^3 sin 2t/(R1-R) - C w^3 sin t", cam.eq_21_as_printed, cam.eq_22, cam.eq_18,
               "17 mended"),
    _rate(22, 215, "jerk", "2C^2 w^3 sin 2t/(R1+r) - C w^3 sin t", cam.eq_22, cam.eq_18, "18"),
    _rate(23, 219, "jerk", "2(rho-R)^2 w^3 sin 2(t+b)/(rho+r) - (rho-R) w^3 sin(t+b)", cam.eq_23, cam.eq_19, "19"),
)  # fmt: skip
