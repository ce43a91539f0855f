"""Time offset, crank phase, sense of rotation and frame of a table, estimated where a user asks for them.

By least squares, from the best of many crank angles round the turn. The frame for each start is the closed solution of
the orthogonal Procrustes problem (Schoenemann 1966; in the plane it is the angle of a complex product), so that no
guess is needed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, Literal

import numpy as np
from scipy.optimize import least_squares

from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.motion import Array, PointMotion
from conrod.own.tables.samples import Alignment, Observed, Samples
from conrod.scenes import Scene

CHOICES = ("time", "phase", "sense", "frame")
FRAME = ("x", "y", "rotation")
# Rows that estimates are made from, evenly spread.
MOST_ROWS = 50_000
# Both senses fit alike where the better one leaves more than this share of what the other leaves.
SAME_FIT = 0.9
ROUNDING = 1e-12
# What is fitted: positions at the nominal time, positions at the table's own crank angle, or that angle itself.
Kind = Literal["nominal", "reached", "crank"]
TURNING = ("time", "phase", "zero")  # what shifts the crank angle
STARTS, START_ROWS, PURSUED = 72, 400, 4
PRECISION = 4.0 * float(np.finfo(float).eps)  # relative, of the sum of squares, of a step and of the slope
# Singular values below this share of the largest one are rounding: their direction cannot be determined.
DETERMINED = 1e-7
INVOLVED = 0.01  # of a unit vector: smaller components are none


@dataclass(frozen=True)
class Estimate:
    """One estimated quantity, SI.

    Attributes:
        name: what is estimated; `zero` is the crank angle where the table's own is 0, x, y and rotation are the frame.
        error: its standard error, for errors of one size (relative to L) that are independent from row to row.
    """

    name: str
    value: float
    error: float


@dataclass(frozen=True)
class Estimation:
    """Estimated quantities, and the alignment of a table with them.

    Attributes:
        alignment: that the table is judged with.
        estimates: in the order asked for; a sense of rotation has no standard error and is not among them.
        sense: where it was estimated: +1 or -1, and the rms errors left with it and with the opposite one.
        undetermined: quantities that cannot be determined, or not separated, a sentence each.
        rows: that were used.
        remaining: rms error that is left, divided by L; of the crank angle [rad] where a table has no positions.
    """

    alignment: Alignment
    estimates: tuple[Estimate, ...]
    sense: tuple[int, float, float] | None
    undetermined: tuple[str, ...]
    rows: int
    remaining: float


def parse_estimate(text: str) -> tuple[str, ...]:
    """The names in `--estimate time,phase`.

    Raises:
        InvalidInput: something that is not estimated.
    """
    names = [name.strip() for name in text.split(",")]
    for name in names:
        if name not in CHOICES:
            raise unknown_choice("thing to estimate", name, CHOICES)
    return tuple(dict.fromkeys(names))


def estimate(observed: Observed, scene: Scene, asked: Sequence[str]) -> Estimation:
    """Estimate what was asked for.

    Raises:
        InvalidInput: the table does not have what it would be determined from, or too little of it.
    """
    if not observed.has("position"):
        if observed.angle is None or "frame" in asked:
            what = "frame" if observed.angle is not None else ",".join(asked)
            raise InvalidInput(f"--estimate {what}: the table has no positions to estimate it from")
    elif scene.kinematics.mechanism.driver.span is not None and tuple(asked) != ("frame",):
        raise InvalidInput(
            f"--estimate {','.join(asked)}: it would be looked for anywhere in a turn, and the input makes one pass; "
            "only frame can be estimated"
        )
    rows = observed.thinned(MOST_ROWS)
    usual = _with_sense(rows, scene, asked, 1)
    if "sense" not in asked:
        return usual
    best, other = sorted((usual, _with_sense(rows, scene, asked, -1)), key=lambda one: one.remaining)
    if other.remaining < ROUNDING or best.remaining > SAME_FIT * other.remaining:
        reason = "sense cannot be determined: both senses of rotation fit alike; it is taken to be the scene's"
        return replace(usual, undetermined=(*usual.undetermined, reason))
    return replace(best, sense=(best.alignment.sense, best.remaining, other.remaining))


def _with_sense(observed: Observed, scene: Scene, asked: Sequence[str], sense: int) -> Estimation:
    fits = list(_fits(observed, scene, asked, Alignment(sense=sense)))
    found, turn = fits[-1].alignment, 2.0 * math.pi
    # The motion repeats: of all offsets that are as good, the smallest.
    repeats = {"time": scene.period, "phase": turn, "zero": turn, "rotation": turn}
    smallest: dict[str, Any] = {name: math.remainder(getattr(found, name), period) for name, period in repeats.items()}
    values = smallest | dict(zip("xy", found.offset, strict=True))
    return Estimation(
        alignment=replace(found, **smallest),
        estimates=tuple(Estimate(name, values[name], error) for one in fits for name, error in one.errors.items()),
        sense=None,
        undetermined=tuple(text for one in fits for text in one.undetermined),
        rows=len(observed.times),
        remaining=fits[0].remaining,
    )


def _fits(observed: Observed, scene: Scene, asked: Sequence[str], start: Alignment) -> Iterator[Fitted]:
    """Of a table that says where its crank was: the crank's zero and the frame first, the clock from what is left."""
    frame = FRAME if "frame" in asked else ()
    if observed.angle is None or not observed.has("position"):
        names = [part for name in asked for part in (frame if name == "frame" else (name,)) if name != "sense"]
        yield fitted(Fit(observed, scene, "crank" if observed.angle is not None else "nominal"), start, names)
        return
    crank = fitted(Fit(observed, scene, "reached"), start, [*(["zero"] if "phase" in asked else []), *frame])
    yield crank
    clock = [name for name in asked if name in ("time", "phase")]
    yield fitted(Fit(observed, scene, "nominal"), crank.alignment, clock)


