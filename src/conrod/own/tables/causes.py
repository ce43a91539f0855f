"""Likely causes of a table's errors: common slips, each named only where undoing it removes the difference."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.tables.columns import AXES, CRANK, CRANK_ANGLE, TIME
from conrod.own.tables.errors import ERRORS, Exact
from conrod.own.tables.estimation import TURN, ahead, shift_of
from conrod.own.tables.slides import Hypothesis, slide_hypotheses
from conrod.own.tables.stuck import MIN_ROWS, remaining, stuck_rows, stuck_words, without_stuck

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
HALF = 0.5  # of a difference that values which stand still make, for them to be named beside what else is wrong
NOTEWORTHY = 1e-6  # nobody asks why an error is that small, but for a tolerance: tables are written with so many digits
STUCK = "dead sensor"
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
    rows = table.thinned(MOST_ROWS)
    before = {name: size for name in wrong if (size := rows.largest(name))}
    found, stuck = _explaining(rows, before), stuck_rows(rows)
    if not stuck or (found and STUCK not in [cause.kind for cause in found]):
        return found
    # A sensor that stands still says so itself; what is left once it is out may have a cause of its own.
    rest = remaining(rows, stuck)
    after = {name: rest.largest(name) or 0.0 for name in before} if len(rest.times) >= MIN_ROWS else {}
    others = _explaining(rest, {name: size for name, size in after.items() if size > NOTEWORTHY})
    explains = {name: (size, after.get(name, 0.0)) for name, size in before.items() if after.get(name, 0.0) < size}
    helps = any(left <= HALF * size for size, left in explains.values())
    own = Cause(STUCK, stuck_words(rows, stuck), explains)
    return (own, *(cause for cause in others if cause.kind != STUCK)) if others or helps else ()


def _explaining(rows: Exact, before: Mapping[str, float]) -> tuple[Cause, ...]:
    """Causes that reproduce differences of some sizes: those that explain most first, then those that leave least."""
    found: dict[str, Cause] = {}
    for kind, text, undone, concerns in _hypotheses(rows, tuple(before)):
        explains = {}
        for name, size in before.items():
            try:
                after = undone.largest(name) if name in concerns else None
            except InvalidInput:
                break  # the linkage does not come to where the crank would then be
            if after is not None and after <= LEFT * min(size, 1.0) and not _is_stillness(rows, undone, name, after):
                explains[name] = (size, after)
        cause = Cause(kind, text, explains)
        # Of one kind the first is the simplest: another one must leave far less.
        if explains and (kind not in found or _left(cause) < MUCH_LESS * _left(found[kind])):
            found[kind] = cause
    ranked = sorted(found.values(), key=lambda cause: (-len(cause.explains), _left(cause)))
    return tuple(cause for place, cause in enumerate(ranked) if not _beaten(cause, ranked[:place]))


def _is_stillness(table: Exact, undone: Exact, name: str, after: float) -> bool:
    """True if a difference is small because undoing the slip makes the exact motion stand still, as the table does."""
    travel = _travel(undone, name)
    return travel < _travel(table, name) and after >= LEFT * travel


def _travel(table: Exact, name: str) -> float:
    """Largest travel, normalised, in the exact motion, of the columns that an error is of."""
    travels = [0.0]
    for point in table.points(name):
        exact = getattr((table.nominal if name == "total" else table.reached).point(point), ERRORS[name])
        axes = list(table.axes(name, point))
        travels.append(float(np.ptp(exact[:, axes], axis=0).max()) / table.norm(name, point))
    return max(travels)


def _beaten(cause: Cause, better: Sequence[Cause]) -> bool:
    """True if others explain all that a cause does, and leave far less of it."""
    return all(
        any(name in b.explains and _left(b) < MUCH_LESS * _left(cause) for b in better) for name in cause.explains
    )


def _left(cause: Cause) -> float:
    """The share that is left; below a part in a million all is explained, and which leaves less is rounding."""
    return max(ALL, *(after / before for before, after in cause.explains.values()))


# -- slips -----------------------------------------------------------------------------------------------------------


def _hypotheses(table: Exact, wrong: Collection[str]) -> Iterator[Hypothesis]:
    """All slips that a table may suffer from, undone; of one kind the simplest first."""
    if stuck := stuck_rows(table):
        yield STUCK, stuck_words(table, stuck), without_stuck(table, stuck), ERRORS
    yield from _units(table)
    opposite = table.scene.with_parameters(speed=-table.scene.speed)
    backwards = replace(table.scaled(-1.0, *CRANK), scene=opposite)
    yield "opposite sense", "the crank turns in the opposite sense", backwards, ERRORS
    other = str.maketrans(AXES, AXES[::-1])
    swapped = {f"{n[:-1]}{n[-1].translate(other)}" if "." in n else n: values for n, values in table.values.items()}
    yield "axes swapped", "x and y are swapped", replace(table, values=swapped), ERRORS
    if "total" in wrong or "position" in wrong:
        yield from _frame(table)
    yield from _times(table, wrong)
    yield from slide_hypotheses(table)


def _units(table: Exact) -> Iterator[Hypothesis]:
    moving = [name for name in table.values if "." in name]
    for factor, slip in _slips(LENGTHS):
        scaled = table.scaled(1.0 / factor, *moving)
        yield "length unit", f"lengths are {factor:.6g} times too large: {slip}", scaled, ERRORS
    for factor, slip in _slips(ANGLES) if CRANK_ANGLE in table.values else ():
        scaled = table.scaled(1.0 / factor, *CRANK)
        yield "angle unit", f"crank angles are {factor:.6g} times too large: {slip}", scaled, ERRORS
    # Positions alone: at another speed, velocities are others too.
    concerns = ("total",) if CRANK_ANGLE in table.values else ("total", "position")
    for factor, slip in _slips(SPEEDS):
        scaled = table.scaled(factor, TIME)
        yield "speed unit", f"the crank turns at {factor:.6g} times the nominal speed: {slip}", scaled, concerns


def _slips(units: Mapping[tuple[str, str], float]) -> Iterator[tuple[float, str]]:
    """Factors that units are taken wrongly by, with the slip; both ways round."""
    for (one, other), factor in units.items():
        yield factor, f"{one} taken for {other}"
        yield 1.0 / factor, f"{other} taken for {one}"


def _frame(table: Exact) -> Iterator[Hypothesis]:
    """Another origin, and another origin with axes that are turned: the mean, and the closed solution in the plane."""
    axes = {point: list(table.axes("position", point)) for point in table.points("position")}
    if not _determined(table, 2):
        return

    def mean(values: Mapping[str, Array]) -> complex:
        """Mean over all rows and points of what each has (T,), by its length."""
        weights = [table.scene.lengths[point] ** -2 for point in values]
        return complex(np.average([own.mean() for own in values.values()], weights=weights)) if values else 0j

    off = {point: table.difference("position", point) for point in axes}
    x, y = (mean({p: off[p][:, own.index(k)] for p, own in axes.items() if k in own}).real for k in (0, 1))
    yield _reframed(table, complex(x, y), 0.0)
    every = [table.axes(name, point) for name in ERRORS for point in table.points(name)]
    if any(len(own) == 1 for own in every) or not _determined(table, 3):
        return
    found = {p: table.values[f"{p}.x"] + 1j * table.values[f"{p}.y"] for p in axes}
    exact = {p: found[p] - off[p] @ [1.0, 1.0j] for p in axes}
    middle, centre = mean(exact), mean(found)
    turn = float(np.angle(mean({p: np.conj(exact[p] - middle) * (found[p] - centre) for p in axes})))
    yield _reframed(table, centre - complex(np.exp(1j * turn)) * middle, turn)


def _reframed(table: Exact, offset: complex, turn: float) -> Hypothesis:
    """A table in a frame that is offset [m] and turned [rad], back in the scene's."""
    values, back = dict(table.values), np.exp(-1j * turn)
    for name in table.values:
        owner, axis = name[:-1], name[-1]
        if "." in name:
            moved = 1.0 if owner.endswith(".") else 0.0
            x, y = (table.values.get(f"{owner}{one}", np.zeros(1)) for one in AXES)
            both = ((x - moved * offset.real) + 1j * (y - moved * offset.imag)) * back
            values[name] = both.real if axis == "x" else both.imag
    turned = f" and turned by {math.degrees(turn):.6g} deg" if turn else ""
    text = f"the table's frame is offset by ({1e3 * offset.real:.6g}, {1e3 * offset.imag:.6g}) mm{turned}"
    return "frame", text, replace(table, values=values), ERRORS


