"""Likely causes of a table's errors: common slips, each named only where undoing it removes the error."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from conrod.errors import InvalidInput
from conrod.exact.link_rotations import ROTATIONS
from conrod.exact.motion import Array
from conrod.models.tables.columns import AXES, CRANK, CRANK_ANGLE, TIME
from conrod.models.tables.errors import ALL_ERRORS, ERRORS, TableComparison
from conrod.models.tables.estimation import best_crank_shift, shift_crank
from conrod.models.tables.lengths import GROUND_POINT, LENGTH, LENGTHS, length_hypotheses
from conrod.models.tables.link_slips import ANGLE_SLIPS, SPEED_SLIPS, factors_both_ways, link_hypotheses
from conrod.models.tables.sensors import SENSOR_FAULTS, outlier_hypotheses, sensor_hypotheses
from conrod.models.tables.slides import Hypothesis, slide_hypotheses
from conrod.models.tables.stuck import MIN_STUCK_ROWS, drop_stuck, replace_stuck, stuck_rows, stuck_words

# Pairs of units that are mistaken for each other, with the ratio of their sizes; either may be taken for the other.
LENGTH_SLIPS = {("mm", "m"): 1e3, ("cm", "m"): 1e2, ("mm", "cm"): 10.0, ("inches", "m"): 1.0 / 0.0254}
# Time shifts of two quantities that differ by less than this share are the same.
SAME_STAMP = 0.02
SOLVER_TOLERANCE = 1e-13  # relative, of a time shift and of its sum of squares
OUT_OF_REACH_ERROR = 1e6  # times L, where the linkage does not go
MAX_STAMP_PERIODS = 0.5  # beyond half a period a time shift is nearer to another turn
# With fewer numbers per unknown almost any hypothesis fits.
MIN_NUMBERS_PER_UNKNOWN = 3
# A cause reproduces an error where undoing it leaves at most this share of it, or of L where the error exceeds L.
MAX_REMAINING_SHARE = 0.05
# A cause replaces another where it leaves less than this factor of what the other leaves; shares below the second are
# rounding.
FAR_BETTER_FACTOR, FULLY_EXPLAINED = 0.1, 1e-6
# A stuck column is named with other causes where replacing it leaves at most this share of some error.
MAX_STUCK_REMAINING = 0.5
# Smaller errors are explained only where a tolerance is exceeded: tables are written with about so many digits.
MIN_NOTEWORTHY_ERROR = 1e-6
STUCK = "dead sensor"
MANY_UNKNOWNS = (*SENSOR_FAULTS, LENGTHS)  # kinds that have an unknown in each column, or several
# Pairs of kinds of which the first replaces the second where it leaves less than this factor of what that leaves.
AS_GOOD_FACTOR = 2.0
AS_GOOD_WITH_FEWER = {
    (LENGTH, "frame"),
    ("frame", GROUND_POINT),
    ("slide offset", LENGTH),
    ("slide offset", GROUND_POINT),
}
# Causes are searched in at most so many evenly spread rows.
MAX_CAUSE_ROWS = 5_000


@dataclass(frozen=True)
class Cause:
    """A likely cause.

    Attributes:
        kind: name of the cause in a word or two, the same for all tables.
        text: with its size.
        explains: name of an error -> its largest value in the table, and with the cause undone.
    """

    kind: str
    text: str
    explains: Mapping[str, tuple[float, float]]


def likely_causes(
    table: TableComparison, wrong: Sequence[str], allowed: Mapping[str, float] | None = None
) -> tuple[Cause, ...]:
    """Find the causes that reproduce a table's errors, the most comprehensive first.

    Args:
        wrong: names of the errors that are to be explained.
        allowed: tolerances, within which a fault of a sensor has to leave an error.
    """
    limits = allowed or {}
    # Single rows are looked for in all of them, and explain what they explain alone.
    every = {name: size for name in wrong if (size := table.largest(name))}
    if (single := _reproducing_causes(outlier_hypotheses(table), table, every, limits)) and _explain_all(single, every):
        return single
    rows = table.thin_rows(MAX_CAUSE_ROWS)
    before = {name: size for name in wrong if (size := rows.largest(name))}
    found, stuck = _reproducing_causes(_hypotheses(rows, tuple(before)), rows, before, limits), stuck_rows(rows)
    if not stuck or (found and STUCK not in [cause.kind for cause in found]):
        return found
    # The other columns may have a further cause, which shows once the stuck ones are left out.
    rest = drop_stuck(rows, stuck)
    after = {name: rest.largest(name) or 0.0 for name in before} if len(rest.times) >= MIN_STUCK_ROWS else {}
    left = {name: size for name, size in after.items() if size > MIN_NOTEWORTHY_ERROR}
    # Without a row, or an error, there is nothing to look at.
    others = _reproducing_causes(_hypotheses(rest, tuple(left)), rest, left, limits) if left else ()
    explains = {name: (size, after.get(name, 0.0)) for name, size in before.items() if after.get(name, 0.0) < size}
    helps = any(left <= MAX_STUCK_REMAINING * size for size, left in explains.values())
    own = Cause(STUCK, stuck_words(rows, stuck), explains)
    return (own, *(cause for cause in others if cause.kind != STUCK)) if others or helps else ()


def _explain_all(causes: Sequence[Cause], errors: Collection[str]) -> bool:
    """True if one of some causes explains every error."""
    return any(set(errors) <= set(cause.explains) for cause in causes)


def _reproducing_causes(
    hypotheses: Iterable[Hypothesis], rows: TableComparison, before: Mapping[str, float], allowed: Mapping[str, float]
) -> tuple[Cause, ...]:
    """Find the causes that reproduce errors of given sizes, the most comprehensive first.

    Args:
        hypotheses: slips that the table may have, each undone.
        allowed: as in `likely_causes`.
    """
    found: dict[str, Cause] = {}
    for kind, text, undone, concerns in hypotheses:
        explains = {}
        for name, size in before.items():
            try:
                after = undone.largest(name) if name in concerns else None
            except InvalidInput:
                break  # the linkage does not come to where the crank would then be
            if (
                after is not None
                and after <= MAX_REMAINING_SHARE * min(size, 1.0)
                and (kind not in SENSOR_FAULTS or after <= allowed.get(name, allowed.get(ERRORS[name], math.inf)))
                and not _makes_motion_still(rows, undone, name, after)
            ):
                explains[name] = (size, after)
        cause = Cause(kind, text, explains)
        # The first hypothesis of a kind is the simplest: another must leave far less.
        if explains and (
            kind not in found or _remaining_share(cause) < FAR_BETTER_FACTOR * _remaining_share(found[kind])
        ):
            found[kind] = cause
    ranked = sorted(found.values(), key=lambda cause: (-len(cause.explains), _remaining_share(cause)))
    return tuple(cause for cause in ranked if not _is_beaten(cause, [other for other in ranked if other is not cause]))


def _makes_motion_still(table: TableComparison, undone: TableComparison, name: str, after: float) -> bool:
    """True if undoing a slip explains an error only because the exact motion then stands still, too.

    Args:
        undone: the table without the slip.
        after: the normalised error that undoing it leaves.
    """
    travel = _travel(undone, name)
    return travel < _travel(table, name) and after >= MAX_REMAINING_SHARE * travel


def _travel(table: TableComparison, name: str) -> float:
    """Largest normalised travel, in the exact motion, of the columns that an error is computed from."""
    travels = [0.0]
    if name in ROTATIONS:
        return 1.0 if table.links(name) else 0.0
    for point in table.points(name):
        exact = getattr(
            (table.motion_at_nominal_crank if name == "total" else table.motion_at_own_crank).point(point), ERRORS[name]
        )
        axes = list(table.axes(name, point))
        travels.append(float(np.ptp(exact[:, axes], axis=0).max()) / table.normalising_size(name, point))
    return max(travels)


def _is_beaten(cause: Cause, better: Sequence[Cause]) -> bool:
    """True if other causes explain every error that this cause explains, and leave far less of each.

    A fault of sensors has unknowns in each column, and so fits better by itself, as two lengths do: a cause of another
    kind explains an error as well even if it leaves up to 1 / `FAR_BETTER_FACTOR` times as much. Another frame has two
    or three unknowns: a length that leaves as much is one number. A slide's offset is said rather than its length, and
    a frame rather than points of the ground.
    """

    def beats(other: Cause) -> bool:
        factor = FAR_BETTER_FACTOR
        if (other.kind, cause.kind) in AS_GOOD_WITH_FEWER:
            factor = AS_GOOD_FACTOR
        elif other.kind not in (*MANY_UNKNOWNS, LENGTH, GROUND_POINT) and cause.kind in MANY_UNKNOWNS:
            factor = 1.0 / FAR_BETTER_FACTOR
        return _remaining_share(other) < factor * _remaining_share(cause)

    return all(any(name in other.explains and beats(other) for other in better) for name in cause.explains)


def _remaining_share(cause: Cause) -> float:
    """Largest share of an explained error that remains; below `FULLY_EXPLAINED` it counts as rounding."""
    return max(FULLY_EXPLAINED, *(after / before for before, after in cause.explains.values()))


# -- slips -----------------------------------------------------------------------------------------------------------


def _hypotheses(table: TableComparison, wrong: Collection[str]) -> Iterator[Hypothesis]:
    """Undo each slip that a table may suffer from; within one kind the simplest comes first."""
    if stuck := stuck_rows(table):
        yield STUCK, stuck_words(table, stuck), replace_stuck(table, stuck), ERRORS
    yield from _unit_slips(table)
    opposite = table.scene.with_parameters(speed=-table.scene.speed)
    backwards = replace(table.scale_columns(-1.0, *CRANK), scene=opposite)
    yield "opposite sense", "the crank turns in the opposite sense", backwards, ALL_ERRORS
    other = str.maketrans(AXES, AXES[::-1])
    swapped = {f"{n[:-1]}{n[-1].translate(other)}" if "." in n else n: values for n, values in table.values.items()}
    yield "axes swapped", "x and y are swapped", replace(table, values=swapped), ERRORS
    if "total" in wrong or "position" in wrong:
        yield from _frame_slips(table)
    yield from _time_slips(table, wrong)
    yield from slide_hypotheses(table)
    yield from length_hypotheses(table)
    yield from link_hypotheses(table)
    yield from sensor_hypotheses(table)


def _unit_slips(table: TableComparison) -> Iterator[Hypothesis]:
    """Yield hypotheses of mistaken units, of lengths, angles and the crank's speed."""
    moving = [name for name in table.values if "." in name]
    for factor, slip in factors_both_ways(LENGTH_SLIPS):
        scaled = table.scale_columns(1.0 / factor, *moving)
        yield "length unit", f"lengths are {factor:.6g} times too large: {slip}", scaled, ERRORS
    for factor, slip in factors_both_ways(ANGLE_SLIPS) if CRANK_ANGLE in table.values else ():
        scaled = table.scale_columns(1.0 / factor, *CRANK)
        yield "angle unit", f"crank angles are {factor:.6g} times too large: {slip}", scaled, ALL_ERRORS
    # Positions alone: at another speed, velocities are others too.
    concerns = ("total",) if CRANK_ANGLE in table.values else ("total", "position")
    for factor, slip in factors_both_ways(SPEED_SLIPS):
        scaled = table.scale_columns(factor, TIME)
        yield "speed unit", f"the crank turns at {factor:.6g} times the nominal speed: {slip}", scaled, concerns


