"""Sentences on a start that leaves loops open, and how violations of a run are taken."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from conrod.mjcf.request import MAX_POSE_NUMBERS, OpenStart
from conrod.models.lint.closures import MAX_BEARING_PLAY, _largest_violations

POSE = "0.1 0.2"


@pytest.mark.parametrize(
    ("others", "words"),
    [
        ((), ""),
        (("slide",), " (1 more closure open)"),
        (("slide", "weld"), " (2 more closures open)"),
        (("slide", "weld", "belt"), " (3 more closures open)"),
    ],
)
def test_open_start_names_the_widest_and_counts_the_rest(others: tuple[str, ...], words: str) -> None:
    start = OpenStart("keyframe home", dict.fromkeys(others, 1e-3) | {"pin": 0.0302}, 1.0, POSE)
    assert start.words() == (
        f'It begins 30.2 mm open: pin, in keyframe home{words}; the nearest closed pose is qpos="{POSE}".'
    )


def test_open_start_of_a_model_in_mm_is_said_in_mm() -> None:
    start = OpenStart("its own pose", {"pin": 2.5}, 1.0, POSE)
    assert start.words(unit=1e-3).startswith("It begins 2.5 mm open: pin, in its own pose; ")


@pytest.mark.parametrize(
    ("closed", "nearest"),
    [
        ("", "no pose near it closes them: look at lengths and places of the closures"),
        (" ".join("0" * MAX_POSE_NUMBERS), f'the nearest closed pose is qpos="{" ".join("0" * MAX_POSE_NUMBERS)}"'),
        (" ".join("0" * (MAX_POSE_NUMBERS + 1)), "`conrod lint` prints the nearest closed pose"),
    ],
)
def test_nearest_pose_is_given_unless_it_is_long_or_missing(closed: str, nearest: str) -> None:
    start = OpenStart("its own pose", {"pin": 0.01}, 1.0, closed)
    assert start.words() == f"It begins 10 mm open: pin, in its own pose; {nearest}."


def violations(*series: list[float], size: float = 1.0) -> list[float]:
    bench: Any = SimpleNamespace(constraint_violations=np.array(series).T, size=size)
    return _largest_violations(bench).tolist()


def test_closure_that_starts_open_is_judged_after_a_quarter() -> None:
    # 20 samples: the first 5 are a quarter; of a closure that starts closed all count.
    opened, closed = [0.5, 0.4, 0.3, 0.2, 0.11] + [0.01] * 15, [0.0, 0.5] + [0.0] * 18
    assert violations(opened, closed) == [0.01, 0.5]
    # At the end of the quarter, and not before: the fifth sample does not count, the sixth does.
    assert violations([0.5] * 5 + [0.3] + [0.0] * 14) == [0.3]


@pytest.mark.parametrize("size", [0.25, 1.0, 4.0])
def test_closure_counts_as_closed_up_to_bearing_play_of_the_size(size: float) -> None:
    limit = MAX_BEARING_PLAY * size
    late = [0.0] * 15
    assert violations([limit, 0.2, 0.0, 0.0, 0.0, *late], size=size) == [0.2]
    assert violations([limit * 1.001, 0.2, 0.0, 0.0, 0.0, *late], size=size) == [0.0]
