"""Today's records against the golden ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from tests.golden.record import Record, Value

# Of |a| or the unit of a number: some 450 of its last digits, room for another machine's order of summation.
TOLERANCE = 1e-13


@dataclass
class Comparison:
    """Numbers and words that were compared, and those that are not what they were.

    Attributes:
        identical, within: how many are equal to the last bit; how many are not, but to `TOLERANCE`.
        out: name -> what it was, what it is, difference in terms of what was allowed (inf where that has no size).
        missing, added: names of records, golden ones that are no more and new ones.
    """

    identical: int = 0
    within: int = 0
    changed: list[str] = field(default_factory=list)
    out: dict[str, tuple[object, object, float]] = field(default_factory=dict)
    missing: list[str] = field(default_factory=list)
    added: list[str] = field(default_factory=list)

    @property
    def count(self) -> int:
        """Values compared."""
        return self.identical + self.within + len(self.out)

    @property
    def passed(self) -> bool:
        """Whether nothing is out and every record is there; not so where nothing was compared."""
        return self.count > 0 and not (self.out or self.missing or self.added)

    @property
    def worst(self) -> str | None:
        """Name of what is furthest out."""
        return max(self.out, key=lambda name: self.out[name][2], default=None)

    def take(self, name: str, golden: object, now: object, unit: float) -> None:
        """Compare two values."""
        excess = _excess(golden, now, unit)
        if excess == 0.0:
            self.identical += 1
        elif excess <= 1.0:
            self.within += 1
            self.changed.append(name)
        else:
            self.out[name] = (golden, now, excess)


def compare(golden: Mapping[str, Value | Sequence[float]], now: Mapping[str, Record]) -> Comparison:
    """Compare records by name, columns value by value."""
    found = Comparison(missing=[name for name in golden if name not in now], added=[n for n in now if n not in golden])
    for name in golden.keys() & now.keys():
        before, after = golden[name], now[name]
        if not isinstance(before, list) or not isinstance(after.value, list):
            found.take(name, before, after.value, after.unit)
        elif len(before) != len(after.value):
            found.out[name] = (f"{len(before)} values", f"{len(after.value)} values", float("inf"))
        else:
            for index, pair in enumerate(zip(before, after.value, strict=True)):
                found.take(f"{name}[{index}]", *pair, after.unit)
    return found


def _excess(golden: object, now: object, unit: float) -> float:
    """Difference in terms of what is allowed: 0 of what is equal, inf of what has no difference."""
    if _is_number(golden) and _is_number(now):
        assert isinstance(golden, (int, float))
        assert isinstance(now, (int, float))
        if golden == now:
            return 0.0
        allowed = TOLERANCE * max(abs(golden), unit)
        # A difference that is not a number is out as well.
        return abs(golden - now) / allowed if allowed > 0.0 and abs(golden - now) >= 0.0 else float("inf")
    return 0.0 if type(golden) is type(now) and golden == now else float("inf")


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