def _determined(table: Exact, unknowns: int) -> bool:
    """True if there are enough numbers to determine so many unknowns."""
    numbers = sum(len(table.axes("position", point)) for point in table.points("position")) * len(table.times)
    return numbers >= NUMBERS_EACH * unknowns


def _times(table: Exact, wrong: Collection[str]) -> Iterator[Hypothesis]:
    """The crank's zero and the clock, found from anywhere in the turn; then single quantities at other instants."""
    scene, shifts = table.scene, []
    # One pass has no turn in which to look anywhere: most of it the linkage does not reach.
    turns = scene.kinematics.mechanism.driver.span is None and _determined(table, 1)
    if turns and CRANK_ANGLE in table.values and "position" in wrong:
        by, *_ = shift_of(table, "position")
        shifts.append(by / scene.speed)
        text = f"the table's crank angle is 0 where the scene's is {math.degrees(by):.6g} deg"
        yield "crank zero", text, ahead(table, by), ERRORS
    if turns and "total" in wrong:
        clock = shift_of(table, "total")[0] / scene.speed
        shifts.append(clock)
        off = f"(or the crank is {math.degrees(abs(clock * scene.speed)):.4g} deg off)"
        # Where the table has a crank angle of its own, its clock says nothing of that.
        text = f"each row belongs {_steps(clock, table)} than its time says {off}"
        yield "time offset", text, table.later(clock), ERRORS
    for name in ("velocity", "acceleration"):
        stamp = _stamp_of(name, table) if name in wrong else None
        if stamp is not None and all(abs(stamp - known) > SAME_STAMP * abs(stamp) for known in shifts):
            text = f"each {name} belongs {_steps(stamp, table)} than its row says"
            yield f"{name} stamp", text, table.later(stamp), (name,)


def _stamp_of(name: str, table: Exact) -> float | None:
    """Time by which the values of a quantity belong later than their rows say [s], by least squares.

    Returns:
        None where no shift within half a turn makes the difference smaller.
    """
    period, still = table.scene.period, table.misses(name).ravel()

    def errors(by: Array) -> Array:
        try:
            return table.later(float(by[0]) * period).misses(name).ravel()
        except InvalidInput:  # the linkage does not come to where the crank would then be
            return np.full_like(still, BEYOND)

    bounds = (-HALF_TURN, HALF_TURN)
    found = least_squares(errors, [0.0], jac="3-point", bounds=bounds, xtol=FINE, ftol=FINE, gtol=FINE)
    within = abs(found.x[0]) < 0.99 * HALF_TURN
    return float(found.x[0]) * period if within and found.cost < 0.5 * float(still @ still) else None


def _steps(by: float, table: Exact) -> str:
    step = float(np.median(np.diff(table.times)))
    return f"{abs(by):.4g} s ({abs(by) / step:.3g} of a step) {'later' if by > 0 else 'earlier'}"
