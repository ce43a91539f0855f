"""Is a user's own model the machine that it is to be? Every defect is planted, and has to be told by its name."""

from __future__ import annotations

import math
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from own_model_edits import (
    HACKSAW,
    ROD_END,
    TEXTS,
    identify_text,
    judge_text,
    mirror_x,
    question,
    replace_once,
    scale_lengths,
    scan_text,
    wrap_in_body,
)

from conrod import scene
from conrod.errors import InvalidInput
from conrod.mjcf.request import ModelFacts, PointPlace
from conrod.models.check.frame import GivenFrame
from conrod.models.check.identity import MAX_CHANGE_SETS, _change_sets
from conrod.models.check.report import length_words, verdict

SAW = TEXTS["saw"]
DEGREES = np.pi / 180.0
BY_HAND = (PointPlace("C", "body", "bow"), PointPlace("M", "geom", "rod"))


def facts(folder: Path, text: str) -> ModelFacts:
    return scan_text(folder, text, question("saw"))[2].facts


# -- it is the machine ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["saw", "press", "cam"])
def test_own_file_is_its_machine_to_rounding_or_shape_error(tmp_path: Path, kind: str) -> None:
    identity = identify_text(tmp_path, kind, TEXTS[kind])
    frame = identity.frame
    assert identity.is_machine(1e-12)
    assert (frame.view.name, frame.rotation, frame.zero, frame.unit) == ("xy", 0.0, 0.0, 1.0)
    assert not identity.explanations
    assert kind != "cam" or 1e-9 < identity.largest < identity.floor < 2e-6


TURNED = wrap_in_body(scale_lengths(SAW, 1.0 / 0.0254), euler=f"0 0 {30 * DEGREES!r}", pos="1 2 3")
FROM_BEHIND = wrap_in_body(scale_lengths(SAW, 1.0 / 0.0254), euler=f"0 {180 * DEGREES!r} 0")


@pytest.mark.parametrize(("text", "given", "asked", "frame"), [
    (TURNED, None, {}, ("xy", 1, 30.0, 0.0, "inch")),
    (FROM_BEHIND, None, {}, ("-xy", 1, 0.0, 0.0, "inch")),
    (HACKSAW.read_text(), None, {"points": BY_HAND, "crank": "motor"}, ("xz", -1, 0.0, 90.0, "m")),
    # A mirror image is the machine where it is to be seen from behind.
    (mirror_x(SAW), GivenFrame(plane="-xy"), {}, ("-xy", -1, 0.0, 0.0, "m")),
], ids=["turned", "from-behind", "by-hand", "mirrored"])  # fmt: skip
def test_the_frame_is_worked_out(
    tmp_path: Path, text: str, given: GivenFrame | None, asked: dict[str, Any], frame: tuple[object, ...]
) -> None:
    identity = identify_text(tmp_path, "saw", text, given, **asked)
    found = identity.frame
    angles = (pytest.approx(math.degrees(angle), abs=1e-12) for angle in (found.rotation, found.zero))
    assert identity.is_machine(1e-12)
    assert (found.view.name, found.sense, *angles, found.unit_name) == frame


def test_a_frame_that_is_given_is_used(tmp_path: Path) -> None:
    turned = wrap_in_body(SAW, euler=f"0 0 {30 * DEGREES!r}")
    right = identify_text(tmp_path, "saw", turned, GivenFrame("xy", 30 * DEGREES, 0.0))
    assert right.is_machine(1e-12)
    # Negative control: what is given is not bettered by a fit.
    for wrong in (GivenFrame(rotation=31 * DEGREES), GivenFrame(zero=1 * DEGREES)):
        assert not identify_text(tmp_path, "saw", turned, wrong, points=("C",)).is_machine(1e-3)


# -- lengths and branch ------------------------------------------------------------------------------------------------


