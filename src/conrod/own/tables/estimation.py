"""Time offset, crank phase, sense of rotation and frame of a table, estimated where a user asks for them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from conrod.errors import InvalidInput, unknown_choice
from conrod.own.tables.fitting import Fit, Fitted, fitted
from conrod.own.tables.samples import Alignment, Observed
from conrod.scenes import Scene

CHOICES = ("time", "phase", "sense", "frame")
FRAME = ("x", "y", "rotation")
# Rows that estimates are made from, evenly spread.
MOST_ROWS = 50_000
# Both senses fit alike where the better one leaves more than this share of what the other leaves.
SAME_FIT = 0.9
ROUNDING = 1e-12
# Name -> SI unit, meaning.
MEANING = {
    "time": ("s", "the table's clock minus the scene's"),
    "phase": ("rad", "crank angle at the scene's time 0"),
    "zero": ("rad", "crank angle where the table's crank angle is 0"),
    "x": ("m", "the scene's origin in the table's frame, x"),
    "y": ("m", "the scene's origin in the table's frame, y"),
    "rotation": ("rad", "turn of the scene's axes in the table's frame"),
}


@dataclass(frozen=True)
class Estimate:
    """One estimated quantity, SI.

    Attributes:
        error: its standard error, for errors of one size (relative to L) that are independent from row to row.
    """

    name: str
    value: float
    error: float

    @property
    def unit(self) -> str:
        """SI unit."""
        return MEANING[self.name][0]

    @property
    def meaning(self) -> str:
        """In words."""
        return MEANING[self.name][1]


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
