"""Drift: what of a validation is other than its baseline, beyond what rounding makes so."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import msgspec

from conrod.errors import InvalidInput
from conrod.studies.frame.baseline import Baseline, Number, exponent_of

NOISE = 1e-12  # normalised errors below it are rounding, and count as it
ORDER = "order of "
NAMED = 3  # differences that a message has room for


class OtherBaseline(InvalidInput):
    """A baseline of another scene, or of other settings: it is compared with nothing, and may be written again."""


@dataclass(frozen=True)
class Drift:
    """A result that is other than rounding makes it.

    Attributes:
        what: the number, a setting of the engine, or `outcome`.
        was, now: as a person reads them.
        digits: by which the change exceeds its band; None where there is no size.
        better: whether an error fell; None of what is no error.
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
class Held:
    """Findings held against their baseline.

    Attributes:
        written: whether the file was written, for the first time or again.
        accepted: whether that was asked for.
        drifts: from what the file had.
        other_bits: results that differ in bits alone.
        versions: that are others, in words.
    """

    file: Path
    written: bool = False
    accepted: bool = False
    drifts: tuple[Drift, ...] = ()
    other_bits: tuple[str, ...] = ()
    versions: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """True if nothing has drifted from a baseline that was there, or what has is accepted."""
        return self.accepted or not (self.written or self.drifts)

    @property
    def text(self) -> str:
        """What was found, the drifts first; empty where there is nothing to be said."""
        lines = []
        if self.drifts:
            lines.append(f"drifted from the baseline {self.file}:")
        for _, same in groupby(self.drifts, key=lambda drift: drift.result):
            worst, *others = sorted(same, key=lambda drift: -(drift.digits or math.inf))
            lines.append(f"  {worst}" + (f" ({', '.join(one.what for one in others)} too)" if others else ""))
        if self.other_bits:
            lines.append(f"other bits only, which is no failure: {', '.join(self.other_bits)}")
        if self.versions and (self.drifts or self.other_bits):
            lines.append(f"the baseline was made with {', '.join(self.versions)}")
        if self.written:
            first = f"no baseline yet: {self.file} is written, look at it, keep it, run again"
            lines.append(f"baseline {self.file} is written" if self.accepted else first)
        return "\n".join(lines)


def check_same(file: Path, before: Baseline, now: Baseline) -> None:
    """Refuse a baseline of another scene, or of other words; raises OtherBaseline, which names what differs."""
    found = [f"{name} {was}, here {here}" for name, was, here in _differing(before.of, now.of)]
    if before.hash != now.hash:
        words = "; ".join(found[:NAMED] or ["another scene of that name"]) + ("; ..." if found[NAMED:] else "")
        raise OtherBaseline(f"the baseline is of something else: {words} ({file}; accept it to have it written again)")


def compared(file: Path, before: Baseline, now: Baseline) -> Held:
    """What has drifted from the baseline in a file, and what has other bits alone."""
    drifts = tuple(drift for name in {**before.results, **now.results} for drift in _drifts(name, before, now))
    drifted, was = {drift.result for drift in drifts}, before.made_with
    bits = [name for name, one in now.results.items() if name not in drifted and one.bits != before.results[name].bits]
    versions = [f"{k} {was[k]}, now {now.made_with.get(k)}" for k in was if now.made_with.get(k) != was[k]]
    return Held(file, drifts=drifts, other_bits=tuple(bits), versions=tuple(versions))


def _differing(was: Mapping[str, Any], now: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Names whose values differ, with both as JSON has them, which has one kind of list."""
    pairs = [(name, *(msgspec.json.encode(one.get(name)).decode() for one in (was, now))) for name in {**was, **now}]
    return [(name, one, other) for name, one, other in pairs if one != other]


def _drifts(name: str, before: Baseline, now: Baseline) -> Iterator[Drift]:
    was, own = before.results.get(name), now.results.get(name)
    if was is None or own is None:
        yield Drift(name, "result", "none" if was is None else "there", "none" if own is None else "there")
    elif was.outcome != own.outcome:
        yield Drift(name, "outcome", was.outcome, own.outcome)
    else:
        for setting, one, other in _differing(was.settings, own.settings):
            yield Drift(name, setting, one, other)
        for what in {**was.numbers, **own.numbers}:
            if drift := _drift(name, what, was.numbers.get(what), own.numbers.get(what)):
                yield drift


def _drift(name: str, what: str, was: Number | None, now: Number | None) -> Drift | None:
    if was is None or now is None:
        texts = ["none" if one is None else f"{one.value:.3g}" for one in (was, now)]
        return Drift(name, what, texts[0], texts[1])
    floor = -math.inf if what.startswith(ORDER) else NOISE
    change = max(now.value, floor) - max(was.value, floor)
    if abs(change) <= was.band:
        return None
    shown = min(17, max(2, exponent_of(was.value) - exponent_of(change) + 1))
    digits, better = math.log10(abs(change) / was.band), None if what.startswith(ORDER) else change < 0.0
    return Drift(name, what, f"{was.value:.{shown}g}", f"{now.value:.{shown}g}", digits, better)