ASIDE = replace_once(SAW, '<body name="rod" pos="0.1 0 0"', '<body name="rod" pos="0.1 0.001 0"')
HIGH = replace_once(SAW, '<body name="slider" pos="0 0 0"', '<body name="slider" pos="0 0.001 0"')


@pytest.mark.parametrize(("kind", "text", "told", "value"), [
    ("saw", ASIDE, "crank is 0.005 % too long", math.hypot(0.1, 0.001)),
    ("saw", HIGH, "offset is 1.1 % too ", 0.091),
    ("press", scale_lengths(TEXTS["press"], 1.001), "all lengths are 1.001 times those expected", 1.001),
], ids=["crank-pin-aside", "slide-high", "all-alike"])  # fmt: skip
def test_one_length_that_is_off_is_found_to_rounding(
    tmp_path: Path, kind: str, text: str, told: str, value: float
) -> None:
    identity = identify_text(tmp_path, kind, text)
    (found,) = identity.explanations
    assert [one.found for one in found.lengths] == [pytest.approx(value, rel=1e-10)]
    assert length_words(found.lengths[0]).startswith(told)
    assert not found.misplaced
    assert identity.left < 1e-12


def test_misplaced_point_is_named_beside_its_longer_rod(tmp_path: Path) -> None:
    text = replace_once(SAW, ROD_END, 'name="slider-pin.rod" pos="0.30003 0 0"')
    (found,) = identify_text(tmp_path, "saw", text).explanations
    assert [length_words(one) for one in found.lengths] == ["rod is 0.01 % too long: 300.03 mm instead of 300 mm"]
    (misplaced,) = found.misplaced
    assert (misplaced.point, misplaced.away) == ("M", pytest.approx(15e-6, rel=1e-6))


@pytest.mark.parametrize("radius", [0.0095, 0.0090001], ids=["by-far", "just-beyond-the-bound"])
def test_wrong_cam_length_is_found_above_shape_error(tmp_path: Path, radius: float) -> None:
    text = replace_once(TEXTS["cam"], 'type="sphere" size="0.009"', f'type="sphere" size="{radius}"')
    identity = identify_text(tmp_path, "cam", text)
    assert not identity.is_machine(1e-6)
    assert {"roller_radius"} in [{one.name for one in found.lengths} for found in identity.explanations]


# The press's slider below the shaft; the saw's to the right of it, with a rod that is too long.
PRESS_BELOW = replace_once(TEXTS["press"], '"slider" pos="0 0.4225 0"', '"slider" pos="0 -0.3575 0"')
PRESS_BELOW = replace_once(PRESS_BELOW, '"rod" pos="0.0325 0 0"', '"rod" pos="0.0325 0 0" euler="0 0 3.14159265"')
SAW_RIGHT = replace_once(SAW, '"slider" pos="0 0 0"', '"slider" pos="0.57236352 0 0"')
SAW_RIGHT = replace_once(SAW_RIGHT, "2.836899999574396", "0.30469265")
SAW_RIGHT = replace_once(SAW_RIGHT, ROD_END, 'name="slider-pin.rod" pos="0.3001 0 0"')


@pytest.mark.parametrize(("kind", "text", "given", "lengths"), [
    ("press", PRESS_BELOW, GivenFrame(rotation=0.0), []),
    ("saw", SAW_RIGHT, None, [[("rod", 0.3001)]]),
])  # fmt: skip
def test_other_branch_is_named_with_a_wrong_length_on_it(
    tmp_path: Path, kind: str, text: str, given: GivenFrame | None, lengths: list[list[tuple[str, float]]]
) -> None:
    identity = identify_text(tmp_path, kind, text, given, points=("C",) if kind == "saw" else ("A", "G"))
    assert identity.other_branch
    assert not identity.is_machine(1e-3)
    assert identity.left < 1e-9
    assert [[(one.name, round(one.found, 9)) for one in found.lengths] for found in identity.explanations] == lengths


