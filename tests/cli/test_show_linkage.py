"""What `conrod show` tells of a linkage, against closed forms, and its JSON."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import conrod

from conrod.scenes import SCENES, Saw

DOCUMENT = Path(__file__).parents[2] / "docs" / "linkages.md"
CRANK, ROD, OFFSET = 0.1, 0.3, 0.09  # of the saw [m]


def told(*arguments: str, folder: Path) -> dict[str, Any]:
    done = conrod("show", *arguments, "--json", "out.json", cwd=folder)
    assert done.returncode == 0, done.stderr
    document: dict[str, Any] = json.loads((folder / "out.json").read_text())
    return document


def test_the_cams_greatest_pressure_angle_is_that_of_its_lift(tmp_path: Path) -> None:
    (angle,) = told("cam-follower", folder=tmp_path)["turn"]["transmission"]
    scene = SCENES["cam-follower"]
    # For a follower that moves through the shaft, tan(pressure angle) = (ds/dt) / s with s from the shaft.
    here = np.linspace(0.0, 2.0 * np.pi, 200_001)
    moved = scene.motion(here, 1.0).point("roller")
    exact = float(np.abs(np.arctan2(moved.velocity[:, 1], moved.position[:, 1])).max())
    greatest = max(0.5 * math.pi - angle["least"]["value"], angle["greatest"]["value"] - 0.5 * math.pi)
    assert greatest == pytest.approx(exact, abs=1e-9)
    assert angle["through"] == "cam"
    # Negative control: without the base circle the same formula gives another angle.
    wrong = np.arctan2(moved.velocity[:, 1], moved.position[:, 1] - moved.position[0, 1] + 0.03)
    assert abs(float(np.abs(wrong).max()) - exact) > 0.01


@pytest.mark.parametrize("degrees", ["130", "-75.5"])
def test_links_and_points_at_an_angle_are_those_of_the_slider_cranks_closed_form(degrees: str, tmp_path: Path) -> None:
    here = told("saw-40rpm", f"--angle={degrees} deg", folder=tmp_path)["instant"]
    angle, saw = math.radians(float(degrees)), Saw(speed=40.0 * 2.0 * math.pi / 60.0)
    w, height = saw.speed, CRANK * math.sin(angle) - OFFSET
    down = math.sqrt(ROD**2 - height**2)
    # The rod from pin to slider, to the left: -rod sin(turn of it) = height of the pin.
    rod_speed = CRANK * math.cos(angle) * w / down
    rod_change = (height * rod_speed**2 - CRANK * math.sin(angle) * w**2) / down
    links = {link["link"]: link for link in here["links"]}
    assert links["rod"]["rate"][2] == pytest.approx(rod_speed, rel=1e-11)
    assert links["rod"]["acceleration"][2] == pytest.approx(rod_change, rel=1e-11)
    motion = saw.motion(angle, w)
    for name, point in here["points"]["points"].items():
        exact = motion.point(name)
        assert point["velocity"][0] == pytest.approx(list(exact.velocity[0]), abs=1e-13)
        assert point["acceleration"][0] == pytest.approx(list(exact.acceleration[0]), abs=1e-12)


def test_the_example_of_the_document_is_what_is_printed() -> None:
    example = DOCUMENT.read_text().split("```text\n")[1].split("```")[0].rstrip("\n")
    printed = [line.rstrip() for line in conrod("show", "saw-40rpm", "--angle", "60deg").stdout.splitlines()]
    assert "\n".join(printed).endswith(example)
    assert example.startswith("crank: turns fully")