def _frame_slips(table: TableComparison) -> Iterator[Hypothesis]:
    """Undo another origin, and another origin with turned axes, by least squares."""
    axes = {point: list(table.axes("position", point)) for point in table.points("position")}
    if not _has_enough_numbers(table, 2):
        return

    def weighted_mean(values: Mapping[str, Array]) -> complex:
        """Mean of series (T,) of points, x + i y or real, over all rows and points, with weights 1 / L^2."""
        weights = [table.scene.lengths[point] ** -2 for point in values]
        return complex(np.average([own.mean() for own in values.values()], weights=weights)) if values else 0j

    off = {point: table.difference("position", point) for point in axes}
    x, y = (weighted_mean({p: off[p][:, own.index(k)] for p, own in axes.items() if k in own}).real for k in (0, 1))
    yield _undo_frame(table, complex(x, y), 0.0)
    every = [table.axes(name, point) for name in ERRORS for point in table.points(name)]
    if any(len(own) == 1 for own in every) or not _has_enough_numbers(table, 3):
        return
    found = {p: table.values[f"{p}.x"] + 1j * table.values[f"{p}.y"] for p in axes}
    exact = {p: found[p] - off[p] @ [1.0, 1.0j] for p in axes}
    middle, centre = weighted_mean(exact), weighted_mean(found)
    turn = float(np.angle(weighted_mean({p: np.conj(exact[p] - middle) * (found[p] - centre) for p in axes})))
    yield _undo_frame(table, centre - complex(np.exp(1j * turn)) * middle, turn)


