"""The SVG of matplotlib in a third of its letters: paths relative to where they are, marks of one look as one path."""

from __future__ import annotations

import re
from collections.abc import Mapping, Set

# A tenth of a point cannot be seen; shapes of marks are small, and have hundredths.
FINE, COARSE = 2, 1  # digits
PATH = re.compile(r'(<path[^>]*?) d="([^"]*)"')
PLACE = re.compile(r'(?<=\s[xy]=")-?[\d.]+(?=")|(?<=translate\()-?[\d.]+ -?[\d.]+')
PART = re.compile(r"([A-Za-z])([^A-Za-z]*)")
NUMBER = re.compile(r"-?[\d.]+")
MARKS = re.compile(
    r'(?:<path d="([^"]*)"([^>]*)/>(\s*<defs>\s*<path[^>]*/>\s*</defs>)?\s*)?'
    r'<g([^>]*)>(\s*<use xlink:href="#(m[0-9a-f]+)" x="[^"]*" y="[^"]*" style="([^"]*)"/>'
    r'(?:\s*<use xlink:href="#\6" x="[^"]*" y="[^"]*" style="\7"/>)+)\s*</g>'
)
DEFINED = re.compile(r'<path id="(m[0-9a-f]+)" d="[^"]*" style="([^"]*)"/>')
USED = re.compile(r'(<use xlink:href="#(m[0-9a-f]+)"[^>]*) style="([^"]*)"')
LETTER = re.compile(r'(<use xlink:href="#[^"]*") transform="translate\((-?[\d.]+) 0\)"')
AT = re.compile(r'x="(-?[\d.]+)" y="(-?[\d.]+)"')


def compact(text: str) -> str:
    """The same drawing, for a file as matplotlib writes it."""
    known = dict[tuple[str, str], str]()
    looks = {name: set(style.split("; ")) for name, style in DEFINED.findall(text)}
    text = USED.sub(lambda found: _styled(found, looks), text)
    text = MARKS.sub(lambda found: _marks(found, known), text)
    text = LETTER.sub(r'\1 x="\2"', text)
    text = PATH.sub(lambda found: f'{found[1]} d="{_relative(found[2], FINE if " id=" in found[1] else COARSE)}"', text)
    return PLACE.sub(
        lambda found: NUMBER.sub(lambda one: _decimal(_whole(one.group(), COARSE), COARSE), found.group()), text
    )


def _styled(found: re.Match[str], looks: Mapping[str, Set[str]]) -> str:
    """A use of a mark, with no more of a style than what the mark's own does not say."""
    own = [part for part in found[3].split("; ") if part not in looks.get(found[2], ())]
    return f'{found[1]} style="{"; ".join(own)}"'


def _marks(found: re.Match[str], known: dict[tuple[str, str], str]) -> str:
    """Marks that are alike, as those of the line through them; else of a path that is no line."""
    line, look, defined, group, marks, shape, style = found.groups(default="")
    places = [f"{x} {y}" for x, y in AT.findall(marks)]
    if (shape, style) not in known:
        name = known[shape, style] = f"{shape}-{len(known)}"
        defined += (
            f'<defs><marker id="{name}" overflow="visible" markerUnits="userSpaceOnUse">'
            f'<use xlink:href="#{shape}" style="{style}"/></marker></defs>'
        )
    mark = f'="url(#{known[shape, style]})"'
    if group in look and _relative(line, COARSE) == _relative(f"M {' L '.join(places)}", COARSE):
        ends = "".join(f" marker-{where}{mark}" for where in ("start", "mid", "end"))
        return f'{defined}<path d="{line}"{look}{ends}/>'
    before = f'<path d="{line}"{look}/>' if line else ""
    # All but the ends have a mark, so that these are there twice.
    through = " L ".join((places[0], *places, places[-1]))
    return f'{before}{defined}<path{group} d="M {through}" fill="none" marker-mid{mark}/>'


def _relative(data: str, digits: int) -> str:
    """Path data in relative commands, from the absolute ones that matplotlib writes."""
    found, written, here, start = list[str](), "", (0, 0), (0, 0)
    for command, given in PART.findall(data):
        numbers = [_whole(one, digits) for one in NUMBER.findall(given)]
        moves = [k - here[n % 2] for n, k in enumerate(numbers)]
        letter = command.lower()
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
        texts = [_decimal(move, digits) for move in moves]
        # A line goes on without its letter, also after a move.
        shown = "" if letter == written and letter not in "mz" else letter
        for text in texts:
            shown += text if shown[-1:].isalpha() or text[0] == "-" else f" {text}"
        found.append(shown)
        written = "l" if letter == "m" else letter
    return "".join(found)


def _whole(text: str, digits: int) -> int:
    """A number in units of the last of some digits."""
    return round(10.0**digits * float(text))


def _decimal(whole: int, digits: int) -> str:
    """The number again, without zeros that say nothing."""
    text = repr(whole / 10**digits).removesuffix(".0")
    return text.replace("0.", ".", 1) if text.startswith(("0.", "-0.")) else text
