"""The MATLAB listing of document 002 (lines 136 to 197), line by line, with MATLAB's own operators.

Between two rows of one length MATLAB's `/` is no division element by element (that is `./`): a/b is the one number x
that solves x b = a in the sense of least squares, x = a b'/(b b'). Lengths in mm, as in the listing.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from audits.formulas.published import Formula, Published
from conrod.exact.motion import Array
from conrod.models.printed.verdicts import VerdictKind
from conrod.scenes import RPM, Saw

R1, R2, R3, R5 = 180.0, 100.0, 300.0, 90.0  # [mm], lines 138 to 141
S0 = 186.1818  # [mm], line 142
Division: TypeAlias = Callable[[Any, Any], Any]


def matrix_right_division(a: Any, b: Any) -> Any:
    """MATLAB's a/b of two rows: the x of least squares in x b = a."""
    return np.vdot(b, a) / np.vdot(b, b)


def elementwise_division(a: Any, b: Any) -> Any:
    """MATLAB's a./b."""
    return a / b


def theta3b(t2: Array) -> Array:
    """Document 002, lines 151-152: asin((r1-r5-r2.*sin(theta2))./(r3)), and pi minus that."""
    return np.asarray(np.pi - np.arcsin((R1 - R5 - R2 * np.sin(t2)) / R3))


def position(*, t2: Array, **_: Any) -> Array:
    """Document 002, line 155: posisiC=((r2*cos(theta2))+(r3*cos(theta3b)))+s0."""
    return R2 * np.cos(t2) + R3 * np.cos(theta3b(t2)) + S0


def pin_distance(*, t2: Array, **_: Any) -> Array:
    """Document 002, line 153: rp=r1^2+r2^2-2*r1*r2*sin(theta2), the square of a distance that nothing else uses."""
    return R1**2 + R2**2 - 2.0 * R1 * R2 * np.sin(t2)


def rod_speed(t2: Array, w2: float, divide: Division) -> Any:
    """Document 002, line 161: w3=-w2*((r2*cos(theta2))/(r3*cos(theta3b)))."""
    return -w2 * divide(R2 * np.cos(t2), R3 * np.cos(theta3b(t2)))


def velocity(t2: Array, w2: float, divide: Division) -> Array:
    """Document 002, lines 166-167: kecepatanC=-r2*w2*sin(theta2)-(r3*w3*sin(theta3b))."""
    return np.asarray(-R2 * w2 * np.sin(t2) - R3 * rod_speed(t2, w2, divide) * np.sin(theta3b(t2)))


def rod_acceleration(t2: Array, w2: float, divide: Division) -> Any:
    """Document 002, line 168: a3=(r2*w2^2*sin(theta2))/(r3*cos(theta3b))+w3^2*sin(theta3b)/(cos(theta3b)).

    With `./` in the lines before, w3 is a row, and `*` and `^` on it are errors in MATLAB too: they are `.*` and `.^`
    here and in the lines that follow.
    """
    t3, w3 = theta3b(t2), rod_speed(t2, w2, divide)
    return divide(R2 * w2**2 * np.sin(t2), R3 * np.cos(t3)) + divide(w3**2 * np.sin(t3), np.cos(t3))


def acceleration(t2: Array, w2: float, divide: Division) -> Array:
    """Document 002, lines 170-171: percepatanC=(-r2*w2^2*cos(theta2))-r3*((w3^2*cos(theta3b))+(a3*sin(theta3b)))."""
    t3, w3 = theta3b(t2), rod_speed(t2, w2, divide)
    return np.asarray(
        -R2 * w2**2 * np.cos(t2) - R3 * (w3**2 * np.cos(t3) + rod_acceleration(t2, w2, divide) * np.sin(t3))
    )


def arguments() -> dict[str, Any]:
    """The listing's own angles, theta2=(0:1:360)*pi/180, and the document's speed."""
    return {"t2": np.arange(361.0) * np.pi / 180.0, "rpm": 40.0}


def _run(function: Callable[[Array, float, Division], Array], divide: Division, per_rpm: float = RPM) -> Formula:
    return lambda t2, rpm: function(t2, rpm * per_rpm, divide)


def _exact(row: str) -> Formula:
    def motion(*, t2: Array, rpm: float) -> Array:
        return np.asarray(getattr(Saw().motion(t2, rpm * RPM).point("C"), row)[:, 0] / 1e-3)

    return motion


