"""Laws of driven joints: their derivatives, where they begin and end, and texts that are none."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space.drive_laws import DriveLaw, parse_drive_law

STEP = 1e-5


@pytest.fixture
def table(tmp_path: Path) -> str:
    times = 0.3 + np.linspace(0.0, 2.0, 41)
    rows = "\n".join(f"{t!r},{math.sin(3.0 * t)!r}" for t in times.tolist())
    (tmp_path / "law.csv").write_text(f"time [s],angle [rad]\n{rows}\n")
    return f"table:{tmp_path / 'law.csv'}"


def law_from_text(text: str, unit: str = "rad", start: float = 0.3) -> DriveLaw:
    return parse_drive_law(text, unit, start, "crank")


def evaluate_law(law: DriveLaw, *times: float) -> Array:
    return law.derivatives(np.array(times))


@pytest.mark.parametrize("text", ["-45rpm", "sine:20deg,1.5Hz", "move:10deg,-90deg,2s", "hold", "TABLE"])
def test_drive_law_derivatives_match_differences(text: str, table: str) -> None:
    law, times = law_from_text(table if text == "TABLE" else text), np.linspace(0.05, 1.9, 23)
    here, ends = law.derivatives(times), [law.derivatives(times + side * STEP) for side in (-1.0, 1.0)]
    for order in (1, 2, 3):
        change = (ends[1][order - 1] - ends[0][order - 1]) / (2.0 * STEP)
        size = 1.0 + np.abs(here[order]).max()
        assert here[order] == pytest.approx(change, abs=1e-6 * size), order
        # Negative control: of a law whose rate changes, a derivative a fifth of a second later is another.
        changes = text not in ("hold", "-45rpm")
        assert (np.abs(law.derivatives(times + 0.2)[order] - here[order]).max() > 1e-2) == changes, order


@pytest.mark.parametrize(("text", "unit", "begin", "duration"), [
    ("60rpm", "rad", (0.3, 2.0 * math.pi), 1.0),
    ("50mm/s", "m", (0.3, 0.05), 20.0),
    ("sine:20deg,4Hz", "rad", (0.3,), 0.25),
    ("hold", "rad", (0.3, 0.0, 0.0, 0.0), math.inf),
    ("move:10deg,90deg,3s", "rad", (math.radians(10.0), 0.0, 0.0), 3.0),
    ("TABLE", "rad", (math.sin(0.9),), 2.0),
])  # fmt: skip
def test_drive_laws_have_stated_start_and_duration(
    text: str, unit: str, begin: tuple[float, ...], duration: float, table: str
) -> None:
    law = law_from_text(table if text == "TABLE" else text, unit)
    assert evaluate_law(law, 0.0)[: len(begin), 0] == pytest.approx(begin, abs=1e-15)
    assert law.duration == pytest.approx(duration)
    if text in ("TABLE", "move:10deg,90deg,3s"):
        end = evaluate_law(law, law.duration)[0, 0]
        assert evaluate_law(law, law.duration + 0.1, law.duration + 50.0).tolist() == [[end, end], *[[0.0, 0.0]] * 3]


def test_table_law_interpolates_by_quintic_spline(table: str) -> None:
    times = np.linspace(0.4, 1.6, 50)
    found, truth = law_from_text(table).derivatives(times), 3.0 * (times + 0.3)
    for order, bar in enumerate((1e-9, 1e-7, 1e-5, 1e-3)):
        exact = 3.0**order * np.sin(truth + 0.5 * math.pi * order)
        assert found[order] == pytest.approx(exact, abs=bar)


def test_drive_law_refuses_invalid_text_in_one_line(tmp_path: Path) -> None:
    tables = {
        "": "not enough values to unpack",
        "1,2\n2,3\n": "at least six rows",
        "\n".join(f"{k % 5},{k}" for k in range(9)): "rising times",
        "\n".join(f"{k},{'nan' if k == 3 else k}" for k in range(9)): "at least six rows of numbers",
    }
    texts = {
        "fast": "'fast' is not a number",
        "60mm/s": "'mm/s' is not a unit of rad/s",
        "sine:20deg": "is no drive law: give `60rpm`",
        "move:90deg,90deg,1s": "way of crank",
    }
    for number, content in enumerate(tables):
        (tmp_path / f"{number}.csv").write_text(content)
    for text, words in (texts | {f"table:{tmp_path}/{k}.csv": said for k, said in enumerate(tables.values())}).items():
        with pytest.raises(InvalidInput, match=words) as refused:
            law_from_text(text)
        assert "crank" in str(refused.value)
        assert "\n" not in str(refused.value)
