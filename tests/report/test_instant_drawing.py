"""The drawing of a crank angle: its polygons close, and it has the instant centres near the mechanism."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import conrod as typed

import conrod
from conrod.exact.linkage import InstantQuantities
from conrod.report.charts.canvas import drawing_style
from conrod.report.drawing.instant import PolygonVector, acceleration_vectors, instant_figure, velocity_vectors
from conrod.scenes import SCENES, catalogue_names

PLANAR = [*SCENES, *catalogue_names()]


def instant(name: str, share: float = 0.23) -> InstantQuantities:
    scene = conrod.scene(name)
    first, last = scene.kinematics.span
    return conrod.instant_quantities(scene.kinematics, first + share * (last - first), scene.speed)


def gap(vectors: Iterable[PolygonVector]) -> float:
    """How far ends of vectors to one letter are apart, over the longest vector [1]."""
    ends, longest = defaultdict(list), 0.0
    for one in vectors:
        longest = max(longest, float(np.linalg.norm(one.stop - one.start)))
        if one.letter:
            ends[one.letter].append(one.stop)
    return max((float(np.ptp(places, axis=0).max()) for places in ends.values()), default=0.0) / (longest or 1.0)


@pytest.mark.parametrize("name", PLANAR)
def test_polygons_close(name: str) -> None:
    found = instant(name)
    assert max(gap(velocity_vectors(found)), gap(acceleration_vectors(found))) <= 1e-12


@pytest.mark.parametrize("name", ["six-bar", "swinging-four-bar", "inverted-slider-crank"])
def test_wrong_relative_motion_leaves_polygons_open(name: str) -> None:
    found = instant(name)
    faster = tuple(replace(one, velocity=1.001 * one.velocity, normal=1.001 * one.normal) for one in found.relative)
    slid = tuple(replace(one, velocity=1.001 * one.velocity, coriolis=0.5 * one.coriolis) for one in found.sliding)
    planted = replace(found, relative=faster, sliding=slid)
    assert gap(velocity_vectors(planted)) > 1e-5
    assert gap(acceleration_vectors(planted)) > 1e-5


def test_drawing_has_near_centres_by_link_numbers() -> None:
    scene = conrod.scene("saw-40rpm")
    found = conrod.instant_quantities(scene.kinematics, math.radians(30.0), scene.speed)
    with drawing_style():
        mechanism, *_ = instant_figure(scene, found).axes
    texts = {text.get_text() for text in mechanism.texts}
    assert {"12", "23", "34", "24", "13"} <= texts
    assert "14" not in texts  # at infinity
    assert "1 ground, 2 crank, 3 rod, 4 slider" in mechanism.get_xlabel()


def test_show_draws_the_angle_that_it_prints(tmp_path: Path) -> None:
    files = [tmp_path / f"{name}.svg" for name in ("here", "there", "plain")]
    for file, angle in zip(files, (["--angle", "30deg"], ["--angle", "31deg"], []), strict=True):
        assert typed("show", "saw-40rpm", *angle, "--svg", str(file)).returncode == 0
        assert ET.parse(file).getroot().tag.endswith("svg")
    assert len({file.read_bytes() for file in files}) == 3
