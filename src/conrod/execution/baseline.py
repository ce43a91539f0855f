"""Baselines: a validation's results in a small file, with the rounding band of each number; drift from them."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby
from pathlib import Path
from typing import Any

import msgspec

from conrod.comparison.plain_values import json_document, plain_values, restore
from conrod.errors import InvalidInput
from conrod.exact.link_rotations import ROTATIONS
from conrod.execution.writing import single_file, write_together

SCHEMA, MARK = 1, "conrod_baseline"
LAST_BIT = 2.0**-52
# Runs at speeds that differ in the last bits round otherwise at every step, as another processor or compiler does.
SPEED_FACTORS = (1.0 - 2.0 * LAST_BIT, 1.0 - LAST_BIT, 1.0 + LAST_BIT, 1.0 + 2.0 * LAST_BIT)
# Student's t for as many deviations as there are factors: one in a million is larger.
BAND_DEVIATIONS = 49.46
MIN_RELATIVE_BAND = (
    8.0 * LAST_BIT
)  # of a number, or of 1, which errors are differences of numbers of: a band is never narrower
ERROR_FLOOR = 1e-12  # normalised errors below it are rounding, and count as it
ORDER_PREFIX = "order of "
PATH = "path"  # how far a body goes in a run: no error, so that more is neither better nor worse
MAX_NAMED_DIFFERENCES = 3  # differences that a message has room for


@dataclass(frozen=True)
class BandedNumber:
    """A number and its band: a change within the band is rounding."""

    value: float
    band: float


@dataclass(frozen=True)
class BaselineLine:
    """Entry of a baseline for one result.

    Attributes:
        passed: the verdict by the law, or by the tolerance asked for; None where nothing is judged.
        numbers: errors by quantity, and observed orders.
    """

    outcome: str
    passed: bool | None
    numbers: Mapping[str, BandedNumber]
    settings: Mapping[str, Any]


@dataclass(frozen=True)
class KeptCost:
    """CPU time of a step over the time of the engine's reference loop, as median and interval."""

    ratio: float
    low: float
    high: float


@dataclass(frozen=True)
class Baseline:
    """All results of a validation.

    Attributes:
        of: arguments of the validation, as the command names them.
        hash: digest of that and of the scene.
        made_with: versions and platform.
        results: results by engine and preset, or by the label of a run.
        costs: costs of these runs, by the same names; empty if they were not asked for.
    """

    of: Mapping[str, Any]
    hash: str
    made_with: Mapping[str, str]
    results: Mapping[str, BaselineLine]
    costs: Mapping[str, KeptCost] = field(default_factory=dict)


def read_baseline(file: Path) -> Baseline:
    """Read the baseline in a file; raise InvalidInput if this conrod cannot read it."""
    try:
        values = json.loads(file.read_bytes())
    except OSError as error:
        raise InvalidInput(f"cannot read {file}: {error.strerror or error}") from None
    except (ValueError, RecursionError):
        values = None
    if not isinstance(values, dict) or MARK not in values:
        raise InvalidInput(f"{file} is no baseline of conrod")
    if values[MARK] != SCHEMA:
        raise InvalidInput(f"{file} is a baseline of schema {values[MARK]}, and this conrod reads {SCHEMA}: delete it")
    try:
        found = restore(Baseline, values)
        _check_numbers(found)
    except InvalidInput as error:
        raise InvalidInput(f"{file} is a damaged baseline, delete it: {error}") from None
    return found


def _check_numbers(baseline: Baseline) -> None:
    """Refuse numbers that conrod never writes: a band that is NaN would let every drift pass."""
    for name, line in baseline.results.items():
        for what, number in line.numbers.items():
            if not math.isfinite(number.value):
                raise InvalidInput(f"{name}: {what} is {number.value}, no number")
            if not 0.0 < number.band < math.inf:
                raise InvalidInput(f"{name}: the band of {what} is {number.band}: it has to be above 0, and finite")
    for name, cost in baseline.costs.items():
        if not 0.0 < cost.low <= cost.ratio <= cost.high < math.inf:
            raise InvalidInput(f"{name}: its cost is {cost.ratio} in {cost.low} to {cost.high}, no interval above 0")


def write_baseline(file: Path, baseline: Baseline) -> None:
    """Write a baseline, whole or not at all, with a number and its band on one line for readable diffs."""
    values = plain_values(baseline)
    if not baseline.costs:
        del values["costs"]
    text = json_document({MARK: SCHEMA, **values})
    text = re.sub(r"[\[{][^\[\]{}]{,120}[\]}]", lambda found: re.sub(r"\n\s*", " ", found[0]), text)
    write_together([single_file(file, text)])


