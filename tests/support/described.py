"""Mechanism files for tests: those that ship, and changes to them."""

from __future__ import annotations

import copy
import random
import tomllib
from pathlib import Path
from typing import Any

import conrod

CATALOGUE = Path(conrod.__file__).parent / "scenes" / "catalogue"
SLIDER_CRANK, FOUR_BAR = CATALOGUE / "slider-crank.toml", CATALOGUE / "swinging-four-bar.toml"
SHIPPED = sorted(CATALOGUE.glob("*.toml"))


def tables(path: Path = SLIDER_CRANK) -> dict[str, Any]:
    """Tables of a mechanism file."""
    return tomllib.loads(path.read_text(encoding="utf-8"))


def with_entry(path: Path, place: str, value: Any) -> dict[str, Any]:
    """The tables of a file with another value at a dotted place; None removes it."""
    whole = tables(path)
    *way, last = place.split(".")
    inside = whole
    for name in way:
        inside = inside.setdefault(name, {})
    if value is None:
        del inside[last]
    else:
        inside[last] = copy.deepcopy(value)
    return whole


def shuffle_declarations(given: Any, seed: int) -> Any:
    """The tables in another order of declaration, with the two points of each pin exchanged."""
    chance = random.Random(seed)
    if not isinstance(given, dict):
        return given
    names = list(given)
    chance.shuffle(names)
    turned = {name: shuffle_declarations(given[name], seed + 1) for name in names}
    if "connects" in turned and chance.random() < 0.5:
        turned["connects"] = turned["connects"][::-1]
    return turned
