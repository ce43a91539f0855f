"""What a scene says of itself, with its parameters as people write them."""

from __future__ import annotations

from conrod.report import numbers
from conrod.scenes import Scene


def described(scene: Scene) -> str:
    """The scene's description, with a number and its unit where it names a parameter."""
    facts = scene.parameter_facts()
    words = {
        name: " ".join(numbers.in_shown_unit(value, facts[name].unit)).removesuffix(" -")
        for name, value in scene.parameters.items()
    }
    return scene.description.format(**words)
