"""Copies of mechanism files with something wrong in them, and what becomes of one: a line, or a machine that runs."""

from __future__ import annotations

import math
import random
import signal
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from conrod.engines import ENGINES, engine_named
from conrod.engines.engine import run_extent
from conrod.engines.run import run
from conrod.errors import InvalidInput
from conrod.mechanism.files import parse_toml
from conrod.scenes.described_scene import DescribedScene, scene_from_tables

LONGEST = 1500  # characters of a refusal
LONGEST_TIME = 20  # [s] of CPU time; a machine under load must not decide what hangs
STEPS = 40  # of a run, and a revolution: coarse on purpose
MOST_STEPS = 60

# Numbers that a file may have by a slip, or by ill will.
SLIPS = (0.0, -0.0, -1.0, 1, 1e-300, 5e-324, 1e-12, 1e-6, 1e3, 1e6, 1e12, 1e300, 1e308, math.inf, -math.inf, math.nan)
FACTORS = (-1.0, 0.0, 1e-9, 1e-3, 0.1, 0.5, 0.9, 0.999999, 1.000001, 1.1, 2.0, 10.0, 1e3, 1e9)
TEXTS = ("", " ", "a", "5 mm", "-5 mm", "1e400 m", "3 parsec", "40 rpm", "90 deg", "1 kg", "nan m", "1e308 m", "0x10 m")
WORDS = ("ground", "crank", "origin", "revolute", "prismatic", "gear", "rack", "rolling", "cam", "screw", "world", "P")
THINGS: tuple[Any, ...] = (None, True, [], {}, [0, 0], [0, 0, 0], ["1 m", 2], [[]], {"x": 1}, 10**400)

Tables = dict[str, Any]
Way = tuple[Any, ...]


def places(whole: Any, way: Way = ()) -> list[Way]:
    """All places in nested tables and lists, each as a sequence of keys."""
    inner = whole.items() if isinstance(whole, dict) else enumerate(whole) if isinstance(whole, list) else ()
    return [found for key, value in inner for found in [(*way, key), *places(value, (*way, key))]]


def value_at(whole: Any, way: Way) -> Any:
    """Value at a place."""
    for key in way:
        whole = whole[key]
    return whole


def set_value(whole: Any, way: Way, value: Any) -> Any:
    """Copy of tables with another value at one place."""
    if not way:
        return value
    copy = dict(whole) if isinstance(whole, dict) else list(whole)
    copy[way[0]] = set_value(copy[way[0]], way[1:], value) if len(way) > 1 else value
    return copy


def without_entry(whole: Any, way: Way) -> Any:
    """Copy of tables without the entry at one place."""
    copy = dict(whole) if isinstance(whole, dict) else list(whole)
    if len(way) == 1:
        del copy[way[0]]
    else:
        copy[way[0]] = without_entry(copy[way[0]], way[1:])
    return copy


# -- changes to tables -----------------------------------------------------------------------------------------------


def _numbers(whole: Tables) -> list[Way]:
    return [
        way
        for way in places(whole)
        if isinstance(value_at(whole, way), int | float | str) and quantity(value_at(whole, way))
    ]


def quantity(given: Any) -> tuple[float, str] | None:
    """Number and unit of a quantity; None for other values."""
    number, _, unit = str(given).partition(" ")
    try:
        return float(number), unit if isinstance(given, str) else ""
    except ValueError:
        return None


def _number(whole: Tables, way: Way, change: Callable[[float], float]) -> Tables:
    """Copy of tables with another number at one place, in the same unit."""
    number, unit = quantity(value_at(whole, way)) or (0.0, "")
    return set_value(whole, way, f"{change(number)!r} {unit}" if unit else change(number))


def slip(whole: Tables, chance: random.Random) -> Tables:
    """A number becomes another one, with or without its unit."""
    way, other = chance.choice(_numbers(whole)), chance.choice(SLIPS)
    return _number(whole, way, lambda _: other) if chance.random() < 0.7 else set_value(whole, way, other)


def scale_numbers(whole: Tables, chance: random.Random) -> Tables:
    """One to three numbers become multiples of themselves: most of the machines that this makes can be read."""
    for _ in range(chance.randint(1, 3)):
        factor = chance.choice([*FACTORS, chance.uniform(0.3, 3.0)])
        whole = _number(whole, chance.choice(_numbers(whole)), lambda number, factor=factor: number * factor)
    return whole


def nudge_number(whole: Tables, chance: random.Random) -> Tables:
    """A number moves by very little: nearly singular machines stay near, and exact coincidences break."""
    way, by = chance.choice(_numbers(whole)), chance.choice((-1.0, 1.0)) * 10.0 ** chance.uniform(-17.0, -2.0)
    return _number(whole, way, lambda number: number + by * max(abs(number), 0.1))


