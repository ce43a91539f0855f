"""Likely causes of a table's errors: common slips, each named only where undoing it removes the difference."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.optimize import least_squares

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.tables.fitting import Fit, fitted
from conrod.own.tables.samples import ERRORS, Alignment, Exact, Observed, largest, table_errors
from conrod.scenes import Scene

GRAVITY, GRAVITY_WIDTH = 9.81, 0.02  # [m/s^2], relative
DEGREE, TURN, RPM = math.pi / 180.0, 2.0 * math.pi, math.pi / 30.0
# What a length is too large by, and the slip that it comes of; those of angles and speeds likewise.
LENGTHS = {
    1e3: "mm taken for m",
    1e-3: "m taken for mm",
    1e2: "cm taken for m",
    1e-2: "m taken for cm",
    10.0: "mm taken for cm",
    0.1: "cm taken for mm",
    1.0 / 0.0254: "inches taken for m",
    0.0254: "m taken for inches",
}
ANGLES = {
    1.0 / DEGREE: "degrees taken for radians",
    DEGREE: "radians taken for degrees",
    1.0 / TURN: "turns taken for radians",
}
SPEEDS = {
    DEGREE: "rad/s taken for deg/s",
    1.0 / DEGREE: "deg/s taken for rad/s",
    RPM: "rad/s taken for rpm",
    1.0 / RPM: "rpm taken for rad/s",
}
# Stamps that differ by less than this share are one and the same.
SAME_STAMP = 0.02
FINE = 1e-13  # relative, of a stamp and of what it leaves
HALF_TURN = 0.5  # of a period: beyond it another instant of another turn is nearer
# Fewer numbers for each unknown are fitted by almost anything.
NUMBERS_EACH = 3
# A cause reproduces a difference where no more than this share of it is left once the cause is undone; of a difference
# beyond L itself, than this share of L.
LEFT = 0.05
MUCH_LESS, ALL = 0.1, 1e-6
# Rows that causes are looked for in, evenly spread: plenty to tell a twentieth.
MOST_ROWS = 5_000


@dataclass(frozen=True)
class Cause:
    """A likely cause.

    Attributes:
        kind: in a word or two, the same for all tables.
        text: with its size.
        explains: name of an error -> its largest value as it is, and with the cause undone.
    """

    kind: str
    text: str
    explains: Mapping[str, tuple[float, float]]


def likely_causes(observed: Observed, scene: Scene, alignment: Alignment, wrong: Sequence[str]) -> tuple[Cause, ...]:
    """Causes that reproduce what is wrong: those that explain most first, then those that leave least.

    Args:
        wrong: names of the errors that are to be explained.
    """
    rows = observed.thinned(MOST_ROWS)
    errors = table_errors(rows, scene, alignment)
    before = {name: size for name in wrong if (size := largest(errors, name))}
    found: dict[str, Cause] = {}
    for hypothesis in hypotheses(rows, scene, alignment, tuple(before)):
        try:
            left = table_errors(hypothesis.observed, scene, hypothesis.alignment)
        except InvalidInput:
            continue  # the linkage does not come to where the crank would then be
        explains = {}
        for name, size in before.items():
            after = largest(left, name) if name in hypothesis.concerns else None
            if after is not None and after <= LEFT * min(size, 1.0):
                explains[name] = (size, after)
        cause = Cause(hypothesis.kind, hypothesis.text, explains)
        # Of one kind the first is the simplest: another one must leave far less.
        if explains and (hypothesis.kind not in found or _left(cause) < MUCH_LESS * _left(found[hypothesis.kind])):
            found[hypothesis.kind] = cause
    ranked = sorted(found.values(), key=lambda cause: (-len(cause.explains), _left(cause)))
    return tuple(cause for place, cause in enumerate(ranked) if not _beaten(cause, ranked[:place]))


def _beaten(cause: Cause, better: Sequence[Cause]) -> bool:
    """True if others explain all that a cause does, and leave far less of it."""
    return all(
        any(name in b.explains and _left(b) < MUCH_LESS * _left(cause) for b in better) for name in cause.explains
    )


def _left(cause: Cause) -> float:
    """The share that is left; below a part in a million all is explained, and which leaves less is rounding."""
    return max(ALL, *(after / before for before, after in cause.explains.values()))


@dataclass(frozen=True)
class Hypothesis:
    """A slip undone.

    Attributes:
        kind, text: as in `Cause`.
        observed, alignment: the table and its alignment without the slip.
        concerns: names of the errors that the slip can be behind.
    """

    kind: str
    text: str
    observed: Observed
    alignment: Alignment
    concerns: Sequence[str] = ERRORS


def hypotheses(observed: Observed, scene: Scene, alignment: Alignment, wrong: Sequence[str]) -> Iterator[Hypothesis]:
    """All slips that a table may suffer from, undone; of one kind the simplest first.

    Args:
        wrong: names of the errors that are to be explained.
    """
    yield from _units(observed, alignment)
    opposite = replace(alignment, sense=-alignment.sense)
    yield Hypothesis("opposite sense", "the crank turns in the opposite sense", observed, opposite)
    swapped = observed.with_samples(lambda _, s: replace(s, axes=tuple(1 - axis for axis in s.axes)))
    yield Hypothesis("axes swapped", "x and y are swapped", swapped, alignment)
    if "acceleration" in wrong:
        yield from _gravity(observed, scene, alignment)
    if "total" in wrong or "position" in wrong:
        yield from _frame(observed, scene, alignment)
    yield from _times(observed, scene, alignment, wrong)


def _units(observed: Observed, alignment: Alignment) -> Iterator[Hypothesis]:
    for factor, slip in LENGTHS.items():
        scaled = observed.with_samples(lambda _, s: replace(s, values=s.values / factor))  # noqa: B023
        yield Hypothesis("length unit", f"lengths are {factor:.6g} times too large: {slip}", scaled, alignment)
    for factor, slip in ANGLES.items() if observed.angle is not None else ():
        scaled = observed.with_crank(partial(np.multiply, 1.0 / factor))
        yield Hypothesis("angle unit", f"crank angles are {factor:.6g} times too large: {slip}", scaled, alignment)
    # Positions alone: at another speed, velocities are others too.
    concerns = ("total",) if observed.angle is not None else ("total", "position")
    for factor, slip in SPEEDS.items():
        scaled = replace(observed, times=alignment.time + (observed.times - alignment.time) * factor)
        text = f"the crank turns at {factor:.6g} times the nominal speed: {slip}"
        yield Hypothesis("speed unit", text, scaled, alignment, concerns)


def _gravity(observed: Observed, scene: Scene, alignment: Alignment) -> Iterator[Hypothesis]:
    """A constant vector of the size of gravity in all accelerations."""
    along: tuple[list[Array], list[Array]] = ([], [])
    exact = Exact(observed, scene, alignment)
    for point, quantities in observed.points.items():
        if "acceleration" in quantities:
            difference = exact.difference("acceleration", point)
            for column, axis in enumerate(quantities["acceleration"].axes):
                along[axis].append(difference[:, column])
    constant = np.array([np.mean(np.concatenate(parts)) if parts else 0.0 for parts in along])
    size = math.hypot(*constant)
    if abs(size / GRAVITY - 1.0) > GRAVITY_WIDTH:
        return
    without = observed.with_samples(
        lambda name, s: replace(s, values=s.values - constant[list(s.axes)]) if name == "acceleration" else s
    )
    direction = math.degrees(math.atan2(constant[1], constant[0]))
    text = f"gravity is left in the accelerations: {size:.4g} m/s² at {direction:.0f} deg from x"
    yield Hypothesis("gravity", text, without, alignment, ("acceleration",))


def _frame(observed: Observed, scene: Scene, alignment: Alignment) -> Iterator[Hypothesis]:
    problem = Fit(observed, scene, "nominal" if observed.angle is None else "reached")
    for names in (["x", "y"], ["x", "y", "rotation"]):
        if not _determined(observed, names):
            return
        other = fitted(problem, alignment, names).alignment
        x, y = (1e3 * (there - here) for there, here in zip(other.offset, alignment.offset, strict=True))
        turn = math.degrees(math.remainder(other.rotation - alignment.rotation, TURN))
        turned = f" and turned by {turn:.6g} deg" if len(names) > 2 else ""
        yield Hypothesis("frame", f"the table's frame is offset by ({x:.6g}, {y:.6g}) mm{turned}", observed, other)


def _determined(observed: Observed, names: Sequence[str]) -> bool:
    """True if there are enough numbers to determine so many unknowns."""
    numbers = sum(s["position"].values.size for s in observed.points.values() if "position" in s)
    return numbers >= NUMBERS_EACH * len(names)


# -- time ------------------------------------------------------------------------------------------------------------


def _times(observed: Observed, scene: Scene, alignment: Alignment, wrong: Sequence[str]) -> Iterator[Hypothesis]:
    """The crank's zero and the clock, found from anywhere in the turn; then single quantities at other instants."""
    # One pass has no turn in which to look anywhere: most of it the linkage does not reach.
    anywhere = scene.kinematics.mechanism.driver.span is None and _determined(observed, ["time"])
    shifts = []
    if anywhere and observed.angle is not None and "position" in wrong:
        other = fitted(Fit(observed, scene, "reached"), alignment, ["zero"]).alignment
        by = math.remainder(other.zero - alignment.zero, TURN)
        shifts.append(by / (alignment.sense * scene.speed))
        text = f"the table's crank angle is 0 where the scene's is {math.degrees(by):.6g} deg"
        yield Hypothesis("crank zero", text, observed, other)
    if anywhere and "total" in wrong:
        other = fitted(Fit(observed, scene, "nominal"), alignment, ["time"]).alignment
        clock = -math.remainder(other.time - alignment.time, scene.period)
        shifts.append(clock)
        degrees = math.degrees(abs(clock * scene.speed))
        text = f"each row belongs {_steps(clock, observed)} than its time says (or the crank is {degrees:.4g} deg off)"
        # Where the table has a crank angle of its own, its clock says nothing of that.
        moved = (_shifted(observed, clock, scene), alignment) if observed.angle is None else (observed, other)
        yield Hypothesis("time offset", text, *moved)
    for name in ("velocity", "acceleration"):
        stamp = _stamp_of(name, observed, scene, alignment) if name in wrong else None
        if stamp is not None and all(abs(stamp - known) > SAME_STAMP * abs(stamp) for known in shifts):
            text = f"each {name} belongs {_steps(stamp, observed)} than its row says"
            yield Hypothesis(f"{name} stamp", text, _shifted(observed, stamp, scene), alignment, (name,))


