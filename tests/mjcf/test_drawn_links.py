"""Links of users' models as lines of a picture: in which plane, where they are, and how many."""

from __future__ import annotations

import json

import mujoco
import numpy as np
import pytest
from four_bars import GRASHOF, four_bar, rocker_pin

from conrod.comparison.plain_values import plain_values
from conrod.mjcf.drawn_links import FRAMES, RunToDraw, draw_links
from conrod.mjcf.link_sketch import MAX_LINKS
from conrod.mjcf.loading import FoundPoint
from conrod.mjcf.picture_planes import OBLIQUE_WORDS, view_of
from conrod.report.drawing.moving_links import BAR, PIN, MovingLinks
from conrod.report.folder import restore_findings


def chain(links: int, axis: str = "0 1 0") -> mujoco.MjModel:
    """Bars of 0.1 m in a row; each other one turns about another axis."""
    bars = "".join(
        f'<body name="bar{k}" pos="{0.1 * (k > 0)} 0 0"><joint name="pin{k}" axis="{axis if k % 2 else "0 1 0"}"/>'
        '<geom type="capsule" fromto="0 0 0 .1 0 0" size=".01" contype="0"/>'
        for k in range(links)
    )
    return mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{bars}{'</body>' * links}</worldbody></mujoco>")


def swings(model: mujoco.MjModel, size: float = 0.3) -> np.ndarray:
    """Coordinates (nq, K) of hinges that swing together."""
    return size * np.sin(np.linspace(0.0, 6.0, FRAMES + 1)) * np.ones((model.nq, 1))


def drawn(model: mujoco.MjModel, exact: np.ndarray | None = None, **runs: np.ndarray) -> MovingLinks:
    given = [RunToDraw(name, "stock", 1.0, coordinates) for name, coordinates in runs.items()]
    found = draw_links(model, exact, given)
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("across", "words"),
    [
        ((0.0, 0.0, 1.0), "In the xy plane"), ((0.0, 1.0, 0.0), "In the xz plane"),
        ((1.0, 0.0, 0.0), "In the yz plane"),
        ((0.0, 0.6, 0.8), "In the plane of its motion, seen from (0, 0.6, 0.8)"),
    ],
)  # fmt: skip
def test_planar_motion_is_seen_in_its_plane(across: tuple[float, ...], words: str) -> None:
    angles = np.linspace(0.0, 3.0, 20)
    one, other = np.linalg.svd(np.array([across]))[2][1:]
    circle = (np.outer(np.cos(angles), one) + np.outer(np.sin(angles), other))[:, None]
    view = view_of(circle)
    assert view.words == words
    # Nothing is foreshortened, and up in space is not down in the picture.
    seen = view.project(circle)[:, 0]
    np.testing.assert_allclose(np.linalg.norm(seen - seen.mean(axis=0), axis=1).max(), np.linalg.norm(
        circle[:, 0] - circle[:, 0].mean(axis=0), axis=1).max())  # fmt: skip
    assert view.project(np.array([0.0, 0.0, 1.0]))[1] <= 1e-12
    # Control: a motion that leaves the plane by a thousandth of itself is one in space.
    assert view_of(circle + 1e-3 * np.sin(3.0 * angles)[:, None, None] * np.array(across)).words == OBLIQUE_WORDS


def test_a_slide_is_seen_from_the_side_that_shows_most() -> None:
    along = np.linspace(0.0, 1.0, 9)[:, None, None] * [0.0, 0.0, 1.0]
    assert view_of(along + np.array([[0.0, 0.0, 0.0], [0.3, 0.01, 0.0]])).words == "In the xz plane"
    assert view_of(along + np.array([[0.0, 0.0, 0.0], [0.01, 0.3, 0.0]])).words == "In the yz plane"


