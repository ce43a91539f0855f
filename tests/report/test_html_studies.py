"""Pages of committed studies: machines on the first page, points that say what they are, and the site."""

from __future__ import annotations

import base64
import json
import re
import runpy
import zlib
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from browser import browser, complaints, open_page
from handmade import handmade_sweep
from html_pages import found_in

from conrod.engines import engine_named
from conrod.execution.writing import Batch
from conrod.report.figure import with_spots
from conrod.report.folder import restore_findings
from conrod.report.html.page import html_document, page_sections
from conrod.report.kind import Part, kind_named
from conrod.scenes import SCENES, catalogue_names
from conrod.studies.sweep.findings import SweepStudy, paste_template
from conrod.studies.sweep.report import diagram_of
from conrod.studies.sweep.study import plan_sweep
from conrod.studies.sweep.tables import timed_points

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def site() -> Any:
    return SimpleNamespace(**runpy.run_path(str(ROOT / "docs" / "site.py")))


@pytest.fixture(scope="module")
def batches(site: Any) -> dict[str, Batch]:
    """Each page of a committed report with the files that it is made of."""
    return dict(site.reports())


@pytest.fixture(scope="module")
def entrance(site: Any, batches: dict[str, Batch], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The first page of the catalogue, as the site has it."""
    page, file = "reports/catalogue/README.md", tmp_path_factory.mktemp("site") / "catalogue.html"
    target = site.addresses(page, site.pages())
    file.write_text(html_document(page_sections(batches[page], outside=target)))
    return file


def test_all_machines_of_the_catalogue_move_on_its_first_page(entrance: Path) -> None:
    found = found_in(entrance.read_text())
    links = [attributes["href"] for tag, attributes in found.elements if tag == "a"]
    assert {f"{name}.html" for name in catalogue_names()} <= set(links)
    moving = [a for tag, a in found.elements if tag == "animatetransform"]
    assert {a["attributename"] for a in moving} == {"transform"}
    assert len(moving) > 4 * len(catalogue_names())
    ids = found.values("id")
    assert len(ids) == len(set(ids))


def test_animations_can_be_paused_and_a_long_table_filtered(entrance: Path) -> None:
    with browser(width=400) as page:
        open_page(page, entrance)
        paused = "return [...document.querySelectorAll('.tiles svg')].map((svg) => svg.animationsPaused())"
        assert all(page.execute_script(paused))  # of one who wants less motion
        page.find_element("css selector", ".tiles").find_element("xpath", "preceding-sibling::button").click()
        assert not any(page.execute_script(paused))
        assert page.execute_script("return document.documentElement.scrollWidth") <= 400
        shown = "return document.querySelectorAll('label.filter + .scroll tbody tr:not([hidden])').length"
        every = page.execute_script(shown)
        page.find_element("css selector", "label.filter input").send_keys("six-bar")
        assert 0 < page.execute_script(shown) < every
        assert complaints(page) == []


def vertices(data: str) -> Any:
    """The places (N, 2) that a path in relative commands goes through."""
    at, found = np.zeros(2), []
    for command, given in re.findall(r"([mhvl])([^a-z]*)", data):
        moves = np.array(re.findall(r"-?[\d.]+", given), dtype=float)
        along = {"h": [1, 0], "v": [0, 1]}.get(command)
        for move in moves.reshape(-1, 2) if along is None else np.outer(moves, along):
            at = at + move
            found.append(at)
    return np.array(found)


def test_points_of_the_diagram_have_words_where_they_are_drawn() -> None:
    study = handmade_sweep()
    diagram = diagram_of(study)
    drawn = ElementTree.fromstring(diagram.svg())
    width, height = (float(one) for one in drawn.attrib["viewBox"].split()[2:])
    curves = [one.attrib["d"] for one in drawn.iter() if "marker-mid" in one.attrib]
    alone = [[float(one.get("x", 0.0)), float(one.get("y", 0.0))] for one in drawn.iter() if one.tag.endswith("use")]
    places = np.concatenate([*(vertices(curve) for curve in curves), alone]) / [width, height]
    spots = diagram.laid_out_spots()
    assert len(spots) >= len(study.points) // 2
    far = [np.abs(places - [x, y]).max(axis=1).min() for x, y, _ in spots]
    assert max(far) < 0.003
    # A spot that is elsewhere is seen to be.
    assert np.abs(places - [spots[0][0] + 0.02, spots[0][1] + 0.02]).max(axis=1).min() > 0.003


def test_words_of_a_point_cannot_close_the_script() -> None:
    page = with_spots("<svg></svg>", [(0.5, 0.5, "</script><b>")])
    assert re.findall("</script>", page) == ["</script>"]
    (packed,) = re.findall('octet-stream">(.*)</script>', page)
    assert json.loads(zlib.decompress(base64.b64decode(packed))) == [[0.5], [0.5], ["</script><b>"]]


# -- weight ---------------------------------------------------------------------------------------------------------

MOST = 500_000  # bytes of a machine's page
HEAVIEST = ("reports/limits/saw-500rpm.md", "reports/sweep/saw-40rpm.md", "reports/catalogue/jansen-leg.md")


def weight(batch: Batch) -> int:
    return len(html_document(page_sections(batch)).encode())


@pytest.mark.parametrize("page", [*HEAVIEST, pytest.param("", marks=pytest.mark.slow)])
def test_page_of_a_report_weighs_at_most_half_a_megabyte(page: str, batches: dict[str, Batch]) -> None:
    weights = {name: weight(batch) for name, batch in batches.items() if name.startswith(page) or not page}
    assert weights
    assert {name: size for name, size in weights.items() if size > MOST} == {}


def test_a_heavy_figure_is_noticed(batches: dict[str, Batch]) -> None:
    batch = batches["reports/limits/cam-follower.md"]
    drawn = next(name for name in batch.files if name.endswith("-steps.svg"))
    heavy = str(batch.files[drawn]).replace("</svg>", f'<path d="M0 0{"h1v1" * (MOST // 4)}"/></svg>')
    assert weight(batch) <= MOST < weight(Batch(batch.folder, {**batch.files, drawn: heavy}))


# -- lines to paste --------------------------------------------------------------------------------------------------


def test_pasted_lines_of_a_point_give_its_settings() -> None:
    file = ROOT / "reports" / "sweep" / "data" / "cam-follower.json"
    swept = restore_findings(SweepStudy, json.loads(file.read_text()))
    scene = SCENES[swept.name]
    plan = plan_sweep(swept.name, scene, [engine_named(name) for name in swept.engines], "coarse")
    # Not by key, which a release of an engine or a version of the cache changes.
    settings = {
        (rule.engine.name, rule.rule.name, case.settings.steps_per_revolution): (rule.engine, case.settings)
        for rule in plan.rules
        for case in rule.cases
    }
    assert {point.engine for point in timed_points(swept)} == {"mujoco", "pymunk"}
    for point in timed_points(swept):
        engine, wanted = settings[point.engine, point.rule, point.steps_per_revolution]
        lines = dict.fromkeys((1, 3), swept.settings_lines(point))
        assert list(paste_template(lines | {2: engine.paste(scene, wanted)})) == ["n"]
        # Negative control: another step has other lines.
        other = engine.paste(scene, replace(wanted, timestep=1.001 * wanted.timestep))
        assert paste_template(lines | {2: other}).keys() == {"1", "2", "3"}


# The page of limits is the heaviest of all, and has the same script.
@pytest.mark.parametrize("name", ["sweep/cam-follower", pytest.param("limits/saw-500rpm", marks=pytest.mark.slow)])
def test_click_and_keyboard_show_the_words_of_a_point(name: str, batches: dict[str, Batch], tmp_path: Path) -> None:
    kind = kind_named(name.partition("/")[0])
    file = ROOT / "reports" / name.replace("/", "/data/")
    findings = restore_findings(kind.findings, json.loads(file.with_suffix(".json").read_text()))
    figures = kind.page_of(Part("", findings, "", "")).figures
    known = {(*words.split("\n", 1), "")[:2] for figure in figures for *_, words in figure.laid_out_spots()}
    (tmp_path / "p.html").write_text(html_document(page_sections(batches[f"reports/{name}.md"])))
    with browser() as page:
        open_page(page, tmp_path / "p.html")
        page.execute_script("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
        said, lines, drawn = (page.find_element("css selector", f".spots {one}") for one in ("output", "pre", "img"))
        assert not lines.is_displayed()
        page.execute_script("arguments[0].scrollIntoView()", drawn)
        drawn.click()
        clicked = said.text, lines.get_attribute("textContent")
        page.find_element("css selector", ".spots input").send_keys("\ue014" * 3)  # to the right
        assert lines.is_displayed() == (kind.name == "sweep")
        assert {clicked, (said.text, lines.get_attribute("textContent"))} <= known
        assert complaints(page) == []
