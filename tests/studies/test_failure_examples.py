"""Every way in which a run can end has an example that ends so, and what was done to it is what makes it end so."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from catalogue import CAM, PRESS, SAW
from failure_examples import EXAMPLES, Example

from conrod.runs.trajectory import Outcome
from conrod.scenes import SCENES, CamFollower, ShearPress
from conrod.studies.execution.dispatch import run_cases
from conrod.studies.execution.local import LocalProcesses
from conrod.studies.frame.ledger import Ledger
from conrod.studies.limits.records import Extremes, is_undetected

BY_NAME = {f"{e.outcome.slug}: {e.title} in {e.engine}": e for e in EXAMPLES}
KILLERS = {name for name, e in BY_NAME.items() if e.outcome is Outcome.CRASHED}


@pytest.fixture(scope="module")
def workers() -> Iterator[LocalProcesses]:
    with LocalProcesses(1, cell_timeout=300.0) as executor:
        yield executor


def test_every_outcome_of_the_closed_list_has_an_example() -> None:
    assert {example.outcome for example in EXAMPLES} == set(Outcome)
    assert len(BY_NAME) == len(EXAMPLES) == len({e.case.key for e in EXAMPLES})


@pytest.mark.parametrize("name", BY_NAME)
def test_an_example_ends_as_its_outcome(name: str, tmp_path: Path, workers: LocalProcesses) -> None:
    example = BY_NAME[name]
    if name in KILLERS:
        with Ledger.open(tmp_path / "ledger.sqlite") as ledger:
            measurement = run_cases([example.case], ledger, workers)[example.case.key]
    else:
        measurement = example.case.perform()
    assert measurement.outcome == example.outcome.slug
    assert bool(measurement.reason) == (example.outcome is not Outcome.COMPLETED)


def faultless(example: Example) -> Example:
    """The same without what was done to it: machine and preset as they are, at usual steps, past half a turn."""
    if example.outcome is Outcome.UNSUPPORTED:
        return replace(example, outcome=Outcome.COMPLETED, name="saw-40rpm", scene=SAW)
    as_it_is = {ShearPress: PRESS, CamFollower: CAM}.get(type(example.scene), SAW)
    return replace(
        example,
        outcome=Outcome.COMPLETED,
        scene=as_it_is if example.name not in SCENES else example.scene,
        steps=max(example.steps, 500),
        changes={},
        unchecked={},
        revolutions=0.6,
        timeout=None,
        headroom=None,
    )


FAULTLESS = {example.case.key: example for example in map(faultless, EXAMPLES)}


@pytest.mark.parametrize("key", FAULTLESS)
def test_without_what_was_done_to_it_the_same_run_completes(key: str) -> None:
    measurement = FAULTLESS[key].case.perform()
    assert measurement.outcome == "completed", measurement.reason
    assert not is_undetected(measurement)


def test_mujocos_silent_reset_is_recognised_although_every_number_is_finite() -> None:
    (example,) = (e for e in EXAMPLES if e.outcome is Outcome.RESET)
    measurement = example.case.perform()
    assert (measurement.outcome, Extremes.of(measurement).finite) == ("reset", True)
    # Negative control: with autoreset off the same run shows numbers that are none.
    off = replace(example, changes={**example.changes, "autoreset": False}).case.perform()
    assert (off.outcome, Extremes.of(off).finite) == ("diverged", False)


def test_the_solver_tolerance_trap_of_a_large_armature_is_shown_by_the_comparison_alone() -> None:
    assert is_undetected(BY_NAME["opened: the solver-tolerance trap in mujoco"].case.perform())
