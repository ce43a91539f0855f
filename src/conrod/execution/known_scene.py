"""A process that runs many cells of one scene computes the scene's tables once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import TypeVar

from conrod.scenes import Scene
from conrod.studies.cell import Cell

Result = TypeVar("Result")

# A sweep has few scenes, a map of limits one in each of its rows; each takes 0.8 MB.
SCENES_KEPT = 128


def on_known_scene(task: Callable[[Cell], Result], cell: Cell) -> Result:
    """What a task makes of a cell, its scene being the equal one that this process has met before, if it has.

    A cell that arrives from another process brings its scene's parameters alone. Tables that are computed from them
    take longer than most runs.
    """
    return task(replace(cell, scene=_known(cell.scene)))


@lru_cache(SCENES_KEPT)
def _known(scene: Scene) -> Scene:
    return scene