def _undo_frame(table: TableComparison, offset: complex, turn: float) -> Hypothesis:
    """Transform a table from a frame that is offset [m] and turned [rad] into the scene's."""
    values, back = dict(table.values), np.exp(-1j * turn)
    for name in table.values:
        owner, axis = name[:-1], name[-1]
        if "." in name:
            moved = 1.0 if owner.endswith(".") else 0.0
            x, y = (table.values.get(f"{owner}{one}", np.zeros(1)) for one in AXES)
            both = ((x - moved * offset.real) + 1j * (y - moved * offset.imag)) * back
            values[name] = both.real if axis == "x" else both.imag
    values |= {name: table.values[name] - turn for name in table.rotation_columns if name.startswith("angle")}
    turned = f" and turned by {math.degrees(turn):.6g} deg" if turn else ""
    text = f"the table's frame is offset by ({1e3 * offset.real:.6g}, {1e3 * offset.imag:.6g}) mm{turned}"
    return "frame", text, replace(table, values=values), ALL_ERRORS


def _has_enough_numbers(table: TableComparison, unknowns: int) -> bool:
    """True if a table has enough positions to fit a number of unknowns."""
    numbers = sum(len(table.axes("position", point)) for point in table.points("position")) * len(table.times)
    return numbers >= MIN_NUMBERS_PER_UNKNOWN * unknowns