def with_bands(now: Baseline, others: Sequence[Mapping[str, BaselineLine]], like: Mapping[str, str]) -> Baseline:
    """Return a baseline with bands from the scatter of runs at speeds that differ in the last bits.

    Args:
        others: results at the scene's speed times each of `SPEED_FACTORS`.
        like: results that the scene's speed does not drive, each with the result whose band it takes over.
    """

    def spread(name: str, quantity: str) -> float:
        lines = [results[name].numbers for results in (now.results, *others)]
        first, *found = [numbers[quantity].value for numbers in lines if quantity in numbers] or [0.0]
        return math.sqrt(sum((value - first) ** 2 for value in found) / max(len(found), 1))

    def number(name: str, quantity: str, value: float) -> BandedNumber:
        widest = max(spread(one, quantity) for one in (name, like.get(name, name)))
        exponent = math.ceil(math.log10(max(BAND_DEVIATIONS * widest, MIN_RELATIVE_BAND * max(1.0, abs(value)))))
        return BandedNumber(
            float(f"{value:.{max(0, _decimal_exponent(value) - exponent + 1)}e}"), float(f"1e{exponent}")
        )

    return replace(
        now,
        results={
            name: replace(line, numbers={q: number(name, q, one.value) for q, one in line.numbers.items()})
            for name, line in now.results.items()
        },
    )


def _decimal_exponent(value: float) -> int:
    """Power of ten of a number's first digit; 0 for 0."""
    return math.floor(math.log10(abs(value))) if value else 0


# -- drift -------------------------------------------------------------------------------------------------------------


class OtherBaseline(InvalidInput):
    """The baseline file belongs to another scene or other settings, and may be overwritten."""


@dataclass(frozen=True)
class Drift:
    """A result that differs from its baseline by more than rounding.

    Attributes:
        result: engine and preset, or the label of the run.
        what: what differs: a number, a setting of the engine, or `outcome`.
        was, now: its values as text.
        digits: decimal logarithm of the change over the rounding band of the number; None if the result is no number.
        better: whether an error became smaller; None if the result is no error.
    """

    result: str
    what: str
    was: str
    now: str
    digits: float | None = None
    better: bool | None = None

    def __str__(self) -> str:
        sense = {True: "better, ", False: "worse, ", None: ""}[self.better]
        by = "" if self.digits is None else f": {sense}drifted by {self.digits:.1f} digits"
        return f"{self.result}: {self.what} {self.now}, was {self.was}{by}"


@dataclass(frozen=True)
class CostChange:
    """Cost of a run over that in its baseline.

    Attributes:
        result: engine and preset.
        ratio: cost now over cost then.
        low, high: interval of the ratio, by those of both costs.
        allowed: ratio above which it fails; None if it is not judged.
    """

    result: str
    ratio: float
    low: float
    high: float
    allowed: float | None = None

    @property
    def exceeded(self) -> bool:
        """True if the whole interval is above the allowed ratio: noise is no verdict."""
        return self.allowed is not None and self.low > self.allowed

    def __str__(self) -> str:
        judged = f", allowed {self.allowed:g}" if self.exceeded else ""
        return f"{self.result}: costs {self.ratio:.2f} of the baseline's ({self.low:.2f} to {self.high:.2f}){judged}"


@dataclass(frozen=True)
class BaselineComparison:
    """Comparison of findings with their baseline.

    Attributes:
        written: whether the file was written, for the first time or again.
        accepted: whether the user accepted the findings.
        drifts: drifts from the results in the file.
        versions: versions that differ from those in the file, in words.
        costs: costs over those in the file, of runs that have both.
    """

    file: Path
    written: bool = False
    accepted: bool = False
    drifts: tuple[Drift, ...] = ()
    versions: tuple[str, ...] = ()
    costs: tuple[CostChange, ...] = ()

    @property
    def passed(self) -> bool:
        """True if an existing baseline shows no drift and no exceeded cost, or these were accepted."""
        return self.accepted or not (self.written or self.drifts or any(one.exceeded for one in self.costs))

    @property
    def text(self) -> str:
        """Comparison in words, the drifts first; empty without a drift or a new baseline."""
        lines = [f"drifted from the baseline {self.file}:"] if self.drifts else []
        for _, same in groupby(self.drifts, key=lambda drift: drift.result):
            worst, *others = sorted(same, key=lambda drift: -(drift.digits or math.inf))
            lines.append(f"  {worst}" + (f" ({', '.join(one.what for one in others)} too)" if others else ""))
        lines += [f"{'too slow: ' if one.exceeded else ''}{one}" for one in self.costs]
        if self.versions and (self.drifts or any(one.exceeded for one in self.costs)):
            lines.append(f"the baseline was made with {', '.join(self.versions)}")
        if self.written:
            first = f"no baseline yet: {self.file} is written, look at it, keep it, run again"
            lines.append(f"baseline {self.file} is written" if self.accepted else first)
        return "\n".join(lines)


