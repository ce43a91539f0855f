"""Units are written in one way in prose and output (docs/glossary.md, "Unit"); input takes the rival spellings too."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from conrod.mechanism.units import EXAMPLES

ROOT = Path(__file__).parents[1]
# What is to be written -> how it is not.
RIVALS = {
    "m/s²": r"\bm/s(\^2|\*\*2|2\b)|\bm s-2",
    "rad/s²": r"\brad/s(\^2|\*\*2|2\b)",
    "kg m²": r"\bk?g ?[*·]? ?m(\^2|2\b)|\bkg[*·]m²",
    "deg": r"\d ?°|\[°\]",
    "µs": r"(\d|\}) ?(us|μs|usec)\b",
    "µm": r"(\d|\}) ?(um|μm)\b",
    "rpm": r"\d ?(r/min|rev/min)\b|(crank speed|turns at)[^|]{0,30} rad/s",
    "1 mm": r"(?<![\w=.[-])\d+(\.\d+)?(mm|deg|rpm|kg|ms|µs|rad)\b",
    "[mm]": r"\((mm|mm/s|m|m/s|m/s²|deg|rad|rad/s|rpm|N|N m|kg|s|ms)\)",
    "angles in deg": r"(phase|angle)[^|.]{0,40} \[rad\]|(\d|\}) rad\b(?!/)",
}
TEMPLATES = [p for p in (ROOT / "src/conrod/report").rglob("*.jinja") if ".xml" not in p.suffixes]  # XML is for tools
PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *TEMPLATES]
# Pages and figures, whose texts stand in them as comments; but for audits, which quote what documents print.
REPORTS = [
    p
    for kind in ("md", "svg")
    for p in (ROOT / "reports").rglob(f"*.{kind}")
    if "audit" not in p.parts or kind == "svg"
]


GENERATED = "\n["  # in a mechanism file that is written as text
TYPED = ("e.g. ", *EXAMPLES.values())  # of what a shell takes without quotes
IN_SI = ("running.py", "pack.py")  # an argument of Python as it was given; a pack, whose numbers are exact


def rivals_in(text: str) -> list[str]:
    """Rival spellings in prose: what stands in code is to be typed, or is typed by others."""
    prose = re.sub(r"```(toml|xml|csv|sh).*?```|`[^`\n]*`", "", text, flags=re.DOTALL)
    return [f"{found[0]} for {right}" for right, rival in RIVALS.items() for found in re.finditer(rival, prose)]


def texts_in(module: Path) -> Iterator[str]:
    """Sentences of a module that a user may read: its strings with a blank, without docstrings."""
    tree = ast.parse(module.read_text(encoding="utf-8"))
    holders = (ast.Module, ast.ClassDef, ast.FunctionDef)
    documented = (n.body[0] for n in ast.walk(tree) if isinstance(n, holders) and n.body)
    docstrings = {id(first.value) for first in documented if isinstance(first, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            yield "".join(part.value if isinstance(part, ast.Constant) else "{}" for part in node.values)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings:
            yield node.value if " " in node.value else ""


@pytest.mark.parametrize("page", [*PAGES, *REPORTS], ids=lambda page: str(page.relative_to(ROOT)))
def test_pages_write_units_in_one_way(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert rivals_in("\n".join(re.findall("<!--(.*)-->", text)) if page.suffix == ".svg" else text) == []


def test_messages_write_units_in_one_way() -> None:
    modules = sorted((ROOT / "src").rglob("*.py"))
    found = [
        f"{m.name}: {rival}"
        for m in modules
        for text in texts_in(m)
        if GENERATED not in text and not any(typed in text for typed in TYPED if typed)
        for rival in rivals_in(text)
        if m.name not in IN_SI or not rival.endswith("angles in deg")
    ]
    assert found == []


def test_rival_spellings_are_found_in_prose_and_not_in_code() -> None:
    typed = "9.81 m/s^2, 2 kg m2, 3 kg*m^2, 30°, 7 us, 4 μs, 8 rev/min, 5 um, 3mm, 2.5deg, gap (mm)"
    for rival in (*typed.split(", "), "the phase [rad]", "off by 0.1 rad", "a crank speed of 52.36 rad/s"):
        assert rivals_in(f"It is {rival} here.") != [], rival
    assert rivals_in('`9.81 m/s^2`\n```toml\ninertia = "1 kg*m^2"\n```\n9.81 m/s², 2 kg m², 30 deg, 7 µs') == []
