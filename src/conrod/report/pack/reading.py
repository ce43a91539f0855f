"""A pack's parameters, made into the scene that they are of."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.parameters import parameters_of
from conrod.report.pack.contents import MACHINE
from conrod.scenes import SCENES, Scene
from conrod.scenes.described_scene import DescribedScene, read_scene


def read_parameters(path: Path) -> Scene:
    """The scene of a pack's `parameters.json`; that of a mechanism file needs the file, which lies beside it.

    Raises:
        InvalidInput: the file is none, or its values are not within range.
    """
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        kind, given = document["kind"], document["parameters"]
        values = {name: float(entry["value"]) for name, entry in given.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise InvalidInput(f"{path}: it does not hold the parameters of a pack") from None
    if "machine" in document:
        return _of_file(path, read_scene(path.parent / MACHINE), values)
    kinds = {scene.kind: type(scene) for scene in SCENES.values()}
    if kind not in kinds:
        raise unknown_choice("kind of scene", str(kind), kinds)
    _check_names(path, values, parameters_of(kinds[kind]))
    return kinds[kind](**values)


def _of_file(path: Path, scene: DescribedScene, values: Mapping[str, float]) -> Scene:
    usual = scene.parameters
    _check_names(path, values, usual)
    changed = {name: value for name, value in values.items() if value != usual[name]}
    return scene.with_parameters(**changed) if changed else scene


def _check_names(path: Path, values: Mapping[str, float], known: Mapping[str, object]) -> None:
    for name in values:
        if name not in known:
            raise unknown_choice("parameter", name, known)
    missing = sorted(known.keys() - values.keys())
    if missing:
        raise InvalidInput(f"{path}: there is no {', '.join(missing)}")
