"""Curves of moving machines: one line a preset, round ticks with zero, coordinates without a sign on zero."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

from conrod.engines import line_style
from conrod.report import numbers
from conrod.report.charts.styles import svg_stroke
from conrod.report.html.panels import axis_ticks
from conrod.report.html.parts import points_text, svg_number

MOVING = sorted((Path(__file__).parents[2] / "reports").rglob("figures/*-moving.svg"))
SIGNED_ZERO_OR_NOISE = re.compile(r"-0(?:\.0+)?(?![\d.])|\de-\d")


@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_live_curves_have_the_dashes_of_figures(engine: str) -> None:
    dashes = {preset: svg_stroke(engine, preset) for preset in ("stock", "tuned", "hardened")}
    for preset in ("stock", "tuned"):
        _, (on, off) = line_style(engine, preset).line
        assert f'stroke-dasharray="{1.5 * on:g} {1.5 * off:g}"' in dashes[preset]
    assert dashes["stock"] != dashes["tuned"]
    if engine == "mujoco":
        assert "dasharray" not in dashes["hardened"]


@pytest.mark.parametrize(
    ("low", "high", "names"),
    [
        (-203.0, 8.0, ["-200", "-100", "0"]),
        (-420.0, -408.0, ["-420", "-415", "-410"]),
        (-0.031, 0.042, ["-0.02", "0.00", "0.02", "0.04"]),
    ],
)
def test_ticks_are_round_with_zero_and_a_middle(low: float, high: float, names: list[str]) -> None:
    ticks, texts = axis_ticks(low, high)
    assert texts == names
    assert low <= ticks.min()
    assert ticks.max() <= high
    assert np.ptp(np.diff(ticks)) < 1e-9


def test_coordinates_have_no_noise_and_no_signed_zero() -> None:
    texts = [svg_number(one) for one in (-4.2633e-14, -0.04, 0.0, -0.06, 1234.56)]
    assert texts == ["0.0", "0.0", "0.0", "-0.1", "1234.6"]
    assert points_text([(-1e-14, 2.0), (3.14159, -0.0)]) == "0.0,2.0 3.1,0.0"
    # Negative control: the texts of before.
    assert SIGNED_ZERO_OR_NOISE.search(f"{-4.2633e-14:.5g}")
    assert SIGNED_ZERO_OR_NOISE.search(f"{-0.0:.1f} 2")


def test_committed_pictures_say_their_magnification() -> None:
    assert MOVING
    for file in MOVING:
        svg = file.read_text(encoding="utf-8")
        assert not SIGNED_ZERO_OR_NOISE.search(svg.partition("<text")[0]), file.name
        assert re.search(r">[^<>]* mm off(, drawn x 10\S*)?</text>", svg), file.name


def test_magnification_by_one_is_none() -> None:
    assert [numbers.magnification(power) for power in (0, 2, 7)] == [
        "not magnified", "magnified 100 times", "magnified 10⁷ times"
    ]  # fmt: skip
    assert math.isclose(float(numbers.power_of_ten(3)), 1e3)
