"""What `import conrod` shows is public, and all of it."""

from __future__ import annotations

import ast
import inspect
from pathlib import Path

import pytest

import conrod


def test_completion_and_help_show_the_public_names_and_nothing_else() -> None:
    assert dir(conrod) == sorted(conrod.__all__)
    assert {"SCENES", "compare", "run"} <= set(dir(conrod))
    shown = dict(inspect.getmembers(conrod))
    assert all(shown[name] is getattr(conrod, name) for name in conrod.__all__)


def test_type_checkers_see_the_same_names() -> None:
    tree = ast.parse(Path(conrod.__file__).read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING")
    typed = {f"{node.module}.{a.asname}" for node in block.body if isinstance(node, ast.ImportFrom) for a in node.names}
    assert typed == {f"{module}.{name}" for name, module in conrod._HOMES.items()}


def test_a_name_that_is_not_there_is_answered_with_those_that_are() -> None:
    with pytest.raises(AttributeError, match=r"no attribute 'Simulate'; it has .*compare, .*run"):
        _ = conrod.Simulate  # type: ignore[attr-defined]  # that is the mistake
