"""A user's MJCF as one tree in memory, of which edited copies are compiled; the file itself is only read.

Includes are put in their places, as MuJoCo does it. That the tree is the user's model is not believed but checked: it
compiles to the same arrays.
"""

from __future__ import annotations

import contextlib
import copy
import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import assert_never
from xml.etree import ElementTree

import mujoco
import numpy as np

from conrod.engines.mujoco import older
from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.errors import InvalidInput
from conrod.mjcf.lint.findings import Change, Edit, Exclude, SetOption
from conrod.own.models.loading import load_model

Element = ElementTree.Element
INCLUDES_DEEP = 32  # MuJoCo refuses a file that includes itself, so this is never reached by one that loads
# Elements that stand for others which MuJoCo makes.
MACROS = ("composite", "flexcomp", "attach")
IN_BODIES = {"body": "body", "geom": "geom", "joint": "joint", "freejoint": "joint"}
GIVEN = "conrod-lint-"  # begins the names that elements without one have while they are numbered


class Document:
    """A model file that can be edited.

    Attributes:
        folder: that its assets are looked for from.
        model: compiled.
    """

    def __init__(self, path: Path) -> None:
        if path.suffix.lower() == ".mjb":
            raise InvalidInput(f"{path}: a binary model cannot be taken apart; give the MJCF that it was made from")
        self.model = load_model(path)
        self.folder = path.resolve().parent
        self._root = _read(path.resolve(), path.name)
        if self._root.tag != "mujoco":
            raise InvalidInput(
                f"{path}: <{self._root.tag}> is no MJCF; mj_saveLastXML writes MJCF of what MuJoCo loads"
            )
        self._include(self._root, self.folder, 0)
        try:
            numbered, self._places = self._find_places()
            difference = differing(self.model, numbered)
        except ValueError as error:
            difference = " ".join(str(error).split())
        if difference:
            raise InvalidInput(f"{path}: with its includes put in place it is another model ({difference})")

    def _include(self, parent: Element, folder: Path, depth: int) -> None:
        if depth > INCLUDES_DEEP:
            raise InvalidInput(f"files are included in files more than {INCLUDES_DEEP} deep")
        position = 0
        while position < len(parent):
            child = parent[position]
            if child.tag != "include":
                self._include(child, folder, depth)
                position += 1
                continue
            # MuJoCo looks beside the including file first, then beside the model file.
            name = child.get("file", "")
            path = next((p for p in (folder / name, self.folder / name) if p.is_file()), folder / name)
            root = _read(path, name)
            self._include(root, path.parent, depth + 1)
            parent[position : position + 1] = list(root)
            position += len(root)

    def _find_places(self) -> tuple[mujoco.MjModel, dict[tuple[str, int], int]]:
        """The compiled tree, and places in the tree of its elements by kind and index.

        Elements without a name get one for the while, which numbers them in the compiled model.
        """
        root = copy.deepcopy(self._root)
        by_name: dict[tuple[str, str], int] = {}
        order = {element: k for k, element in enumerate(root.iter())}
        for kind, element in _elements(root):
            name = element.attrib.setdefault("name", f"{GIVEN}{order[element]}-")
            by_name[kind, name] = order[element]
        model = _compiled(root, self.folder)
        counts = {"body": model.nbody, "joint": model.njnt, "geom": model.ngeom, "equality": model.neq}
        counts |= {"sensor": model.nsensor, "key": model.nkey}
        places = {}
        for kind, count in counts.items():
            kind_id = getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}")
            for index in range(count):
                name = mujoco.mj_id2name(model, kind_id, index) or ""
                given = re.match(rf"{GIVEN}(\d+)-", name)
                place = int(given[1]) if given else by_name.get((kind, name))
                if place is not None:
                    places[kind, index] = place
        return model, places

    def reordered(self) -> tuple[mujoco.MjModel, mujoco.MjModel]:
        """The model, and that with what each body has and its constraints in reverse order; joints have names in both.

        Raises:
            ValueError: the reverse does not compile, or is made of elements that stand for others.
        """
        root = copy.deepcopy(self._root)
        if macro := next((e.tag for e in root.iter() if e.tag in (*MACROS, "replicate")), None):
            raise ValueError(f"<{macro}> makes elements of its own")
        for number, (kind, element) in enumerate(_elements(root)):
            if kind == "joint":
                element.attrib.setdefault("name", f"{GIVEN}{number}-")
        named = _compiled(root, self.folder)
        for section in root.iter():
            if section.tag == "equality" or section.tag in ("worldbody", "body"):
                # A body's own joints are one after the other: their order is part of the machine.
                moving = [child for child in section if child.tag not in ("joint", "freejoint")]
                section[:] = [child for child in section if child not in moving] + moving[::-1]
        return named, _compiled(root, self.folder)

    def can_edit(self, kind: str, index: int) -> bool:
        """Return True where an element stands in the file as such, rather than being made by the compiler."""
        return (kind, index) in self._places

    def can_make(self, edits: Sequence[Edit]) -> bool:
        """Return True where all elements of edits stand in the file."""
        changed = [(edit.kind, edit.index) for edit in edits if isinstance(edit, Change)]
        excluded = [("body", body) for edit in edits if isinstance(edit, Exclude) for body in edit.indices if body]
        return all(place in self._places for place in (*changed, *excluded))

    # -- editing -----------------------------------------------------------------------------------------------------

    def compiled(self, edits: Sequence[Edit], folder: Path | None = None) -> mujoco.MjModel:
        """The model with edits, its assets looked for from a folder.

        Raises:
            ValueError: it does not compile.
        """
        return _compiled(self._edited(edits), folder or self.folder)

    def text(self, edits: Sequence[Edit], comment: str) -> str:
        """The file with edits; a comment says at its top what they are."""
        root = self._edited(edits)
        note = ElementTree.Comment(comment.replace("--", "- -"))
        note.tail = "\n  "
        root.insert(0, note)
        return ElementTree.tostring(root, encoding="unicode") + "\n"

    def moved(self, folder: Path) -> tuple[Edit, ...]:
        """Edits that let a file in another folder find the assets."""
        if folder == self.folder:
            return ()
        edits = []
        for attribute in ("meshdir", "texturedir"):
            given = [c.get(attribute, c.get("assetdir")) for c in self._root if c.tag == "compiler"]
            last = next((value for value in reversed(given) if value is not None), "")
            edits.append(SetOption(("compiler",), attribute, os.path.relpath(self.folder / last, folder)))
        return tuple(edits)

    def _edited(self, edits: Sequence[Edit]) -> Element:
        root = copy.deepcopy(self._root)
        elements = list(root.iter())
        parents = {child: parent for parent in elements for child in parent}
        for edit in edits:
            match edit:
                case Change():
                    element = elements[self._places[edit.kind, edit.index]]
                    if edit.attribute:
                        element.set(edit.attribute, edit.value)
                    else:
                        parents[element].remove(element)
                case SetOption():
                    _option(root, edit.path).set(edit.attribute, edit.value)
                case Exclude():
                    one, other = (self._body_name(elements, index) for index in edit.indices)
                    ElementTree.SubElement(_option(root, ("contact",)), "exclude", {"body1": one, "body2": other})
                case _:
                    assert_never(edit)
        older.adapt(root)
        return root

    def _body_name(self, elements: list[Element], index: int) -> str:
        if index == 0:
            return "world"
        return elements[self._places["body", index]].attrib.setdefault("name", f"body-{index}")