def check_same_request(file: Path, before: Baseline, now: Baseline) -> None:
    """Raise OtherBaseline if the baseline is of another scene or request; the message names the differences."""
    if before.hash != now.hash:
        found = [f"{name} {was}, here {here}" for name, was, here in _differences(before.of, now.of)]
        words = "; ".join(found[:MAX_NAMED_DIFFERENCES] or ["another scene of that name"]) + (
            "; ..." if found[MAX_NAMED_DIFFERENCES:] else ""
        )
        raise OtherBaseline(f"the baseline is of something else: {words} ({file}; accept it to have it written again)")


def compare_baselines(file: Path, before: Baseline, now: Baseline) -> BaselineComparison:
    """Compare results with the baseline in a file."""
    drifts = tuple(drift for name in {**before.results, **now.results} for drift in _result_drifts(name, before, now))
    was = before.made_with
    versions = [f"{k} {was[k]}, now {now.made_with.get(k)}" for k in was if now.made_with.get(k) != was[k]]
    return BaselineComparison(file, drifts=drifts, versions=tuple(versions))


def compare_costs(before: Baseline, now: Baseline, allowed: float | None) -> tuple[CostChange, ...]:
    """Compare the costs of runs that both baselines have."""
    pairs = [(name, before.costs[name], cost) for name, cost in now.costs.items() if name in before.costs]
    return tuple(
        CostChange(name, cost.ratio / was.ratio, cost.low / was.high, cost.high / was.low, allowed)
        for name, was, cost in pairs
    )


def _differences(was: Mapping[str, Any], now: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Names whose values differ, with both values as JSON text."""
    pairs = [(name, *(msgspec.json.encode(one.get(name)).decode() for one in (was, now))) for name in {**was, **now}]
    return [(name, one, other) for name, one, other in pairs if one != other]


def _result_drifts(name: str, before: Baseline, now: Baseline) -> Iterator[Drift]:
    was, own = before.results.get(name), now.results.get(name)
    if was is None or own is None:
        there = ["none" if one is None else "there" for one in (was, own)]
        yield Drift(name, "result", there[0], there[1])
    elif was.outcome != own.outcome:
        yield Drift(name, "outcome", was.outcome, own.outcome)
    else:
        # A setting that only one of two versions of conrod knows says nothing of the run.
        common = was.settings.keys() & own.settings.keys()
        settings = ({name: value for name, value in one.settings.items() if name in common} for one in (was, own))
        yield from (Drift(name, *differing) for differing in _differences(*settings))
        # Links' rotations and paths are in no baseline that was written before they were compared.
        younger = {*ROTATIONS, PATH} - was.numbers.keys()
        for what in (name for name in {**was.numbers, **own.numbers} if name not in younger):
            yield from _number_drift(name, what, was.numbers.get(what), own.numbers.get(what))


def _number_drift(name: str, what: str, was: BandedNumber | None, now: BandedNumber | None) -> Iterator[Drift]:
    if was is None or now is None:
        there = ["none" if one is None else f"{one.value:.3g}" for one in (was, now)]
        yield Drift(name, what, there[0], there[1])
        return
    is_error = not what.startswith(ORDER_PREFIX) and what != PATH
    floor = ERROR_FLOOR if is_error else -math.inf
    change = max(now.value, floor) - max(was.value, floor)
    if abs(change) > was.band:
        shown = min(17, max(2, _decimal_exponent(was.value) - _decimal_exponent(change) + 1))
        digits, better = math.log10(abs(change) / was.band), change < 0.0 if is_error else None
        yield Drift(name, what, f"{was.value:.{shown}g}", f"{now.value:.{shown}g}", digits, better)
