"""Links laid over links, by hand: which distances and tilts differ, in any unit, and which machines do not match."""

from __future__ import annotations

import math

import numpy as np
import pytest

from conrod.mechanism.mechanism import GROUND
from conrod.models.check.links import LinkDifference, LinkGraph, SlideTilt, graph_of, link_differences
from conrod.scenes import CamFollower, Saw


def four_bar(
    crank: float = 0.1, coupler: float = 0.4, rocker: float = 0.3, ground: float = 0.5, point: float = 0.2,
    unit: float = 1.0, names: str = "abcd", on: str = "coupler",
) -> LinkGraph:  # fmt: skip
    """A four-bar with its point on the coupler [m], each link along x of its own frame, in a unit [m]."""
    graph = LinkGraph("crank")
    graph.link(GROUND)
    a, b, c, d = names
    at = {key: np.array([value / unit, 0.0]) for key, value in {
        "0": 0.0, "crank": crank, "coupler": coupler, "rocker": rocker, "ground": ground, "point": point,
    }.items()}  # fmt: skip
    graph.pin(a, GROUND, "crank", (at["0"], at["0"]))
    graph.pin(b, "crank", "coupler", (at["crank"], at["0"]))
    graph.pin(c, "coupler", "rocker", (at["coupler"], at["0"]))
    graph.pin(d, "rocker", GROUND, (at["rocker"], at["ground"]))
    graph.link(on).points["P"] = at["point"]
    return graph


def slider_crank(offset: float = 0.05, tilt: float = 0.0, rod: float = 0.3, beside: float = 0.0) -> LinkGraph:
    """A slider-crank whose ground has a second pin 1 m along x, on which a second crank of 0.2 m turns."""
    graph = LinkGraph("crank")
    graph.link(GROUND)
    zero, way = np.zeros(2), np.array([1.0, 0.0])
    graph.pin("shaft", GROUND, "crank", (zero, zero))
    graph.pin("pin", "crank", "rod", (np.array([0.1, 0.0]), zero))
    graph.pin("slider-pin", "rod", "slider", (np.array([rod, 0.0]), np.array([0.0, beside])))
    line = np.array([math.cos(tilt), math.sin(tilt)])
    graph.slide("slide", GROUND, "slider", ((np.array([0.4, offset]), line), (zero, way)))
    graph.pin("second", GROUND, "other", (np.array([1.0, 0.0]), zero))
    return graph


def words(model: LinkGraph, machine: LinkGraph) -> list[str] | None:
    found = link_differences(model, machine)
    return None if found is None else [one.words for one in found]


@pytest.mark.parametrize(("one", "words"), [
    (LinkDifference("rod", ("pin a", "M"), 0.303, 0.3), "rod is 1 % longer from pin a to M: 303 mm instead of 300 mm"),
    (LinkDifference("rod", ("pin a", "M"), 0.15, 0.26),
     "rod is 42.3 % shorter from pin a to M: 150 mm instead of 260 mm"),
    (LinkDifference("rod", ("pin a", "M"), 0.0123456, 0.0),
     "rod has pin a 12.3456 mm from M, where they should be at one place"),
    (SlideTilt("slide", "ground", math.radians(0.5)), "slide is tilted by 0.5 deg on ground"),
])  # fmt: skip
def test_words_of_a_difference(one: LinkDifference | SlideTilt, words: str) -> None:
    assert one.words == words


@pytest.mark.parametrize("unit", [1.0, 1e-2, 1e-3, 0.0254])
def test_links_of_other_names_and_units_are_the_same(unit: float) -> None:
    assert words(four_bar(unit=unit, names="wxyz"), four_bar()) == []


@pytest.mark.parametrize(("change", "expected"), [
    ({"coupler": 0.42}, ["coupler is 10 % longer from pin c to P: 220 mm instead of 200 mm",
                         "coupler is 5 % longer from pin b to pin c: 420 mm instead of 400 mm"]),
    ({"crank": 0.09}, ["crank is 10 % shorter from pin a to pin b: 90 mm instead of 100 mm"]),
    ({"ground": 0.51, "rocker": 0.33}, ["rocker is 10 % longer from pin c to pin d: 330 mm instead of 300 mm",
                                        "ground is 2 % longer from pin a to pin d: 510 mm instead of 500 mm"]),
    ({"point": 0.0}, ["coupler is 100 % shorter from pin b to P: 0 mm instead of 200 mm",
                      "coupler is 100 % longer from pin c to P: 400 mm instead of 200 mm"]),
    # Six digits of the largest distance are the same.
    ({"crank": 0.1 + 0.4e-6}, []),
    ({"crank": 0.1 + 0.6e-6}, ["crank is 0.0006 % longer from pin a to pin b: 100.001 mm instead of 100 mm"]),
])  # fmt: skip
def test_distances_that_differ_are_named_the_largest_ratio_first(change: dict[str, float], expected: list[str]) -> None:
    assert words(four_bar(**change, unit=1e-3), four_bar()) == expected  # type: ignore[arg-type]


def test_links_that_cannot_be_laid_over_one_another_do_not_match() -> None:
    machine = four_bar()
    fewer = four_bar()
    fewer.edges.pop()
    assert words(fewer, machine) is None
    more = four_bar()
    more.link("flap")
    assert words(more, machine) is None
    # The point is on another link.
    assert words(four_bar(on="rocker"), machine) is None
    sliding = four_bar()
    edge = sliding.edges.pop()
    sliding.slide(edge.name, *edge.links, ((np.zeros(2), np.array([1.0, 0.0])),) * 2)
    assert words(sliding, machine) is None


def test_slides_are_compared_by_distances_across_and_tilts() -> None:
    machine = slider_crank()
    assert words(slider_crank(), machine) == []
    # Pins of the ground are 50 mm from the line through the slider's pin, which is 1 mm more.
    assert words(slider_crank(offset=0.051), machine) == [
        "slide is 2 % longer from pin second to the line of pin slider-pin: 51 mm instead of 50 mm",
    ]
    assert words(slider_crank(beside=-0.001), machine) == [
        "slide is 2 % shorter from pin second to the line of pin slider-pin: 49 mm instead of 50 mm",
    ]
    # Which point of the line the slide is drawn at does not matter, nor its sense.
    turned = slider_crank()
    start, way = turned.links[GROUND].lines["slide"]
    turned.links[GROUND].lines["slide"] = (start + 0.3 * way, -way)
    assert words(turned, machine) == []
    tilted = words(slider_crank(tilt=math.radians(0.5)), machine)
    assert tilted is not None
    assert tilted[0] == "slide is tilted by 0.5 deg on ground"


def test_graph_of_a_machine_has_its_pins_slides_and_points() -> None:
    graph = graph_of(Saw().mechanism())
    assert graph is not None
    assert graph.crank == "crank"
    assert sorted((edge.name, edge.kind) for edge in graph.edges) == [
        ("crank-pin", "pin"), ("shaft", "pin"), ("slide", "slide"), ("slider-pin", "pin"),
    ]  # fmt: skip
    assert sorted(graph.links) == ["crank", GROUND, "rod", "slider"]
    assert graph.links["rod"].points["M"].tolist() == [0.15, 0.0]
    assert graph.links["rod"].pins["slider-pin"].tolist() == [0.3, 0.0]
    # On each link a point of the slide's line and its direction.
    for link, point in ((GROUND, [0.0, 0.0]), ("slider", [0.0, 0.0])):
        start, way = graph.links[link].lines["slide"]
        assert (start.tolist(), way.tolist()) == (point, [1.0, 0.0])
    assert graph_of(CamFollower().mechanism()) is None
