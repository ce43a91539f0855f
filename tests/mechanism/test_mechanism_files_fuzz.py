"""Whatever stands in a mechanism file: one clear error, or a mechanism that moves."""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as some

from conrod.errors import InvalidInput
from conrod.mechanism.files.toml_file import parse
from conrod.scenes.described_scene import DescribedScene, scene_of
from tests.support.described import SHIPPED, tables

FEW = settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
MANY = settings(FEW, max_examples=120)
LONGEST = 1500  # characters of a message

TEXTS = [path.read_bytes() for path in SHIPPED]
TABLES = [tables(path) for path in SHIPPED]

VALUES = some.one_of(
    some.none(),
    some.booleans(),
    some.integers(),
    some.floats(),
    some.text(max_size=20),
    some.sampled_from(
        [
            "5 mm",
            "-1 kg",
            "1e400 m",
            "3 parsec",
            "40 rpm",
            "ground",
            "crank.A",
            "rod",
            "revolute",
            "0x10",
            "1_000",
            "gear",
            "cam",
        ]
    ),
    some.sampled_from([10**500, 1e308, 5e-324, math.inf, -0.0, 1e-300]),
)
ANYTHING = some.recursive(
    VALUES,
    lambda inner: some.lists(inner, max_size=4) | some.dictionaries(some.text(max_size=8), inner, max_size=4),
    max_leaves=8,
)


def outcome(whole: Any) -> DescribedScene | str:
    """The scene that tables describe, moved once around; or the one line that refuses them."""
    try:
        scene = scene_of(whole)
    except InvalidInput as error:
        return one_line(error)
    low, high = scene.span or (0.0, 2.0 * math.pi)
    for point in scene.motion(np.linspace(low, high, 5), scene.speed).points.values():
        assert np.isfinite(point.position).all()
    return scene


def one_line(error: InvalidInput) -> str:
    """A refusal, seen to be one clear line."""
    text = str(error)
    assert "\n" not in text
    assert 0 < len(text) <= LONGEST
    return text


def places(whole: Any, way: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Where something stands in tables."""
    inner = whole.items() if isinstance(whole, dict) else enumerate(whole) if isinstance(whole, list) else ()
    return [found for key, value in inner for found in [(*way, key), *places(value, (*way, key))]]


def put(whole: Any, way: tuple[Any, ...], value: Any) -> Any:
    """A copy with another value in one place."""
    if not way:
        return value
    copy = dict(whole) if isinstance(whole, dict) else list(whole)
    copy[way[0]] = put(copy[way[0]], way[1:], value)
    return copy


@FEW
@given(some.dictionaries(some.sampled_from([*TABLES[0], "extra"]) | some.text(max_size=9), ANYTHING, max_size=8))
def test_any_tables(whole: dict[str, Any]) -> None:
    assert isinstance(outcome(whole), str)


@MANY
@given(some.sampled_from(TABLES), some.randoms(use_true_random=False), ANYTHING)
def test_a_shipped_file_with_anything_in_one_place(whole: dict[str, Any], chance: random.Random, value: Any) -> None:
    outcome(put(whole, chance.choice(places(whole)), value))


@FEW
@given(some.sampled_from(TABLES), some.randoms(use_true_random=False))
def test_a_shipped_file_with_one_entry_in_anothers_place(whole: dict[str, Any], chance: random.Random) -> None:
    ways = places(whole)
    taken: Any = whole
    for key in chance.choice(ways):
        taken = taken[key]
    outcome(put(whole, chance.choice(ways), taken))


@FEW
@given(some.sampled_from(TABLES), some.randoms(use_true_random=False), some.floats(0.2, 5.0))
def test_a_shipped_file_with_a_number_scaled(whole: dict[str, Any], chance: random.Random, factor: float) -> None:
    scene = scene_of(whole)
    name = chance.choice(sorted(scene.parameters))
    try:
        other = scene.with_parameters(**{name: factor * scene.parameters[name]})
    except InvalidInput:
        return
    assert other.parameters[name] == factor * scene.parameters[name]
    assert other.with_parameters(**{name: scene.parameters[name]}).parameters_text == scene.parameters_text


@MANY
@given(some.sampled_from(TEXTS), some.integers(0, 2**32), some.binary(min_size=1, max_size=6))
def test_a_shipped_file_with_other_bytes(text: bytes, place: int, other: bytes) -> None:
    at = place % len(text)
    mutated(text[:at] + other + text[at + place % 7 :])


@FEW
@given(some.sampled_from(TEXTS), some.integers(0, 2**32))
def test_a_shipped_file_cut_short(text: bytes, place: int) -> None:
    mutated(text[: place % len(text)])


@MANY
@given(some.binary(max_size=60) | some.text(max_size=60).map(str.encode))
def test_any_bytes(content: bytes) -> None:
    mutated(content)


def mutated(content: bytes) -> None:
    try:
        whole = parse(content)
    except InvalidInput as error:
        one_line(error)
        return
    outcome(whole)


def test_the_shipped_files_are_mechanisms() -> None:
    # Negative control: the fuzz tests do get through to motion.
    assert all(isinstance(outcome(whole), DescribedScene) for whole in TABLES)
