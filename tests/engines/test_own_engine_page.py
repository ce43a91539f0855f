"""The engine that docs/own-engine.md walks through keeps the rules, and its law holds."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from conrod.engines.running import whole_run
from conrod.runs.comparison import compare
from conrod.scenes import SCENES
from conrod.testing import EngineConformance

PAGE = Path(__file__).parents[2] / "docs" / "own-engine.md"
SAW: Any = SCENES["saw-500rpm"]
CODE = "\n".join(re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL))


def engine_of(code: str) -> Any:
    """The engine that a module of this code has."""
    module = sys.modules["shake_engine"] = ModuleType("shake_engine")
    exec(compile(code, str(PAGE), "exec"), vars(module))
    return module.ENGINE


class TestShake(EngineConformance):
    engine = engine_of(CODE)
    scenes = ("saw-500rpm",)
    steps = (100, 200)


@pytest.mark.parametrize(
    ("what", "wrong", "seen"),
    [
        ("", "", ()),
        ("np.diff(values, 2, axis=0) / h**2", "0.999 * np.diff(values, 2, axis=0) / h**2", ("acceleration",)),
        ("return x + out *", "return x + 1.001 * out *", ("position", "velocity", "acceleration")),
    ],
)
def test_its_law_bounds_its_errors_and_a_mistake_breaks_it(what: str, wrong: str, seen: tuple[str, ...]) -> None:
    assert what in CODE
    engine = engine_of(CODE.replace(what, wrong, 1))
    settings = engine.presets["tuned"](SAW, 200)
    found, law = compare(whole_run(engine, SAW, settings, 1.0), SAW), engine.expected_error(SAW, settings)
    for quantity in ("position", "velocity", "acceleration"):
        assert (found.worst(quantity) > getattr(law, quantity)) == (quantity in seen)