# -- wiring and limits -------------------------------------------------------------------------------------------------


FLAP = '<body><joint name="flap" axis="0 1 0"/><geom size="1"/></body>'
WELD = '<weld body1="crank" body2="world"/>'


@pytest.mark.parametrize(("text", "told"), [
    (re.sub(r"(?s)<equality>.*</equality>", "", SAW), r"mobility is 3 .* is 1: .* slide, crank-pin can still move"),
    (replace_once(SAW, "</worldbody>", f"{FLAP}</worldbody>"), r"mobility is 2 .* flap can still move"),
    (replace_once(SAW, "</equality>", f"{WELD}</equality>"), r"leaves 0; 1 of its 1 drives is too many"),
    (replace_once(SAW, ROD_END, 'name="slider-pin.rod" pos="0.12 0 0"'), "goes no further than"),
], ids=["open", "a-flap-too", "welded", "short-rod"])  # fmt: skip
def test_a_model_of_another_mobility_or_that_cannot_turn_is_told(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(InvalidInput, match=told):
        identify_text(tmp_path, "saw", text)


def test_a_joint_of_another_kind_is_not_explained_by_lengths(tmp_path: Path) -> None:
    hinge = '<joint name="slide" type="hinge" axis="0 0 1" pos="0 0.4 0" />'
    study = judge_text(tmp_path, "saw", replace_once(SAW, '<joint name="slide" type="slide" axis="1 0 0" />', hinge))
    assert not study.identity.is_machine(1e-2)
    assert not study.identity.explanations
    assert "no lengths explain it: it has 3 hinges, 1 connect, the machine 3 pins, 1 slide" in verdict(study)
    # It is not driven: its errors would be those of another machine.
    assert not study.runs


def test_limits_that_keep_a_model_from_its_turn_are_told(tmp_path: Path) -> None:
    slide, crank = '<joint name="slide" type="slide"', '<joint name="crank" type="hinge"'
    limited = judge_text(tmp_path, "saw", replace_once(SAW, slide, f'{slide} range="-0.1 0.3"'))
    assert limited.is_machine
    assert not limited.passed
    told = "limits keep it from its turn: slide is held to -0.1 to 0.3 units of length, needs -0.203541 to 0.00756977"
    assert told in verdict(limited)
    # Negative control: limits that the turn stays within are no matter.
    for joint, wide in ((slide, "-0.3 0.3"), (crank, "-4 4")):
        assert facts(tmp_path, replace_once(SAW, joint, f'{joint} range="{wide}"')).stops == ()


# -- plane -----------------------------------------------------------------------------------------------------------


def test_a_plane_that_cannot_be_told_is_an_error_with_its_size(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="nothing moves, of C"):
        identify_text(tmp_path, "saw", SAW, points=(PointPlace("C", "body", "crank"),))
    with pytest.raises(InvalidInput, match="is not across it"):
        identify_text(tmp_path, "saw", SAW, GivenFrame(plane="xz"))
    riding = replace_once(
        SAW, '<joint name="crank-pin" type="hinge"', '<joint name="crank-pin" type="hinge" armature="1"'
    )
    with pytest.raises(InvalidInput, match="axis itself moves"):
        identify_text(tmp_path, "saw", riding, crank="crank-pin")


@pytest.mark.parametrize(("name", "sizes"), [("saw-40rpm", [1, 2, 3]), ("six-bar", [1])])
def test_sets_of_lengths_are_tried_as_far_as_they_are_few(name: str, sizes: list[int]) -> None:
    search: Any = SimpleNamespace(scene=scene(name), scan=SimpleNamespace(points=["C"]), lengths=("crank",))
    *some, everything = list(_change_sets(search))
    assert [len(lengths) + len(points) for lengths, points in (changes[0] for changes in some)] == sizes
    assert max(map(len, some)) <= MAX_CHANGE_SETS
    assert everything == [(("crank",), ())]
