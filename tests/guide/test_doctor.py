"""`conrod doctor`: what is out of range, missing or no longer noticed makes exit status 1."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

import conrod
from conrod.cli import cli
from conrod.guide.doctor import api
from conrod.guide.doctor.api import Diagnosis, EngineCheck, SelfTest, check_packages

WELL = Diagnosis(
    "conrod 0.1.0, Python",
    tuple(check_packages()),
    (EngineCheck("mujoco", "4.0.0"), EngineCheck("exudyn", missing="not installed: pip install 'conrod[exudyn]'")),
    (SelfTest("mujoco", "within tolerance", within=True, noticed=api.TESTED_DEFECTS),),
)


def test_doctor_checks_every_required_package() -> None:
    found = {one.name: one for one in check_packages()}
    assert {"mujoco", "pymunk", "numpy", "click"} <= set(found)
    assert "pytest" not in found  # of an extra
    assert all(one.good for one in found.values())


def test_doctor_names_a_package_out_of_range_and_one_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    def version(name: str) -> str:
        if name == "rich":
            raise api.PackageNotFoundError(name)
        return "1.0" if name == "numpy" else "4.0.0"

    monkeypatch.setattr(api, "version", version)
    found = {one.name: one for one in check_packages()}
    assert (found["numpy"].good, found["numpy"].installed) == (False, "1.0")
    assert (found["rich"].good, found["rich"].installed) == (False, "")
    assert found["mujoco"].good


@pytest.mark.parametrize(
    ("found", "status", "said"),
    [
        (WELL, 0, "all is well"),
        (replace(WELL, tests=(replace(WELL.tests[0], missed=("other",)),)), 1, "NOT NOTICED: other"),
        (replace(WELL, tests=(replace(WELL.tests[0], noticed=()),)), 1, "noticed: none"),
        (replace(WELL, tests=(replace(WELL.tests[0], within=False),)), 1, "something is wrong"),
        (replace(WELL, tests=()), 1, "something is wrong"),
        (replace(WELL, packages=(api.PackageCheck("numpy", "1.0", ">=2.3", good=False),)), 1, "'numpy>=2.3'"),
    ],
)
def test_doctor_says_what_is_wrong_and_exits_with_it(
    found: Diagnosis, status: int, said: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(api, "doctor", lambda: found)
    ended = CliRunner().invoke(cli, ["doctor", "--json", str(tmp_path / "x.json")])
    assert (ended.exit_code, said in ended.output) == (status, True), ended.output
    assert "pip install 'conrod[exudyn]'" in ended.output
    assert json.loads((tmp_path / "x.json").read_text("utf-8"))["passed"] is (status == 0)


@pytest.mark.slow  # runs and judges a saw in both engines with every defect
def test_doctor_finds_this_installation_well() -> None:
    found = conrod.doctor()
    assert [(one.engine, one.noticed, one.missed) for one in found.tests] == [
        ("mujoco", api.TESTED_DEFECTS, ()),
        ("pymunk", api.TESTED_DEFECTS, ()),
    ]
    assert found.passed
