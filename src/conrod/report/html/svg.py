"""Figures as part of an HTML page: without scripts, styles or links of their own, and with ids that no other has."""

from __future__ import annotations

import re
from collections.abc import Callable
from xml.etree import ElementTree

SVG, XLINK = "{http://www.w3.org/2000/svg}", "{http://www.w3.org/1999/xlink}"
# Elements that a figure is drawn with, and attributes that give these their shape; all others are left out.
DRAWN = re.compile(
    r"animateTransform|svg|g|defs|clipPath|path|use|rect|circle|ellipse|line|polyline|polygon|text|tspan|title"
)
SHAPES = re.compile(
    r"id|class|d|x|y|[xy][12]|c[xy]|r|r[xy]|width|height|points|transform|viewBox|opacity|text-anchor|font-size"
    r"|attributeName|type|values|dur|repeatCount|clip-(path|rule)|fill(-rule|-opacity)?|stroke(-[a-z]+)?"
)
AROUND = re.compile(r"\s*([A-Za-z])\s*")  # spaces about the letters of a path
REFERENCE = re.compile(r"(url\(#|^#)([^)]+)")


def inlined(text: str, prefix: str, alt: str) -> str:
    """A figure's SVG as part of a page.

    Args:
        text: of the SVG file.
        prefix: of all its ids, which makes them the page's only ones.
        alt: what it shows, in words.

    Raises:
        ElementTree.ParseError: it is no XML.
    """
    root, ids = ElementTree.fromstring(text), dict[str, str]()
    # Short ones: thousands of marks refer to them.
    _clean(root, lambda given: ids.setdefault(given, f"{prefix}{len(ids)}"))
    # matplotlib gives these by a style sheet, which would be the whole page's.
    root.attrib = {"stroke-linejoin": "round", **root.attrib, "role": "img", "aria-label": alt}
    for name in ("width", "height"):
        root.attrib.pop(name, None)
    return ElementTree.tostring(root, encoding="unicode", short_empty_elements=True)


def _clean(element: ElementTree.Element, named: Callable[[str], str]) -> None:
    """Keep of an element and all in it what draws; a style becomes attributes, which need no permission of a page."""
    style = dict(part.split(":", 1) for part in element.get("style", "").split(";") if ":" in part)
    reference = element.get(f"{XLINK}href") or element.get("href") or ""
    given = {**element.attrib, **{name.strip(): value.strip() for name, value in style.items()}}
    element.attrib = {name: value for name, value in given.items() if SHAPES.fullmatch(name) and _is_inside(value)}
    if reference.startswith("#"):
        element.attrib["href"] = reference
    for name in ("id", "href", "clip-path"):
        if name in element.attrib:
            value = element.attrib[name]
            element.attrib[name] = (
                named(value) if name == "id" else REFERENCE.sub(lambda found: found[1] + named(found[2]), value)
            )
    if "d" in element.attrib:
        element.attrib["d"] = AROUND.sub(r"\1", element.attrib["d"])
    element.tag = element.tag.removeprefix(SVG)
    element.tail = None
    if element.tag not in ("text", "tspan", "title"):
        element.text = None
    for child in list(element):
        if isinstance(child.tag, str) and DRAWN.fullmatch(child.tag.removeprefix(SVG)):
            _clean(child, named)
        else:
            element.remove(child)
    _share(element)


def _share(group: ElementTree.Element) -> None:
    """Give a group of marks the look that all of them have, and them no longer: figures have thousands."""
    if group.tag == "g" and len(group) > 1 and all(child.tag == "use" for child in group):
        alike = set.intersection(*(set(child.attrib.items()) for child in group))
        for name, value in alike:
            if name.startswith(("fill", "stroke")) and name not in group.attrib:
                group.set(name, value)
                for child in group:
                    del child.attrib[name]


def _is_inside(value: str) -> bool:
    """True unless a value leads out of the figure."""
    return "url(" not in value or value.startswith("url(#")
