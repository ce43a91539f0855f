"""A pack's parameters, made into the scene that they are of."""

from __future__ import annotations

import json
from pathlib import Path

from conrod.errors import InvalidInput, unknown_choice
from conrod.scenes import SCENES, Scene
from conrod.scenes.parameters import parameters_of


def read_parameters(path: Path) -> Scene:
    """The scene of a pack's `parameters.json`.

    Raises:
        InvalidInput: the file is none, or its values are not within range.
    """
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        kind, given = document["kind"], document["parameters"]
        values = {name: float(entry["value"]) for name, entry in given.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise InvalidInput(f"{path}: it does not hold the parameters of a pack") from None
    kinds = {scene.kind: type(scene) for scene in SCENES.values()}
    if kind not in kinds:
        raise unknown_choice("kind of scene", str(kind), kinds)
    known = parameters_of(kinds[kind])
    for name in values:
        if name not in known:
            raise unknown_choice("parameter", name, known)
    missing = sorted(known.keys() - values.keys())
    if missing:
        raise InvalidInput(f"{path}: there is no {', '.join(missing)}")
    return kinds[kind](**values)