# -- least squares ----------------------------------------------------------------------------------------------------


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


@dataclass(frozen=True)
class Fit:
    """A least-squares problem. Fitted quantities are in units in which each is about one; see `scale`.

    Attributes:
        kind: what is fitted.
    """

    observed: Observed
    scene: Scene
    kind: Kind

    @cached_property
    def positions(self) -> dict[str, Samples]:
        """Samples of position by point."""
        return {name: s["position"] for name, s in self.observed.points.items() if "position" in s}

    def scale(self, name: str) -> float:
        """The unit of a fitted quantity, SI: the time of a radian at nominal speed, the largest L, or a radian."""
        if name == "time":
            return 1.0 / abs(self.scene.speed)
        return max(self.scene.lengths.values()) if name in ("x", "y") else 1.0

    def moved(self, alignment: Alignment, names: Sequence[str], step: Sequence[float] | Array) -> Alignment:
        """An alignment changed by so many units of each quantity."""
        change = {name: float(size) * self.scale(name) for name, size in zip(names, step, strict=True)}
        x, y = alignment.offset
        offset = (x + change.pop("x", 0.0), y + change.pop("y", 0.0))
        return replace(alignment, offset=offset, **{name: getattr(alignment, name) + by for name, by in change.items()})

    def angle(self, alignment: Alignment) -> Array:
        """Crank angles (T,) [rad] at which positions are fitted."""
        at = alignment.nominal if self.kind == "nominal" else alignment.reached
        return at(self.observed, self.scene.speed)

    def left(self, alignment: Alignment) -> float:
        """Sum of squares."""
        residuals, _ = self.linearised(alignment)
        return float(residuals @ residuals)

    def linearised(self, alignment: Alignment, names: Sequence[str] = ()) -> tuple[Array, Array]:
        """Residuals (N,), table minus exact, and derivatives of the exact values (N, p).

        Positions are divided by L; the crank angle is in radians.
        """
        if self.kind == "crank":
            reached = np.unwrap(alignment.reached(self.observed, self.scene.speed))
            slopes = np.array([self._turn(alignment, name) for name in names])
            nominal = alignment.nominal(self.observed, self.scene.speed)
            return reached - nominal, np.broadcast_to(slopes, (len(reached), len(names)))
        motion = self.scene.motion(self.angle(alignment), 1.0)
        residuals, parts = [], []
        for point, samples in self.positions.items():
            exact, length = motion.point(point), self.scene.lengths[point]
            off = samples.values - alignment.seen(exact.position, samples, placed=True)
            residuals.append(off.ravel() / length)
            columns = [self._slope(name, exact, samples, alignment).ravel() for name in names]
            parts.append((np.column_stack(columns) if columns else np.empty((off.size, 0))) / length)
        return np.concatenate(residuals), np.concatenate(parts)

    def _slope(self, name: str, exact: PointMotion, samples: Samples, alignment: Alignment) -> Array:
        if name in TURNING:
            # At a crank speed of 1 rad/s the velocity is the derivative by the angle.
            return self._turn(alignment, name) * alignment.seen(exact.velocity, samples, placed=False)
        if name == "rotation":
            turned = replace(alignment, rotation=alignment.rotation + 0.5 * math.pi)
            return turned.seen(exact.position, samples, placed=False)
        along = np.array([float(axis == "xy".index(name)) for axis in samples.axes])
        return np.broadcast_to(along * self.scale(name), samples.values.shape)

    def _turn(self, alignment: Alignment, name: str) -> float:
        """Derivative of the crank angle by what shifts it."""
        return -alignment.sense * math.copysign(1.0, self.scene.speed) if name == "time" else 1.0


