"""conrod's own models with something planted in them, and all their names exchanged for random ones."""

from __future__ import annotations

import random
import string
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

MJCF = Path(__file__).parents[2] / "mjcf"
SAW = (MJCF / "saw-500rpm.xml").read_text(encoding="utf-8")
REFERENCES = ("name", "site1", "site2", "objname", "mesh", "geom1", "geom2", "site", "refsite", "body1", "body2")
CLOSURE = 'solref="0.00096 1" solimp="0.9999 0.9999 0.001 0.5 2"'
INERT = 'contype="0" conaffinity="0" '


def renamed(text: str, seed: int = 0) -> str:
    """A model in which no name says what it is."""
    rng = random.Random(seed)
    root = ElementTree.fromstring(text)
    named = [element.attrib["name"] for element in root.iter() if "name" in element.attrib]
    letters = {name: "".join(rng.choices(string.ascii_lowercase, k=12)) for name in sorted(set(named))}
    for element in root.iter():
        for attribute in REFERENCES:
            if element.get(attribute) in letters:
                element.set(attribute, letters[element.attrib[attribute]])
    return ElementTree.tostring(root, encoding="unicode")


def replaced(old: str, new: str) -> Callable[[str], str]:
    """An edit that is sure to change something."""

    def edit(text: str) -> str:
        assert old in text, old
        return text.replace(old, new)

    return edit


def colliding_links(text: str) -> str:
    return replaced(INERT, "")(replaced(' contact="disable"', "")(text))


def closed_twice(text: str) -> str:
    again = f'<connect site1="slider-pin.rod" site2="slider-pin.slider" {CLOSURE} />'
    return replaced("</equality>", f"{again}</equality>")(text)


@dataclass(frozen=True)
class Plant:
    """What is planted, the findings that are to be, and how long to run [s]: a turn of the crank takes 0.12 s."""

    edit: Callable[[str], str]
    expected: frozenset[str]
    seconds: float


def plant(edit: Callable[[str], str], *expected: str, seconds: float = 0.03) -> Plant:
    return Plant(edit, frozenset(expected), seconds)


PLANTED = {
    "links that collide at their pin": plant(colliding_links, "joined-links-collide"),
    "a loop closed twice": plant(closed_twice, "redundant-closure"),
    "a soft closure": plant(replaced(f" {CLOSURE}", ""), "soft-closure"),
    "a void tolerance": plant(replaced('tolerance="0" ', ""), "solver-stops-early"),
    "a silent reset": plant(replaced('autoreset="disable" ', ""), "silent-reset"),
    "a step that is too long": plant(replaced('timestep="0.00012"', 'timestep="0.05"'), "step-too-long", seconds=10.0),
    "an open start": plant(replaced('euler="0 0 2.836899999574396"', 'euler="0 0 2.8379"'), "open-start"),
}
