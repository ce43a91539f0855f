"""What a pymunk model may carry: added and taken away, seen in the space, and felt in the motion or not."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pymunk
import pytest
from catalogue import CAM, EVERY_SCENE, LINKAGES, PRESS, SAW, WITH_A_ROD

from conrod import Comparison, InvalidInput, Outcome, PymunkSettings, Trajectory, compare, run
from conrod.engines import engine_named
from conrod.engines.massless_rod import BODY, DISTANCE_JOINT
from conrod.engines.pymunk import mobility
from conrod.engines.pymunk import model_edits as dressing
from conrod.engines.pymunk import points as pymunk_instants
from conrod.engines.pymunk.settings import NAMES, SHAPES, SUBSTEPS
from conrod.engines.pymunk.space import build
from conrod.engines.variants import Ingredient

ENGINE = engine_named("pymunk")
QUANTITIES = ("position", "velocity", "acceleration")
MACHINES = {"press": PRESS, "saw": SAW, "cam": CAM}
TURN = 2.0 * math.pi


def minimal(scene: Any, steps: int = 1000) -> PymunkSettings:
    return ENGINE.minimal(scene, steps)


def ingredients(scene: Any, steps: int = 1000) -> dict[str, Ingredient[PymunkSettings]]:
    return {one.name: one for one in ENGINE.ingredients(scene, minimal(scene, steps))}


@cache
def ran(scene: Any, settings: PymunkSettings, revolutions: float = 2.0) -> Trajectory:
    return run(scene, settings, revolutions)


@cache
def measured(scene: Any, settings: PymunkSettings) -> Comparison:
    trajectory = ran(scene, settings)
    assert trajectory.outcome is Outcome.COMPLETED, trajectory.reason
    return compare(trajectory, scene)


# -- settings --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MACHINES)
def test_what_is_added_is_taken_away_again(name: str) -> None:
    scene, model = MACHINES[name], minimal(MACHINES[name])
    found = ingredients(scene)
    assert len(found) > 15
    for one in found.values():
        changed = (one.removed if one.minimal else one.added)(model)
        assert changed != model, one.name
        assert (one.added if one.minimal else one.removed)(changed) == model, one.name
        assert ENGINE.refusal(scene, changed) is None, one.name


def test_results_from_before_keep_their_keys() -> None:
    plain = PymunkSettings.tuned(SAW, 200).as_dict()
    assert "dressing" not in plain
    assert "cam" not in plain


def test_equal_models_are_equal_whatever_the_order_they_were_dressed_in() -> None:
    one = replace(minimal(SAW), dressing=("damping", "redundant-joints", "damping"))
    other = replace(minimal(SAW), dressing=("redundant-joints", "damping"))
    assert one == other
    assert one.dressing == ("redundant-joints", "damping")
    with pytest.raises(InvalidInput, match=r"unknown dressing 'dampin'.*did you mean 'damping'"):
        replace(one, dressing=("dampin",))


# -- the space -------------------------------------------------------------------------------------------------------


def space_of(scene: Any, *names: str, **fields: Any) -> pymunk.Space:
    return build(scene, replace(minimal(scene), dressing=names, **fields)).space


def test_every_name_is_an_edit_or_sub_steps() -> None:
    assert set(dressing.EDITS) | set(SUBSTEPS) == set(NAMES)
    assert not set(dressing.EDITS) & set(SUBSTEPS)


def test_the_space_is_what_its_dressing_says() -> None:
    assert space_of(SAW).damping == 1.0
    assert space_of(SAW, "damping").damping == 0.9
    assert math.isinf(space_of(SAW).sleep_time_threshold)
    assert space_of(SAW, "sleeping").sleep_time_threshold == 0.5
    assert len(space_of(SAW, "redundant-joints").constraints) == 2 * len(space_of(SAW).constraints)
    assert [type(c) for c in space_of(SAW, "open-loop").constraints] == [pymunk.GrooveJoint]
    opened = space_of(SAW, "open-loop", rod=BODY).constraints
    assert [type(c) for c in opened] == [pymunk.PivotJoint, pymunk.GrooveJoint]
    assert not space_of(CAM, "open-loop").shapes
    again = space_of(SAW, "redundant-joints", rod=BODY)
    assert {c.error_bias for c in again.constraints} == {0.0}


# -- the motion ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", LINKAGES)
def test_the_minimal_model_is_as_accurate_as_the_best_preset(name: str) -> None:
    scene: Any = LINKAGES[name]
    assert minimal(scene).rod == DISTANCE_JOINT
    small, tuned = measured(scene, minimal(scene)), measured(scene, PymunkSettings.tuned(scene, 1000))
    for quantity in QUANTITIES:
        assert small.worst(quantity) == pytest.approx(tuned.worst(quantity), rel=0.01)


@pytest.mark.parametrize("name", WITH_A_ROD)
def test_its_iterations_are_enough(name: str) -> None:
    scene: Any = EVERY_SCENE[name]
    few, many = (measured(scene, replace(minimal(scene), iterations=count)) for count in (10, 300))
    for quantity in QUANTITIES:
        assert few.worst(quantity) == pytest.approx(many.worst(quantity), rel=0.03)


@pytest.mark.parametrize("name", ["gravity", "damping", "sleeping", "stock-contact", "redundant-joints", *SHAPES[1:]])
def test_what_the_motion_does_not_need_does_not_change_it(name: str) -> None:
    carried = ingredients(SAW)[name].added(minimal(SAW))
    for point, tracks in ran(SAW, minimal(SAW)).points.items():
        difference = ran(SAW, carried).points[point].position.values - tracks.position.values
        assert np.abs(difference).max() < 1e-9 * SAW.lengths[point]


@pytest.mark.parametrize(("name", "quantity"), [("full-correction", "position"), ("iterations", "acceleration")])
def test_what_the_minimal_model_consists_of_it_needs(name: str, quantity: str) -> None:
    lacking = ingredients(SAW)[name].removed(minimal(SAW))
    assert measured(SAW, lacking).worst(quantity) > 10.0 * measured(SAW, minimal(SAW)).worst(quantity)


@pytest.mark.parametrize(("name", "closure"), [("press", "closure"), ("saw", "closure"), ("cam", "contact")])
def test_without_its_closure_a_loop_does_not_hold(name: str, closure: str) -> None:
    scene = MACHINES[name]
    assert ran(scene, ingredients(scene)[closure].removed(minimal(scene)), 0.7).outcome is not Outcome.COMPLETED


def test_links_that_collide_where_they_are_joined_do_not_move_as_they_should() -> None:
    found = ingredients(SAW, 200)
    body, colliding = (found[name].added(minimal(SAW, 200)) for name in ("rod-body", "rod-body-colliding"))
    assert measured(SAW, body).worst("position") < 1e-3
    ended = ran(SAW, colliding)
    assert ended.outcome is not Outcome.COMPLETED or compare(ended, SAW).worst("position") > 0.01


# -- sub-steps -------------------------------------------------------------------------------------------------------


def test_a_velocity_belongs_to_half_a_sub_step_after_it(monkeypatch: pytest.MonkeyPatch) -> None:
    stepped = replace(minimal(SAW, 200), iterations=100, dressing=("substeps-10",))
    right = measured(SAW, stepped).worst("velocity")
    assert right < 0.05 * measured(SAW, replace(stepped, dressing=())).worst("velocity")
    # Negative control: read as if it belonged to half a step after it.
    told = pymunk_instants.staggered
    monkeypatch.setattr("conrod.engines.pymunk.dynamics.staggered", lambda *arguments: told(*arguments[:-1]))
    assert compare(run(SAW, stepped), SAW).worst("velocity") > 10.0 * right


# -- mobility --------------------------------------------------------------------------------------------------------

ALONG = np.linspace(0.01, TURN, 12)


@pytest.mark.parametrize("name", EVERY_SCENE)
def test_the_space_has_the_freedom_that_gruebler_counts(name: str) -> None:
    scene: Any = EVERY_SCENE[name]
    for settings in (minimal(scene), PymunkSettings.tuned(scene, 1000)):
        count = ENGINE.mobility(scene, settings, ALONG)
        assert count.freedom == count.most_freedom == scene.kinematics.mechanism.mobility == 1
        assert (dict(count.redundant), count.missing, count.empty) == ({}, 0, ())
        links = len(build(scene, settings).bodies)
        assert (count.coordinates, count.rows) == (3 * links, 3 * links - 1)


def test_redundant_and_missing_joints_are_named() -> None:
    for scene, rod, again in ((SAW, BODY, {"slide": 1, "crank-pin": 2, "slider-pin": 2}), (CAM, BODY, {"guide": 1})):
        twice = replace(minimal(scene), rod=rod, dressing=("redundant-joints",))
        count = ENGINE.mobility(scene, twice, ALONG)
        assert count.freedom == 1
        assert dict(count.redundant) == {f"{name} again": rows for name, rows in again.items()}
        opened = ENGINE.mobility(scene, replace(twice, dressing=("open-loop",)), ALONG)
        assert opened.missing == (2 if scene is SAW else 1)


def test_the_rows_are_the_gradients_of_the_gaps() -> None:
    # What the space's own joints leave of the exact rates, which close every gap, is rounding.
    for scene, rod in ((SAW, BODY), (SAW, DISTANCE_JOINT), (PRESS, BODY)):
        made = build(scene, replace(minimal(scene), rod=rod))
        poses, slopes = scene.kinematics.derivatives(np.array([0.7]), 1)
        made.place(poses[0], slopes[0])
        for row, gradient in mobility._rows(made):
            rate = sum(
                x * body.velocity.x + y * body.velocity.y + turn * body.angular_velocity
                for body, (x, y, turn) in gradient.items()
            )
            assert abs(rate) < 1e-15, row
        # Negative control: a rate that does not fit the joints shows in some of them.
        made.bodies[-1].velocity += pymunk.Vec2d(1e-3, 1e-3)
        rates = [
            sum(x * b.velocity.x + y * b.velocity.y + t * b.angular_velocity for b, (x, y, t) in gradient.items())
            for _, gradient in mobility._rows(made)
        ]
        assert np.abs(rates).max() > 1e-4
