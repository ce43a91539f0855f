"""What the report of limits says: in plain words, quiet runs first, every figure from the walks."""

from __future__ import annotations

from limit_studies import limit_study, same_again
from limit_walks import (
    SCENE,
    Part,
    listed,
    mass_walks,
    pose_walks,
    probe,
    quietened,
    regularisation_walks,
    steps_walks,
    walked,
)

from conrod.report.limits.axis_section import axis_section
from conrod.report.limits.boundaries_table import boundaries_table, refusals, solver_notes
from conrod.report.limits.findings import findings
from conrod.report.limits.other_tables import determinism_table, steps_table
from conrod.report.limits.plain_words import sentences
from conrod.report.limits.undetected_table import quiet_ranges, quiet_summary, quiet_table
from conrod.studies.limits.results import Walk
from conrod.studies.limits.walk import CRITERIA, boundary_of

# -- words -------------------------------------------------------------------------------------------------------------


def test_the_page_says_safe_here_wrong_but_quiet_there_broken_there() -> None:
    said = sentences(steps_walks())
    assert said[0] == (
        "MuJoCo `stock`: rough down to 200 steps, **wrong but quiet** from 199 to 31 steps, **broken but quiet** "
        "(opened) from 30 to 12 steps, unbounded (diverged) from 11 steps on."
    )
    # Presets that behave alike are told once.
    assert "MuJoCo `tuned`; pymunk `tuned`: safe down to 60 steps" in said[1]
    assert len(said) == 4


def test_a_warning_makes_a_wrong_run_loud() -> None:
    said = " ".join(sentences(quietened(steps_walks())))
    assert "quiet" not in said
    assert "wrong, and the engine warns from 199 to 31 steps" in said


def test_both_directions_are_told_apart() -> None:
    said = sentences(mass_walks())
    assert [text for text in said if "towards 1e+06: safe up to 30" in text]
    assert [text for text in said if "towards 1e-06: safe down to 0.01" in text]


def test_presets_that_fail_alike_at_other_values_are_told_together_where_that_is_short() -> None:
    walks = [
        walked("mass-ratio", "mujoco", preset, 1.0, ((good, "safe", "completed", False, 1e-4), (1e6, *EXPLODED)))
        for preset, good in (("stock", 10.0), ("tuned", 100.0))
    ]
    (said,) = sentences(walks)
    assert "safe up to 10 (`stock`) or 100 (`tuned`), unbounded (exploded) from 10.15 (`stock`) or" in said


EXPLODED = ("unbounded", "exploded", False, None)


def flickering() -> Walk:
    """Safe and opened in turn, from 100 on."""
    ends = [("safe", "completed", False, 1e-4), ("broken", "opened", True, None)]
    probes = tuple(probe(2.0**k, *ends[k % 2 if k > 3 else 0]) for k in range(12))
    return Walk("mass-ratio", SCENE, "pymunk", "stock", "", probes, tuple(boundary_of(probes, c) for c in CRITERIA))


def test_what_comes_and_goes_is_not_told_value_by_value() -> None:
    (said,) = sentences([flickering()])
    assert (
        said == "pymunk `stock`: safe up to 16, from 32 on it comes and goes: **broken but quiet** (opened) and safe."
    )
    assert "16 *" in boundaries_table([flickering()])
    assert "further on there are runs that keep the criterion" in boundaries_table([flickering()])
    assert " *" not in boundaries_table(steps_walks())


def test_lists_are_told_by_their_number() -> None:
    said = sentences(pose_walks())
    assert "MuJoCo `stock`: safe in 69 of 72 runs, **broken but quiet** (flipped) in 3 of 72 runs." in said
    assert "MuJoCo `tuned`; pymunk `stock`: safe throughout (72 runs)." in said


# -- what is dangerous -------------------------------------------------------------------------------------------------


def test_quiet_runs_come_first_and_those_in_one_piece_before_all() -> None:
    study = limit_study()
    ranges = quiet_ranges(study.walks)
    levels = [one.level for one in ranges]
    assert levels == sorted(levels, key=["wrong", "broken", "unbounded"].index)
    # None is lost, and none is counted twice.
    assert sum(len(one.probes) for one in ranges) == sum(p.undetected for walk in study.walks for p in walk.probes)
    assert quiet_table(quietened(study.walks)) == quiet_summary(quietened(study.walks)) == ""


def test_a_quiet_range_says_where_how_and_how_far_off() -> None:
    row = next(line for line in quiet_table(steps_walks()).splitlines() if "pymunk" in line)
    assert row == "| Steps per revolution | pymunk | stock | 79 .. 20 steps | wrong | ran to its end | 0.70 |"


