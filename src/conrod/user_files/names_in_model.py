"""Names of the elements of a MuJoCo model, read from its text: no library for models is loaded, nothing is compiled."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path
from xml.parsers.expat import ExpatError, ParserCreate

MAX_BYTES = 2**20  # of all files together that are read; names beyond are not found
# Joints are kept by their type, as MJCF and URDF call it; all that is driven by an actuator's control is an actuator.
JOINT_TYPES = {"revolute": "hinge", "continuous": "hinge", "prismatic": "slide"}
KINDS = {"site": "site", "body": "body", "link": "body", "geom": "geom", "key": "key"}


def names_in_model(path: Path) -> Mapping[str, list[str]]:
    """Read the names in a model file and the files that it includes.

    Returns:
        Names by kind, in the order of the file: hinge, slide, ball, site, body, geom, key, actuator; empty for a file
        that cannot be read, is no XML or is no model's text.
    """
    reader = _NameReader(path.parent)
    try:
        reader.read_file(path)
    except (OSError, ExpatError, ValueError, LookupError, RecursionError):
        return {}
    return reader.names()


class _NameReader:
    """Reader of names in a model file and its includes; resolves joint types by classes of defaults."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._room = MAX_BYTES
        self._read: set[Path] = set()
        self._open: list[tuple[str, str]] = []  # elements that are open, each with the class of its joints
        self._found = defaultdict[str, list[str]](list)
        self._joints = list[tuple[str, str, str]]()  # name, stated type or "", class
        self._types, self._parents = dict[str, str](), dict[str, str]()  # by class of defaults

    def names(self) -> Mapping[str, list[str]]:
        """Return all names by kind; joints by their type (hinge, slide, ball)."""
        joints = defaultdict[str, list[str]](list)
        for name, stated, joint_class in self._joints:
            joints[stated or self._type_of_class(joint_class)].append(name)
        return {**self._found, **joints}

    def read_file(self, path: Path) -> None:
        """Read the names in a file, and in the files that it includes."""
        if path.resolve() in self._read or not path.is_file():
            return
        self._read.add(path.resolve())
        with path.open("rb") as file:
            text = file.read(self._room)
        self._room -= len(text)
        parser, depth = ParserCreate(), len(self._open)
        parser.StartElementHandler = lambda tag, given: self._begin(tag, given, path.parent)
        parser.EndElementHandler = lambda tag: self._open.pop()
        parser.Parse(text, self._room > 0)  # a text that is cut off is not at its end
        del self._open[depth:]

    def _begin(self, tag: str, given: Mapping[str, str], folder: Path) -> None:
        parent, joint_class = self._open[-1] if self._open else ("", "")
        inside, name = {one for one, _ in self._open}, given.get("name", "")
        if tag == "default":
            top = "default" not in inside
            own = "" if top else given.get("class", joint_class)
            self._parents.setdefault(own, joint_class) if not top else None
            joint_class = own
        elif tag == "include":
            self._include(given.get("file", ""), folder)
        elif tag in ("joint", "freejoint") and "default" in inside:
            self._types[joint_class] = given.get("type", "")
        elif parent == "actuator":
            self._keep("actuator", name)
        elif tag == "joint" and "equality" not in inside and is_plain_word(name):
            stated = given.get("type", "")
            self._joints.append((name, JOINT_TYPES.get(stated, stated), given.get("class", joint_class)))
        elif tag in KINDS:
            self._keep(KINDS[tag], name)
        self._open.append((tag, given.get("childclass", joint_class)))

    def _include(self, name: str, folder: Path) -> None:
        """Read an included file, from the folder of the model or else of the including file."""
        for place in dict.fromkeys((self._folder, folder)):
            if name and (place / name).is_file():
                self.read_file(place / name)
                return

    def _keep(self, kind: str, name: str) -> None:
        if is_plain_word(name):
            self._found[kind].append(name)

    def _type_of_class(self, joint_class: str) -> str:
        """Joint type of a class of defaults or its nearest ancestor with one; a hinge without any."""
        for _ in range(len(self._parents) + 1):
            if self._types.get(joint_class):
                break
            joint_class = self._parents.get(joint_class, "")
        return self._types.get(joint_class) or "hinge"


def is_plain_word(name: str) -> bool:
    """True if a name is one word that a shell takes without quotes, and a terminal shows."""
    return bool(name) and name.isprintable() and not set(name) & set(" \"'`$\\&|;<>()*?[]!#~")
