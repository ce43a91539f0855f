"""Reports in a real browser: nothing is asked for, the drawing is where the exact motion says, and it works by hand."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import browser, complaints, open_page, requested_addresses
from command_line import conrod

from conrod.execution.resolve_arguments import select_scenes
from conrod.report.folder import restore_findings
from conrod.studies.validation.moving_drawing import moving_machine
from conrod.studies.validation.results import SceneStudy

MACHINE = "saw-500rpm"
# Where the elements of a drawing are, in its own units: a body's origin and the end of its first axis.
PLACES = """return [...document.querySelectorAll(`.machine .${arguments[0]} use`)].map((use) => {
  const to = use.ownerSVGElement.getScreenCTM().inverse().multiply(use.getScreenCTM());
  return [[to.e, to.f], [to.e + 100 * to.a, to.f + 100 * to.b]]; })"""
MOVE = """const s = document.querySelector(".machine input"); s.value = arguments[0];
s.dispatchEvent(new Event("input"))"""
CHOOSE = """const s = document.querySelector(`[name=${arguments[0]}]`); s.value = arguments[1];
s.dispatchEvent(new Event("change"))"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("reports")
    asked = ("validate", MACHINE, "--engine", "pymunk", "--steps-per-rev", "120")
    assert conrod(*asked, "--out", "r", "--html", "r.html", cwd=out).returncode == 0
    return out


@pytest.fixture(scope="module")
def page() -> Iterator[Any]:
    with browser() as found:
        yield found


def machine(folder: Path) -> Any:
    found = restore_findings(SceneStudy, json.loads((folder / "r" / "data" / f"{MACHINE}.json").read_text()))
    return moving_machine(found)


def body_axes(poses: Any) -> Any:
    """Origin and end of the first axis of each body, from poses as the drawing has them; (n, 2, 2)."""
    x, y, turn = poses.reshape(-1, 3).T
    along = 100.0 * np.stack([np.cos(np.radians(turn)), np.sin(np.radians(turn))], axis=1)
    origin = np.stack([x, y], axis=1)
    return np.stack([origin, origin + along], axis=1)


def exact_at(folder: Path, index: int) -> Any:
    """The same from the scene's exact motion alone."""
    scene, drawing = select_scenes([MACHINE], [])[MACHINE], machine(folder).drawing
    return body_axes(drawing.poses(scene.kinematics.poses(np.radians([float(index)])))[0])


def test_page_requests_nothing_and_logs_no_complaint(page: Any, folder: Path) -> None:
    open_page(page, folder / "r.html")
    assert requested_addresses(page) == [(folder / "r.html").as_uri()]
    assert complaints(page) == []
    assert page.execute_script("return document.documentElement.scrollWidth") <= 1280


def test_page_that_requests_something_is_detected(page: Any, folder: Path, tmp_path: Path) -> None:
    planted = (folder / "r.html").read_text().replace("<main>", '<main><img src="https://127.0.0.1:9/a.png" alt="">')
    (tmp_path / "p.html").write_text(planted.replace("img-src data:", "img-src *"))
    assert requested_addresses(open_page(page, tmp_path / "p.html"))[1:] == ["https://127.0.0.1:9/a.png"]
    (tmp_path / "p.html").write_text(planted)
    open_page(page, tmp_path / "p.html")
    assert any("Content Security Policy" in one for one in complaints(page))


def test_the_grey_machine_is_where_the_exact_motion_says(page: Any, folder: Path) -> None:
    open_page(page, folder / "r.html")
    for index in (0, 45, 137, 359):
        page.execute_script(MOVE, index)
        np.testing.assert_allclose(page.execute_script(PLACES, "ghost"), exact_at(folder, index), atol=0.02)


def test_planted_pose_of_the_grey_machine_is_detected(page: Any, folder: Path, tmp_path: Path) -> None:
    (tmp_path / "p.html").write_text((folder / "r.html").read_text().replace('"exact":[[', '"exact":[[1', 1))
    open_page(page, tmp_path / "p.html").execute_script(MOVE, 0)
    with pytest.raises(AssertionError):
        np.testing.assert_allclose(page.execute_script(PLACES, "ghost"), exact_at(folder, 0), atol=0.02)


def test_coloured_machine_is_off_by_the_magnified_error(page: Any, folder: Path) -> None:
    found = machine(folder)
    open_page(page, folder / "r.html").execute_script(CHOOSE, "run", "1")
    page.execute_script(MOVE, 60)
    power = found.power(found.runs[1])
    assert page.execute_script("return document.querySelector('[name=power]').value") == str(power) != "0"
    for k in (power, power - 1):
        page.execute_script(CHOOSE, "power", str(k))
        wanted = body_axes(found.exact[60] + 10.0**k * found.errors(found.runs[1])[10])
        np.testing.assert_allclose(page.execute_script(PLACES, "engine"), wanted, atol=0.1)


def test_caption_states_the_error_of_the_point(page: Any, folder: Path) -> None:
    scene, found = select_scenes([MACHINE], [])[MACHINE], machine(folder)
    run = found.runs[0]
    angle, poses = run.poses.angle[[10]], run.poses.values[[10]]
    off = scene.kinematics.point_derivatives([scene.kinematics.poses(angle) + poses])["C"][0]
    metres = float(np.linalg.norm(off - scene.motion(angle, scene.speed).point("C").position))
    open_page(page, folder / "r.html").execute_script(MOVE, 60)
    words = page.find_element("css selector", ".now").text
    assert words.startswith("Crank angle 60 deg, off by ")
    assert float(words.split()[-2]) == pytest.approx(1e3 * metres, rel=0.05)


def test_slider_moves_by_keyboard_and_by_the_play_button(page: Any, folder: Path) -> None:
    slider = open_page(page, folder / "r.html").find_element("css selector", ".machine input")
    before = page.execute_script(PLACES, "ghost")
    slider.send_keys("\ue014" * 3)  # to the right
    assert slider.get_attribute("value") == "63"
    assert page.execute_script(PLACES, "ghost") != before
    assert "63 deg" in slider.get_attribute("aria-valuetext")
    page.find_element("css selector", ".machine button").click()
    page.execute_async_script("setTimeout(arguments[0], 300)")
    page.find_element("css selector", ".machine button").click()
    assert int(slider.get_attribute("value")) > 63


def test_table_sorts_by_a_click_on_its_heading(page: Any, folder: Path) -> None:
    open_page(page, folder / "r.html")
    rows = "return [...document.querySelector('main table').tBodies[0].rows].map((row) => row.cells[5].textContent)"
    before = page.execute_script(rows)
    page.execute_script("document.querySelectorAll('main table th button')[5].click()")
    numbers = [float(text.lstrip("< ")) for text in page.execute_script(rows)]
    assert numbers == sorted(numbers)
    assert sorted(before) == sorted(page.execute_script(rows))


def test_page_is_readable_without_scripts(folder: Path) -> None:
    with browser(width=400, scripts=False) as page:
        open_page(page, folder / "r.html")
        assert not page.find_element("css selector", ".controls").is_displayed()
        drawing = page.find_element("css selector", ".machine > svg")
        assert drawing.is_displayed()
        assert "at crank angle 60 deg" in drawing.get_attribute("aria-label")
        assert page.find_element("css selector", "main table").is_displayed()
        assert complaints(page) == []
        layout = page.execute_cdp_cmd("Page.getLayoutMetrics", {})
        assert layout["cssContentSize"]["width"] <= 400
