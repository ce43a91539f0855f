"""Defects found in engines: each file stands alone, and shows what the page on them says."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from importlib.util import find_spec
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "docs" / "findings"
FILES = sorted(FOLDER.glob("*.py"))
PAGE = (FOLDER / "README.md").read_text(encoding="utf-8")
# Modules that a file may import, by what it requires.
MODULES = {"drake": {"pydrake"}, "newton": {"newton", "warp"}, "warp-lang": {"warp"}, "numpy": {"numpy"}}
MAX_LINES = 10


def required_packages(text: str) -> list[str]:
    """Names of the packages in the header of a script (PEP 723)."""
    (block,) = re.findall(r"^# /// script\n((?:#.*\n)+?)# ///$", text, re.MULTILINE)
    header = tomllib.loads("\n".join(line.removeprefix("#").strip() for line in block.splitlines()))
    return [re.split(r"[<>=!~\[; ]", one)[0] for one in header["dependencies"]]


def imported_modules(text: str) -> set[str]:
    """Modules that a script imports, but for Python's own."""
    found = set[str]()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found.add((node.module or "").partition(".")[0])
    return found - {*sys.stdlib_module_names}


def quoted_numbers(file: Path) -> list[str]:
    """What the page's row of a finding quotes of the file's output."""
    (row,) = (line for line in PAGE.splitlines() if line.startswith("|") and f"]({file.name})" in line)
    return re.findall(r"`([^`]+)`", row.split("|")[3] + row.split("|")[4])


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_finding_stands_alone_and_has_its_row(file: Path) -> None:
    text = file.read_text(encoding="utf-8")
    names = required_packages(text)
    assert "numpy" in names
    assert imported_modules(text) <= set[str]().union(*(MODULES[name] for name in names))
    assert ast.get_docstring(ast.parse(text))
    assert len(quoted_numbers(file)) >= 2, "the exact value and the engine's"


def test_every_link_of_the_table_is_a_finding() -> None:
    assert set(re.findall(r"\]\((\w+\.py)\)", PAGE)) == {file.name for file in FILES}


def test_a_finding_that_needs_conrod_is_seen() -> None:
    # Negative control: other imports and a missing header are noticed.
    text = FILES[0].read_text(encoding="utf-8")
    assert "conrod" in imported_modules(text + "\nfrom conrod.engines import engine_named\n")
    with pytest.raises(ValueError, match="unpack"):
        required_packages(text.replace("# /// script", "# script"))


@pytest.mark.slow
@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_finding_is_there_with_the_numbers_of_the_page(file: Path) -> None:
    modules = sorted(imported_modules(file.read_text(encoding="utf-8")))
    if missing := [name for name in modules if find_spec(name) is None]:
        pytest.skip(f"{' and '.join(missing)} is not installed")
    ended = subprocess.run([sys.executable, str(file)], capture_output=True, text=True, timeout=600, check=False)
    assert ended.returncode == 1, ended.stdout + ended.stderr
    assert len(ended.stdout.splitlines()) <= MAX_LINES
    for number in quoted_numbers(file):
        assert number in ended.stdout
