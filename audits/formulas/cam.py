"""Formulas of document 004: simple harmonic motion, and the cam of circular arcs, equations (2) to (23).

Lengths in m: base R, flank rho, nose R1, centre distance C, roller r, harmonic lift h; t (theta), b (beta) in rad;
w (omega) in rad/s. The rising sectors count their angle t - b, the falling ones t + b.
"""

from __future__ import annotations

from typing import Any

import numpy as np

# The argument names are the document's letters.
# ruff: noqa: N803


def eq_2(*, h: Any, phi: Any, **_: Any) -> Any:
    """Document 004, (2): s = h/2 (1 - cos phi)."""
    return h / 2.0 * (1.0 - np.cos(phi))


def eq_3(*, h: Any, t: Any, b: Any, **_: Any) -> Any:
    """Document 004, (3): s = h/2 (1 - cos(pi t/b))."""
    return h / 2.0 * (1.0 - np.cos(np.pi * t / b))


def eq_4(*, h: Any, t: Any, b: Any, w: Any, **_: Any) -> Any:
    """Document 004, (4): v = pi h w/(2 b) sin(pi t/b)."""
    return np.pi * h * w / (2.0 * b) * np.sin(np.pi * t / b)


def eq_5(*, h: Any, t: Any, b: Any, w: Any, **_: Any) -> Any:
    """Document 004, (5): A = pi^2 h w^2/(2 b^2) cos(pi t/b)."""
    return np.pi**2 * h * w**2 / (2.0 * b**2) * np.cos(np.pi * t / b)


def eq_8(*, t: Any, b: Any, R: Any, rho: Any, r: Any, **_: Any) -> Any:
    """Document 004, (8), arc BC: h = (rho-R) - (rho-R)^2/(2(rho+r)) sin^2(t-b) - (rho-R) cos(t-b)."""
    d = rho - R
    return d - d**2 / (2.0 * (rho + r)) * np.sin(t - b) ** 2 - d * np.cos(t - b)


def eq_9(*, t: Any, R: Any, R1: Any, C: Any, r: Any, **_: Any) -> Any:
    """Document 004, (9), arc CD: h = (R1-R) - C^2 sin^2 t/(2(R1+r)) - C cos t."""
    return (R1 - R) - C**2 * np.sin(t) ** 2 / (2.0 * (R1 + r)) - C * np.cos(t)


def eq_10(*, t: Any, R: Any, R1: Any, C: Any, r: Any, **_: Any) -> Any:
    """Document 004, (10), arc DE: h = (R1+r) - C^2 sin^2 t/(2(R1+r)) - C cos t - (R+r)."""
    return (R1 + r) - C**2 * np.sin(t) ** 2 / (2.0 * (R1 + r)) - C * np.cos(t) - (R + r)


def eq_11(*, t: Any, b: Any, R: Any, rho: Any, r: Any, **_: Any) -> Any:
    """Document 004, (11), arc EF: (8) with t + b."""
    d = rho - R
    return d - d**2 / (2.0 * (rho + r)) * np.sin(t + b) ** 2 - d * np.cos(t + b)


def eq_12(*, t: Any, b: Any, R: Any, rho: Any, r: Any, w: Any, **_: Any) -> Any:
    """Document 004, (12), arc BC: V = -(rho-R)^2 w/(2(rho+r)) sin 2(t-b) + (rho-R) w sin(t-b)."""
    d = rho - R
    return -(d**2) * w / (2.0 * (rho + r)) * np.sin(2.0 * (t - b)) + d * w * np.sin(t - b)


def eq_13_as_printed(*, t: Any, R: Any, R1: Any, C: Any, w: Any, **_: Any) -> Any:
    """Document 004, (13), arc CD, as printed: V = -C^2 w sin 2t/(2(R1-R)) + C w sin t."""
    return -(C**2) * w * np.sin(2.0 * t) / (2.0 * (R1 - R)) + C * w * np.sin(t)