def differing(one: mujoco.MjModel, other: mujoco.MjModel) -> str:
    """Name of the first array that two compiled models do not share, bit for bit, names apart; empty if none."""
    for name in dir(one):
        value = getattr(one, name)
        if not name.startswith(("_", "name")) and isinstance(value, np.ndarray) and "path" not in name:
            same = value.shape == getattr(other, name).shape
            if not same or not np.array_equal(value, getattr(other, name), equal_nan=value.dtype.kind == "f"):
                return name
    return "" if str(one.opt) == str(other.opt) else "option"


def _read(path: Path, shown: str) -> Element:
    parser = ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))
    try:
        root: Element = ElementTree.parse(path, parser).getroot()
    except (ElementTree.ParseError, OSError, UnicodeError) as error:
        raise InvalidInput(f"{shown}: it is not well-formed XML: {error}") from None
    return root


def _compiled(root: Element, folder: Path) -> mujoco.MjModel:
    with contextlib.chdir(folder), warnings_kept_quiet():
        return mujoco.MjModel.from_xml_string(ElementTree.tostring(root, encoding="unicode"))


def _elements(root: Element) -> Iterator[tuple[str, Element]]:
    """Elements of the tree that become those of a model, with their kinds."""
    for section in root:
        if section.tag == "worldbody":
            yield from _in_body(section)
        elif section.tag == "keyframe":
            yield from (("key", element) for element in section if element.tag == "key")
        elif section.tag in ("equality", "sensor"):
            yield from ((section.tag, element) for element in section if isinstance(element.tag, str))


def _in_body(parent: Element) -> Iterator[tuple[str, Element]]:
    for element in parent:
        if element.tag in IN_BODIES:
            yield IN_BODIES[element.tag], element
        if isinstance(element.tag, str) and element.tag not in MACROS:
            yield from _in_body(element)


def _option(root: Element, path: Sequence[str]) -> Element:
    """A section, or what is in it; the last of its name, since the last one counts, or a new one."""
    element = root
    for tag in path:
        found = [child for child in element if child.tag == tag]
        element = found[-1] if found else ElementTree.SubElement(element, tag)
    return element