def _steps(by: float, observed: Observed) -> str:
    return f"{abs(by):.4g} s ({abs(by) / observed.step:.3g} of a step) {'later' if by > 0 else 'earlier'}"


def _shifted(observed: Observed, by: float, scene: Scene) -> Observed:
    """The table with all its rows so much later [s], the crank as far on as it turns in that time."""
    rate = scene.speed if observed.rate is None else observed.rate
    angle = None if observed.angle is None else observed.angle + rate * by
    return replace(observed, times=observed.times + by, angle=angle)


def _stamp_of(name: str, observed: Observed, scene: Scene, alignment: Alignment) -> float | None:
    """Time by which the values of a quantity belong later than their rows say [s], by least squares.

    Returns:
        None where no shift within half a turn makes the difference smaller.
    """
    samples = {point: own[name] for point, own in observed.points.items() if name in own}
    rate = "acceleration" if name == "velocity" else "jerk"

    def motion(by: Array) -> Exact:
        return Exact(_shifted(observed, float(by[0]) * scene.period, scene), scene, alignment)

    def residuals(by: Array) -> Array:
        try:
            exact = motion(by)
            return np.concatenate([exact.difference(name, p).ravel() / scene.lengths[p] for p in samples])
        except InvalidInput:  # the linkage does not come to where the crank would then be
            return np.full(sum(own.values.size for own in samples.values()), np.nan)

    def slopes(by: Array) -> Array:
        exact = motion(by).motion(name)
        rates = {p: getattr(exact.point(p), rate) for p in samples}
        seen = [alignment.seen(rates[p], own, placed=False).ravel() / scene.lengths[p] for p, own in samples.items()]
        return -scene.period * np.concatenate(seen)[:, None]

    start = np.zeros(1)
    before = 0.5 * float(np.sum(residuals(start) ** 2))
    found = least_squares(residuals, start, jac=slopes, bounds=(-HALF_TURN, HALF_TURN), xtol=FINE, ftol=FINE, gtol=FINE)
    within = abs(found.x[0]) < 0.99 * HALF_TURN
    return float(found.x[0]) * scene.period if within and found.cost < before else None
