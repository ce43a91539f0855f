"""What people commonly get wrong in a table: how it would be without each of these."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from conrod.exact.motion import Array
from conrod.own.tables.alignment import Alignment
from conrod.own.tables.fit import Fit
from conrod.own.tables.gauss_newton import fitted
from conrod.own.tables.judging import ERRORS, Exact, shifted, stamp_of
from conrod.own.tables.samples import Observed, Samples
from conrod.scenes import Scene

GRAVITY, GRAVITY_WIDTH = 9.81, 0.02  # [m/s^2], relative
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
DEGREE, TURN, RPM = math.pi / 180.0, 2.0 * math.pi, math.pi / 30.0
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
# Fewer numbers for each unknown are fitted by almost anything.
NUMBERS_EACH = 3


@dataclass(frozen=True)
class Idea:
    """A slip to try.

    Attributes:
        kind: in a word or two.
        text: with its size.
        observed, alignment: the table as it would be without the slip.
        concerns: names of the errors that it may explain.
    """

    kind: str
    text: str
    observed: Observed
    alignment: Alignment
    concerns: tuple[str, ...] = ERRORS


def ideas(observed: Observed, scene: Scene, alignment: Alignment, wrong: Sequence[str]) -> Iterator[Idea]:
    """All slips that a table may suffer from; of one kind the simplest first.

    Args:
        wrong: names of the errors that are to be explained.
    """
    yield from _units(observed, alignment)
    opposite = replace(alignment, sense=-alignment.sense)
    yield Idea("opposite sense", "the crank turns in the opposite sense", observed, opposite)
    swapped = _changed(observed, lambda s: replace(s, axes=tuple(1 - axis for axis in s.axes)))
    yield Idea("axes swapped", "x and y are swapped", swapped, alignment)
    if "acceleration" in wrong:
        yield from _gravity(observed, scene, alignment)
    if "total" in wrong or "position" in wrong:
        yield from _frame(observed, scene, alignment)
    yield from _times(observed, scene, alignment, wrong)


def _changed(observed: Observed, change: Callable[[Samples], Samples]) -> Observed:
    points = {
        point: {quantity: change(samples) for quantity, samples in quantities.items()}
        for point, quantities in observed.points.items()
    }
    return replace(observed, points=points)


# -- units -----------------------------------------------------------------------------------------------------------


def _units(observed: Observed, alignment: Alignment) -> Iterator[Idea]:
    for factor, slip in LENGTHS.items():
        yield Idea(
            "length unit", f"lengths are {factor:.6g} times too large: {slip}", _scaled(observed, factor), alignment
        )
    if observed.angle is not None:
        for factor, slip in ANGLES.items():
            columns = (observed.angle, observed.rate, observed.acceleration)
            angle, rate, acceleration = (None if column is None else column / factor for column in columns)
            turned = replace(observed, angle=angle, rate=rate, acceleration=acceleration)
            yield Idea("angle unit", f"crank angles are {factor:.6g} times too large: {slip}", turned, alignment)
    # Positions alone: at another speed, velocities are others too.
    concerns = ("total",) if observed.angle is not None else ("total", "position")
    for factor, slip in SPEEDS.items():
        elapsed = (observed.times - alignment.time) * factor
        text = f"the crank turns at {factor:.6g} times the nominal speed: {slip}"
        yield Idea("speed unit", text, replace(observed, times=alignment.time + elapsed), alignment, concerns)


def _scaled(observed: Observed, factor: float) -> Observed:
    return _changed(observed, lambda samples: replace(samples, values=samples.values / factor))


# -- vectors ---------------------------------------------------------------------------------------------------------


def _gravity(observed: Observed, scene: Scene, alignment: Alignment) -> Iterator[Idea]:
    """A constant vector of the size of gravity in all accelerations."""
    along: tuple[list[Array], list[Array]] = ([], [])
    exact = Exact(observed, scene, alignment)
    for point, quantities in observed.points.items():
        if (samples := quantities.get("acceleration")) is not None:
            difference = exact.difference("acceleration", point)
            for column, axis in enumerate(samples.axes):
                along[axis].append(difference[:, column])
    constant = [float(np.mean(np.concatenate(parts))) if parts else 0.0 for parts in along]
    size = math.hypot(*constant)
    if abs(size / GRAVITY - 1.0) > GRAVITY_WIDTH:
        return
    direction = math.degrees(math.atan2(constant[1], constant[0]))
    without = _without(observed, constant)
    text = f"gravity is left in the accelerations: {size:.4g} m/s² at {direction:.0f} deg from x"
    yield Idea("gravity", text, without, alignment, ("acceleration",))


def _without(observed: Observed, constant: Sequence[float]) -> Observed:
    points = {}
    for point, quantities in observed.points.items():
        points[point] = dict(quantities)
        if (samples := quantities.get("acceleration")) is not None:
            values = samples.values - np.array([constant[axis] for axis in samples.axes])
            points[point]["acceleration"] = replace(samples, values=values)
    return replace(observed, points=points)


def _frame(observed: Observed, scene: Scene, alignment: Alignment) -> Iterator[Idea]:
    problem = Fit(observed, scene, "nominal" if observed.angle is None else "reached")
    for names in (["x", "y"], ["x", "y", "rotation"]):
        if not _tell(observed, names):
            return
        other = fitted(problem, alignment, names).alignment
        x, y = (1e3 * (there - here) for there, here in zip(other.offset, alignment.offset, strict=True))
        turn = math.degrees(math.remainder(other.rotation - alignment.rotation, TURN))
        turned = f" and turned by {turn:.6g} deg" if len(names) > 2 else ""
        yield Idea("frame", f"the table's frame is offset by ({x:.6g}, {y:.6g}) mm{turned}", observed, other)


def _tell(observed: Observed, names: Sequence[str]) -> bool:
    """Whether there are numbers enough to tell so many unknowns."""
    return sum(s["position"].values.size for s in observed.points.values() if "position" in s) >= NUMBERS_EACH * len(
        names
    )


# -- time ------------------------------------------------------------------------------------------------------------


def _times(observed: Observed, scene: Scene, alignment: Alignment, wrong: Sequence[str]) -> Iterator[Idea]:
    """The crank's zero and the clock, found from anywhere in the turn; then what alone belongs to other instants."""
    # One pass has no turn in which to look anywhere: most of it the linkage does not reach.
    turns = scene.kinematics.mechanism.driver.span is None
    shifts, told = [], turns and _tell(observed, ["time"])
    if told and observed.angle is not None and "position" in wrong:
        other = fitted(Fit(observed, scene, "reached"), alignment, ["zero"]).alignment
        by = math.remainder(other.zero - alignment.zero, TURN)
        shifts.append(by / (alignment.sense * scene.speed))
        text = f"the table's crank angle is 0 where the scene's is {math.degrees(by):.6g} deg"
        yield Idea("crank zero", text, observed, other)
    if told and "total" in wrong:
        other = fitted(Fit(observed, scene, "nominal"), alignment, ["time"]).alignment
        clock = -math.remainder(other.time - alignment.time, scene.period)
        shifts.append(clock)
        # Where the table has a crank angle of its own, its clock says nothing of that.
        alone = observed.angle is None
        moved = (shifted(observed, clock, scene), alignment) if alone else (observed, other)
        yield Idea("time offset", _late(clock, observed, scene), *moved)
    for name in ("velocity", "acceleration"):
        stamp = stamp_of(name, observed, scene, alignment) if name in wrong else None
        if stamp is not None and all(abs(stamp - known) > SAME_STAMP * abs(stamp) for known in shifts):
            text = f"each {name} belongs {_steps(stamp, observed)} than its row says"
            yield Idea(f"{name} stamp", text, shifted(observed, stamp, scene), alignment, (name,))


def _late(clock: float, observed: Observed, scene: Scene) -> str:
    phase = math.degrees(abs(clock * scene.speed))
    return f"each row belongs {_steps(clock, observed)} than its time says (or the crank is {phase:.4g} deg off)"


def _steps(stamp: float, observed: Observed) -> str:
    return f"{abs(stamp):.4g} s ({abs(stamp) / observed.step:.3g} of a step) {'later' if stamp > 0 else 'earlier'}"
