"""Sections that a study fills: criteria, code, solution and settings say the figures of the study, each in its unit."""

from __future__ import annotations

import math
from typing import Any

import handmade_studies as made
import pytest
from handmade_studies import FIRST, FOURTH, SECOND, loop_study, model_study, scene_study, table_study

from conrod.execution.result import SceneResults
from conrod.mjcf.loop_results import LoopRequest
from conrod.models.check import report as model_report
from conrod.models.loops import report as loop_report
from conrod.models.tables import report as table_report
from conrod.report.table import ColouredCell, Table
from conrod.scenes import CamFollower
from conrod.verification.page import VerificationSection
from conrod.verification.sections import Refinement, all_refinements, study_sections

CRITERIA_HEAD = ("run", "quantity", "criterion", "found", "within")
CODE_HEAD = ("run", "quantity", "formal order", "observed", "agreement")
SOLUTION_HEAD = (
    "run", "error", "found", "at a step of zero", "numerical uncertainty", "order of the three finest",
)  # fmt: skip
NO = ColouredCell("NO", "bad")
NO_CRITERION = "no criterion was fixed before the run: errors are measured, not judged (--tolerance)"
ONE_RUN = "no numerical uncertainty: there are no runs at other steps"
NO_ORDER = "no formal order is claimed for these runs"
ROUNDING = (3e-12, 1e-12, 1e-12, 1e-12)


def criteria(*rows: tuple[str, ...]) -> Table:
    return Table(CRITERIA_HEAD, rows, frozenset({"criterion", "found"}), names=2)


def code(*rows: tuple[Any, ...]) -> Table:
    return Table(CODE_HEAD, rows, names=2)


def solution(*rows: tuple[str, ...]) -> Table:
    return Table(SOLUTION_HEAD, rows, frozenset(SOLUTION_HEAD[2:]), names=2)


def judged_scene() -> Any:
    """The saw tuned, hardened without errors, and in kinematic mode, which has neither limits nor refinement."""
    tuned = made.validation_result(
        "tuned", refinement=made.refinement(SECOND, FIRST, SECOND), settings={"timestep": 0.001}
    )
    hardened = made.validation_result(
        "hardened", refinement=made.refinement(FOURTH, FIRST, ROUNDING), errors=None, phase=None
    )
    limits = {"position": 1e-3, "velocity_rms": 2e-3, "phase": math.radians(0.25)}
    return scene_study(
        made.with_tolerance(tuned, "laws of tuned", **limits),
        made.with_tolerance(hardened, "laws of hardened", position=1e-6),
        made.validation_result(None, mode="kinematic", steps_per_revolution=None),
    )


def test_sections_of_a_scene_state_limits_errors_and_settings() -> None:
    found, deviations = study_sections(judged_scene())
    assert list(found) == ["criteria", "code", "solution", "settings"]
    # Errors of 1.6e-4 over L = 0.2 m are 0.032 mm; the rms is half of the largest 3e-4; 1e-3 rad are 0.057 deg.
    assert found["criteria"] == VerificationSection(
        (
            criteria(
                ("MuJoCo tuned", "position", "1.00e-3 (0.200 mm)", "1.60e-4 (0.0320 mm)", "yes"),
                ("MuJoCo tuned", "velocity_rms", "2.00e-3", "1.50e-4", "yes"),
                ("MuJoCo tuned", "phase", "0.250 deg", "0.0573 deg", "yes"),
                ("MuJoCo hardened", "position", "1.00e-6 (2.00e-4 mm)", "n/a", "n/a"),
            ),
        ),
        ("MuJoCo tuned: laws of tuned", "MuJoCo hardened: laws of hardened"),
        {
            "MuJoCo tuned position": "0.001", "MuJoCo tuned velocity_rms": "0.002", "MuJoCo tuned phase": "0.25 deg",
            "MuJoCo hardened position": "1e-06",
        },
    )  # fmt: skip
    # Tuned claims an order of positions alone, hardened one of all three; below 1e-11 no order can be seen.
    assert found["code"] == VerificationSection(
        (
            code(
                ("MuJoCo tuned", "position", "2", "2.0", "yes"),
                ("MuJoCo hardened", "position", "4", "4.0", "yes"),
                ("MuJoCo hardened", "velocity", "4", "1.0", NO),
                ("MuJoCo hardened", "acceleration", "4", "n/a", "at rounding, not shown"),
            ),
        ),
    )
    # At 100 steps an error of limit + size is size from its limit, times 1.25; of rounding it is 3 times.
    assert found["solution"] == VerificationSection(
        (
            solution(
                ("MuJoCo tuned", "position", "1.6e-4 (0.032 mm)", "1.0e-6 (2.0e-4 mm)", "± 2.0e-4 (0.040 mm)", "2.0"),
                ("MuJoCo tuned", "velocity", "4.0e-5", "< 1e-12", "± 5.0e-5", "1.0"),
                ("MuJoCo tuned", "acceleration", "1.6e-4", "1.0e-6", "± 2.0e-4", "2.0"),
                ("MuJoCo hardened", "position", "4.0e-6 (8.0e-4 mm)", "2.0e-9 (4.0e-7 mm)", "± 5.0e-6 (0.0010 mm)",
                 "4.0"),
                ("MuJoCo hardened", "velocity", "4.0e-5", "< 1e-12", "± 5.0e-5", "1.0"),
                ("MuJoCo hardened", "acceleration", "1.0e-12", "1.0e-12", "± < 1e-12", "n/a"),
            ),
        ),
    )  # fmt: skip
    settings = Table(("MuJoCo setting", "tuned"), (("`timestep`", "0.001"),), title="MuJoCo")
    assert found["settings"] == VerificationSection((settings,))
    assert deviations == ["MuJoCo hardened: the order of velocity is not the formal 4, observed is 1.0"]


