"""Models as users might bring them: conrod's own files, edited as text."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from unittest.mock import patch

import numpy as np

from conrod.mjcf.driving import LoopRecording
from conrod.mjcf.request import ModelRequest, PointPlace, Scan
from conrod.models.check import study as scene_study
from conrod.models.check.frame import GivenFrame
from conrod.models.check.identity import Identity, identify
from conrod.models.check.results import ModelStudy
from conrod.models.check.scanning import scan
from conrod.models.check.study import SceneBench
from conrod.models.check.turning import Turning, prepare_turning
from conrod.scenes import SCENES

ROOT = Path(__file__).parents[2]
HACKSAW = Path(__file__).parent / "own_models" / "hacksaw.xml"
FILES = {"saw": "saw-40rpm", "press": "shear-press", "cam": "cam-follower"}
TEXTS = {name: (ROOT / "mjcf" / f"{file}.xml").read_text(encoding="utf-8") for name, file in FILES.items()}
POINTS = {"saw": ("C", "M"), "press": ("A", "G"), "cam": ("roller",)}

ROD_END = 'name="slider-pin.rod" pos="0.3 0 0"'


def replaced(text: str, old: str, new: str) -> str:
    """An edit that is sure to have been made."""
    assert text.count(old) == 1, old
    return text.replace(old, new)


def placed(text: str, **attributes: str) -> str:
    """All of the model within a body that does not move."""
    inside = " ".join(f'{name}="{value}"' for name, value in attributes.items())
    text = replaced(text, "<worldbody>", f"<worldbody><body {inside}>")
    # The camera is for the world.
    return replaced(text, "</worldbody>", "</body></worldbody>")


def multiplied(text: str, factors: Mapping[str, Sequence[float]]) -> str:
    """Numbers of the worldbody's attributes times factors by name, which are taken in turns."""
    root = ET.fromstring(text)
    for element in root.find("worldbody").iter():
        for name in factors.keys() & element.keys():
            values = np.array(element.attrib[name].split(), dtype=float)
            element.set(name, " ".join(map(repr, (values * np.resize(factors[name], len(values))).tolist())))
    return ET.tostring(root, encoding="unicode")


def scaled(text: str, factor: float) -> str:
    """In another unit of length."""
    return multiplied(text, dict.fromkeys(("pos", "fromto", "size"), (factor,)))


def mirrored(text: str) -> str:
    """x to the left; hinges keep their axes."""
    return multiplied(text, dict.fromkeys(("pos", "fromto", "axis"), (-1.0, 1.0, 1.0)) | {"euler": (-1.0,)})


def settled(text: str, option: str, closure: str = "") -> str:
    """With other options, and the drive's armature taken away."""
    text = re.sub(r"<option.*?</option>", option, text, flags=re.DOTALL)
    text = re.sub(r' armature="[^"]*"', "", text)
    return re.sub(r"(<connect [^>]*?) solref=.*?/>", rf"\1 {closure}/>", text)


def question(kind: str, **asked: object) -> ModelRequest:
    """All points of a machine at the sites that conrod's own files have for them."""
    mechanism = SCENES[FILES[kind]].mechanism()
    points = asked.pop("points", POINTS[kind])
    places = tuple(p if isinstance(p, PointPlace) else PointPlace(p, "site", p) for p in points)
    crank = str(asked.pop("crank", "crank"))
    return ModelRequest(crank, places, mechanism.mobility, len(mechanism.cam_contacts), **asked)  # type: ignore[arg-type]


_TURNS: dict[tuple[str, str], tuple[Turning, Scan]] = {}


def scanned(folder: Path, text: str, put: ModelRequest) -> tuple[Path, Turning, Scan]:
    """The model as a file, and what its paths are: followed once for all tests that ask the same of it."""
    path = folder / "model.xml"
    path.write_text(text, encoding="utf-8")
    key = (text, repr(put))
    if key not in _TURNS:
        turning = prepare_turning(path, put)
        _TURNS[key] = turning, scan(turning, put)
    return path, *_TURNS[key]


def seen(folder: Path, kind: str, text: str, given: GivenFrame | None = None, **asked: object) -> Identity:
    """What a model's paths say, in this process."""
    *_, found = scanned(folder, text, question(kind, **asked))
    return identify(SCENES[FILES[kind]], found, given or GivenFrame())[0]


def judged(
    folder: Path, kind: str, text: str, turns: float = 1.0, tolerance: dict[str, float] | None = None,
    spoil: Callable[[LoopRecording], LoopRecording] = lambda run: run, **asked: object,
) -> ModelStudy:  # fmt: skip
    """All of the judgement, in this process; `spoil` changes what is run before it is judged."""
    put = question(kind, **asked)
    path, turning, found = scanned(folder, text, put)
    judge, known = SceneBench.judge, {"prepare_turning": lambda *_: turning, "scan": lambda *_: found}
    spoiled = patch.object(SceneBench, "judge", lambda bench, label, run, step: judge(bench, label, spoil(run), step))
    with patch.multiple(scene_study, **known), spoiled:
        return scene_study.study_scene_model(
            path, (FILES[kind], SCENES[FILES[kind]]), put, GivenFrame(), turns, tolerance
        )
