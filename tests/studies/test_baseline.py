"""Baselines: what rounding leaves is no drift, and anything else is, with its size; files that are none are refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from conrod.execution.baseline import (
    BAND_DEVIATIONS,
    SPEED_FACTORS,
    BandedNumber,
    Baseline,
    BaselineLine,
    Drift,
    compare_baselines,
    read_baseline,
    with_bands,
    write_baseline,
)

ERROR, SPREAD = 4.6446e-5, 3e-13
FILE = Path("b.json")


def found(position: float = ERROR, **fields: Any) -> dict[str, BaselineLine]:
    numbers = {"position": BandedNumber(position, 0.0), "order of position": BandedNumber(2.0, 0.0)}
    return {"mujoco tuned": replace(BaselineLine("completed", True, numbers, {"tolerance": 0.0}), **fields)}


def baseline(results: dict[str, BaselineLine], **fields: Any) -> Baseline:
    return replace(Baseline({"scene": ["saw"], "preset": "tuned"}, "ab", {"mujoco": "4.0.0"}, results), **fields)


OTHERS = [found(ERROR + SPREAD), found(ERROR - SPREAD)] * 2  # which are rounded otherwise
KEPT = with_bands(baseline(found()), OTHERS, {})


def drifts(now: dict[str, BaselineLine]) -> tuple[Drift, ...]:
    return compare_baselines(FILE, KEPT, baseline(now)).drifts


def test_the_band_is_what_runs_that_round_otherwise_leave() -> None:
    position, order = KEPT.results["mujoco tuned"].numbers.values()
    assert BAND_DEVIATIONS * SPREAD <= position.band < 10.0 * BAND_DEVIATIONS * SPREAD
    # In the digits that are rounding's, and one more: files of two machines differ in few places.
    assert position.value == 4.6446e-05
    # What does not change by these at all still has eight last bits of 1.
    assert order.band == pytest.approx(1e-14)
    assert len({*SPEED_FACTORS, 1.0}) == len(OTHERS) + 1
    # A run that the speed does not drive takes the rounding of one that stands for it.
    alone = {"own": found()["mujoco tuned"]}
    own = with_bands(baseline(found() | alone), [one | alone for one in OTHERS], {"own": "mujoco tuned"})
    assert own.results["own"].numbers["position"].band == position.band


def test_what_is_within_its_band_is_no_drift_and_other_versions_are_said_beside_one() -> None:
    held = compare_baselines(FILE, KEPT, baseline(found(ERROR + 0.9e-10), made_with={"mujoco": "4.0.1"}))
    assert (held.passed, held.drifts, held.text) == (True, (), "")
    held = compare_baselines(FILE, KEPT, baseline(found(2.0 * ERROR), made_with={"mujoco": "4.0.1"}))
    assert held.text.splitlines()[-1] == "the baseline was made with mujoco 4.0.0, now 4.0.1"


@pytest.mark.parametrize(("change", "better"), [(1e-8, False), (-1e-8, True)])
def test_a_change_beyond_the_band_is_a_drift_of_so_many_digits_worse_or_better(change: float, better: bool) -> None:
    (drift,) = drifts(found(ERROR + change))
    assert (drift.what, drift.better) == ("position", better)
    assert drift.digits == pytest.approx(2.0, abs=0.01)
    assert f"was 4.645e-05: {'better' if better else 'worse'}, drifted by 2.0 digits" in str(drift)


def test_an_outcome_an_order_and_a_result_that_are_others_are_drifts() -> None:
    assert str(drifts(found(outcome="diverged", numbers={}))[0]) == "mujoco tuned: outcome diverged, was completed"
    lost = {"position": BandedNumber(ERROR, 0.0)}
    assert str(drifts(found(numbers=lost))[0]) == "mujoco tuned: order of position none, was 2"
    assert [drift.result for drift in drifts({"new": found()["mujoco tuned"]})] == ["mujoco tuned", "new"]
    # The same words, and another rule for the preset's settings.
    assert str(drifts(found(settings={"tolerance": 1e-8}))[0]) == "mujoco tuned: tolerance 1e-8, was 0.0"
    assert drifts(found(numbers=lost | {"order of position": BandedNumber(1.0, 0.0)}))[0].better is None


def test_errors_below_rounding_are_noise_and_one_that_leaves_it_is_not() -> None:
    noise = with_bands(baseline(found(1e-15)), [found(2e-15)] * len(SPEED_FACTORS), {})
    assert compare_baselines(FILE, noise, baseline(found(9e-13))).passed
    assert not compare_baselines(FILE, noise, baseline(found(2e-12))).passed


def test_a_baseline_comes_back_from_its_file_a_number_on_a_line(tmp_path: Path) -> None:
    file = tmp_path / "made" / "b.json"
    write_baseline(file, KEPT)
    assert read_baseline(file).results["mujoco tuned"] == KEPT.results["mujoco tuned"]
    assert '"position": { "value": 4.6446e-05, "band": 1e-10 }' in file.read_text(encoding="utf-8")
    assert [one.name for one in file.parent.iterdir()] == ["b.json"]
