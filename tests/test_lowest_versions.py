"""The lowest versions that are allowed are those that `make lowest` installs, and what is tested lies in the ranges."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

ROOT = Path(__file__).parents[1]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
# mjx needs a newer MuJoCo than conrod does, and mutants are planted with today's versions.
INSTALLED = ("box2d", "dev", "drake", "exudyn", "fmi")


def requirements(*extras: str) -> dict[str, Requirement]:
    """What is required directly, by name."""
    texts = [*PROJECT["dependencies"], *(text for extra in extras for text in PROJECT["optional-dependencies"][extra])]
    return {canonicalize_name(one.name): one for one in map(Requirement, texts) if one.name != "conrod"}


def pinned_versions(name: str) -> dict[str, Version]:
    """Versions that a file of constraints names."""
    lines = [line.partition("#")[0].strip() for line in (ROOT / name).read_text(encoding="utf-8").splitlines()]
    pairs = [line.split("==") for line in lines if line]
    return {canonicalize_name(package): Version(version) for package, version in pairs}


def lower_end(requirement: Requirement) -> Version:
    (lowest,) = [Version(one.version) for one in requirement.specifier if one.operator == ">="]
    return lowest


@pytest.mark.parametrize("name", sorted(requirements(*INSTALLED)))
def test_lowest_constraints_name_the_lower_end_of_each_range(name: str) -> None:
    assert pinned_versions("constraints-lowest.txt")[name] == lower_end(requirements(*INSTALLED)[name])


def test_make_lowest_installs_extras_with_pinned_lower_ends() -> None:
    (asked,) = re.findall(r"constraints-lowest\.txt --editable '\.\[(.*?)\]'", (ROOT / "Makefile").read_text())
    assert sorted(asked.split(",")) == sorted(INSTALLED)


@pytest.mark.parametrize("name", sorted(requirements(*PROJECT["optional-dependencies"])))
def test_constraints_lie_in_the_ranges(name: str) -> None:
    asked, tested = requirements(*PROJECT["optional-dependencies"])[name], pinned_versions("constraints.txt")
    assert name not in tested or tested[name] in asked.specifier


@pytest.mark.parametrize("name", sorted(requirements("box2d", "drake", "exudyn", "fmi", "mjx")))
def test_requirement_of_users_has_an_upper_end(name: str) -> None:
    assert any(one.operator == "<" for one in requirements("box2d", "drake", "exudyn", "fmi", "mjx")[name].specifier)


def test_constraints_have_no_addresses() -> None:
    for name in ("constraints.txt", "constraints-lowest.txt"):
        assert not re.search(r"://|^-", (ROOT / name).read_text(encoding="utf-8"), re.MULTILINE)