def test_drawn_pins_are_where_the_linkage_has_them() -> None:
    model = mujoco.MjModel.from_xml_string(four_bar(frame=""))
    pose = model.qpos0[:, None] * np.ones(FRAMES + 1)
    pose[0] += np.linspace(0.0, 1.0, FRAMES + 1)  # the crank alone: its pin moves, the rocker's stands
    found = drawn(model, None, run=pose)
    pins = {shape.link: shape.points[0] for shape in (*found.shapes, *found.ground) if shape.kind == PIN}
    row = found.runs[0].rows[0].reshape(-1, 2)
    crank, ground = found.ground_points[pins["crank"]], found.ground_points[pins["rocker"]]
    scale = float(np.linalg.norm(ground - crank)) / GRASHOF[3]
    wanted = crank + scale * rocker_pin(GRASHOF, 1.0) * [1.0, -1.0]
    np.testing.assert_allclose(row[pins["pin"]], wanted, atol=0.2)
    # Control: an end of the crank that is drawn elsewhere is not where it should be.
    assert float(np.linalg.norm(row[pins["coupler"]] - wanted)) > 50.0


def test_differences_from_the_exact_places_keep_their_digits() -> None:
    model = chain(2)
    exact = swings(model)
    found = drawn(model, exact, close=exact + 1e-9, broke=exact[:, :20])
    assert found.reference == "exact"
    close, broke = found.runs
    # The far end is 0.1 m off the first pin's axis and 0.1 m off the second's: off by 1e-9 (0.1 + 0.2) m at most.
    assert 1e-7 < max(close.off) <= 3.01e-7
    assert 0.0 < float(np.abs(close.rows).max()) < 1e-5
    assert len(broke.rows) == 20
    assert max(broke.off) == 0.0
    # Control: what is planted into a run shows.
    assert max(drawn(model, exact, far=exact + 1e-3).runs[0].off) == pytest.approx(0.3, rel=0.02)


@pytest.mark.parametrize("links", [1, 60, 75])
def test_picture_is_bounded_whatever_is_in_the_model(links: int) -> None:
    model = chain(links, "0 0 1")
    motion = swings(model, 0.1)
    found = drawn(model, None, run=motion)
    assert found.left_out == max(0, links - MAX_LINKS)
    bars = {shape.link for shape in found.shapes if shape.kind != PIN}
    assert len(bars) == min(links, MAX_LINKS)
    assert found.runs[0].rows.shape[0] == FRAMES + 1
    assert found.runs[0].rows.size < 40_000
    several = drawn(model, motion, one=motion, two=motion, three=motion)
    assert several.exact.size + sum(run.rows.size for run in several.runs) < 60_000
    assert len(several.exact) == len(several.runs[2].rows) >= 1 + FRAMES // 6
    assert found.view == (OBLIQUE_WORDS if links > 1 else "In the xz plane")


def test_judged_points_are_named_and_links_without_geoms_drawn() -> None:
    model = mujoco.MjModel.from_xml_string(four_bar(frame=""))
    sites = {model.site(k).name: FoundPoint(model.site(k).name, "site", k, int(model.site_bodyid[k])) for k in range(3)}
    pose = model.qpos0[:, None] + np.linspace(0.0, 0.3, 5) * np.ones((3, 1))
    found = draw_links(model, pose, [RunToDraw("run", "", 1.0, pose)], [sites["A"], sites["B"], sites["C"]])
    assert found is not None
    assert {name for _, name in found.labels} == {"A", "B", "C"}
    assert {shape.link for shape in found.shapes if shape.kind == BAR} == {"crank", "coupler", "rocker"}
    # A point that stays beside a named one is not named over it.
    twice = draw_links(model, pose, [RunToDraw("run", "", 1.0, pose)], [sites["A"], sites["A"]])
    assert twice is not None
    assert len(twice.labels) == 1


def test_picture_is_read_from_the_ledger_as_it_was_kept() -> None:
    model = chain(2)
    values = plain_values(drawn(model, own=swings(model)))

    def is_restored(kept: str) -> bool:
        return json.dumps(plain_values(restore_findings(MovingLinks, json.loads(kept)))) == kept

    assert is_restored(json.dumps(values))
    # Negative control: a number written in a way that its type does not have.
    assert not is_restored(json.dumps({**values, "box": [float(one) for one in values["box"]]}))


def test_nothing_is_drawn_of_what_cannot_move() -> None:
    still = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
    assert draw_links(still, None, [RunToDraw("run", "", 1.0, np.zeros((0, 5)))]) is None
    assert draw_links(chain(1), None, []) is None
