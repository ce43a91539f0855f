"""Likely causes of a table's errors: common slips, each named only where undoing it removes the difference."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np
from scipy.optimize import least_squares

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.tables.estimation import TURN, fitted
from conrod.own.tables.samples import ERRORS, Exact, Observed, Samples

# The two units of a slip: the size of the one taken for the other. Either may be taken for the other.
LENGTHS = {("mm", "m"): 1e3, ("cm", "m"): 1e2, ("mm", "cm"): 10.0, ("inches", "m"): 1.0 / 0.0254}
ANGLES = {("degrees", "radians"): 180.0 / math.pi, ("turns", "radians"): 1.0 / TURN}
SPEEDS = {("deg/s", "rad/s"): 180.0 / math.pi, ("rpm", "rad/s"): 30.0 / math.pi}
# Stamps that differ by less than this share are one and the same.
SAME_STAMP = 0.02
FINE = 1e-13  # relative, of a stamp and of what it leaves
BEYOND = 1e6  # times L, where the linkage does not go
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


def likely_causes(table: Exact, wrong: Sequence[str]) -> tuple[Cause, ...]:
    """Causes that reproduce what is wrong: those that explain most first, then those that leave least.

    Args:
        wrong: names of the errors that are to be explained.
    """
    rows = replace(table, observed=table.observed.thinned(MOST_ROWS))
    before = {name: size for name in wrong if (size := rows.largest(name))}
    found: dict[str, Cause] = {}
    for kind, text, undone, concerns in _hypotheses(rows, tuple(before)):
        explains = {}
        for name, size in before.items():
            try:
                after = undone.largest(name) if name in concerns else None
            except InvalidInput:
                break  # the linkage does not come to where the crank would then be
            if after is not None and after <= LEFT * min(size, 1.0):
                explains[name] = (size, after)
        cause = Cause(kind, text, explains)
        # Of one kind the first is the simplest: another one must leave far less.
        if explains and (kind not in found or _left(cause) < MUCH_LESS * _left(found[kind])):
            found[kind] = cause
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


# -- slips -----------------------------------------------------------------------------------------------------------

# A slip undone: kind and text as in `Cause`, the table without the slip, names of the errors that it can be behind.
Hypothesis: TypeAlias = tuple[str, str, Exact, Sequence[str]]


def _hypotheses(table: Exact, wrong: Sequence[str]) -> Iterator[Hypothesis]:
    """All slips that a table may suffer from, undone; of one kind the simplest first."""
    observed = table.observed
    yield from _units(table)
    opposite = table.scene.with_parameters(speed=-table.scene.speed)
    backwards = replace(table, scene=opposite, observed=observed.with_crank(np.negative))
    yield "opposite sense", "the crank turns in the opposite sense", backwards, ERRORS
    swapped = observed.with_samples(lambda _, s: replace(s, axes=tuple(1 - axis for axis in s.axes)))
    yield "axes swapped", "x and y are swapped", replace(table, observed=swapped), ERRORS
    if "total" in wrong or "position" in wrong:
        yield from _frame(table)
    yield from _times(table, wrong)


def _units(table: Exact) -> Iterator[Hypothesis]:
    observed = table.observed
    for factor, slip in _slips(LENGTHS):
        scaled = observed.with_samples(partial(_smaller, factor))
        text = f"lengths are {factor:.6g} times too large: {slip}"
        yield "length unit", text, replace(table, observed=scaled), ERRORS
    for factor, slip in _slips(ANGLES) if observed.angle is not None else ():
        scaled = observed.with_crank(partial(np.multiply, 1.0 / factor))
        text = f"crank angles are {factor:.6g} times too large: {slip}"
        yield "angle unit", text, replace(table, observed=scaled), ERRORS
    # Positions alone: at another speed, velocities are others too.
    concerns = ("total",) if observed.angle is not None else ("total", "position")
    for factor, slip in _slips(SPEEDS):
        scaled = replace(observed, times=observed.times * factor)
        text = f"the crank turns at {factor:.6g} times the nominal speed: {slip}"
        yield "speed unit", text, replace(table, observed=scaled), concerns


def _slips(units: Mapping[tuple[str, str], float]) -> Iterator[tuple[float, str]]:
    """Factors that units are taken wrongly by, with the slip; both ways round."""
    for (one, other), factor in units.items():
        yield factor, f"{one} taken for {other}"
        yield 1.0 / factor, f"{other} taken for {one}"


def _smaller(factor: float, _: str, samples: Samples) -> Samples:
    return replace(samples, values=samples.values / factor)


def _frame(table: Exact) -> Iterator[Hypothesis]:
    """Another origin, and another origin with axes that are turned: the mean, and the closed solution in the plane."""
    places = {point: own["position"] for point, own in table.observed.points.items() if "position" in own}
    weights = {point: table.scene.lengths[point] ** -2 for point in places}
    if not _determined(table.observed, 2):
        return

    def mean(values: Mapping[str, Array]) -> complex:
        """Weighted mean over all rows and points of what each has (T,)."""
        whole = sum(weights[point] * own.sum() for point, own in values.items())
        return complex(whole / (sum(weights[point] * len(own) for point, own in values.items()) or 1.0))

    def undone(offset: complex, turn: float) -> Hypothesis:
        turned = f" and turned by {math.degrees(turn):.6g} deg" if turn else ""
        text = f"the table's frame is offset by ({1e3 * offset.real:.6g}, {1e3 * offset.imag:.6g}) mm{turned}"
        reframed = table.observed.with_samples(partial(_reframed, offset, turn))
        return "frame", text, replace(table, observed=reframed), ERRORS

    off = {point: table.difference("position", point) for point in places}
    x, y = (mean({p: off[p][:, own.axes.index(k)] for p, own in places.items() if k in own.axes}) for k in (0, 1))
    yield undone(x + 1j * y, 0.0)
    every = [own for samples in table.observed.points.values() for own in samples.values()]
    if any(len(own.axes) == 1 for own in every) or not _determined(table.observed, 3):
        return
    found = {point: own.values @ [1.0, 1.0j] for point, own in places.items()}
    exact = {point: found[point] - off[point] @ [1.0, 1.0j] for point in places}
    middle, centre = mean(exact), mean(found)
    turn = float(np.angle(mean({p: np.conj(exact[p] - middle) * (found[p] - centre) for p in places})))
    yield undone(centre - complex(np.exp(1j * turn)) * middle, turn)


def _reframed(offset: complex, turn: float, quantity: str, samples: Samples) -> Samples:
    """Samples in a frame that is offset [m] and turned [rad], back in the scene's."""
    moved = [(offset.real, offset.imag)[axis] for axis in samples.axes]
    values = samples.values - (moved if quantity == "position" else 0.0)
    c, s = math.cos(turn), math.sin(turn)
    return replace(samples, values=values @ np.array([[c, -s], [s, c]]) if turn else values)


