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
from conrod.models.check.study import ModelBench
from conrod.models.check.turning import Turning, prepare_turning
from conrod.scenes import SCENES

ROOT = Path(__file__).parents[2]
HACKSAW = Path(__file__).parent / "own_models" / "hacksaw.xml"
FILES = {"saw": "saw-40rpm", "press": "shear-press", "cam": "cam-follower"}
TEXTS = {name: (ROOT / "mjcf" / f"{file}.xml").read_text(encoding="utf-8") for name, file in FILES.items()}
POINTS = {"saw": ("C", "M"), "press": ("A", "G"), "cam": ("roller",)}

ROD_END = 'name="slider-pin.rod" pos="0.3 0 0"'


def replace_once(text: str, old: str, new: str) -> str:
    """Replace a text that occurs exactly once."""
    assert text.count(old) == 1, old
    return text.replace(old, new)


def wrap_in_body(text: str, **attributes: str) -> str:
    """Wrap the whole model in a body that does not move."""
    inside = " ".join(f'{name}="{value}"' for name, value in attributes.items())
    text = replace_once(text, "<worldbody>", f"<worldbody><body {inside}>")
    # The camera is for the world.
    return replace_once(text, "</worldbody>", "</body></worldbody>")


def multiply_attributes(text: str, factors: Mapping[str, Sequence[float]]) -> str:
    """Multiply numbers of the worldbody's attributes by cyclic factors, given by attribute name."""
    root = ET.fromstring(text)
    for element in root.find("worldbody").iter():
        for name in factors.keys() & element.keys():
            values = np.array(element.attrib[name].split(), dtype=float)
            element.set(name, " ".join(map(repr, (values * np.resize(factors[name], len(values))).tolist())))
    return ET.tostring(root, encoding="unicode")


def scale_lengths(text: str, factor: float) -> str:
    """Convert a model to another unit of length."""
    return multiply_attributes(text, dict.fromkeys(("pos", "fromto", "size"), (factor,)))


def mirror_x(text: str) -> str:
    """Mirror a model along x; hinges keep their axes."""
    return multiply_attributes(text, dict.fromkeys(("pos", "fromto", "axis"), (-1.0, 1.0, 1.0)) | {"euler": (-1.0,)})


def replace_settings(text: str, option: str, closure: str = "") -> str:
    """Replace the options, and remove the drive's armature."""
    text = re.sub(r"<option.*?</option>", option, text, flags=re.DOTALL)
    text = re.sub(r' armature="[^"]*"', "", text)
    return re.sub(r"(<connect [^>]*?) solref=.*?/>", rf"\1 {closure}/>", text)


def question(kind: str, **asked: object) -> ModelRequest:
    """Request for a machine with all observed points at the sites of conrod's own files."""
    mechanism = SCENES[FILES[kind]].mechanism()
    points = asked.pop("points", POINTS[kind])
    places = tuple(p if isinstance(p, PointPlace) else PointPlace(p, "site", p) for p in points)
    crank = str(asked.pop("crank", "crank"))
    return ModelRequest(crank, places, mechanism.mobility, len(mechanism.cam_contacts), **asked)  # type: ignore[arg-type]


_TURNS: dict[tuple[str, str], tuple[Turning, Scan]] = {}


def scan_text(folder: Path, text: str, put: ModelRequest) -> tuple[Path, Turning, Scan]:
    """Write a model to a file and scan its paths, once for all tests with the same request."""
    path = folder / "model.xml"
    path.write_text(text, encoding="utf-8")
    key = (text, repr(put))
    if key not in _TURNS:
        turning = prepare_turning(path, put)
        _TURNS[key] = turning, scan(turning, put)
    return path, *_TURNS[key]


def identify_text(folder: Path, kind: str, text: str, given: GivenFrame | None = None, **asked: object) -> Identity:
    """Identify a model by its paths, in this process."""
    *_, found = scan_text(folder, text, question(kind, **asked))
    return identify(SCENES[FILES[kind]], found, given or GivenFrame())[0]


def judge_text(
    folder: Path, kind: str, text: str, turns: float = 1.0, tolerance: dict[str, float] | None = None,
    spoil: Callable[[LoopRecording], LoopRecording] = lambda run: run, refine: bool = False, qualify: bool = False,
    **asked: object,
) -> ModelStudy:  # fmt: skip
    """Study a model against its machine, in this process; `spoil` changes each run before it is judged."""
    put = question(kind, **asked)
    path, turning, found = scan_text(folder, text, put)
    judge, known = ModelBench.judge, {"prepare_turning": lambda *_: turning, "scan": lambda *_: found}
    spoiled = patch.object(ModelBench, "judge", lambda bench, label, run, step: judge(bench, label, spoil(run), step))
    with patch.multiple(scene_study, **known), spoiled:
        return scene_study.study_scene_model(
            path, (FILES[kind], SCENES[FILES[kind]]), put, GivenFrame(), turns, tolerance, refine, qualify
        )
