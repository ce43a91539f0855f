"""Pages of users' own models in motion: names are escaped, one magnification is said, and scripts run."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from browser import browser, complaints, open_page

from conrod.report.drawing.moving_links import BAR, GEOM, PIN, DrawnRun, LinkShape, MovingLinks
from conrod.report.html.moving_links import links_html, magnifying_power
from conrod.report.html.page import PageSection, html_document

NAME = "<b onclick='x'>&\"link"
TIMES = np.linspace(0.0, 1.0, 13)
EXACT = np.column_stack([0.0 * TIMES, 0.0 * TIMES, 800.0 * TIMES, -300.0 * TIMES])


def motion(**sizes: float) -> MovingLinks:
    """A bar that moves, and runs that are off by some drawing units in the end."""
    runs = tuple(
        DrawnRun(name, "hardened", 2.0, size * np.outer(TIMES, [0.0, 0.0, 1.0, 0.0]), tuple(1e-3 * size * TIMES))
        for name, size in sizes.items()
    )
    shapes = (LinkShape(GEOM, NAME, (0, 1), 30.0), LinkShape(BAR, NAME, (0, 1)), LinkShape(PIN, NAME, (1,)))
    ground = (LinkShape(PIN, NAME, (0,)),)
    box, still = (-80.0, -400.0, 1000.0, 500.0), np.zeros((1, 2))
    return MovingLinks("In the xy plane", "exact", box, shapes, ground, still, ((1, NAME),), EXACT, runs)


def test_names_of_a_model_cannot_become_markup() -> None:
    text = links_html(motion(run=0.05), "page", NAME)
    assert "<b onclick" not in text
    assert text.count("&lt;b onclick") >= 5
    # Control: the name is there, and would have been found.
    assert "<b onclick" in text.replace("&lt;", "<")


def test_all_inputs_of_a_moving_model_have_a_label() -> None:
    def unlabelled(text: str) -> int:
        return len(re.findall(r"<(?:input|select)\b", re.sub(r"<label>.*?</label>", "", text, flags=re.DOTALL)))

    text = links_html(motion(run=0.05), "page", "model")
    assert unlabelled(text) == 0
    assert unlabelled(text.replace("label>", "span>")) == 4  # control


def test_one_magnification_holds_for_all_runs() -> None:
    drawn = motion(coarse=0.5, fine=5e-7)
    assert magnifying_power(drawn) == 2  # 0.5 units are made 50 of 1000; at 1000 times they would be half the picture
    text = links_html(drawn, "page", "model")
    data = json.loads(re.findall(r'<script type="application/json">(.*?)</script>', text)[0])
    assert data["power"] == 2
    assert "magnified 100 times" in text
    # A run that broke off does not set it, unless all did.
    broke = replace(drawn, runs=(replace(drawn.runs[0], ended="ended as opened"), drawn.runs[1]))
    assert magnifying_power(broke) == 8
    assert "coarse: ended as opened" in links_html(broke, "page", "model")


def test_run_without_exact_motion_has_no_grey_machine() -> None:
    drawn = replace(motion(run=1.0), exact=np.empty((0, 0)), reference="")
    drawn = replace(drawn, runs=(replace(drawn.runs[0], rows=EXACT, off=()),))
    text = links_html(drawn, "page", "model")
    assert 'class="ghost"' not in text
    assert "magnified" not in text
    assert 'class="ghost"' in links_html(motion(run=1.0), "page", "model")
    assert links_html(None, "page", "model") == ""


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two models on one page, one of them without an exact motion."""
    alone = replace(motion(run=1.0), exact=np.empty((0, 0)), reference="")
    alone = replace(alone, runs=(replace(alone.runs[0], rows=EXACT, off=()),))
    parts = [links_html(motion(coarse=0.5, fine=5e-7), "one", "one"), links_html(alone, "two", "two")]
    file = tmp_path_factory.mktemp("links") / "page.html"
    file.write_text(html_document([PageSection(f"s{k}", f"s{k}", text) for k, text in enumerate(parts)]), "utf-8")
    return file


@pytest.mark.parametrize("width", [400, pytest.param(1280, marks=pytest.mark.slow)])
def test_links_move_in_a_browser_without_complaints(page: Path, width: int) -> None:
    places = """const root = document.querySelectorAll(".links")[arguments[1]];
        const bars = [...root.querySelectorAll(`.${arguments[0]} .bar`)];
        return bars.map((one) => one.getAttribute("d").slice(1).split(/[ ,]/).map(Number))"""
    with browser(width=width) as shown:
        open_page(shown, page)
        for number in (0, 1):
            shown.execute_script(
                'const s = document.querySelectorAll(".links")[arguments[0]].querySelector("input"); s.value = 180;'
                's.dispatchEvent(new Event("input"))',
                number,
            )
        np.testing.assert_allclose(shown.execute_script(places, "ghost", 0), [[0.0, 0.0, 400.0, -150.0]])
        # At half the time the run is off by a quarter of a unit, which is drawn 100 times as large.
        np.testing.assert_allclose(shown.execute_script(places, "engine", 0), [[0.0, 0.0, 425.0, -150.0]])
        np.testing.assert_allclose(shown.execute_script(places, "engine", 1), [[0.0, 0.0, 400.0, -150.0]])
        assert "At 1 s, off by 0.00025 mm." in shown.find_element("css selector", ".now").text
        assert shown.execute_script("return document.documentElement.scrollWidth") <= width
        assert complaints(shown) == []