def test_sections_of_a_scene_name_what_stock_adds_to_the_engine() -> None:
    stock = made.validation_result("stock", settings={"armature": 250.0, "tolerance": 1e-12})
    (words,) = study_sections(scene_study(stock))[0]["settings"].sentences
    assert words == (
        "MuJoCo stock is MuJoCo as it comes, and a drive: a flywheel of 250 kg m² on the crank, and a solver "
        "tolerance of 1e-12"
    )


def test_sections_of_a_scene_without_limits_have_a_deviation() -> None:
    found, deviations = study_sections(scene_study(made.validation_result("tuned")))
    assert found["criteria"] == VerificationSection((criteria(),), (NO_CRITERION,))
    assert found["code"] == VerificationSection((code(),), (NO_ORDER,))
    assert found["solution"] == VerificationSection((solution(),), (ONE_RUN,))
    assert deviations == [NO_CRITERION]


def test_no_order_is_claimed_of_a_contact() -> None:
    result = made.validation_result("hardened", refinement=made.refinement(FOURTH, FIRST, SECOND))
    refined = list(all_refinements(SceneResults("cam", CamFollower(), (result,))))
    assert [one.formal for one in refined] == [None] * 3
    assert [one.formal for one in all_refinements(scene_study(result))] == [4] * 3


def test_refinement_of_a_run_without_steps_is_of_none() -> None:
    result = made.validation_result(
        "hardened", steps_per_revolution=None, refinement=made.refinement(FOURTH, FIRST, SECOND)
    )
    assert [one.steps for one in all_refinements(scene_study(result))] == [0] * 3


