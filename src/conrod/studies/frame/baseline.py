"""Baselines: what a validation found, in a small file, with the band in which rounding leaves each number."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from conrod.errors import InvalidInput
from conrod.runs.plain import json_document, plain, restore
from conrod.studies.frame.writing import single, write_together

SCHEMA, MARK = 1, "conrod_baseline"
LAST_BIT = 2.0**-52
# Runs at speeds that differ in the last bits round otherwise at every step, as another processor or compiler does.
FACTORS = tuple(1.0 + k * LAST_BIT for k in (-2, -1, 1, 2))
# Student's t of as many deviations, of which one in a million is larger.
DEVIATIONS = 49.46
ROUNDED = 8.0 * LAST_BIT  # of a number, or of 1, which errors are differences of numbers of: a band is never narrower


@dataclass(frozen=True)
class Number:
    """A number, and the band in which rounding leaves it."""

    value: float
    band: float


@dataclass(frozen=True)
class Line:
    """What a baseline keeps of one result.

    Attributes:
        passed: the verdict by the law, or by the tolerance asked for; None where nothing is judged.
        numbers: errors by quantity, and observed orders.
        bits: digest of all that the run showed.
        cost: CPU time of a revolution, over the engine's fixed reference loop; never compared.
    """

    outcome: str
    passed: bool | None
    numbers: Mapping[str, Number]
    bits: str
    settings: Mapping[str, Any]
    cost: float | None = None


@dataclass(frozen=True)
class Baseline:
    """All results of a validation.

    Attributes:
        of: what was asked for, in the words of the command.
        hash: digest of that and of the scene.
        made_with: versions and platform.
        results: by engine and preset, or by the label of a run.
    """

    of: Mapping[str, Any]
    hash: str
    made_with: Mapping[str, str]
    results: Mapping[str, Line]


def read(file: Path) -> Baseline:
    """The baseline in a file; raises InvalidInput where there is none that this conrod can read."""
    try:
        values = json.loads(file.read_bytes())
    except OSError as error:
        raise InvalidInput(f"cannot read {file}: {error.strerror or error}") from None
    except ValueError:
        values = None
    if not isinstance(values, dict) or MARK not in values:
        raise InvalidInput(f"{file} is no baseline of conrod")
    if values[MARK] != SCHEMA:
        raise InvalidInput(f"{file} is a baseline of schema {values[MARK]}, and this conrod reads {SCHEMA}: delete it")
    try:
        return restore(Baseline, values)
    except InvalidInput as error:
        raise InvalidInput(f"{file} is a damaged baseline, delete it: {error}") from None


def write(file: Path, baseline: Baseline, costs: Mapping[str, float]) -> None:
    """Write a baseline, whole or not at all: a number and its band on a line, for those who read differences."""
    results = {name: replace(line, cost=costs.get(name)) for name, line in baseline.results.items()}
    text = json_document({MARK: SCHEMA, **plain(replace(baseline, results=results))})
    text = re.sub(r"[\[{][^\[\]{}]{,120}[\]}]", lambda found: re.sub(r"\n\s*", " ", found[0]), text)
    write_together([single(file, text)])


def banded(now: Baseline, others: Sequence[Mapping[str, Line]], like: Mapping[str, str]) -> Baseline:
    """A baseline with the bands that follow from runs that round otherwise, in the digits that rounding leaves.

    Args:
        others: results at the scene's speed times each of `FACTORS`.
        like: results that the scene's speed does not drive, and those whose rounding stands for theirs.
    """

    def spread(name: str, quantity: str) -> float:
        lines = [results[name].numbers for results in (now.results, *others)]
        first, *found = [numbers[quantity].value for numbers in lines if quantity in numbers] or [0.0]
        return math.sqrt(sum((value - first) ** 2 for value in found) / max(len(found), 1))

    def number(name: str, quantity: str, value: float) -> Number:
        widest = max(spread(one, quantity) for one in (name, like.get(name, name)))
        exponent = math.ceil(math.log10(max(DEVIATIONS * widest, ROUNDED * max(1.0, abs(value)))))
        return Number(float(f"{value:.{max(0, exponent_of(value) - exponent + 1)}e}"), float(f"1e{exponent}"))

    return replace(
        now,
        results={
            name: replace(line, numbers={q: number(name, q, one.value) for q, one in line.numbers.items()})
            for name, line in now.results.items()
        },
    )


def exponent_of(value: float) -> int:
    """Power of ten of the first digit; 0 of 0."""
    return math.floor(math.log10(abs(value))) if value else 0
