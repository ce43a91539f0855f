"""Every way in which a run can end has a run that ends so, and what was done to it is what makes it end so."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from catalogue import CAM, PRESS, SAW

from conrod.engines import engine_named
from conrod.runs.trajectory import Outcome
from conrod.scenes import SCENES, CamFollower, ShearPress
from conrod.studies.execution.dispatch import run_cases
from conrod.studies.execution.local import LocalProcesses
from conrod.studies.execution.worker import perform
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.run import RunCase, measure
from conrod.studies.frame.study import pursue
from conrod.studies.limits.cell import LimitCell
from conrod.studies.limits.extremes import Extremes, SolverWatch
from conrod.studies.limits.failure_examples import GALLERY, Exhibit, Specimen, exhibit, gallery_search
from conrod.studies.limits.perform import BoundedCell
from conrod.studies.limits.solver_notes import LEFT, solver_note

BY_NAME = {f"{s.outcome.slug}: {s.title} in {s.engine}": s for s in GALLERY}
KILLERS = {name for name, s in BY_NAME.items() if s.outcome is Outcome.CRASHED}


@pytest.fixture(scope="module")
def workers() -> Iterator[LocalProcesses]:
    with LocalProcesses(1, cell_timeout=300.0) as executor:
        yield executor


def shown(specimen: Specimen, tmp_path: Path, workers: LocalProcesses | None = None) -> Exhibit:
    """A specimen, run here, or in a worker process where it would take this one down."""

    def run(cells: list[LimitCell]) -> dict[str, Measurement]:
        if workers is None:
            return {cell.key: perform(cell) for cell in cells}
        with Ledger.open(tmp_path / "ledger.sqlite") as ledger:
            return run_cases(cells, ledger, workers)

    ((one,),) = pursue([gallery_search((specimen,))], run)
    return one


def test_every_outcome_of_the_closed_list_has_a_specimen() -> None:
    assert {specimen.outcome for specimen in GALLERY} == set(Outcome)
    assert len(BY_NAME) == len(GALLERY) == len({s.cell.key for s in GALLERY})
    assert all(s.title and s.what for s in GALLERY)


@pytest.mark.parametrize("name", BY_NAME)
def test_a_specimen_ends_as_its_outcome(name: str, tmp_path: Path, workers: LocalProcesses) -> None:
    specimen = BY_NAME[name]
    one = shown(specimen, tmp_path, workers if name in KILLERS else None)
    assert (one.outcome, one.expected) == (specimen.outcome.slug, specimen.outcome.slug)
    assert bool(one.reason) == (specimen.outcome is not Outcome.COMPLETED)
    assert Exhibit.of(json.loads(json.dumps(one.as_dict()))) == one


def harmless(specimen: Specimen) -> Specimen:
    """The same without what was done to it: machine and preset as they are, at usual steps, past half a turn."""
    if specimen.outcome is Outcome.UNSUPPORTED:
        return replace(specimen, outcome=Outcome.COMPLETED, name="saw-40rpm", scene=SAW)
    plain = {ShearPress: PRESS, CamFollower: CAM}.get(type(specimen.scene), SAW)
    return replace(
        specimen,
        outcome=Outcome.COMPLETED,
        scene=plain if specimen.name not in SCENES else specimen.scene,
        steps=max(specimen.steps, 500),
        changes={},
        step_constant=None,
        unchecked={},
        revolutions=0.6,
        timeout=None,
        headroom=None,
    )


@pytest.mark.parametrize("name", BY_NAME)
def test_without_what_was_done_to_it_the_same_run_completes(name: str, tmp_path: Path) -> None:
    one = shown(harmless(BY_NAME[name]), tmp_path)
    assert one.outcome == "completed", one.reason
    assert not one.quiet


def test_a_specimen_that_ends_otherwise_is_shown_as_it_ended() -> None:
    specimen = BY_NAME["opened: the solver-tolerance trap in mujoco"]
    one = exhibit(specimen, Measurement("exploded", "beyond reach"))
    assert (one.expected, one.outcome, one.reason) == ("opened", "exploded", "beyond reach")


# -- the two that are named ------------------------------------------------------------------------------------------


def only(outcome: Outcome) -> Specimen:
    (specimen,) = (s for s in GALLERY if s.outcome is outcome)
    return specimen


def test_mujocos_silent_reset_is_recognised_although_every_number_is_finite(tmp_path: Path) -> None:
    specimen = only(Outcome.RESET)
    one = shown(specimen, tmp_path)
    assert one.finite
    assert one.outcome == "reset"
    # Negative control: with autoreset off the same run shows what it is, numbers that are none.
    off = shown(replace(specimen, changes={**specimen.changes, "autoreset": False}), tmp_path)
    assert (off.outcome, off.finite) == ("diverged", False)


@pytest.mark.parametrize("scene", ["saw-40rpm", "shear-press"])
def test_the_solver_tolerance_trap_of_a_large_armature_is_recognised(scene: str, tmp_path: Path) -> None:
    specimen = replace(BY_NAME["opened: the solver-tolerance trap in mujoco"], name=scene, scene=SCENES[scene])
    one = shown(specimen, tmp_path)
    assert one.outcome == "opened"
    assert one.solver.startswith("stopped after 0 iterations, residual above ")
    # Nothing but the comparison tells: finite numbers, no warning.
    assert one.quiet
    # Negative control: the tolerance alone makes the difference.
    off = shown(replace(specimen, changes={"tolerance": 0.0}), tmp_path)
    assert (off.outcome, off.solver) == ("completed", "")


def test_the_trap_is_told_even_where_the_loop_stays_closed(tmp_path: Path) -> None:
    trap = BY_NAME["opened: the solver-tolerance trap in mujoco"]
    fast = replace(trap, outcome=Outcome.COMPLETED, name="saw-500rpm", scene=SCENES["saw-500rpm"])
    one = shown(fast, tmp_path)
    assert one.outcome == "completed"
    assert one.solver.startswith("stopped after 0 iterations")


# -- what is said of a solver ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("solver", "note"),
    [
        (SolverWatch(40, 100, 0, 0, 11.9), "stopped after 0 iterations, residual above 10"),
        (SolverWatch(40, 100, 0, 1, 0.17), "stopped after 0 iterations at some steps, residual above 0.1"),
        (SolverWatch(40, 10, 10, 10, 9.6e-6), "took all its iterations, residual above 1e-06"),
        (SolverWatch(40, 100, 3, 7, 2e-3), "stopped before all its iterations, residual above 0.001"),
        (SolverWatch(40, 100, None, None, 2e-3), "left its task unfinished, residual above 0.001"),
        (SolverWatch(40, 100, 0, 0, 1e-15), ""),
        (SolverWatch(40, 272, 272, 272, 2.2e-14), ""),
        (SolverWatch(40, 100, 1, 1, None), ""),
    ],
)
def test_a_note_says_how_the_solver_ended_where_it_left_something(solver: SolverWatch, note: str) -> None:
    assert solver_note(solver) == note


def solver_of(engine: str, preset: str, **changes: Any) -> SolverWatch | None:
    settings = engine_named(engine).presets[preset](SAW, 200)
    watched = Extremes.of(perform(LimitCell("saw-40rpm", SAW, replace(settings, preset="custom", **changes), 1.0)))
    assert watched is not None
    return watched.solver


def note_of(engine: str, preset: str, **changes: Any) -> str:
    solver = solver_of(engine, preset, **changes)
    assert solver is not None
    return solver_note(solver)


@pytest.mark.parametrize(
    ("engine", "preset"), [("mujoco", "stock"), ("mujoco", "tuned"), ("mujoco", "hardened"), ("pymunk", "tuned")]
)
def test_nothing_is_said_of_presets_whose_solver_converges(engine: str, preset: str) -> None:
    assert note_of(engine, preset) == ""


def test_pymunks_ten_iterations_are_too_few_and_said_to_be() -> None:
    assert note_of("pymunk", "stock").startswith("took all its iterations, residual above ")
    assert note_of("pymunk", "tuned", iterations=4).startswith("took all its iterations, residual above ")


def test_a_rounded_state_is_no_fault_of_the_solver() -> None:
    assert solver_of("pymunk", "tuned", rounded_state=True) is None
    assert note_of("mujoco", "hardened", rounded_state=True) == ""


def test_a_mujoco_solver_with_few_iterations_is_said_to_have_left_something() -> None:
    assert note_of("mujoco", "tuned", solver="PGS", iterations=3).startswith("took all its iterations")
    assert note_of("mujoco", "tuned", solver="PGS", iterations=300) == ""
    assert note_of("mujoco", "tuned", tolerance=1e-8).startswith("stopped after 0 iterations")


def test_the_threshold_is_above_rounding_at_the_worst_mass_ratio() -> None:
    heavy = SAW.with_parameters(slider_mass=6e6)
    settings = engine_named("mujoco").presets["hardened"](heavy, 1000)
    watched = Extremes.of(perform(LimitCell("heavy", heavy, settings, 1.0)))
    assert watched is not None
    assert watched.solver is not None
    assert watched.solver.residual is not None
    assert 1e-12 < watched.solver.residual < LEFT


# -- runs with limits of their own -----------------------------------------------------------------------------------


def test_a_bounded_run_that_keeps_its_limits_is_the_run_itself() -> None:
    settings = engine_named("pymunk").presets["tuned"](SAW, 20)
    plain, bounded = LimitCell("saw", SAW, settings, 1.0), BoundedCell("saw", SAW, settings, 1.0, headroom=1 << 30)
    assert perform(bounded) == perform(plain)
    assert bounded.key != plain.key
    assert bounded.key != replace(bounded, timeout=1.0).key
    whole = replace(bounded, whole=True)
    assert perform(whole) == measure(RunCase("saw", SAW, settings, 1.0))
    assert whole.key != bounded.key
