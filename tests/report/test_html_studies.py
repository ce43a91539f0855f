"""Pages of committed studies: machines on the first page, points that say what they are, and the site."""

from __future__ import annotations

import importlib.util
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from browser import browser, complaints, opened
from handmade import handmade_sweep
from html_pages import found_in

from conrod.report.figure import Figure
from conrod.report.html.page import document, sections_of
from conrod.report.html.spots import with_spots
from conrod.report.kind import kind_named
from conrod.report.saved import restore
from conrod.report.sweep.report import _diagram, _spots
from conrod.scenes.catalogue import catalogue_names

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def site() -> Any:
    spec = importlib.util.spec_from_file_location("site_of_conrod", ROOT / "docs" / "site.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def entrance(site: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The first page of the catalogue, as the site has it."""
    page, file = "reports/catalogue/README.md", tmp_path_factory.mktemp("site") / "catalogue.html"
    target = site.addresses(page, site.pages())
    file.write_text(document(sections_of(dict(site.reports())[page], outside=target)))
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


def test_what_moves_can_be_paused(entrance: Path) -> None:
    with browser(width=400) as page:
        opened(page, entrance)
        paused = "return [...document.querySelectorAll('.tiles svg')].map((svg) => svg.animationsPaused())"
        assert all(page.execute_script(paused))  # of one who wants less motion
        page.find_element("css selector", ".tiles").find_element("xpath", "preceding-sibling::button").click()
        assert not any(page.execute_script(paused))
        assert page.execute_script("return document.documentElement.scrollWidth") <= 400
        assert complaints(page) == []


def test_links_of_the_site_lead_to_pages_that_it_has(site: Any) -> None:
    pages = site.pages()
    target = site.addresses("docs/limits.md", pages)
    assert target("running.md#reports-in-html") == "running.html#running--reports-in-html"
    assert target("../README.md") == "../index.html"
    assert target("../pyproject.toml") is None
    assert pages["reports/catalogue/six-bar.md"] == "reports/catalogue/six-bar.html"


def test_a_point_of_the_diagram_says_what_it_is_where_it_is_drawn() -> None:
    study = handmade_sweep()
    diagram = _diagram(study)
    assert isinstance(diagram, Figure)
    drawn = ElementTree.fromstring(diagram.svg())
    width, height = (float(one) for one in drawn.attrib["viewBox"].split()[2:])
    marks = [one.attrib for one in drawn.iter() if one.tag.endswith("}use") and "x" in one.attrib]
    places = np.array([[float(mark["x"]) / width, float(mark["y"]) / height] for mark in marks])
    spots = _spots(study)[diagram.name]
    assert len(spots) >= len(study.points) // 2
    far = [np.abs(places - [x, y]).max(axis=1).min() for x, y, _ in spots]
    assert max(far) < 0.003
    assert all("Lines to paste: conrod recommend" in words for *_, words in spots)
    # A spot that is elsewhere is seen to be.
    assert np.abs(places - [spots[0][0] + 0.02, spots[0][1] + 0.02]).max(axis=1).min() > 0.003


def test_a_cell_of_a_map_says_what_happened_there() -> None:
    kind = kind_named("limits")
    file = ROOT / "reports" / "limits" / "data" / "saw-500rpm.json"
    study = restore(kind.findings, json.loads(file.read_text()))
    study = replace(study, maps=study.maps[:2])
    assert kind.spots is not None
    assert study.maps
    for one, spots in zip(study.maps, kind.spots(study).values(), strict=True):
        assert len(spots) == len(one.runs)
        said = [words for *_, words in spots]
        assert said[0].startswith(f"{one.x[one.runs[0].i]:.4g} steps, ")
        assert all(run.level in words and run.outcome in words for run, words in zip(one.runs, said, strict=True))


def test_words_of_a_place_close_no_script() -> None:
    page = with_spots("<svg></svg>", [(0.5, 0.5, "</script><b>")])
    assert re.findall("</script>", page) == ["</script>"]
    assert json.loads(re.findall('json">(.*)</script>', page)[0])["phrases"] == ["</script><b>"]