def test_sections_of_a_model_state_paths_own_run_and_refinement() -> None:
    study = model_study()
    found, deviations = study_sections(study)
    # The drive keeps its speed to 1e-7 of 4 pi rad, which is 7.2e-5 deg; 2e-9 rad are 1.1e-7 deg.
    assert found["criteria"] == VerificationSection(
        (
            criteria(
                ("kinematic mode", "position", "1.00e-6 (2.00e-4 mm)", "1.00e-5 (2.00e-3 mm)", NO),
                ("its own settings", "phase", "7.20e-5 deg", "1.15e-7 deg", "yes"),
                ("its own settings", "velocity", "1.00e-3", "4.00e-4", "yes"),
            ),
        ),
        (
            "kinematic mode: what a model written with six digits can do, or --tolerance",
            "its own settings: --tolerance; phase and total: what a clock is allowed",
        ),
        {
            "kinematic mode position": "1e-06", "its own settings phase": "7.2e-05 deg",
            "its own settings velocity": "0.001",
        },
    )  # fmt: skip
    proofs = (
        "2 hinges, 1 slide, 1 connect; the machine has 3 pins, 1 slide",
        "mobility 1: 3 degrees of freedom, of which closures take 2",
        "largest distance from the exact path: C 1.0e-5 of its travel (0.0020 mm)",
        "not given, so not judged: M",
    )
    table = code(
        ("hardened", "position", "4", "4.0", "yes"),
        ("hardened", "velocity", "4", "1.0", NO),
        ("hardened", "acceleration", "4", "2.0", NO),
    )
    assert found["code"] == VerificationSection((table,), proofs)
    uncertain = solution(
        ("hardened", "position", "4.0e-6 (8.0e-4 mm)", "2.0e-9 (4.0e-7 mm)", "± 5.0e-6 (0.0010 mm)", "4.0"),
        ("hardened", "velocity", "4.0e-5", "< 1e-12", "± 5.0e-5", "1.0"),
        ("hardened", "acceleration", "1.6e-4", "1.0e-6", "± 2.0e-4", "2.0"),
    )
    assert found["solution"] == VerificationSection((model_report.runs_table(study), uncertain))
    assert found["settings"] == VerificationSection(
        (),
        (
            "plane xy, turned by 0 deg, crank zero at 0 deg, unit m",
            "the crank's axis is at (0 0 0) m; the crank angle grows with the hinge's coordinate",
            "timestep 0.001 s",
        ),
    )
    assert deviations == [
        "hardened: the order of velocity is not the formal 4, observed is 1.0",
        "hardened: the order of acceleration is not the formal 4, observed is 2.0",
    ]


def test_refinements_of_a_model_use_the_steps_of_its_judged_run() -> None:
    found = list(all_refinements(model_study()))
    assert found == [
        Refinement("hardened", name, 100, tuple(zip(made.PATH, errors, strict=True)), 4)
        for name, errors in {"position": FOURTH, "velocity": FIRST, "acceleration": SECOND}.items()
    ]


def test_sections_of_a_model_without_runs_judge_paths_alone() -> None:
    found, deviations = study_sections(model_study(tolerance=None, runs={}, refined={}))
    (table,) = found["criteria"].tables
    assert table == criteria(("kinematic mode", "position", "1.00e-6 (2.00e-4 mm)", "1.00e-5 (2.00e-3 mm)", NO))
    assert found["criteria"].sentences == (
        "kinematic mode: what a model written with six digits can do, or --tolerance",
    )
    assert found["code"].sentences[-1] == NO_ORDER
    assert found["solution"].sentences == (ONE_RUN,)
    # Its paths are judged in any case, and no tolerance was given all the same.
    assert deviations == [NO_CRITERION]


def test_sections_of_closed_loops_are_in_si() -> None:
    study = loop_study()
    found, deviations = study_sections(study)
    assert found["criteria"] == VerificationSection(
        (
            criteria(
                ("as it is", "position", "1.00e-3 m", "3.00e-4 m", "yes"),
                ("as it is", "loops", "1.00e-3 m", "2.00e-5 m", "yes"),
                ("tuned", "position", "1.00e-3 m", "1.61e-4 m", "yes"),
                ("tuned", "loops", "1.00e-3 m", "1.00e-5 m", "yes"),
            ),
        ),
        ("as it is: --tolerance", "tuned: --tolerance"),
        {f"{run} {name}": "0.001 m" for run in ("as it is", "tuned") for name in ("position", "loops")},
    )
    kinematic = (
        "kinematic mode: MuJoCo's own kinematics differ from the exact motion by position < 1e-12, over the largest "
        "of each"
    )
    assert found["code"] == VerificationSection((code(("tuned", "position", "2", "2.0", "yes")),), (kinematic,))
    uncertain = solution(
        ("tuned", "position", "1.6e-4 m", "1.0e-6 m", "± 2.0e-4 m", "2.0"),
        ("tuned", "velocity", "3.2e-4 m/s", "2.0e-6 m/s", "± 4.0e-4 m/s", "2.0"),
        ("tuned", "acceleration", "4.8e-4 m/s²", "3.0e-6 m/s²", "± 6.0e-4 m/s²", "2.0"),
    )
    assert found["solution"] == VerificationSection((loop_report.runs_table(study), uncertain))
    assert found["settings"] == VerificationSection(
        (),
        (
            "driven: `crank=1rad/s`; 2 s; points go up to 300 mm from their start",
            "mobility 1: of 3 degrees of freedom of its joints 2 equations of its closures take 2",
            "nearest to a singular pose at 0.5 s: the least singular value is 0.25 of the largest",
            "a remark",
        ),
    )
    assert deviations == []


