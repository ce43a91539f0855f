"""Why MuJoCo refuses a model file: names that no element has, with the nearest ones, and text that is no XML."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path

from conrod.errors import unknown_choice

# Errors of Python's XML parser, the last two of encodings that it lacks; MuJoCo reads such files as bytes.
XML_ERRORS = (ET.ParseError, OSError, ValueError, LookupError)
# What MuJoCo says of a name that no element has.
UNKNOWN_NAME = re.compile(
    r"(?:transmission target|unknown element|unrecognized name) '([^']*)'|unknown transmission target '([^']*)'"
)
# Elements that an attribute names, by the attribute without its number.
ELEMENTS = {
    "joint": ("joint", "freejoint"), "jointinparent": ("joint",), "tendon": ("spatial", "fixed"), "site": ("site",),
    "body": ("body",), "geom": ("geom",), "actuator": (), "objname": ("body", "site", "geom", "camera"),
}  # fmt: skip


NOT_CLOSED = re.compile(r"XML_ERROR_MISMATCHED_ELEMENT.*name=([\w.-]+)", re.DOTALL)


def malformed_xml_words(path: Path, error: str) -> str:
    """Say where a file is no XML, by line and column; empty if MuJoCo refuses it for another reason.

    Args:
        error: what MuJoCo says of the file.
    """
    if "XML parse error" not in error:
        return ""
    try:
        ET.parse(path)
    except ET.ParseError as found:
        opened = NOT_CLOSED.search(error)
        return f"it is no XML: {found}" + (f"; <{opened[1]}> is opened and not closed" if opened else "")
    except XML_ERRORS:
        pass
    return ""


def unknown_name_words(path: Path, error: str) -> str:
    """Say in one line which unknown name an element has, with the nearest names; empty for any other error.

    Args:
        error: what MuJoCo says of the file.
    """
    if not (found := UNKNOWN_NAME.search(error)) or path.suffix.lower() != ".xml":
        return ""
    name = found[1] or found[2] or ""
    try:
        root = ET.parse(path).getroot()
    except XML_ERRORS:
        return ""
    for element in root.iter():
        for attribute, value in element.attrib.items():
            kind = attribute.rstrip("12")
            if value != name or not ELEMENTS.get(kind):
                continue
            known = {one.get("name") for tag in ELEMENTS[kind] for one in root.iter(tag)}
            if name in known:
                continue
            what = f"{element.tag} {element.get('name') or ''}".strip()
            shown = "joint" if kind == "jointinparent" else "object" if kind == "objname" else kind
            return f"{what}: {unknown_choice(shown, name, filter(None, known))}"
    return ""
