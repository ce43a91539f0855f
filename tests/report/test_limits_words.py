"""Words and tables of the report of limits: every figure in them is from the walks."""

from __future__ import annotations

from dataclasses import replace

from limit_walks import SCENE, detected, limit_study, mass_walks, pose_walks, saved, steps_walks

from conrod.report.limits.tables import limits_table, repeated_words, undetected_table, undetected_words
from conrod.studies.limits.determinism import RUNS


def test_how_far_each_preset_can_be_relied_on_has_a_row_for_each_walk() -> None:
    rows = limits_table([*steps_walks(), *mass_walks(), *pose_walks()]).rows
    beyond = "wrong (undetected), flipped (undetected), opened (undetected)"
    assert rows[3] == ("steps", "pymunk", "stock", "20000 .. 2 steps", "400 steps", "80 steps", beyond)
    assert rows[0][4] == "none of it"
    assert rows[8][3:6] == ("1 .. 1e-06", "1e-05", "1e-05")
    assert rows[9][3:] == ("72 values", "69 of 72", "69 of 72", "flipped (undetected)")
    assert undetected_words(steps_walks()) == "15 of 86 runs, on 2 of 5 walks"
    assert not limits_table([])


def test_undetected_runs_in_one_piece_come_before_all() -> None:
    rows = undetected_table(limit_study().walks).rows
    levels = [str(row[1]).partition(",")[0] for row in rows]
    assert levels == sorted(levels, key=["wrong", "broken", "unbounded"].index)
    # Negative control: there is no row where no run is undetected.
    assert not undetected_table(detected(limit_study().walks))


def test_an_undetected_stretch_has_its_place_its_kind_and_its_error() -> None:
    row = undetected_table(steps_walks()).rows[0]
    assert row[:2] == ("steps", "wrong, ran to its end")
    assert "pymunk stock: 79 .. 20 steps" in str(row[2])
    assert row[3] == "0.70"


def test_determinism_names_what_was_different() -> None:
    one, two = saved(SCENE).determinism[:2]
    other = replace(one, fingerprints={**one.fingerprints, RUNS[-1]: "f" * 64})
    assert repeated_words([other, two]) == [
        "The same to the last bit: MuJoCo tuned.", "MuJoCo stock: different in another process."
    ]  # fmt: skip
