"""A scene in words: its description with its numbers, and its parameters as people write them."""

from __future__ import annotations

from conrod.report import numbers
from conrod.report.table import Table, table
from conrod.scenes import Scene


def described(scene: Scene) -> str:
    """The scene's description, with a number and its unit where it names a parameter."""
    facts = scene.parameter_facts()
    words = {
        name: " ".join(numbers.in_shown_unit(value, facts[name].unit)).removesuffix(" -")
        for name, value in scene.parameters.items()
    }
    return scene.description.format(**words)


def parameters_table(scene: Scene) -> Table:
    """Values, units and meanings of the scene's parameters."""
    facts = scene.parameter_facts()
    rows = [
        (f"`{name}`", *numbers.in_shown_unit(value, facts[name].unit), facts[name].meaning)
        for name, value in scene.parameters.items()
    ]
    return table(("parameter", "value", "unit", "meaning"), rows, right=("value",))
