"""What pages name exists, what they print runs, and they write units in one way."""

from __future__ import annotations

import ast
import importlib.util
import re
import runpy
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

from conrod.engines.mujoco import MUJOCO_PRESETS
from conrod.engines.pymunk import PYMUNK_PRESETS
from conrod.mechanism.units import UNIT_EXAMPLES
from conrod.studies.limits.axes import AXES

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
SOURCE = ROOT / "src" / "conrod"
ROOMS = sorted(path.parent.name for path in SOURCE.glob("*/__init__.py"))
MADE = {"benchmarks/results.json"}  # written by a command, not committed
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "examples").glob("*.md"), *DOCS.rglob("*.md")])
REPORTS = sorted((ROOT / "reports").rglob("*.md"))


def text(page: Path) -> str:
    return page.read_text(encoding="utf-8")


def anchors(page: Path) -> set[str]:
    """Anchors of a page's headings, as they are made from their words."""
    headings = re.findall(r"^#+ (.*)$", text(page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", [*PAGES, *REPORTS], ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    for link in re.findall(r"\]\(([^)\s]+)\)", text(page)):
        if not link.startswith("http"):
            path, _, anchor = link.partition("#")
            target = (page.parent / path).resolve() if path else page
            assert target.exists(), link
            assert not anchor or anchor in anchors(target), link


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_files_and_modules_that_a_page_names_exist(page: Path) -> None:
    words = text(page)
    for path in re.findall(r"`((?:src|tests|docs|audits|benchmarks)/[\w./-]+)`", words):
        assert (ROOT / path).exists() or "NAME" in path or path in MADE, path
    for path in re.findall(rf"`((?:{'|'.join(ROOMS)})/[\w/]+\.py)`", words):
        assert (SOURCE / path).exists(), path
    for module in re.findall(r"^from (conrod(?:\.\w+)*) import", words, re.MULTILINE):
        assert importlib.util.find_spec(module), module


def unknown_names(words: str) -> list[str]:
    """Names of functions, classes and tables in a page that stand nowhere in the code."""
    code = [*(ROOT / "src").rglob("*.py"), *(ROOT / "tests").rglob("*.py"), ROOT / "pyproject.toml", ROOT / "Makefile"]
    known = {word for file in code if file != Path(__file__) for word in re.findall(r"\w+", text(file))}
    named = re.findall(r"`([A-Za-z_][\w.]*)(?:\([^`]*\))?`", words)
    return [name for name in named if "NAME" not in name and name.split(".")[-1] not in known]


def test_names_in_contributing_stand_in_the_code() -> None:
    page = text(ROOT / "CONTRIBUTING.md")
    assert unknown_names(page) == []
    # Negative control: a name as it was before a renaming.
    assert unknown_names(page.replace("`bench.with_edits`", "`bench.with_edits_as_before`")) == [
        "bench.with_edits_as_before"
    ]


def missing_rows(page: Path, names: Iterable[str]) -> list[str]:
    """Names without a row of a table that begins with them."""
    rows = set(re.findall(r"^\| `([\w-]+)`", text(page), re.MULTILINE))
    return [name for name in names if name not in rows]


def test_every_axis_and_preset_has_its_row() -> None:
    assert missing_rows(DOCS / "limits.md", AXES) == []
    assert missing_rows(DOCS / "validation.md", {**MUJOCO_PRESETS, **PYMUNK_PRESETS}) == []
    # Negative control: a name without a row.
    assert missing_rows(DOCS / "limits.md", ["steps", "sideways"]) == ["sideways"]


def test_the_readme_is_short_and_its_python_runs(capsys: pytest.CaptureFixture[str]) -> None:
    readme = text(ROOT / "README.md")
    assert len(readme.split()) <= 950
    code = re.search(r"```python\n(.*?)```", readme, re.DOTALL)
    exec(compile(code[1], "README.md", "exec"), {})
    outcome, error = capsys.readouterr().out.split()[:2]
    assert outcome == "Outcome.COMPLETED"
    assert float(error) == pytest.approx(7e-10, rel=0.1)


