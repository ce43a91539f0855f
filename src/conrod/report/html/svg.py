"""Figures as part of an HTML page: without scripts, styles or links of their own, and with ids that no other has."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

SVG, XLINK = "{http://www.w3.org/2000/svg}", "{http://www.w3.org/1999/xlink}"
# Elements that a figure is drawn with, and attributes that give these their shape; all others are left out.
DRAWN = re.compile(
    r"animateTransform|svg|g|defs|clipPath|marker|path|use|rect|circle|ellipse|line|polyline|polygon|text|tspan|title"
)
SHAPES = re.compile(
    r"id|class|d|x|y|[xy][12]|c[xy]|r|r[xy]|width|height|points|transform|viewBox|opacity|text-anchor|font-size"
    r"|attributeName|type|values|dur|repeatCount|clip-(path|rule)|fill(-rule|-opacity)?|stroke(-[a-z]+)?"
    r"|overflow|marker(Units|-start|-mid|-end)"
)
WORDS = ("use", "g")
FEWEST = 4  # marks that are a path
REFERENCE = re.compile(r"(url\(#|^#)([^)]+)")
MOVED = re.compile(r"^translate\(([^)]* [^)]*)\)(.*)$")
REFERRING = ("href", "clip-path", "marker-start", "marker-mid", "marker-end")


@dataclass
class Figures:
    """The figures of a page. What several have, such as letters and words, is defined by the first of them.

    Attributes:
        prefix: of all their ids, which makes them the page's only ones.
        known: id of what is defined, by its markup.
        count: of figures.
    """

    prefix: str
    known: dict[str, str] = field(default_factory=dict)
    count: int = 0

    def inlined(self, text: str, alt: str) -> str:
        """A figure's SVG as part of the page, with words for what it shows.

        Raises:
            ElementTree.ParseError: it is no XML.
        """
        root = ElementTree.fromstring(text)
        self.count += 1
        _clean(root)
        self._name(root)
        _flatten(root)
        for parent in list(root.iter()):
            _join(parent)
            self._join_marks(parent)
        for group in [one for one in root.iter("g") if MOVED.fullmatch(one.get("transform", "")) and len(one) > 1]:
            self._share(group)
        # matplotlib gives these by a style sheet, which would be the whole page's.
        root.attrib = {"stroke-linejoin": "round", **root.attrib, "role": "img", "aria-label": alt}
        for name in ("width", "height"):
            root.attrib.pop(name, None)
        return ElementTree.tostring(root, encoding="unicode").replace(" />", "/>")

    def _id(self, markup: str) -> str:
        return self.known.setdefault(markup, f"{self.prefix}{len(self.known)}")

    def _name(self, root: Element) -> None:
        """Give what is referred to an id of the page, and leave out what is defined in it."""
        wanted = {found[2] for element in root.iter() for _, found in _references(element)}
        ids = dict[str, str]()
        for parent in list(root.iter()):
            for element in list(parent):
                name = element.attrib.pop("id", None)
                if name is not None and name in wanted:
                    # What is drawn where it is defined is another figure's in no case.
                    place = "" if parent.tag == "defs" else f"{self.count} {name}"
                    within = [found[2] for one in element.iter() for _, found in _references(one)]
                    means = [ids.get(one, f"{self.count} {one}") for one in within]
                    markup = f"{place}{ElementTree.tostring(element, encoding='unicode')}{means}"
                    if markup in self.known:
                        parent.remove(element)
                    ids[name] = self._id(markup)
                    element.set("id", ids[name])
        for element in root.iter():
            for name, found in list(_references(element)):
                if found[2] in ids:
                    element.set(name, REFERENCE.sub(rf"\g<1>{ids[found[2]]}", element.attrib[name]))
                else:
                    del element.attrib[name]

    def _join_marks(self, group: Element) -> None:
        """Make marks of one look, such as ticks, a path that has the mark at its places."""
        alike = dict[tuple[tuple[str, str], ...], list[Element]]()
        for element in group:
            if element.tag == "use" and {"x", "y"} <= element.attrib.keys():
                look = tuple((name, value) for name, value in element.attrib.items() if name not in ("x", "y"))
                alike.setdefault(look, []).append(element)
        for look, marks in alike.items():
            if len(marks) >= FEWEST:
                markup = repr(look)
                known, name = markup in self.known, self._id(markup)
                marker = Element("marker", {"id": name, "overflow": "visible", "markerUnits": "userSpaceOnUse"})
                ElementTree.SubElement(marker, "use", dict(look))
                marks[0].tag = "path"
                places = " ".join(f"{one.get('x')} {one.get('y')}" for one in (marks[0], *marks, marks[-1]))
                marks[0].attrib = {"d": f"M{places}", "fill": "none", "marker-mid": f"url(#{name})"}
                for one in marks[1:]:
                    group.remove(one)
                if not known:
                    group.insert(list(group).index(marks[0]), marker)

    def _share(self, group: Element) -> None:
        """Define a group that only uses others, such as a word, at its first place, and use it at the next ones."""
        uses = [child for child in group if child.tag != "defs"]
        if any(child.tag != "use" for child in uses):
            return
        _, place, scale, _ = MOVED.split(group.attrib.pop("transform"))
        markup = f"{scale}{[ElementTree.tostring(child, encoding='unicode') for child in uses]}"
        known, name = markup in self.known, self._id(markup)
        for child in uses:
            group.remove(child)
        if known:
            group.tag = "use"
            x, _, y = place.partition(" ")
            group.attrib |= {"x": x, "y": y, "href": f"#{name}"}
        else:
            group.set("transform", f"translate({place})")
            ElementTree.SubElement(group, "g", id=name, transform=scale).extend(uses)


def _references(element: Element) -> Iterator[tuple[str, re.Match[str]]]:
    """Attributes that refer to another element, with what they refer to."""
    for name in REFERRING:
        found = REFERENCE.match(element.get(name, ""))
        if found:
            yield name, found


def _clean(element: Element) -> None:
    """Keep of an element and all in it what draws; a style becomes attributes, which need no permission of a page."""
    style = dict(part.split(":", 1) for part in element.get("style", "").split(";") if ":" in part)
    reference = element.get(f"{XLINK}href") or element.get("href") or ""
    given = {**element.attrib, **{name.strip(): value.strip() for name, value in style.items()}}
    element.attrib = {name: value for name, value in given.items() if SHAPES.fullmatch(name) and _is_inside(value)}
    if reference.startswith("#"):
        element.attrib["href"] = reference
    element.tag = element.tag.removeprefix(SVG)
    element.tail = None
    if element.tag not in ("text", "tspan", "title"):
        element.text = None
    for child in list(element):
        if isinstance(child.tag, str) and DRAWN.fullmatch(child.tag.removeprefix(SVG)):
            _clean(child)
        else:
            element.remove(child)


def _flatten(element: Element) -> None:
    """Put what is in groups that say nothing in their places."""
    for child in list(element):
        _flatten(child)
        if child.tag in ("g", "defs") and not child.attrib and (child.tag == "g" or not len(child)):
            place = list(element).index(child)
            element[place : place + 1] = list(child)


def _join(group: Element) -> None:
    """Make lines of one look one, such as those of a grid, and marks too, where nothing but words is between them."""
    last = Element("")
    for element in list(group):
        drawn = element.get("d", "")
        if element.tag == "path" and element.get("fill") == "none" and not {"id", "opacity"} & element.attrib.keys():
            if {**element.attrib, "d": ""} == {**last.attrib, "d": ""}:
                last.set("d", last.get("d", "") + drawn.replace("m", "M", 1))
                group.remove(element)
            else:
                last = element
        elif element.tag not in WORDS:
            last = Element("")


def _is_inside(value: str) -> bool:
    """True unless a value leads out of the figure."""
    return "url(" not in value or value.startswith("url(#")
