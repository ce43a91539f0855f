"""Least squares of an alignment, from the best of many crank angles round the turn.

The frame for each start is the closed solution of the orthogonal Procrustes problem (Schoenemann 1966; in the plane it
is the angle of a complex product), so that no guess is needed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.optimize import least_squares

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.tables.fit import TURNING, Fit
from conrod.own.tables.samples import Alignment

STARTS, START_ROWS, PURSUED = 72, 400, 4
PRECISION = 4.0 * float(np.finfo(float).eps)  # relative, of the sum of squares, of a step and of the slope
# Singular values below this share of the largest one are rounding: their direction cannot be determined.
DETERMINED = 1e-7
INVOLVED = 0.01  # of a unit vector: smaller components are none


@dataclass(frozen=True)
class Fitted:
    """A least-squares fit.

    Attributes:
        alignment: the best one.
        errors: standard error of what was fitted, SI, by name.
        undetermined: quantities left out because they cannot be determined, a sentence each.
        remaining: rms error that is left, divided by L; of the crank angle [rad] where that was fitted.
    """

    alignment: Alignment
    errors: Mapping[str, float]
    undetermined: tuple[str, ...]
    remaining: float


def fitted(problem: Fit, start: Alignment, asked: Sequence[str]) -> Fitted:
    """The alignment that leaves least, of what was asked for and can be determined; the rest stays as in `start`.

    Raises:
        InvalidInput: there are no more residuals than unknowns.
    """
    names, undetermined = list(asked), []
    count = len(problem.linearised(start)[0])
    if count <= len(names):
        raise InvalidInput(f"{count} numbers are too few to estimate {', '.join(names)} from")
    while True:
        best = _best(problem, start, names)
        residuals, slopes = problem.linearised(best, names)
        tied = _tied(slopes, names)
        if not tied:
            break
        undetermined.append(_undetermined(tied))
        names.remove(tied[-1])
    errors = _standard_errors(problem, names, residuals, slopes)
    remaining = math.sqrt(float(residuals @ residuals) / problem.vectors)
    return Fitted(best, errors, tuple(undetermined), remaining)


def _tied(slopes: Array, names: Sequence[str]) -> list[str]:
    """Quantities of which a combination changes nothing; empty where all can be determined."""
    if not names:
        return []
    _, singular, directions = np.linalg.svd(slopes, full_matrices=False)
    if singular[-1] > DETERMINED * max(singular[0], math.sqrt(len(slopes)) * DETERMINED):
        return []
    return [name for name, part in zip(names, directions[-1], strict=True) if abs(part) > INVOLVED]


def _undetermined(tied: Sequence[str]) -> str:
    last = tied[-1]
    if len(tied) == 1:
        return f"{last} cannot be determined: nothing in this table depends on it"
    if set(tied) == {"time", "phase"}:
        return f"time and phase cannot be separated at constant speed: {tied[0]} stands for both, {last} is kept at 0"
    return f"{' and '.join(tied)} cannot be separated in this table: {last} is kept at 0, the others stand for it"


def _standard_errors(problem: Fit, names: Sequence[str], residuals: Array, slopes: Array) -> dict[str, float]:
    """Of independent errors of one size: the square root of s^2 (J^T J)^-1, s^2 = r^T r / (N - p)."""
    if not names:
        return {}
    variance = float(residuals @ residuals) / (len(residuals) - len(names))
    _, singular, directions = np.linalg.svd(slopes, full_matrices=False)
    spread = np.sqrt(variance * np.sum((directions / singular[:, None]) ** 2, axis=0))
    return {name: float(size) * problem.scale(name) for name, size in zip(names, spread, strict=True)}


# -- the way there ---------------------------------------------------------------------------------------------------


def _best(problem: Fit, start: Alignment, names: Sequence[str]) -> Alignment:
    if not names:
        return start
    turning = next((name for name in names if name in TURNING), None)
    coarse = problem.thinned(START_ROWS)
    if problem.kind == "crank" or turning is None:
        starts = [_framed(coarse, start, names)]
    else:
        turns = np.arange(STARTS) * (2.0 * np.pi / STARTS)
        around = [_framed(coarse, coarse.moved(start, [turning], [t]), names) for t in turns]
        starts = _lowest(around, [_left(coarse, one) for one in around])
    pursued = [_descended(coarse, one, names) for one in starts]
    return _descended(problem, min(pursued, key=lambda one: _left(coarse, one)), names)


def _lowest(around: Sequence[Alignment], left: Sequence[float]) -> list[Alignment]:
    """The best starts of a ring, each lower than its neighbours."""
    count = len(around)
    minima = [k for k in range(count) if left[k] <= min(left[k - 1], left[(k + 1) % count])]
    return [around[k] for k in sorted(minima, key=lambda k: left[k])[:PURSUED]]


def _left(problem: Fit, alignment: Alignment) -> float:
    residuals, _ = problem.linearised(alignment)
    return float(residuals @ residuals)


def _descended(problem: Fit, alignment: Alignment, names: Sequence[str]) -> Alignment:
    """The nearest minimum, by Levenberg and Marquardt; what cannot be determined has no slope and is not moved."""

    @lru_cache(1)
    def linearised(*steps: float) -> tuple[Array, Array]:
        return problem.linearised(problem.moved(alignment, names, steps), names)

    found = least_squares(
        lambda steps: linearised(*steps)[0],
        np.zeros(len(names)),
        jac=lambda steps: -linearised(*steps)[1],
        method="lm",
        xtol=PRECISION,
        ftol=PRECISION,
        gtol=PRECISION,
    )
    return problem.moved(alignment, names, found.x)


def _framed(problem: Fit, alignment: Alignment, names: Sequence[str]) -> Alignment:
    """With the best frame at the crank angles as they are, as far as a frame is asked for."""
    if "x" not in names or not all(samples.whole for samples in problem.positions.values()):
        return alignment
    motion = problem.scene.motion(problem.angle(alignment), 1.0)
    exact = np.concatenate([_complex(motion.point(name).position) for name in problem.positions])
    found = np.concatenate(
        [_complex(samples.values[:, np.argsort(samples.axes)]) for samples in problem.positions.values()]
    )
    rows = len(problem.observed.times)
    weights = np.repeat([problem.scene.lengths[name] ** -2 for name in problem.positions], rows)
    middle, centre = np.average(exact, weights=weights), np.average(found, weights=weights)
    product = np.sum(weights * np.conj(exact - middle) * (found - centre))
    rotation = float(np.angle(product)) if "rotation" in names else alignment.rotation
    offset = centre - np.exp(1j * rotation) * middle
    return replace(alignment, rotation=rotation, offset=(float(offset.real), float(offset.imag)))


def _complex(vectors: Array) -> np.ndarray[tuple[int], np.dtype[np.complex128]]:
    return np.asarray(vectors[:, 0] + 1j * vectors[:, 1])
