"""The first line of a verb on scenes names each machine with its speed, in both units, and what was changed."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from conrod.cli import outputs
from conrod.cli.outputs import Outputs, machine_lines
from conrod.report.terminal import verdict_line
from conrod.scenes import SCENES

SAW = SCENES["saw-500rpm"]


def test_a_machine_is_named_with_its_speed_and_changes() -> None:
    other = SAW.with_parameters(speed=320.0, crank=0.08)
    assert list(machine_lines({"saw": other}, ["speed", "crank"])) == ["saw: 3055.77 rpm (320 rad/s), crank 80 mm"]
    assert list(machine_lines({"saw": SAW}, [])) == ["saw: 500 rpm (52.36 rad/s)"]
    assert list(machine_lines({"saw": SAW, "again": SAW}, ["rod", "beam"])) == [
        "saw: 500 rpm (52.36 rad/s), rod 300 mm", "again: 500 rpm (52.36 rad/s), rod 300 mm",
    ]  # fmt: skip


def test_a_machine_without_drive_has_no_speed_that_is_kept() -> None:
    assert list(machine_lines({"saw": SAW}, ["speed"], driven=False)) == [f"saw: {SAW.title}"]


def test_many_machines_are_counted() -> None:
    assert list(machine_lines({f"m{k}": SAW for k in range(9)}, [])) == ["9 machines: m0, m1, m2, m3, m4, m5, .."]


def test_doubt_of_conrod_itself_stands_before_the_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    printed = list[Any]()
    monkeypatch.setattr(outputs, "print_parts", printed.extend)
    for doubts in ([], [verdict_line("saw: Cannot be trusted (MuJoCo)", False)]):
        printed.clear()
        kind: Any = SimpleNamespace(name="validation", printed=lambda found, first=doubts: [*first, "the table"])
        asked: Any = SimpleNamespace(assignments=("rod=310mm",))
        found: Any = {}
        Outputs(kind, asked).print_and_write(found, "validate", (), machines={"saw": SAW})
        assert printed == [*doubts, "saw: 500 rpm (52.36 rad/s), rod 300 mm", "the table"]