def _rod_angle(t2: Array, rpm: float) -> Array:
    """Angle [rad] of the rod from the crank pin to C in the exact motion, in the listing's frame, from 0 to a turn."""
    along = _exact("position")(t2=t2, rpm=rpm) - (np.sqrt(R3**2 - (R1 - R5) ** 2) - R2) - R2 * np.cos(t2)
    return np.asarray(np.mod(np.arctan2(R1 - R5 - R2 * np.sin(t2), along), 2.0 * np.pi))


def _rod(order: int) -> Formula:
    """The rod's angular velocity (1) or acceleration (2), from the velocities of its pins in the exact motion."""

    def motion(*, t2: Array, rpm: float) -> Array:
        w2, t3 = rpm * RPM, theta3b(t2)
        # The end C stays on its line: r3 t3' cos t3 = -(velocity of the crank pin across the line).
        speed = -R2 * w2 * np.cos(t2) / (R3 * np.cos(t3))
        return speed if order == 1 else (R2 * w2**2 * np.sin(t2) + R3 * speed**2 * np.sin(t3)) / (R3 * np.cos(t3))

    return motion


def _operators(line: int, quantity: str, text: str, right: str, function: Any, truth: Formula) -> Published:
    """A line of the listing, and the same with the operators that go element by element wherever two rows meet."""
    return Published(
        "002",
        "MATLAB listing",
        line,
        quantity,
        text,
        _run(function, matrix_right_division),
        truth,
        "the exact motion",
        _run(function, elementwise_division),
        right,
        VerdictKind.WRONG_STEP,
    )


FORMULAS = (
    Published("002", "MATLAB listing", 153, "rp", "r1^2+r2^2-2*r1*r2*sin(theta2)", pin_distance,
              lambda t2, **_: np.hypot(R2 * np.cos(t2), R2 * np.sin(t2) - R1) ** 2,
              "the square of the crank pin's distance from the height r1"),
    Published("002", "MATLAB listing", 154, "theta_p", "theta_p=asin((r1-r2*sin(theta2);", None,
              lambda t2, **_: t2, "",
              hindrance="cannot be evaluated: its parentheses do not close, and MATLAB runs nothing of a script that "
              "it cannot read; no other line uses theta_p, so that the line may go"),
    Published("002", "MATLAB listing", 151, "theta3a", "asin((r1-r5-r2.*sin(theta2))./(r3))",
              lambda t2, **_: np.pi - theta3b(t2), lambda t2, rpm: np.pi - _rod_angle(t2, rpm),
              "pi less the rod's angle in the exact motion"),
    Published("002", "MATLAB listing", 152, "theta3b", "pi-theta3a", lambda t2, **_: theta3b(t2),
              _rod_angle, "the rod's angle in the exact motion"),
    Published("002", "MATLAB listing", 155, "posisiC, less s0", "(r2*cos(theta2))+(r3*cos(theta3b))",
              lambda t2, **_: position(t2=t2) - S0,
              lambda t2, rpm: _exact("position")(t2=t2, rpm=rpm) - (np.sqrt(R3**2 - (R1 - R5) ** 2) - R2),
              "the exact motion"),
    _operators(161, "w3", "-w2*((r2*cos(theta2))/(r3*cos(theta3b)))", "-w2*((r2*cos(theta2))./(r3*cos(theta3b)))",
               rod_speed, _rod(1)),
    _operators(167, "kecepatanC", "-r2*w2*sin(theta2)-(r3*w3*sin(theta3b))",
               "-r2*w2*sin(theta2)-(r3*w3.*sin(theta3b))", velocity, _exact("velocity")),
    _operators(168, "a3", "(r2*w2^2*sin(theta2))/(r3*cos(theta3b))+w3^2*sin(theta3b)/(cos(theta3b))",
               "(r2*w2^2*sin(theta2))./(r3*cos(theta3b))+w3.^2.*sin(theta3b)./(cos(theta3b))", rod_acceleration,
               _rod(2)),
    _operators(171, "percepatanC", "(-r2*w2^2*cos(theta2))-r3*((w3^2*cos(theta3b))+(a3*sin(theta3b)))",
               "(-r2*w2^2*cos(theta2))-r3*((w3.^2.*cos(theta3b))+(a3.*sin(theta3b)))", acceleration,
               _exact("acceleration")),
    Published("002", "MATLAB listing", 160, "w2", "w2=input('putaran input = '), which line 201 answers in rpm",
              _run(velocity, elementwise_division, 1.0), _exact("velocity"),
              "the exact velocity at that speed, if the number of rpm is typed in, where lines 161 to 171 want rad/s,",
              _run(velocity, elementwise_division), "w2=2*pi/60*input('putaran input = ')"),
)  # fmt: skip