def _time_slips(table: TableComparison, wrong: Collection[str]) -> Iterator[Hypothesis]:
    """Yield hypotheses of wrong time: crank zero, clock offset, a shift of velocities or accelerations alone."""
    scene, shifts = table.scene, []
    # One pass has no turn in which to look anywhere: most of it the linkage does not reach.
    turns = scene.kinematics.mechanism.driver.span is None and _has_enough_numbers(table, 1)
    if turns and CRANK_ANGLE in table.values and "position" in wrong:
        by, *_ = best_crank_shift(table, "position")
        shifts.append(by / scene.speed)
        text = f"the table's crank angle is 0 where the scene's is {math.degrees(by):.6g} deg"
        yield "crank zero", text, shift_crank(table, by), ALL_ERRORS
    if turns and "total" in wrong:
        clock = best_crank_shift(table, "total")[0] / scene.speed
        shifts.append(clock)
        off = f"(or the crank is {math.degrees(abs(clock * scene.speed)):.4g} deg off)"
        # Where the table has a crank angle of its own, its clock says nothing of that.
        text = f"each row belongs {_steps_words(clock, table)} than its time says {off}"
        yield "time offset", text, table.shift_time(clock), ALL_ERRORS
    for name in ("velocity", "acceleration"):
        stamp = _fit_stamp(name, table) if name in wrong else None
        if stamp is not None and all(abs(stamp - known) > SAME_STAMP * abs(stamp) for known in shifts):
            text = f"each {name} belongs {_steps_words(stamp, table)} than its row says"
            yield f"{name} stamp", text, table.shift_time(stamp), (name,)


def _fit_stamp(name: str, table: TableComparison) -> float | None:
    """Time [s] by which a quantity's values belong later than their rows say, by least squares.

    Returns:
        None where the best shift is at half a turn, the end of what is tried.
    """
    period, still = table.scene.period, table.normalised_differences(name).ravel()

    def errors(by: Array) -> Array:
        try:
            return table.shift_time(float(by[0]) * period).normalised_differences(name).ravel()
        except InvalidInput:  # the linkage does not come to where the crank would then be
            return np.full_like(still, OUT_OF_REACH_ERROR)

    bounds = (-MAX_STAMP_PERIODS, MAX_STAMP_PERIODS)
    found = least_squares(
        errors, [0.0], jac="3-point", bounds=bounds, xtol=SOLVER_TOLERANCE, ftol=SOLVER_TOLERANCE, gtol=SOLVER_TOLERANCE
    )
    return float(found.x[0]) * period if abs(found.x[0]) < 0.99 * MAX_STAMP_PERIODS else None


def _steps_words(by: float, table: TableComparison) -> str:
    """Describe a time shift in seconds and steps, as '0.001 s (0.5 of a step) later'."""
    step = float(np.median(np.diff(table.times)))
    return f"{abs(by):.4g} s ({abs(by) / step:.3g} of a step) {'later' if by > 0 else 'earlier'}"
