"""The exact motion as polynomials in the crank angle, which agree with it to 1e-12 of L everywhere or are refused."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from conrod import InvalidInput
from conrod.exact.motion_table import TOLERANCE, MotionTable, _errors, motion_table
from conrod.mechanism.units import REVOLUTION
from conrod.scenes import SCENES, catalogue_names, scene_named


@cache
def tabulate_scene(name: str) -> MotionTable:
    return motion_table(scene_named(name))


# In closed form, a cam by arcs, a law whose fourth derivative jumps, one pass, three turns until wheels stand alike.
@pytest.mark.parametrize("name", ["saw-500rpm", "cam-follower", "cam-4-5-6-7", "double-rocker", "rolling-on-concave"])
def test_motion_table_matches_exact_motion_between_knots(name: str) -> None:
    scene, table = scene_named(name), tabulate_scene(name)
    angle = np.linspace(*scene.kinematics.span, 1009)
    angle = angle if table.turns == 0 else np.concatenate([angle, angle + 5.0 * REVOLUTION, angle - 7.0 * REVOLUTION])
    assert _errors(scene, table.evaluate(angle), angle, table.scales).max() < TOLERANCE


@pytest.mark.slow
@pytest.mark.parametrize("name", [*SCENES, *catalogue_names()])
def test_motion_table_exists_for_every_machine(name: str) -> None:
    assert len(tabulate_scene(name).knots) - 1 <= 84


@pytest.mark.parametrize(
    ("name", "turns"), [("saw-500rpm", 1), ("double-rocker", 0), ("rolling-on-concave", 3), ("planetary-gear", 21)]
)
def test_motion_table_covers_turns_until_motion_repeats(name: str, turns: int) -> None:
    assert tabulate_scene(name).turns == turns


@pytest.mark.parametrize("term", [0, 1, 2])
def test_motion_table_check_finds_coefficient_off_by_1e_9(term: int) -> None:
    scene, table = SCENES["saw-500rpm"], tabulate_scene("saw-500rpm")
    table.check(scene)
    coefficients = table.coefficients.copy()
    coefficients[3, table.names.index("C.x"), term] += 1e-9 * scene.lengths["C"]
    with pytest.raises(InvalidInput, match=r"of C\.x at crank angle .* differ by .*e-09; 1e-12 is allowed"):
        replace(table, coefficients=coefficients).check(scene)


@pytest.mark.parametrize(("part", "place"), [("knots", 3), ("gains", 2)])
def test_motion_table_check_finds_wrong_knot_or_gain(part: str, place: int) -> None:
    table = tabulate_scene("saw-500rpm")
    values = getattr(table, part).copy()
    values[place] += 1e-9
    with pytest.raises(InvalidInput, match="1e-12 is allowed"):
        replace(table, **{part: values}).check(SCENES["saw-500rpm"])


def test_motion_table_refuses_motion_that_never_repeats() -> None:
    radii = {"sun-mesh": (0.0201, 0.0149), "ring-mesh": (0.0149, 0.0499)}  # [m]; 700 turns of the sun to 201 of the arm
    gear = scene_named("planetary-gear").with_parameters(
        **{f"joints.{mesh}.radii.{k}": radius for mesh, pair in radii.items() for k, radius in enumerate(pair)}
    )
    with pytest.raises(InvalidInput, match="does not repeat within 60 turns"):
        motion_table(gear)