def out_of_scale(whole: Tables, chance: random.Random) -> Tables:
    """Numbers in another power of ten: one, some, or all lengths, as of units that were left out or mistaken."""
    factor = 10.0 ** chance.choice([k for k in range(-9, 10) if k])
    ways, some = _numbers(whole), chance.choice([1, 2, 0])
    lengths = [way for way in ways if str(value_at(whole, way)).endswith("m") or way[-1] in (0, 1)]
    for way in chance.sample(ways, some) if some else lengths:
        whole = _number(whole, way, lambda number: number * factor)
    return whole


def move_entry(whole: Tables, chance: random.Random) -> Tables:
    """Something becomes another thing, has the contents of another place or another name, or is missing."""
    way, other = chance.choice(places(whole)), chance.choice(places(whole))
    match chance.choice(("worded", "swapped", "dropped", "renamed")):
        case "worded":
            return set_value(whole, way, chance.choice([*TEXTS, *WORDS, *THINGS, *SLIPS]))
        case "swapped" if way[: len(other)] != other and other[: len(way)] != way:
            return dict(set_value(set_value(whole, way, value_at(whole, other)), other, value_at(whole, way)))
        case "renamed" if isinstance(way[-1], str):
            name = chance.choice([*WORDS, *TEXTS, *(w[-1] for w in places(whole) if isinstance(w[-1], str))])
            return dict(set_value(without_entry(whole, way), (*way[:-1], name), value_at(whole, way)))
        case _:
            return dict(without_entry(whole, way))


def break_text(text: bytes, chance: random.Random) -> bytes:
    """A line is missing, twice there or in the place of another one; some bytes are others; the end is missing."""
    lines, k = text.splitlines(keepends=True), chance.randrange(len(text))
    i, j = chance.randrange(len(lines)), chance.randrange(len(lines))
    match chance.choice(("lost", "twice", "exchanged", "bytes", "cut")):
        case "bytes":
            return text[:k] + chance.randbytes(chance.randint(0, 4)) + text[k + chance.randint(0, 4) :]
        case "cut":
            return text[:k]
        case "exchanged":
            lines[i], lines[j] = lines[j], lines[i]
        case kind:
            lines[i : i + 1] = [lines[i]] * (2 if kind == "twice" else 0)
    return b"".join(lines)


def mutant(path: Path, seed: int) -> bytes | Tables:
    """The changed copy of a file that a seed determines: its text, or its tables."""
    chance = random.Random(f"{path.name} {seed}")
    text = path.read_bytes()
    if chance.random() < 0.25:
        return break_text(text, chance)
    return chance.choice((slip, scale_numbers, scale_numbers, nudge_number, move_entry, move_entry))(
        parse_toml(text), chance
    )


# -- what becomes of them --------------------------------------------------------------------------------------------


def scene_or_refusal(given: bytes | Tables) -> DescribedScene | str:
    """The scene that a file or its tables describe, or the one line that refuses them."""
    try:
        return scene_from_tables(parse_toml(given) if isinstance(given, bytes) else given)
    except InvalidInput as error:
        return one_line(error)


def one_line(error: InvalidInput) -> str:
    """Text of a refusal, checked to be one line."""
    text = str(error)
    assert "\n" not in text
    assert 0 < len(text) <= LONGEST
    return text


def check_motion(scene: DescribedScene) -> None:
    """Check that the exact motion of a scene is finite."""
    low, high = scene.kinematics.span
    for point in scene.motion(np.linspace(low, high, 9), scene.speed).points.values():
        assert np.isfinite(point.position).all()


def outcomes_in_engines(scene: DescribedScene) -> list[str]:
    """How short runs of a scene end, with the first and the last preset of each engine."""
    ends = []
    for engine in map(engine_named, ENGINES):
        for preset in (min(engine.presets), max(engine.presets)):
            try:
                settings = engine.presets[preset](scene, STEPS)
                if engine.refusal(scene, settings):
                    continue
                start, revolutions = run_extent(scene, STEPS, MOST_STEPS / STEPS)
                ends.append(run(scene, settings, min(revolutions, MOST_STEPS / STEPS), start).outcome.slug)
            except InvalidInput as error:
                one_line(error)
                ends.append("refused")
    return ends


@contextmanager
def in_time(what: str, longest: float = LONGEST_TIME) -> Iterator[None]:
    """Fail if the context takes more than a CPU time [s]."""

    def late(*_: object) -> None:
        raise TimeoutError(f"{what} takes more than {longest} s")

    before = signal.signal(signal.SIGVTALRM, late)
    signal.setitimer(signal.ITIMER_VIRTUAL, longest)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def count_outcomes(path: Path, seeds: range, engines: bool) -> Counter[str]:
    """How many of a file's mutants were refused, and how many moved; those are stepped in both engines too."""
    warnings.simplefilter("error")
    ends: Counter[str] = Counter()
    for seed in seeds:
        with in_time(f"{path.name}, mutant {seed}"):
            found = scene_or_refusal(mutant(path, seed))
            if isinstance(found, DescribedScene):
                check_motion(found)
                if engines:
                    outcomes_in_engines(found)
            ends["valid" if isinstance(found, DescribedScene) else "refused"] += 1
    return ends
