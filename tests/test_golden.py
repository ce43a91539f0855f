"""The golden checks fail where a digit, a record or a word is not what it was."""

from __future__ import annotations

import math
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.golden import extract, perform, store
from tests.golden.__main__ import DATA, check_answers, main
from tests.golden.compare import compare
from tests.golden.perform import records_of
from tests.golden.record import Record
from tests.golden.tasks import Task, all_tasks

Records = dict[str, Record]
PENDULUM = next(task for task in all_tasks() if (task.group, task.name) == ("exact", "pendulum"))


def passes(task: Task, records: Records) -> bool:
    return check_answers({task: records}, DATA)


@pytest.fixture(scope="module")
def pendulum() -> Records:
    """What the command writes today."""
    return records_of(PENDULUM, DATA)


def next_digit(value: float) -> float:
    """Another in the twelfth digit."""
    return value * (1.0 + 3e-12)


# -- through the command -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("heading", ["tip.x [m]", "tip.jy [m/s^3]"])
def test_one_changed_digit_at_one_of_a_hundred_angles_fails(
    pendulum: Records, heading: str, capsys: pytest.CaptureFixture[str]
) -> None:
    values = [*pendulum[heading].value]
    values[60] = next_digit(values[60])
    assert not passes(PENDULUM, pendulum | {heading: replace(pendulum[heading], value=values)})
    assert f"worst: pendulum: {heading}[60]: was " in capsys.readouterr().out


def test_exit_status_of_the_check_is_1_when_a_digit_differs(
    pendulum: Records, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(DATA, tmp_path, dirs_exist_ok=True)
    monkeypatch.setattr("tests.golden.__main__.DATA", tmp_path)
    assert main(["check", "exact/pendulum"]) == 0
    assert "0 out; records: 0 missing, 0 added" in capsys.readouterr().out
    heading = "tip.vy [m/s]"
    values = [next_digit(value) for value in pendulum[heading].value]
    store.write(tmp_path, "exact", {"pendulum": pendulum | {heading: replace(pendulum[heading], value=values)}})
    assert main(["check", "exact/pendulum"]) == 1
    assert capsys.readouterr().out.endswith("golden: FAILED\n")


def test_writing_takes_a_group_by_name() -> None:
    with pytest.raises(SystemExit) as ended:
        main(["write"])
    assert ended.value.code == 2
    with pytest.raises(SystemExit):
        main(["write", "exact/pendulum"])  # a group is written whole


# -- on the records that are kept --------------------------------------------------------------------------------------

SAW = Task("scenes", "saw-500rpm", ())
TUNED = "saw-500rpm/mujoco/tuned"


@pytest.fixture(scope="module")
def saw() -> Records:
    """Records as if they had come out as they were; of normalised numbers."""
    _, tasks = store.read(DATA, SAW.group)
    records = {place: Record(value, extract.NORMALISED) for place, value in tasks[SAW.name].items()}
    assert passes(SAW, records)
    return records


def test_option_identical_refuses_what_is_within_the_rule(saw: Records, capsys: pytest.CaptureFixture[str]) -> None:
    name = f"{TUNED}/errors/C/position/max"
    changed = saw | {name: Record(math.nextafter(saw[name].value, 1.0), extract.NORMALISED)}
    assert check_answers({SAW: changed}, DATA)
    assert not check_answers({SAW: changed}, DATA, identical=True)
    assert "1 within 1e-13, 0 out" in capsys.readouterr().out


def test_a_record_that_is_missing_or_new_fails(saw: Records, capsys: pytest.CaptureFixture[str]) -> None:
    name = f"{TUNED}/order/position"
    assert not passes(SAW, {place: record for place, record in saw.items() if place != name})
    assert f"missing: saw-500rpm: {name}" in capsys.readouterr().out
    assert not passes(SAW, saw | {f"{TUNED}/order/jerk": Record(2.0)})
    assert f"added: saw-500rpm: {TUNED}/order/jerk" in capsys.readouterr().out


def test_a_task_without_golden_records_fails() -> None:
    for group in ("scenes", "nothing"):
        assert not passes(Task(group, "unknown", ()), {"exit status": Record(0)})
    assert not passes(SAW, {})


# -- the rule ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("golden", "now", "unit", "identical", "within"),
    [
        (1.0, 1.0, 0.0, 1, 0),
        (2.0, 2.0 * (1.0 + 5e-14), 0.0, 0, 1),
        (2.0, 2.0 * (1.0 + 2e-13), 0.0, 0, 0),
        (1e-15, 3e-15, 0.0, 0, 0),
        (1e-15, 3e-15, 1.0, 0, 1),  # an error whose own digits are rounding
        (0.0, 1e-300, 0.0, 0, 0),
        (True, 1, 1.0, 0, 0),
        ("completed", "opened", 1.0, 0, 0),
        ("1.0", 1.0, 1.0, 0, 0),
        (1.0, math.nan, 1.0, 0, 0),
        (1.0, math.inf, 1.0, 0, 0),
        (1.0, None, 1.0, 0, 0),
        (1000, 1001, 0.0, 0, 0),
        ([1.0, 2.0], [1.0, 2.0 + 1e-13], 2.0, 1, 1),
        ([1.0, 2.0], [1.0], 0.0, 0, 0),
    ],
)
def test_the_rule_is_1e_13_of_the_number_or_of_its_unit(
    golden: Any, now: Any, unit: float, identical: int, within: int
) -> None:
    found = compare({"x": golden}, {"x": Record(now, unit)})
    assert (found.identical, found.within) == (identical, within)
    assert found.passed == (identical + within == found.count)


def test_order_is_compared_to_the_rounding_of_its_errors() -> None:
    errors = [4e-9, 1e-9]
    ((_, order),) = extract._orders("run", {"position": 2.0}, {"position": errors})
    noisy = math.log2((errors[0] + 0.9e-13) / (errors[1] - 0.9e-13))
    assert compare({"x": 2.0}, {"x": replace(order, value=noisy)}).passed
    assert not compare({"x": 2.0}, {"x": replace(order, value=2.001)}).passed


# -- the ledger --------------------------------------------------------------------------------------------------------


def test_new_runs_are_counted_over_all_rounds_of_a_study() -> None:
    said = "runs: 65 to do, 3 in the ledger\nruns: 9 more to do, 2 in the ledger\nruns: 74 done in 9.3 s\n"
    assert extract.announced(said) == (74, 5)
    with pytest.raises(ValueError, match="nothing is said"):
        extract.announced("costs: 3 to do, 0 in the ledger\n")


@pytest.mark.skipif(not store.KERNELS, reason="kernels are chosen on x86-64 alone")
def test_commands_use_the_same_kernels_on_any_processor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # What is run in a folder takes this for conrod.
    (tmp_path / "conrod.py").write_text("""
import numpy, scipy.linalg
from numpy._core._multiarray_umath import __cpu_features__ as has
from threadpoolctl import threadpool_info
print({(one["architecture"], one["num_threads"]) for one in threadpool_info() if one["user_api"] == "blas"})
print(has.get("X86_V4", False))
""")
    monkeypatch.setenv("OPENBLAS_CORETYPE", "SkylakeX")
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)
    assert perform.run(tmp_path, "show").stdout == "{('Haswell', 1)}\nFalse\n"