def test_scattered_values_of_a_list_are_one_row() -> None:
    (one,) = quiet_ranges(pose_walks())
    assert one.where == "3 of 72: 0, 125, 250"
    assert len(one.probes) == 3


def test_findings_are_made_of_the_walks() -> None:
    said = findings(steps_walks())
    assert said[1] == (
        "**Steps per revolution**, 20000 .. 2 steps: within 10 % furthest with MuJoCo `hardened` (down to 5 steps), "
        "least far with MuJoCo `stock` (down to 200 steps); 2 of 5 leave it quietly."
    )
    assert "within 10 % furthest with MuJoCo `tuned`; pymunk `tuned` (down to 25 steps)" in " ".join(
        findings([walk for walk in steps_walks() if walk.preset != "hardened"])
    )
    assert said[0].startswith("**Wrong, and nothing says so:** 15 of 86 runs, on 2 of 5 walks")
    assert findings([]) == []


# -- tables ------------------------------------------------------------------------------------------------------------


def test_steps_at_which_an_engine_leaves_and_breaks() -> None:
    rows = steps_table([*steps_walks(), *mass_walks()]).splitlines()[2:]
    assert len(rows) == 5
    assert rows[3] == (
        f"| {SCENE} | pymunk | stock | 400 (399: rough) | 80 (79: wrong, quiet) | 20 (19: flipped, quiet) | all of it |"
    )
    assert "none of it (20000: rough)" in rows[0]


def test_what_only_the_harmless_end_lacks_is_not_called_nowhere() -> None:
    late: tuple[Part, ...] = ((10_000.0, "wrong", "completed", True, 0.2), (2.0, "safe", "completed", False, 1e-3))
    never: tuple[Part, ...] = ((2.0, "wrong", "completed", True, 0.2),)
    walk = walked("steps", "mujoco", "stock", 20_000.0, late, text="{:.0f}")
    table = boundaries_table([walk])
    assert "| not at first * | not at first * | all of it |" in table
    assert "further on there are runs" in table
    assert "not at first (20000: wrong, quiet)" in steps_table([walk])
    assert "not at first, but further on with MuJoCo `stock`" in findings([walk])[1]
    other = walked("steps", "mujoco", "stock", 20_000.0, never)
    assert "| none of it | none of it | all of it |" in boundaries_table([other])
    assert "further on" not in boundaries_table([other])
    assert "nowhere with MuJoCo `stock`" in findings([other])[1]


def test_the_solver_that_stopped_early_is_in_the_table() -> None:
    text = boundaries_table(regularisation_walks())
    assert "stopped after 0 iterations: 1e-10 .. 1e-15 (7 of 15 runs)" in text
    assert "its solver" not in boundaries_table(steps_walks())


def test_residuals_of_many_sizes_are_told_together() -> None:
    left = [f"took all its iterations, residual above {power}" for power in ("0.01", "1e-06", "1e-06")]
    notes = [*left, "stopped after 0 iterations", ""]
    runs = [probe(float(k), "safe", "completed", False, 1e-3, solver=note) for k, note in enumerate(notes)]
    assert solver_notes(runs) == (
        "took all its iterations: 0 .. 2 (3 of 5 runs), residual above 1e-06 to 0.01; "
        "stopped after 0 iterations: 3 (1 of 5 runs)"
    )


def test_few_values_of_a_list_have_a_column_each() -> None:
    runs = [
        probe(0.0, "safe", "completed", False, 1e-3, text="double precision"),
        probe(1.0, "wrong", "completed", True, 0.2, text="single precision"),
    ]
    head, _, row = boundaries_table([listed("rounding", "mujoco", "stock", runs)]).splitlines()
    assert head.count("precision") == 2
    assert row == "| MuJoCo | stock | 0.0010 | 0.20 (quiet) |"
    assert "72" in boundaries_table(pose_walks())


def test_refusals_are_told_once_with_those_they_are_for() -> None:
    said = refusals(regularisation_walks())
    assert said == ["Not walked with pymunk `stock` and `tuned`: pymunk does not regularise."]
    section = axis_section("regularisation", regularisation_walks(), lambda name, text: "")
    assert said[0] in section
    assert "least, by 5.6e-10, at 5.623e-07" in section


def test_determinism_says_what_was_different() -> None:
    rows = determinism_table([same_again("mujoco", "stock"), same_again("pymunk", "stock", across=False)])
    one, other = rows.splitlines()[2:]
    assert one.count("identical") == 3
    assert "**different**" in other
    assert "**different**" not in one