def test_refinements_of_loops_are_sorted_claiming_positions_only() -> None:
    found = list(all_refinements(loop_study()))
    assert [(one.run, one.quantity, one.steps, one.formal) for one in found] == [
        ("as it is", "position", 100, None),
        ("as it is", "velocity", 100, None),
        ("as it is", "acceleration", 100, None),
        ("tuned", "position", 100, 2),
        ("tuned", "velocity", 100, None),
        ("tuned", "acceleration", 100, None),
    ]
    assert found[0].path == ((100, 3e-4),)
    assert found[3].path == tuple(zip(made.PATH, SECOND, strict=True))


def test_closed_loops_without_a_tolerance_have_an_open_deviation() -> None:
    found, deviations = study_sections(loop_study(question=LoopRequest({"crank": "1rad/s"})))
    assert found["criteria"] == VerificationSection((criteria(),), (NO_CRITERION,))
    assert deviations == [NO_CRITERION]


def test_sections_of_a_table_say_its_errors_columns_and_notes() -> None:
    study = table_study()
    found, deviations = study_sections(study)
    assert found["criteria"] == VerificationSection(
        (
            criteria(
                ("the table", "position", "0.0100 (2.00 mm)", "0.00200 (0.400 mm)", "yes"),
                ("the table", "phase", "1.00 deg", "0.500 deg", "yes"),
            ),
        ),
        ("the table: --tolerance; phase and total: what a clock is allowed",),
        {"the table position": "0.01", "the table phase": "1 deg"},
    )
    assert found["code"] == VerificationSection((code(),), (NO_ORDER,))
    assert found["solution"] == VerificationSection((table_report.errors_table(study), solution()), (ONE_RUN,))
    assert found["settings"] == VerificationSection(
        (table_report.columns_table(study.columns),),
        (
            "t.csv: 7 rows, 0 to 4.5 s, 3 revolutions of saw (text, separated by commas, decimal points)",
            "crank angle off the nominal one by 0.50 deg at most",
            "columns not used: who",
            "note: a note",
        ),
    )
    assert deviations == []
    assert study_sections(table_study(tolerance={}))[1] == [NO_CRITERION]


@pytest.mark.parametrize(
    ("errors", "formal", "order", "off"),
    [
        # 0.3 is left at a step of zero: far from nothing if an order of four counts, and nothing if two does.
        ((256.3, 16.3, 1.3), 4, None, True),
        ((256.3, 16.3, 1.3), None, math.log2(16.0), False),
        # 0.04 of 1.04 is little enough to show the order of the three finest, whose pairs differ; 0.06 is not.
        ((295.0, 16.04, 1.04), 4, math.log2(278.96 / 15.0), False),
        ((295.0, 16.06, 1.06), 4, None, True),
        # The order may be off by a quarter.
        ((2.0**7.6, 2.0**3.8, 1.0), 4, 3.8, False),
        ((2.0**7.4, 2.0**3.7, 1.0), 4, 3.7, True),
        ((2.0**8.6, 2.0**4.3, 1.0), 4, 4.3, True),
    ],
)  # fmt: skip
def test_observed_order_of_a_refinement_follows_its_errors(
    errors: tuple[float, ...], formal: int | None, order: float | None, off: bool
) -> None:
    path = tuple((100 * 2**k, 1e-6 * error) for k, error in enumerate(errors))
    one = Refinement("run", "position", 400, path, formal)
    assert one.order == (None if order is None else pytest.approx(order, rel=1e-9))
    assert one.is_off is off
    assert one.finest_error == pytest.approx(1e-6 * errors[-1])


def test_errors_near_rounding_have_no_order_that_is_off() -> None:
    for finest, off in ((0.9e-11, False), (1.1e-11, True)):
        path = ((100, 4.0 * finest), (200, 2.0 * finest), (400, finest))
        assert Refinement("run", "position", 400, path, 4).is_off is off
    two = Refinement("run", "position", 400, ((100, 1e-3), (200, 1e-4), (400, None)), 4)
    assert (two.finest_error, two.order, two.is_off) == (1e-4, None, True)
    # What shows no order does not have the first order.
    assert two._replace(formal=1).is_off
    assert Refinement("run", "position", 400, ((100, None),), 4).finest_error == math.inf