def eq_14(*, t: Any, R1: Any, C: Any, r: Any, w: Any, **_: Any) -> Any:
    """Document 004, (14), arc DE, and (13) mended: V = -C^2 w sin 2t/(2(R1+r)) + C w sin t."""
    return -(C**2) * w * np.sin(2.0 * t) / (2.0 * (R1 + r)) + C * w * np.sin(t)


def eq_15(*, t: Any, b: Any, R: Any, rho: Any, r: Any, w: Any, **_: Any) -> Any:
    """Document 004, (15), arc EF: (12) with t + b."""
    return eq_12(t=t, b=-b, R=R, rho=rho, r=r, w=w)


def eq_16(*, t: Any, b: Any, R: Any, rho: Any, r: Any, w: Any, **_: Any) -> Any:
    """Document 004, (16), arc BC: A = -(rho-R)^2 w^2/(rho+r) cos 2(t-b) + (rho-R) w^2 cos(t-b)."""
    d = rho - R
    return -(d**2) * w**2 / (rho + r) * np.cos(2.0 * (t - b)) + d * w**2 * np.cos(t - b)


def eq_17_as_printed(*, t: Any, R: Any, R1: Any, C: Any, w: Any, **_: Any) -> Any:
    """Document 004, (17), arc CD, as printed: A = -C^2 w^2 cos 2t/(R1-R) + C w^2 cos t."""
    return -(C**2) * w**2 * np.cos(2.0 * t) / (R1 - R) + C * w**2 * np.cos(t)


def eq_18(*, t: Any, R1: Any, C: Any, r: Any, w: Any, **_: Any) -> Any:
    """Document 004, (18), arc DE, and (17) mended: A = -C^2 w^2 cos 2t/(R1+r) + C w^2 cos t."""
    return -(C**2) * w**2 * np.cos(2.0 * t) / (R1 + r) + C * w**2 * np.cos(t)


def eq_19(*, t: Any, b: Any, R: Any, rho: Any, r: Any, w: Any, **_: Any) -> Any:
    """Document 004, (19), arc EF: (16) with t + b."""
    return eq_16(t=t, b=-b, R=R, rho=rho, r=r, w=w)


def eq_20(*, t: Any, b: Any, R: Any, rho: Any, r: Any, w: Any, **_: Any) -> Any:
    """Document 004, (20), arc BC: j = 2(rho-R)^2 w^3 sin 2(t-b)/(rho+r) - (rho-R) w^3 sin(t-b)."""
    d = rho - R
    return 2.0 * d**2 * w**3 * np.sin(2.0 * (t - b)) / (rho + r) - d * w**3 * np.sin(t - b)


def eq_21_as_printed(*, t: Any, R: Any, R1: Any, C: Any, w: Any, **_: Any) -> Any:
    """Document 004, (21), arc CD, as printed: j = 2C^2 w^3 sin 2t/(R1-R) - C w^3 sin t."""
    return 2.0 * C**2 * w**3 * np.sin(2.0 * t) / (R1 - R) - C * w**3 * np.sin(t)


def eq_22(*, t: Any, R1: Any, C: Any, r: Any, w: Any, **_: Any) -> Any:
    """Document 004, (22), arc DE, and (21) mended: j = 2C^2 w^3 sin 2t/(R1+r) - C w^3 sin t."""
    return 2.0 * C**2 * w**3 * np.sin(2.0 * t) / (R1 + r) - C * w**3 * np.sin(t)


def eq_23(*, t: Any, b: Any, R: Any, rho: Any, r: Any, w: Any, **_: Any) -> Any:
    """Document 004, (23), arc EF: (20) with t + b."""
    return eq_20(t=t, b=-b, R=R, rho=rho, r=r, w=w)


# Lift, velocity, acceleration and jerk of each arc, (13), (17) and (21) mended.
FLANK = (eq_8, eq_12, eq_16, eq_20)
NOSE = (eq_9, eq_14, eq_18, eq_22)
