"""A slice is a folder that can be deleted: what it imports of others, and conrod without it (docs/design.md)."""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

import pytest
from import_graph import MODULES, ROOT, import_graph, within

from conrod.slices import REQUIRED, SLICES

PACKAGES = {one.folder: one.package for one in SLICES}
OPTIONAL = [folder for folder in PACKAGES if folder not in REQUIRED]
# Imports in functions, when they are asked for: by an option or by the kind of a file.
ON_DEMAND = {
    ("studies.validation", "studies.detection"), ("studies.validation", "verification"),
    ("models.check", "models.tables"), ("models.check", "models.fmu"), ("models.check", "models.loops"),
    ("models.check", "models.torque_runs"),
    ("models.check", "verification"), ("studies.validation", "models.check"),
    ("models.check", "studies.detection"), ("guide.explain", "models.lint"),
    ("guide.explain", "studies.limits"),
    ("models.check", "models.inspection"),
    ("models.check", "models.engine_comparison"),
    ("studies.versions", "models.upgrades"), ("studies.validation", "studies.space"),
}  # fmt: skip
ASSEMBLED = "verification"  # puts findings of others together, and stands above them

WITHOUT = """
import sys
from pathlib import Path
import conrod
from click.testing import CliRunner
from conrod.cli import VERBS, cli

copy, project, ledger, verbs, functions = sys.argv[1:6]
assert Path(conrod.__file__).is_relative_to(copy), conrod.__file__
told = CliRunner().invoke(cli, ["--help"], standalone_mode=False)
assert told.exit_code == 0 and "validate" in told.output, told.output
assert not set(verbs.split()) & {*VERBS} and not set(functions.split()) & {*conrod.__all__}
runs = conrod.Runs(ledger=Path(ledger), jobs=1)
found = conrod.validate("saw-500rpm", engines="mujoco", preset="tuned", steps_per_rev=200, revolutions=1, runs=runs)
assert found.passed, found.verdict
model = Path(project, "mjcf", "saw-500rpm.xml")
found = conrod.check(model, "saw-500rpm", crank="crank", points={"C": "body:slider"}, revolutions=1)
assert found.passed, found.verdict
"""


def slice_of(module: str) -> str | None:
    return next((folder for folder, package in PACKAGES.items() if within(module, package)), None)


def imports_of_others(graph: dict[str, set[str]]) -> set[tuple[str, str]]:
    """Pairs of slices of which the first imports the second, and does not name it as one that it is built on."""
    built_on = {(one.folder, other) for one in SLICES for other in one.uses}
    pairs = {(slice_of(module), slice_of(name)) for module, names in graph.items() for name in names}
    return {(a, b) for a, b in pairs if a and b and a not in (b, ASSEMBLED) and (a, b) not in built_on | ON_DEMAND}


def test_a_slice_imports_only_those_it_is_built_on() -> None:
    assert imports_of_others(import_graph()) == set()
    # Negative control.
    planted = {"conrod.studies.limits.plan": {"conrod.studies.sweep.findings"}}
    assert imports_of_others(planted) == {("studies.limits", "studies.sweep")}


def test_no_room_below_imports_a_slice() -> None:
    # The command line's own modules may when a verb asks for it.
    below = {module for module in MODULES if slice_of(module) is None and not within(module, "conrod.cli")}
    found = {module: names for module in below if (names := {n for n in import_graph()[module] if slice_of(n)})}
    assert found == {}


def test_table_of_slices_names_every_folder_and_nothing_else() -> None:
    packages = (path.parent for room in ("studies", "models", "guide") for path in (ROOT / room).glob("*/__init__.py"))
    folders = {f"{path.parent.name}.{path.name}" for path in packages}
    assert {*PACKAGES} - {ASSEMBLED} == folders
    for one in SLICES:
        reports = {place.rpartition(".")[0] for place in one.reports.values()}
        modules = {*one.functions.values(), *reports, *(["verb"] if one.verbs else [])}
        assert {f"{one.package}.{module}" for module in modules} <= {*MODULES}


def entry_removed(source: str, folders: Iterable[str]) -> str:
    """The table of slices without the entries of some folders, and without their names where others use them."""
    lines = source.splitlines()
    calls = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Call) and node.args]
    for node in sorted(calls, key=lambda one: -one.lineno):
        if ast.unparse(node.func) == "Slice" and ast.literal_eval(node.args[0]) in folders:
            assert node.end_lineno is not None
            del lines[node.lineno - 1 : node.end_lineno]
    return "\n".join(lines) + "\n"


def run_without(folders: list[str], place: Path) -> None:
    """Validate a saw and check a model by a copy of the package without some slices."""
    copy = place / "conrod"
    shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns("__pycache__"))
    for folder in folders:
        shutil.rmtree(copy.joinpath(*folder.split(".")))
    table = copy / "slices.py"
    table.write_text(entry_removed(table.read_text(encoding="utf-8"), folders), encoding="utf-8")
    dropped = [one for one in SLICES if one.folder in folders]
    verbs, functions = ([name for one in dropped for name in getattr(one, what)] for what in ("verbs", "functions"))
    done = subprocess.run(
        [
            sys.executable, "-c", WITHOUT, place, Path(__file__).parents[1], place / "ledger.sqlite", " ".join(verbs),
            " ".join(functions),
        ],
        env={**os.environ, "PYTHONPATH": str(place)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


def test_conrod_works_without_any_optional_slice(tmp_path: Path) -> None:
    run_without(OPTIONAL, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("folder", OPTIONAL)
def test_conrod_works_without_a_slice(folder: str, tmp_path: Path) -> None:
    run_without([folder, *(one.folder for one in SLICES if folder in one.uses)], tmp_path)


def test_removal_of_a_required_slice_is_detected(tmp_path: Path) -> None:
    # Negative control: the run does need what it says it needs.
    with pytest.raises(AssertionError, match=r"validat|ModuleNotFound|AttributeError"):
        run_without(["studies.validation"], tmp_path)
