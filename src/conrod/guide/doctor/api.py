"""Check an installation of conrod: its packages, its engines, and that wrong runs are noticed."""

from __future__ import annotations

import os
import platform
import re
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

from packaging.requirements import Requirement

from conrod.engines import OPTIONAL_ENGINES, installed_extras, loadable_engines
from conrod.execution.runner import Runs
from conrod.report.notebook import NotebookResult
from conrod.report.table import ColouredCell, Table, table
from conrod.studies.validation.api import validate

TESTED_SCENE, TESTED_PRESET = "saw-500rpm", "tuned"
# Defects that both engines are exact enough to show, by their names in `conrod validate --qualify`.
TESTED_DEFECTS = ("velocity stamped early", "gravity left in an acceleration", "no number in a sample")


@dataclass(frozen=True)
class PackageCheck:
    """A package that conrod needs: its installed version (empty if missing), and the versions allowed."""

    name: str
    installed: str
    allowed: str
    good: bool


@dataclass(frozen=True)
class EngineCheck:
    """An engine by its name: its version, or why it cannot run and what to do."""

    name: str
    version: str = ""
    missing: str = ""


@dataclass(frozen=True)
class SelfTest:
    """A run of one engine that has to be within its tolerances, and planted defects that have to be noticed.

    Attributes:
        verdict: the run's own verdict, in words.
        noticed: names of the planted defects that the verdict noticed.
        missed: names of those that it did not.
    """

    engine: str
    verdict: str
    within: bool
    noticed: tuple[str, ...] = ()
    missed: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """True if the healthy run is within tolerance and every planted defect was noticed."""
        return self.within and bool(self.noticed) and not self.missed


@dataclass(frozen=True)
class Diagnosis(NotebookResult):
    """Findings of `doctor` on an installation."""

    system: str
    packages: tuple[PackageCheck, ...]
    engines: tuple[EngineCheck, ...]
    tests: tuple[SelfTest, ...]

    @property
    def passed(self) -> bool:
        """True if all packages are in range, and both engines pass their self-test."""
        return all(one.good for one in self.packages) and bool(self.tests) and all(one.passed for one in self.tests)

    @property
    def verdict(self) -> str:
        """Whether all is well."""
        return "all is well" if self.passed else "something is wrong"

    def tables(self) -> list[Table]:
        """Packages, and engines, a row for each."""
        yes, no = ColouredCell("yes", "good"), ColouredCell("NO", "bad")
        packages = [
            (one.name, one.installed or "missing", one.allowed, yes if one.good else no) for one in self.packages
        ]
        engines = [(one.name, one.version or one.missing) for one in self.engines]
        return [
            table(("package", "installed", "allowed", "in range"), packages),
            table(("engine", "version"), engines),
        ]


def doctor() -> Diagnosis:
    """Check versions and engines, run one machine in both engines, and plant three defects that must be noticed."""
    from conrod import __version__

    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    python = f"Python {platform.python_version()} on {platform.system()} {platform.machine()}"
    found, left_out = loadable_engines(installed_extras())
    missing = [name for name in OPTIONAL_ENGINES if name not in installed_extras()]
    engines = [
        *(EngineCheck(one.name, one.version) for one in found),
        *(EngineCheck(_engine_in(line), missing=line) for line in left_out),
        *(EngineCheck(name, missing=f"not installed: pip install 'conrod[{name}]'") for name in missing),
    ]
    words = f"conrod {__version__}, {python}, {cores} processors"
    return Diagnosis(words, tuple(check_packages()), tuple(engines), run_self_tests())


def _engine_in(line: str) -> str:
    """Return the name of the engine that a line says cannot be loaded."""
    named = re.search(r"engine '([^']+)'", line)
    return named[1] if named else "engine"


def check_packages() -> Iterator[PackageCheck]:
    """Compare the installed version of each package that conrod requires with the versions allowed."""
    for text in requires("conrod") or ():
        needed = Requirement(text)
        if needed.marker is not None and not needed.marker.evaluate({"extra": ""}):
            continue
        try:
            installed = version(needed.name)
        except PackageNotFoundError:
            installed = ""
        good = bool(installed) and needed.specifier.contains(installed, prereleases=True)
        yield PackageCheck(needed.name, installed, str(needed.specifier), good)


def run_self_tests() -> tuple[SelfTest, ...]:
    """Validate a saw in both engines, with defects planted, in a temporary ledger."""
    with tempfile.TemporaryDirectory() as folder:
        runs = Runs(ledger=Path(folder, "ledger.sqlite"), jobs=1)
        found = validate(TESTED_SCENE, preset=TESTED_PRESET, revolutions=1, qualify=True, runs=runs)
    tests = list[SelfTest]()
    for result in found[TESTED_SCENE].results:
        if result.mode != "dynamic":
            continue
        planted = result.qualified.motion if result.qualified else ()
        noticed = {one.defect: bool(one.by) for one in planted}
        tests.append(
            SelfTest(
                result.engine,
                "within tolerance" if result.passed else f"out of tolerance ({result.outcome})",
                result.passed is True,
                tuple(name for name in TESTED_DEFECTS if noticed.get(name)),
                tuple(name for name in TESTED_DEFECTS if not noticed.get(name)),
            )
        )
    return tuple(tests)
