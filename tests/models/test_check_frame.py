"""The frame of a scene's document in a model: views of a plane, and what becomes of places, angles and units in it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from conrod.errors import InvalidInput
from conrod.models.check.frame import Frame, PlaneView, candidate_views

X, Y, Z = np.eye(3)
XZ = PlaneView("xz", (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), -1)
# Turned by a right angle in the view, in mm, about an anchor; the shaft is at (0.2, 0.3) m of the document.
FRAME = Frame(XZ, -1, math.pi / 2.0, 0.25, 1e-3, (10.0, 20.0, 30.0), (0.2, 0.3))


@pytest.mark.parametrize(("axis", "sense", "views"), [
    # Seen along z with x to the right and y up, along y with x and z, along x with y and z.
    (Z, 1, [("xy", 1)]), (-Z, -1, [("xy", -1)]), (X, 1, [("yz", 1)]), (-Y, 1, [("xz", 1)]),
    # Where the crank angle would fall as the hinge's coordinate grows, it may be seen from behind.
    (Z, -1, [("xy", 1), ("-xy", -1)]), (Y, 1, [("xz", -1), ("-xz", 1)]), (-X, 1, [("yz", -1), ("-yz", 1)]),
    (np.array([1e-8, -1.0, 0.0]), 1, [("xz", 1)]),
])  # fmt: skip
def test_a_plane_is_seen_from_its_usual_side_first(axis: np.ndarray, sense: int, views: list[tuple[str, int]]) -> None:
    found = candidate_views(axis, sense, None)
    assert [(view.name, view.sense) for view in found] == views


def test_a_view_has_its_directions() -> None:
    (view,) = candidate_views(Y, 1, "-xz")
    assert view == PlaneView("-xz", (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 1)
    (view,) = candidate_views(Z, 1, "y-x")
    assert view == PlaneView("y-x", (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), 1)
    (view,) = candidate_views(Z, 1, "+x-y")
    assert (view.right, view.up, view.sense) == ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), -1)


@pytest.mark.parametrize("plane", ["", "x", "xx", "x-x", "xw", "xyz", "x y"])
def test_a_plane_that_is_none_is_refused(plane: str) -> None:
    with pytest.raises(InvalidInput) as refused:
        candidate_views(Z, 1, plane)
    assert str(refused.value) == f"--plane {plane}: give the directions to the right and up, e.g. xy, xz, yz, or -xz"


def test_a_plane_that_the_axis_is_not_across_is_refused() -> None:
    with pytest.raises(InvalidInput) as refused:
        candidate_views(Z, 1, "xz")
    assert str(refused.value) == (
        "plane xz: the crank's axis (0 0 1) is not across it, so it is not that of the motion"
    )
    slant = np.array([0.0, math.sin(2e-3), math.cos(2e-3)])  # the cosine is off by 2e-6
    with pytest.raises(InvalidInput, match=r"the crank's axis \(0 0\.002 1\) is not across it"):
        candidate_views(slant, 1, None)
    near = np.array([0.0, math.sin(1e-3), math.cos(1e-3)])  # by 5e-7
    assert candidate_views(near, 1, None)[0].name == "xy"


def test_vectors_are_projected_to_the_picture() -> None:
    vectors = np.array([[1.0, 2.0, 3.0], [-4.0, 5.0, 6.0]])
    assert XZ.as_complex(vectors).tolist() == [1 + 3j, -4 + 6j]


def test_places_and_vectors_are_seen_in_the_document() -> None:
    # x of the document is z of the model, y is -x; of mm.
    assert FRAME.document_vectors(np.array([[1.0, 2.0, 3.0]])) == pytest.approx(np.array([[3e-3, -1e-3]]))
    assert FRAME.document_positions(np.array([[11.0, 7.0, 33.0], [10.0, 0.0, 30.0]])) == pytest.approx(
        np.array([[0.203, 0.299], [0.2, 0.3]])
    )


def test_crank_angles_grow_with_or_against_the_coordinate() -> None:
    assert FRAME.angle(np.array([0.25, 1.25])) == pytest.approx([0.0, -1.0])
    assert replace(FRAME, sense=1).angle(np.array([0.25, 1.25])) == pytest.approx([0.0, 1.0])


@pytest.mark.parametrize(("unit", "name"), [
    (1.0, "m"), (1e-2, "cm"), (1e-3, "mm"), (0.0254, "inch"), (0.3048, "0.3048 m"),
])  # fmt: skip
def test_units_have_names(unit: float, name: str) -> None:
    assert replace(FRAME, unit=unit).unit_name == name
