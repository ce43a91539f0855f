"""A model file with what it declares in reverse order, which is the same machine."""

from __future__ import annotations

import contextlib
from pathlib import Path
from xml.etree import ElementTree

import mujoco

Element = ElementTree.Element
INCLUDES_DEEP = 32  # MuJoCo refuses a file that includes itself, so this is never reached by one that loads
MACROS = ("composite", "flexcomp", "attach", "replicate")  # elements that stand for others which MuJoCo makes
BODIES = ("worldbody", "body")


def both_orders(path: Path) -> tuple[mujoco.MjModel, mujoco.MjModel]:
    """The model, and that with what each body has and its constraints in reverse order; joints have names in both.

    Raises:
        ValueError: there is no file to take apart, or the reverse does not compile.
    """
    if path.suffix.lower() == ".mjb":
        raise ValueError("there is no file to take apart")
    folder = path.resolve().parent
    root = _with_includes(path.resolve(), folder, 0)
    if root.tag != "mujoco":
        raise ValueError(f"<{root.tag}> is no MJCF")
    if macro := next((element.tag for element in root.iter() if element.tag in MACROS), None):
        raise ValueError(f"<{macro}> makes elements of its own")
    for number, joint in enumerate(e for body in root.iterfind("worldbody") for e in body.iter()):
        if joint.tag in ("joint", "freejoint"):
            joint.attrib.setdefault("name", f"conrod-{number}")
    named = _compiled(root, folder)
    for section in root.iter():
        if section.tag in ("equality", *BODIES):
            # A body's own joints are one after the other: their order is part of the machine.
            moving = [child for child in section if child.tag not in ("joint", "freejoint")]
            section[:] = [child for child in section if child not in moving] + moving[::-1]
    return named, _compiled(root, folder)


def _with_includes(path: Path, folder: Path, depth: int) -> Element:
    """The tree of a file with its includes in their places, as MuJoCo puts them there."""
    if depth > INCLUDES_DEEP:
        raise ValueError(f"files are included in files more than {INCLUDES_DEEP} deep")
    try:
        root = ElementTree.parse(path).getroot()
    except (ElementTree.ParseError, OSError) as error:
        raise ValueError(f"{path.name}: {error}") from None
    for parent in list(root.iter()):
        for child in [child for child in parent if child.tag == "include"]:
            # MuJoCo looks beside the including file first, then beside the model file.
            name, place = child.get("file", ""), list(parent).index(child)
            found = next((p for p in (path.parent / name, folder / name) if p.is_file()), folder / name)
            parent[place : place + 1] = list(_with_includes(found, folder, depth + 1))
    return root


def _compiled(root: Element, folder: Path) -> mujoco.MjModel:
    with contextlib.chdir(folder):
        return mujoco.MjModel.from_xml_string(ElementTree.tostring(root))