def _determined(observed: Observed, unknowns: int) -> bool:
    """True if there are enough numbers to determine so many unknowns."""
    numbers = sum(s["position"].values.size for s in observed.points.values() if "position" in s)
    return numbers >= NUMBERS_EACH * unknowns


def _times(table: Exact, wrong: Sequence[str]) -> Iterator[Hypothesis]:
    """The crank's zero and the clock, found from anywhere in the turn; then single quantities at other instants."""
    observed, scene = table.observed, table.scene
    # One pass has no turn in which to look anywhere: most of it the linkage does not reach.
    anywhere = scene.kinematics.mechanism.driver.span is None and _determined(observed, 1)
    shifts = []
    if anywhere and observed.angle is not None and "position" in wrong:
        by, _, _ = fitted(table, "position")
        shifts.append(by / scene.speed)
        text = f"the table's crank angle is 0 where the scene's is {math.degrees(by):.6g} deg"
        yield "crank zero", text, replace(table, observed=replace(observed, angle=observed.angle + by)), ERRORS
    if anywhere and "total" in wrong:
        clock = fitted(table, "total")[0] / scene.speed
        shifts.append(clock)
        degrees = math.degrees(abs(clock * scene.speed))
        text = f"each row belongs {_steps(clock, observed)} than its time says (or the crank is {degrees:.4g} deg off)"
        # Where the table has a crank angle of its own, its clock says nothing of that.
        yield "time offset", text, _shifted(table, clock), ERRORS
    for name in ("velocity", "acceleration"):
        stamp = _stamp_of(name, table) if name in wrong else None
        if stamp is not None and all(abs(stamp - known) > SAME_STAMP * abs(stamp) for known in shifts):
            text = f"each {name} belongs {_steps(stamp, observed)} than its row says"
            yield f"{name} stamp", text, _shifted(table, stamp), (name,)


def _steps(by: float, observed: Observed) -> str:
    return f"{abs(by):.4g} s ({abs(by) / observed.step:.3g} of a step) {'later' if by > 0 else 'earlier'}"


def _shifted(table: Exact, by: float) -> Exact:
    """The table with all its rows so much later [s], the crank as far on as it turns in that time."""
    observed = table.observed
    rate = table.scene.speed if observed.rate is None else observed.rate
    angle = None if observed.angle is None else observed.angle + rate * by
    return replace(table, observed=replace(observed, times=observed.times + by, angle=angle))


def _stamp_of(name: str, table: Exact) -> float | None:
    """Time by which the values of a quantity belong later than their rows say [s], by least squares.

    Returns:
        None where no shift within half a turn makes the difference smaller.
    """
    samples = {point: own[name] for point, own in table.observed.points.items() if name in own}
    lengths, period = table.scene.lengths, table.scene.period

    def residuals(by: Array) -> Array:
        try:
            shifted = _shifted(table, float(by[0]) * period)
            return np.concatenate([shifted.difference(name, p).ravel() / lengths[p] for p in samples])
        except InvalidInput:  # the linkage does not come to where the crank would then be
            return np.full(sum(own.values.size for own in samples.values()), BEYOND)

    start = np.zeros(1)
    before = 0.5 * float(np.sum(residuals(start) ** 2))
    found = least_squares(
        residuals, start, jac="3-point", bounds=(-HALF_TURN, HALF_TURN), xtol=FINE, ftol=FINE, gtol=FINE
    )
    within = abs(found.x[0]) < 0.99 * HALF_TURN
    return float(found.x[0]) * period if within and found.cost < before else None
