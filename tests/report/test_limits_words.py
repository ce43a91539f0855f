"""Words and tables of the report of limits: every figure in them is from the walks."""

from __future__ import annotations

from dataclasses import replace

from limit_walks import (
    SCENE,
    Part,
    detected,
    limit_study,
    mass_walks,
    probe,
    saved,
    steps_walks,
    walked,
)

from conrod.report.limits.tables import (
    boundaries_table,
    determinism_table,
    reach_table,
    steps_table,
    undetected_table,
    undetected_words,
)
from conrod.report.table import Toned
from conrod.studies.limits.determinism import RUNS
from conrod.studies.limits.results import Walk
from conrod.studies.limits.walk import CRITERIA, boundary_of


def test_how_far_ten_per_cent_holds_has_a_column_for_each_preset() -> None:
    found = reach_table([*steps_walks(), *mass_walks()])
    assert found.headings[2:] == ("MuJoCo stock", "MuJoCo tuned", "MuJoCo hardened", "pymunk stock", "pymunk tuned")
    steps, heavier, lighter = found.rows
    reached = ("200 steps, then undetected", "25 steps", "5 steps", "80 steps, then undetected", "25 steps")
    assert steps == ("Steps per revolution", "2 steps", *reached)
    assert (heavier[1:3], lighter[1:3]) == (("1e+06", "1500"), ("1e-06", "0.01, then undetected"))
    assert undetected_words(steps_walks()) == "15 of 86 runs, on 2 of 5 walks"
    assert not reach_table([])


def flickering() -> Walk:
    """Safe and opened in turn, from 100 on."""
    ends = [("safe", "completed", False, 1e-4), ("broken", "opened", True, None)]
    probes = tuple(probe(2.0**k, *ends[k % 2 if k > 3 else 0]) for k in range(12))
    return Walk("mass-ratio", SCENE, "pymunk", "stock", "", probes, tuple(boundary_of(probes, c) for c in CRITERIA))


def test_what_comes_and_goes_has_a_star() -> None:
    row = boundaries_table([flickering()]).rows[0]
    assert "16 *" in row
    assert row[-2:] == ("opened (undetected)", "32")
    assert not any(" *" in str(cell) for row in boundaries_table(steps_walks()).rows for cell in row)


# -- wrong and undetected ----------------------------------------------------------------------------------------------


def test_undetected_runs_in_one_piece_come_before_all() -> None:
    rows = undetected_table(limit_study().walks).rows
    levels = [str(row[1]).partition(",")[0] for row in rows]
    assert levels == sorted(levels, key=["wrong", "broken", "unbounded"].index)
    # Negative control: there is no row where no run is undetected.
    assert not undetected_table(detected(limit_study().walks))


def test_an_undetected_stretch_has_its_place_its_kind_and_its_error() -> None:
    row = undetected_table(steps_walks()).rows[0]
    assert row[:2] == ("Steps per revolution", "wrong, ran to its end")
    assert "pymunk stock: 79 .. 20 steps" in str(row[2])
    assert row[3] == "0.70"


# -- tables ------------------------------------------------------------------------------------------------------------


def test_steps_at_which_an_engine_leaves_and_breaks() -> None:
    rows = steps_table([*steps_walks(), *mass_walks()]).rows
    assert len(rows) == 5
    held = ("400 steps", "80 steps", "20 steps", "all of it")
    beyond = "wrong (undetected), flipped (undetected), opened (undetected)"
    assert rows[3] == (SCENE, "pymunk", "stock", *held, beyond)
    assert rows[0][3] == "none of it"


def test_what_only_the_safe_end_lacks_is_not_called_nowhere() -> None:
    late: tuple[Part, ...] = ((10_000.0, "wrong", "completed", True, 0.2), (2.0, "safe", "completed", False, 1e-3))
    never: tuple[Part, ...] = ((2.0, "wrong", "completed", True, 0.2),)
    walk = walked("steps", "mujoco", "stock", 20_000.0, late, text="{:.0f}")
    assert boundaries_table([walk]).rows[0][3:6] == ("not at first *", "not at first *", "all of it")
    assert reach_table([walk]).rows[0][-1] == "not at first *, then undetected"
    other = walked("steps", "mujoco", "stock", 20_000.0, never)
    assert boundaries_table([other]).rows[0][3:6] == ("none of it", "none of it", "all of it")


def test_determinism_shows_what_was_different() -> None:
    one = saved().determinism[0]
    other = replace(one, fingerprints={**one.fingerprints, RUNS[-1]: "f" * 64})
    same, different = determinism_table([one, other]).rows
    assert same.count("identical") == 3
    assert Toned("different", "bad") in different