def fitted(problem: Fit, start: Alignment, asked: Sequence[str]) -> Fitted:
    """The alignment that leaves least, of what was asked for and can be determined; the rest stays as in `start`.

    Raises:
        InvalidInput: there are no more residuals than unknowns.
    """
    names, undetermined = list(asked), list[str]()
    count = len(problem.linearised(start)[0])
    if count <= len(names):
        raise InvalidInput(f"{count} numbers are too few to estimate {', '.join(names)} from")
    while names:
        best = _best(problem, start, names)
        residuals, slopes = problem.linearised(best, names)
        _, singular, directions = np.linalg.svd(slopes, full_matrices=False)
        if singular[-1] > DETERMINED * max(singular[0], math.sqrt(count) * DETERMINED):
            # Of independent errors of one size: the square root of s^2 (J^T J)^-1, s^2 = r^T r / (N - p).
            variance = float(residuals @ residuals) / (count - len(names))
            spread = np.sqrt(variance * np.sum((directions / singular[:, None]) ** 2, axis=0))
            errors = {name: float(size) * problem.scale(name) for name, size in zip(names, spread, strict=True)}
            break
        tied = [name for name, part in zip(names, directions[-1], strict=True) if abs(part) > INVOLVED]
        undetermined.append(_undetermined(tied))
        names.remove(tied[-1])
    else:
        best, errors = start, {}
    vectors = len(problem.observed.times) * (1 if problem.kind == "crank" else len(problem.positions))
    return Fitted(best, errors, tuple(undetermined), math.sqrt(problem.left(best) / vectors))


def _undetermined(tied: Sequence[str]) -> str:
    """Quantities of which a combination changes nothing, in words."""
    last = tied[-1]
    if len(tied) == 1:
        return f"{last} cannot be determined: nothing in this table depends on it"
    if set(tied) == {"time", "phase"}:
        return f"time and phase cannot be separated at constant speed: {tied[0]} stands for both, {last} is kept at 0"
    return f"{' and '.join(tied)} cannot be separated in this table: {last} is kept at 0, the others stand for it"


# -- the way there ---------------------------------------------------------------------------------------------------


def _best(problem: Fit, start: Alignment, names: Sequence[str]) -> Alignment:
    """The best minimum that descents lead to from the best starts of a ring, each lower than its neighbours."""
    turning = next((name for name in names if name in TURNING), None)
    coarse = replace(problem, observed=problem.observed.thinned(START_ROWS))
    if problem.kind == "crank" or turning is None:
        starts = [_framed(coarse, start, names)]
    else:
        turns = np.arange(STARTS) * (2.0 * np.pi / STARTS)
        around = [_framed(coarse, coarse.moved(start, [turning], [turn]), names) for turn in turns]
        left = [coarse.left(one) for one in around]
        minima = [k for k in range(STARTS) if left[k] <= min(left[k - 1], left[(k + 1) % STARTS])]
        starts = [around[k] for k in sorted(minima, key=lambda k: left[k])[:PURSUED]]
    pursued = [_descended(coarse, one, names) for one in starts]
    return _descended(problem, min(pursued, key=coarse.left), names)


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
    motion, parts = problem.scene.motion(problem.angle(alignment), 1.0), np.array([1.0, 1.0j])
    exact = np.concatenate([motion.point(name).position @ parts for name in problem.positions])
    found = np.concatenate([s.values[:, np.argsort(s.axes)] @ parts for s in problem.positions.values()])
    weights = np.repeat([problem.scene.lengths[name] ** -2 for name in problem.positions], len(problem.observed.times))
    middle, centre = np.average(exact, weights=weights), np.average(found, weights=weights)
    product = np.sum(weights * np.conj(exact - middle) * (found - centre))
    rotation = float(np.angle(product)) if "rotation" in names else alignment.rotation
    offset = centre - np.exp(1j * rotation) * middle
    return replace(alignment, rotation=rotation, offset=(float(offset.real), float(offset.imag)))