@pytest.mark.parametrize("defect", ["[x](docs/nothing.md)", "[x](docs/design.md#nothing)"])
def test_a_broken_link_is_found(defect: str, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(defect.replace("docs/", f"{DOCS}/"), encoding="utf-8")
    with pytest.raises(AssertionError):
        test_links_lead_somewhere(page)


# -- units are written in one way in prose and output (docs/glossary.md, "Unit"); input takes rivals, too --------------

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
# Pages and figures, whose texts stand in them as comments; but for audits, which quote what documents print.
SHOWN = [*(page for page in REPORTS if "audit" not in page.parts), *(ROOT / "reports").rglob("*.svg")]
GENERATED = "\n["  # in a mechanism file that is written as text
TYPED = ("e.g. ", *UNIT_EXAMPLES.values())  # of what a shell takes without quotes
IN_SI = ("engines/run.py", "pack.py")  # an argument of Python as it was given; a pack, whose numbers are exact


def rivals_in(text: str) -> list[str]:
    """Rival spellings in prose: what stands in code is to be typed, or is typed by others."""
    prose = re.sub(r"```(toml|xml|csv|sh).*?```|`[^`\n]*`|\n(draw it|next): conrod [^\n]*", "", text, flags=re.DOTALL)
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


@pytest.mark.parametrize("page", [*PAGES, *TEMPLATES, *SHOWN], ids=lambda page: str(page.relative_to(ROOT)))
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
        if not m.as_posix().endswith(IN_SI) or not rival.endswith("angles in deg")
    ]
    assert found == []


def test_rival_spellings_are_found_in_prose_and_not_in_code() -> None:
    typed = "9.81 m/s^2, 2 kg m2, 3 kg*m^2, 30°, 7 us, 4 μs, 8 rev/min, 5 um, 3mm, 2.5deg, gap (mm)"
    for rival in (*typed.split(", "), "the phase [rad]", "off by 0.1 rad", "a crank speed of 52.36 rad/s"):
        assert rivals_in(f"It is {rival} here.") != [], rival
    assert rivals_in('`9.81 m/s^2`\n```toml\ninertia = "1 kg*m^2"\n```\n9.81 m/s², 2 kg m², 30 deg, 7 µs') == []


# -- worked studies run as they are printed, and find what their pages say ---------------------------------------------


def run_study(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What a study's script leaves; its figure goes elsewhere."""
    mpl.use("Agg")
    plt.close("all")
    monkeypatch.setattr("sys.argv", [name, str(tmp_path / name)])
    left = runpy.run_path(str(DOCS / "studies" / f"{name}.py"))
    plt.close("all")
    assert (tmp_path / f"{name}.svg").read_text(encoding="utf-8").count("<path") > 10
    return left


def page(name: str) -> str:
    return " ".join((DOCS / "studies" / f"{name}.md").read_text(encoding="utf-8").split())


def test_flywheel_keeps_the_required_speed_fluctuation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told = re.search(r"It finds ([\d.]+) kg m²", page("flywheel"))
    # Its search takes most of the time; what it finds is held to what is wanted.
    monkeypatch.setattr("scipy.optimize.brentq", lambda *_, **__: float(told[1]))
    left = run_study("flywheel", tmp_path, monkeypatch)
    found, lighter = (
        np.ptp(speed) / speed.mean() for _, speed in map(left["course"], (left["least"], 0.9 * left["least"]))
    )
    assert found == pytest.approx(left["WANTED"], rel=5e-3)
    assert lighter > 1.05 * left["WANTED"]
    assert left["least"] < left["rule"]
    assert f"{left['rule']:.1f} kg m²" in page("flywheel")


def test_the_counterweight_leaves_the_least_shaking_force(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    left = run_study("balance", tmp_path, monkeypatch)
    peak, best = left["peak"], left["best"]
    assert peak(best) < min(peak(0.9 * best), peak(1.1 * best), peak(0.0), peak(left["full"]))
    assert [f"{peak(c) / 1e3:.2f} kN" in page("balance") for c in (0.0, best, left["full"])] == [True] * 3
    # The momentum of all that moves changes by the force on the frame, which over a turn comes to nothing.
    mean = left["shaking"](best)[:, :-1].mean(axis=1)
    assert np.abs(mean).max() < 1e-9 * peak(best)


def test_softest_spring_keeps_the_push_and_an_engine_agrees(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    left = run_study("cam-spring", tmp_path, monkeypatch)
    push, least = left["push"], left["least"]
    assert push(least).min() == pytest.approx(left["LEAST_PUSH"], rel=1e-9)
    assert push(0.99 * least).min() < left["LEAST_PUSH"]
    assert f"{least / 1e3:.2f} N/mm" in page("cam-spring")
    kept, lost = (1e6 * float(gap.max()) for gap in left["gaps"])
    assert kept < 2.0
    assert lost > 20.0
    assert f"{kept:.1f} µm" in page("cam-spring")
    assert f"{lost:.1f} µm" in page("cam-spring")
