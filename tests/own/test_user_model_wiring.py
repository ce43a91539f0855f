"""Wiring, assembly branch and plane of a user's own model: every defect is planted, and has to be told by its name."""

from __future__ import annotations

from pathlib import Path

import pytest
from own_model_edits import (
    CONNECT,
    PIECES,
    ROD_END,
    TEXTS,
    judged,
    mirrored,
    other_branch_of_the_press,
    other_branch_of_the_saw,
    question,
    replaced,
    scanned,
    seen,
    without,
)

from conrod.errors import InvalidInput
from conrod.own.models.frame import GivenFrame
from conrod.own.models.request import ModelFacts, Place
from conrod.report.user_model import verdict

SAW = TEXTS["saw"]


def facts(folder: Path, text: str) -> ModelFacts:
    return scanned(folder, text, question("saw"))[1].facts


# -- wiring and branch ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "given"),
    [
        (other_branch_of_the_saw(), GivenFrame()),
        (mirrored(SAW), GivenFrame()),
        (other_branch_of_the_press(), GivenFrame(rotation=0.0)),
    ],
    ids=["saw", "saw-mirrored", "press"],
)
def test_the_other_assembly_branch_is_named(tmp_path: Path, text: str, given: GivenFrame) -> None:
    identity = seen(tmp_path, "press" if "press" in text[:40] else "saw", text, given)
    assert identity.other_branch
    assert not identity.is_machine(1e-3)
    assert identity.left < 1e-9


def test_a_mirror_image_is_the_machine_where_it_is_to_be_seen_from_behind(tmp_path: Path) -> None:
    identity = seen(tmp_path, "saw", mirrored(SAW), GivenFrame(plane="-xy"))
    assert identity.is_machine(1e-12)
    assert (identity.frame.view.behind, identity.frame.sense) == (True, -1)


FLAP = '<body><joint name="flap" axis="0 1 0"/><geom size="1"/></body>'
WELD = '<weld body1="crank" body2="world"/>'


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (without(SAW, PIECES["equality"]), r"mobility is 3 .* machine is 1: .* slide, crank-pin can still move"),
        (replaced(SAW, "</worldbody>", f"{FLAP}</worldbody>"), r"mobility is 2 .* flap can still move"),
        (replaced(SAW, "</equality>", f"{WELD}</equality>"), r"mobility is 0 .* its closures hold the crank"),
        (replaced(SAW, ROD_END, 'name="slider-pin.rod" pos="0.12 0 0"'), "goes no further than"),
    ],
    ids=["open", "a-flap-too", "welded", "short-rod"],
)
def test_a_model_of_another_mobility_or_that_cannot_turn_is_told(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(InvalidInput, match=told):
        seen(tmp_path, "saw", text)


def test_a_redundant_closure_is_named_and_harms_nothing(tmp_path: Path) -> None:
    twice = replaced(SAW, "</equality>", f"{CONNECT}</equality>")
    wiring = facts(tmp_path, twice).wiring
    assert (wiring.idle, wiring.loops) == (("again",), 1)
    assert facts(tmp_path, SAW).wiring.idle == ()


def test_a_joint_of_another_kind_is_not_explained_by_lengths(tmp_path: Path) -> None:
    hinge = '<joint name="slide" type="hinge" axis="0 0 1" pos="0 0.4 0" />'
    text = replaced(SAW, '<joint name="slide" type="slide" axis="1 0 0" />', hinge)
    study = judged(tmp_path, "saw", text)
    assert not study.identity.is_machine(1e-2)
    assert not study.identity.explanations
    assert (
        "it has 3 hinges, 1 connect, the machine 3 pins, 1 slide: is a joint of another kind, or a link missing?"
        in verdict(study)
    )
    # It is not driven: its errors would be those of another machine.
    assert not study.runs


def test_limits_that_keep_a_model_from_its_turn_are_told(tmp_path: Path) -> None:
    slide = '<joint name="slide" type="slide"'
    limited = judged(tmp_path, "saw", replaced(SAW, slide, f'{slide} range="-0.1 0.3"'))
    assert limited.is_machine
    assert not limited.passed
    assert (
        "limits keep it from its turn: slide is held to -0.1 to 0.3 units of length, needs -0.203541 to 0.00756977"
        in verdict(limited)
    )
    # Negative control: limits that the turn stays within are no matter.
    assert facts(tmp_path, replaced(SAW, slide, f'{slide} range="-0.3 0.3"')).stops == ()


def test_a_crank_with_limits_needs_room_for_a_turn(tmp_path: Path) -> None:
    crank = '<joint name="crank" type="hinge"'
    for limits, told in (("-0.5 0.5", ("crank is held to -0.5 to 0.5 rad, needs a full turn",)), ("-4 4", ())):
        assert facts(tmp_path, replaced(SAW, crank, f'{crank} range="{limits}"')).stops == told


# -- plane -----------------------------------------------------------------------------------------------------------


def test_a_plane_that_cannot_be_told_is_an_error_with_its_size(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="nothing moves, of C"):
        seen(tmp_path, "saw", SAW, points=(Place("C", "body", "crank"),))
    with pytest.raises(InvalidInput, match="is not across it"):
        seen(tmp_path, "saw", SAW, GivenFrame(plane="xz"))
    riding = replaced(SAW, '<joint name="crank-pin" type="hinge"', '<joint name="crank-pin" type="hinge" armature="1"')
    with pytest.raises(InvalidInput, match="axis itself moves"):
        seen(tmp_path, "saw", riding, crank="crank-pin")


def test_a_point_that_leaves_the_plane_is_an_error_with_its_size(tmp_path: Path) -> None:
    flap = '<body><joint name="tilt" axis="1 0 0"/><geom size="0.01"/><site name="T" pos="0 0.1 0"/></body>'
    text = replaced(SAW, '<site name="C" pos="0 0 0" />', f'<site name="C" pos="0 0 0" />{flap}')
    text = replaced(text, "</equality>", '<joint joint1="tilt" joint2="slide" polycoef="0 0.5 0 0 0"/></equality>')
    assert seen(tmp_path, "saw", text).is_machine(1e-12)
    with pytest.raises(InvalidInput, match=r"C leaves the plane across the crank's axis by 0\.0105"):
        seen(tmp_path, "saw", text, points=(Place("C", "site", "T"),))
