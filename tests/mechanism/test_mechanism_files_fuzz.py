"""Whatever stands in a mechanism file: one clear error, or a mechanism that moves."""

from __future__ import annotations

import math
import random
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as some

from conrod.errors import InvalidInput
from conrod.mechanism.files.toml_file import parse
from conrod.scenes.described_scene import DescribedScene, scene_of
from tests.support import mutants
from tests.support.described import SHIPPED, tables

FEW = settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
# What is refused at once costs little.
MANY = settings(FEW, max_examples=100)

TEXTS = [path.read_bytes() for path in SHIPPED]
TABLES = [tables(path) for path in SHIPPED]
WORDS = (*mutants.TEXTS, *mutants.WORDS, "crank.A", "rod", "-1 kg", "1_000")
VALUES = some.one_of(
    some.none(),
    some.booleans(),
    some.integers(),
    some.floats(),
    some.text(max_size=20),
    some.sampled_from(WORDS),
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
        return mutants.one_line(error)
    mutants.moved(scene)
    return scene


@FEW
@given(some.dictionaries(some.sampled_from([*TABLES[0], "extra"]) | some.text(max_size=9), ANYTHING, max_size=8))
def test_any_tables(whole: dict[str, Any]) -> None:
    assert isinstance(outcome(whole), str)


@MANY
@given(some.sampled_from(TABLES), some.randoms(use_true_random=False), ANYTHING)
def test_a_shipped_file_with_anything_in_one_place(whole: dict[str, Any], chance: random.Random, value: Any) -> None:
    outcome(mutants.put(whole, chance.choice(mutants.places(whole)), value))


@FEW
@given(some.sampled_from(TABLES), some.randoms(use_true_random=False))
def test_a_shipped_file_with_one_entry_in_anothers_place(whole: dict[str, Any], chance: random.Random) -> None:
    ways = mutants.places(whole)
    outcome(mutants.put(whole, chance.choice(ways), mutants.at(whole, chance.choice(ways))))


@settings(FEW, max_examples=20)
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
@given(some.sampled_from(TEXTS), some.integers(0, 2**32), some.binary(max_size=6), some.booleans())
def test_a_shipped_file_with_other_bytes_or_cut_short(text: bytes, place: int, other: bytes, cut: bool) -> None:
    at = place % len(text)
    content = text[:at] + other + (b"" if cut else text[at + place % 7 :])
    try:
        whole = parse(content)
    except InvalidInput as error:
        mutants.one_line(error)
        return
    outcome(whole)


def test_the_shipped_files_are_mechanisms() -> None:
    # Negative control: the fuzz tests do get through to motion.
    assert all(isinstance(outcome(whole), DescribedScene) for whole in TABLES)
