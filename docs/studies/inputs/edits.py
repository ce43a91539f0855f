"""Shipped models, mechanism files and tables, and edits of them as texts."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from conrod.engines.mujoco.standalone import standalone_mjcf
from conrod.exact.motion import Array
from conrod.scenes import SCENES, Scene, catalogue_text, scene_named
from conrod.scenes.space import MACHINES

ROOT = Path(__file__).parents[3]
SAW = "--scene saw-40rpm --crank crank --point C=site:C --point M=site:M"
HACKSAW = "--scene saw-40rpm --crank motor --point C=body:bow --point M=geom:rod"
PRESS = "--scene shear-press --crank crank --point A=site:A --point G=site:G"
CUTTER = "--scene web-cutter --crank crank --point P=site:P --point C=site:C"
SMALL = "--tolerance position=1e-4"
ROD_END = 'name="slider-pin.rod" pos="0.3 0 0"'
KEYFRAME = '<key name="start" qpos="0 0 0" qvel="-0.1317313576766063 4.1887902047863905 -2.7251084528240996" />'
CLOSURE = (
    '<connect name="slider-pin" site1="slider-pin.rod" site2="slider-pin.slider" solref="0.012 1" '
    'solimp="0.9999 0.9999 0.001 0.5 2" />'
)
CRANK = '<joint name="crank" type="hinge" axis="0 0 1" armature="1e+14" />'
SLIDE = '<joint name="slide" type="slide" axis="1 0 0" />'
PIN = '<joint name="crank-pin" type="hinge" axis="0 0 1" />'
ROD_TURN = 2.836899999574396  # [rad] of the rod in the reference pose


@cache
def saw() -> str:
    """conrod's own model of the hacksaw, MJCF, at 40 rpm."""
    return (ROOT / "mjcf" / "saw-40rpm.xml").read_text(encoding="utf-8")


@cache
def hacksaw() -> str:
    """The hacksaw as somebody else might draw it: another frame, another tree, stock closures."""
    return (ROOT / "tests" / "support" / "own_models" / "hacksaw.xml").read_text(encoding="utf-8")


def exported(name: str, **parameters: float) -> str:
    """The MJCF model of a scene with other parameters, SI, where they are given."""
    if name in MACHINES:
        return MACHINES[name]().mjcf
    scene = scene_named(name)
    return standalone_mjcf(name, scene.with_parameters(**parameters) if parameters else scene, None)


def toml(name: str) -> str:
    """A mechanism file of the catalogue."""
    return catalogue_text(name)


def replaced(text: str, *pairs: tuple[str, str]) -> str:
    """Edits of which each is sure to have been made."""
    for old, new in pairs:
        assert text.count(old) == 1, f"{text.count(old)} times: {old}"
        text = text.replace(old, new)
    return text


def multiplied(text: str, factors: Mapping[str, Sequence[float]]) -> str:
    """Numbers of the worldbody's attributes times factors by name, which are taken in turns."""
    root = ElementTree.fromstring(text)
    world = root.find("worldbody")
    assert world is not None
    for element in world.iter():
        for name in factors.keys() & element.keys():
            values = np.array(element.attrib[name].split(), dtype=float)
            element.set(name, " ".join(map(repr, (values * np.resize(factors[name], len(values))).tolist())))
    return ElementTree.tostring(root, encoding="unicode")


def scaled(text: str, factor: float) -> str:
    """All lengths of the worldbody times a factor."""
    return multiplied(text, dict.fromkeys(("pos", "fromto", "size"), (factor,)))


def rounded(text: str, digits: int) -> str:
    """All numbers with a fraction in so many digits, as somebody types them."""
    return re.sub(r"-?\d+\.\d{6,}(?:e-?\d+)?", lambda found: f"{float(found[0]):.{digits}g}", text)


def placed(text: str, **attributes: str) -> str:
    """All of a model within a body that does not move."""
    inside = " ".join(f'{name}="{value}"' for name, value in attributes.items())
    text = replaced(text, ("<worldbody>", f"<worldbody><body {inside}>"))
    return replaced(text, ("</worldbody>", "</body></worldbody>"))


def saw_keyframe(degrees: float, rate: float = 1.0) -> str:
    """A keyframe of the saw on its exact motion at a crank angle, its rates times a factor."""
    scene = SCENES["saw-40rpm"]
    angle = np.array([np.radians(degrees)])
    poses, slopes = scene.kinematics.derivatives(angle, order=1)
    place = {body: 3 * k for body, k in scene.kinematics.mechanism.body_index.items()}
    found = []
    for values in (poses[0], slopes[0] * scene.speed * rate):
        crank, rod = (values[place[body] + 2] for body in ("crank", "rod"))
        found.append([values[place["slider"]], crank, rod - crank])
    found[0][2] -= ROD_TURN
    qpos, qvel = (" ".join(map(repr, map(float, values))) for values in found)
    return f'<key name="start" qpos="{qpos}" qvel="{qvel}" />'


def served(text: str, control: float, gain: float = 100.0, timestep: float = 0.0003) -> str:
    """The saw with a velocity servo on its crank in place of conrod's flywheel, and a control in its keyframe."""
    text = replaced(text, (' armature="1e+14"', ""), ('timestep="0.0015"', f'timestep="{timestep}"'))
    servo = f'<actuator><velocity name="motor" joint="crank" kv="{gain}" /></actuator>'
    text = replaced(text, ("<sensor>", f"{servo}<sensor>"))
    return re.sub(r'(<key name="start"[^>]*?) />', rf'\1 ctrl="{control}" />', text)


# -- tables ------------------------------------------------------------------------------------------------------------

Columns = dict[str, Array]


def saw_table(*quantities: str, rows: int = 180, turns: float = 1.0, scene: Scene | None = None) -> Columns:
    """Columns of the exact motion of the saw, SI, by conrod's names: time, crank angle, and what is asked for."""
    made = scene or SCENES["saw-40rpm"]
    times = np.arange(round(rows * turns) + 1) * made.period / rows
    columns = {"time": times, "crank_angle": made.speed * times}
    for point, motion in made.reference(times).points.items():
        for quantity in quantities or ("position",):
            letters = {"position": "", "velocity": "v", "acceleration": "a"}[quantity]
            values = getattr(motion, quantity)
            columns |= {f"{point}.{letters}{axis}": values[:, k].copy() for k, axis in enumerate("xy")}
    return columns


def csv(columns: Mapping[str, Array], digits: int = 12, separator: str = ",", decimal: str = ".") -> str:
    """Columns as a text table."""
    rows = zip(*columns.values(), strict=True)
    texts = [separator.join(f"{value:.{digits}g}".replace(".", decimal) for value in row) for row in rows]
    return "\n".join([separator.join(columns), *texts]) + "\n"


def renamed(columns: Mapping[str, Array], **names: str) -> Columns:
    """Columns under other headings, by a name with `_` for the point: `C_x="C.x [mm]"`."""
    given = {name.replace("_", ".", 1) if name[0].isupper() else name: heading for name, heading in names.items()}
    return {given.get(name, name): values for name, values in columns.items()}
