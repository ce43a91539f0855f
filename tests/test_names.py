"""Names that many have to read: of tests, and of classes (docs/glossary.md)."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
MAX_TEST_NAME = 60  # characters


def definitions(folder: str, kind: type[ast.FunctionDef] | type[ast.ClassDef]) -> Iterator[tuple[str, str]]:
    """File and name of each definition of a kind below a folder."""
    for file in sorted((ROOT / folder).rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, kind):
                yield str(file.relative_to(ROOT)), node.name


def long_test_names(names: Iterable[tuple[str, str]]) -> list[tuple[str, str]]:
    return [(file, name) for file, name in names if name.startswith("test_") and len(name) > MAX_TEST_NAME]


def repeated(names: Iterable[tuple[str, str]]) -> dict[str, int]:
    """Public names that are defined more than once, with how often."""
    counts = Counter(name for _, name in names if not name.startswith("_"))
    return {name: count for name, count in counts.items() if count > 1}


def test_test_names_have_at_most_sixty_characters() -> None:
    named = [*definitions("tests", ast.FunctionDef), *definitions("src/conrod", ast.FunctionDef)]
    assert long_test_names(named) == []
    # Negative control.
    assert long_test_names([("a.py", "test_" + 60 * "x")]) == [("a.py", "test_" + 60 * "x")]


def test_no_two_public_classes_have_one_name() -> None:
    assert repeated(definitions("src/conrod", ast.ClassDef)) == {}
    # Negative control.
    assert repeated([("a.py", "Verdict"), ("b.py", "Verdict"), ("b.py", "_Law"), ("c.py", "_Law")]) == {"Verdict": 2}


def test_no_test_hides_another_of_its_name() -> None:
    hidden = []
    for file in sorted((ROOT / "tests").rglob("test_*.py")):
        body = ast.parse(file.read_text(encoding="utf-8")).body
        counts = Counter(node.name for node in body if isinstance(node, ast.FunctionDef))
        hidden += [(file.name, name) for name, count in counts.items() if count > 1]
    assert hidden == []
