"""The joint equation of a roller on a cam that is made from a motion law, as jets.

With H the way along the follower's line that belongs to the roller's distance from the shaft, and u the law's angle
that belongs to its direction, the roller's centre is on the pitch curve where H = H0 + s(u). That is a length along the
follower's line; times the cosine of the pressure angle it is the distance along the common normal, exact where it is
0, with its gradient of unit length there, and off by a part of (distance / radius of curvature) elsewhere.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from conrod.cam_law import LawProfile
from conrod.jet import Array, Jet, direction, reciprocal, square_root


def law_gap(profile: LawProfile, x: Jet, y: Jet, turn: Jet, segment: NDArray[np.intp]) -> Jet:
    """Distance [m] of roller and profile, positive outside.

    Args:
        x, y: the roller's centre from the cam's origin [m], in the document's directions.
        turn: of the cam [rad].
        segment: the one in force at each sample.
    """
    e, sense = profile.offset, profile.sense
    height = square_root(x * x + y * y - e * e)
    polar = direction(x, y) - turn
    if e != 0.0:
        polar = polar - direction(height, height * 0.0 + e)
    lift, slope = _law_jets(profile, (profile.begin - polar) * sense, segment)
    on_curve = lift + profile.least_height
    across = slope + sense * e
    cosine = on_curve * reciprocal(square_root(across * across + on_curve * on_curve))
    return (height - on_curve) * cosine


def law_normal(profile: LawProfile, x: Array, y: Array, segment: NDArray[np.intp]) -> tuple[Array, Array]:
    """Gradient of the distance by the roller's centre (x, y) [m], all in the cam's frame."""
    e, sense = profile.offset, profile.sense
    square = x * x + y * y
    reach, height = np.sqrt(square), np.sqrt(square - e * e)
    lift, slope, bend = profile.lift(profile.law_angle(x, y), 2, segment)
    on_curve, across = profile.least_height + lift, slope + sense * e
    rate = np.hypot(across, on_curve)
    cosine = on_curve / rate
    cosine_slope = slope / rate - on_curve * (across * bend + on_curve * slope) / rate**3
    # By the way outwards and by the way round (counter-clockwise): of H, and of the law's angle.
    height_out = reach / height
    angle_out, angle_round = -sense * e / (reach * height), -sense / reach
    by_angle = (height - on_curve) * cosine_slope - cosine * slope
    out, around = cosine * height_out + by_angle * angle_out, by_angle * angle_round
    return (x * out - y * around) / reach, (y * out + x * around) / reach


def _law_jets(profile: LawProfile, angle: Jet, segment: NDArray[np.intp]) -> tuple[Jet, Jet]:
    """Lift and its slope at a law angle."""
    order = len(angle.coefficients) - 1
    derivatives = profile.lift(np.asarray(angle.coefficients[0]), order + 1, segment)
    return _composed(derivatives[:-1], angle), _composed(derivatives[1:], angle)


def _composed(derivatives: list[Array], angle: Jet) -> Jet:
    """A function with these derivatives, at a jet."""
    departure = Jet((0.0, *angle.coefficients[1:]))
    terms = [derivative / math.factorial(k) for k, derivative in enumerate(derivatives)]
    total = Jet([terms[-1], *(0.0 for _ in terms[1:])])
    for term in reversed(terms[:-1]):
        total = total * departure + term
    return total
