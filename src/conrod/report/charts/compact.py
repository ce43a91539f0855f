"""Shrink the SVG of matplotlib to a third: relative paths, joined marks, and no invisible elements."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import count
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

SVG, LINK = "{http://www.w3.org/2000/svg}", "{http://www.w3.org/1999/xlink}href"
# Decimals of a point. A tenth cannot be seen; shapes of marks are small, and have hundredths.
MARK_DIGITS, PATH_DIGITS = 2, 1
# Style of the whole drawing. Texts stay texts: they are laid out for the first of these fonts, the widest.
ROOT_STYLE = "font:9px DejaVu Sans,Verdana,sans-serif;stroke-linejoin:round"
DEFAULT_STYLES = ("font-family: 'DejaVu Sans'", "font-size: 9px", "text-anchor: start", "stroke-dashoffset: 0", "")
MIN_JOINED_MARKS = 4  # joined into a path
NUMBER_ATTRIBUTES = ("x", "y", "transform", "width", "height", "viewBox")
REFERENCE = re.compile(r"#([^)\s]+)")
NO_ROTATION = re.compile(r"rotate\(-?0 [^)]*\)")
PATH_COMMAND = re.compile(r"([A-Za-z])([^A-Za-z]*)")
COLOUR = re.compile(r"#(.)\1(.)\2(.)\3")
NUMBER = re.compile(r"-?[\d.]+(?:e-?\d+)?")


def compact_svg(text: str) -> str:
    """Return the same drawing in fewer letters, from the SVG that matplotlib writes."""
    root = ElementTree.fromstring(text)
    for element in root.iter():
        element.tag = element.tag.removeprefix(SVG)
        if LINK in element.attrib:
            element.attrib["href"] = element.attrib.pop(LINK)
    for needless in [
        *root.findall("metadata"),
        *root.findall("defs[style]"),
    ]:  # the author, and the styles in `ROOT_STYLE`
        root.remove(needless)
    _shorten_ids(root)
    looks = {f"#{one.get('id')}": one.get("style", "").split("; ") for one in root.iter("path") if "id" in one.attrib}
    for element in root.iter():
        _shorten_attributes(element, looks.get(element.get("href", ""), []))
    _unwrap_groups(root)
    numbers = count()
    for group in [*root.iter("g"), root]:
        _join_marks(group, numbers)
        _join_lines(group)
    root.attrib |= {"xmlns": SVG[1:-1], "style": ROOT_STYLE}
    # One element a line: what changed in a figure can be seen in a comparison of files.
    return ElementTree.tostring(root, encoding="unicode").replace(" />", "/>").replace("><", ">\n<")


def _shorten_ids(root: Element) -> None:
    """Give short ids to elements that are referred to, and remove all other ids."""
    used = {name for one in root.iter() for text in one.attrib.values() for name in REFERENCE.findall(text)}
    names = {one.get("id", ""): f"m{k}" for k, one in zip(count(), (e for e in root.iter() if e.get("id") in used))}
    for element in root.iter():
        name = element.attrib.pop("id", None)
        for key, value in element.attrib.items():
            element.attrib[key] = REFERENCE.sub(lambda found: f"#{names.get(found[1], found[1])}", value)
        if name in names:
            element.set("id", names[name])


def _shorten_attributes(element: Element, known: list[str]) -> None:
    """Shorten an element's numbers, and its style by the parts that its mark already has."""
    given = element.attrib
    if "d" in given:
        given["d"] = _relative_path(given["d"], MARK_DIGITS if "id" in given else PATH_DIGITS)
    if NO_ROTATION.fullmatch(given.get("transform", "")):
        del given["transform"]
    for name in NUMBER_ATTRIBUTES:
        if name in given and "scale" not in given[name]:
            given[name] = NUMBER.sub(
                lambda one: _decimal_text(_scaled_integer(one[0], PATH_DIGITS), PATH_DIGITS), given[name]
            )
    style = [part for part in given.pop("style", "").split("; ") if part not in (*known, *DEFAULT_STYLES)]
    if style:
        given["style"] = COLOUR.sub(r"#\1\2\3", ";".join(part.replace(": ", ":") for part in style))
    if element.text and not element.text.strip():
        element.text = None
    element.tail = None


def _unwrap_groups(element: Element) -> None:
    """Replace each group without attributes by its children."""
    for child in list(element):
        _unwrap_groups(child)
        if child.tag == "g" and not child.attrib:
            place = list(element).index(child)
            element[place : place + 1] = list(child)


def _join_marks(group: Element, numbers: Iterator[int]) -> None:
    """Replace marks of equal style, such as a curve's, by one path with markers."""
    alike = dict[str, list[Element]]()
    for element in group:
        if element.tag == "use" and {"x", "y"} <= element.attrib.keys():
            look = {name: value for name, value in element.attrib.items() if name not in ("x", "y")}
            alike.setdefault(repr(look), []).append(element)
    for marks in alike.values():
        if len(marks) >= MIN_JOINED_MARKS:
            first, places = marks[0], [f"{one.attrib.pop('x')} {one.attrib.pop('y')}" for one in marks]
            name = f"k{next(numbers)}"
            marker = Element("marker", {"id": name, "overflow": "visible", "markerUnits": "userSpaceOnUse"})
            ElementTree.SubElement(marker, "use", dict(first.attrib))
            group.insert(list(group).index(first), marker)
            # SVG marks no end of a path, so the ends are repeated.
            through = _relative_path(f"M {' L '.join([places[0], *places, places[-1]])}", PATH_DIGITS)
            first.tag, first.attrib = "path", {"d": through, "fill": "none", "marker-mid": f"url(#{name})"}
            for one in marks[1:]:
                group.remove(one)


def _join_lines(group: Element) -> None:
    """Join lines of equal style, such as a grid's, into one path."""
    last = Element("")
    for element in list(group):
        look = {**element.attrib, "d": ""}
        if element.tag == "path" and "fill:none" in look.get("style", "") and look == {**last.attrib, "d": ""}:
            last.set("d", last.get("d", "") + element.get("d", "").replace("m", "M", 1))
            group.remove(element)
        elif element.tag not in ("text", "g"):
            last = element if element.tag == "path" else Element("")


def _relative_path(data: str, digits: int) -> str:
    """Turn path data from matplotlib's absolute commands into relative ones."""
    found, written, here, start = list[str](), "", (0, 0), (0, 0)
    for command, given in PATH_COMMAND.findall(data):
        numbers = [_scaled_integer(one, digits) for one in NUMBER.findall(given)]
        moves = [k - here[n % 2] for n, k in enumerate(numbers)]
        letter = command.lower()
        if letter == "m" and moves == [0, 0] and written not in ("", "z"):
            continue  # a line that continues from the end of the last one
        if numbers:
            here = numbers[-2], numbers[-1]
        match letter, moves:
            case "m", _:
                start = here
            case "z", _:
                here = start
            case "l", [along, 0]:
                letter, moves = "h", [along]
            case "l", [0, along]:
                letter, moves = "v", [along]
        texts = [_decimal_text(move, digits) for move in moves]
        # A repeated command needs no letter.
        shown = "" if letter == written and letter not in "mz" else letter
        for text in texts:
            shown += text if shown[-1:].isalpha() or text[0] == "-" else f" {text}"
        found.append(shown)
        written = letter
    return "".join(found)


def _scaled_integer(text: str, digits: int) -> int:
    """Return a number in text as an integer, in units of its last kept decimal."""
    return round(10.0**digits * float(text))


def _decimal_text(whole: int, digits: int) -> str:
    """Return an integer of `_scaled_integer` as a decimal number, without needless zeros."""
    text = repr(whole / 10**digits).removesuffix(".0")
    return text.replace("0.", ".", 1) if text.startswith(("0.", "-0.")) else text
