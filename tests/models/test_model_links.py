"""Links of models and machines side by side: healthy ones have no difference, and each length that is off is named."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import mujoco
import pytest
from command_line import conrod
from four_bars import four_bar
from own_model_edits import mirror_x, replace_once, scale_lengths, wrap_in_body

from conrod import scene
from conrod.engines.mujoco.standalone import standalone_mjcf
from conrod.mechanism.mechanism import GROUND
from conrod.mjcf.reading import tree_of
from conrod.mjcf.request import ModelRequest, PointPlace
from conrod.models.check.links import LinkDifference, LinkGraph, graph_of, link_differences
from conrod.models.check.model_links import _PlanarModel, links_of
from conrod.models.check.scene_causes import axial_gaps, refusal_causes, scene_causes, tilted_axes

CASES = Path(__file__).parents[1] / "data" / "cases"
MEANT = str(CASES / "anchor-apart-meant.toml")
PLANAR = (
    *("saw-40rpm", "shear-press", "six-bar", "jansen-leg", "watt-straight-line", "peaucellier", "crank-shaper"),
    *("whitworth", "two-slider-linkage", "inverted-slider-crank", "double-rocker", "parallelogram", "web-cutter"),
)


@cache
def exported(name: str) -> str:
    return standalone_mjcf(name, scene(name), 1000)


def found(name: str, text: str, crank: str = "crank", sites: dict[str, str] | None = None) -> list[str] | None:
    """Differences of a model from a scene, in words; None where their links are other ones."""
    tree = tree_of(model := mujoco.MjModel.from_xml_string(text), model.qpos0)
    mechanism = scene(name).mechanism()
    named = sites or {one.name: one.name for one in mechanism.observed}
    points = {point: tree.points[site] for point, site in named.items() if site in tree.points}
    own, right = links_of(tree, crank, points), graph_of(mechanism)
    if own is None or right is None:
        return None
    seen = link_differences(own, right)
    return None if seen is None else [one.words for one in seen]


@pytest.mark.parametrize("name", PLANAR)
def test_the_links_of_a_model_of_a_machine_are_the_machines(name: str) -> None:
    assert found(name, exported(name)) == []
    # In another unit, turned and seen from behind, too.
    assert found(name, wrap_in_body(scale_lengths(exported(name), 1e3), euler="0.3 2 1", pos="1 2 3")) == []
    assert found(name, mirror_x(exported(name))) == []


def changed(text: str, tag: str, name: str, place: str) -> str:
    made = re.sub(rf'(<{tag} name="{re.escape(name)}" pos=")[^"]*"', rf'\g<1>{place}"', text)
    assert made != text
    return made


@pytest.mark.parametrize(("name", "change", "words"), [
    ("saw-40rpm", ("site", "slider-pin.rod", "0.303 0 0"),
     "rod is 1 % longer from pin crank-pin to pin slider-pin: 303 mm instead of 300 mm"),
    ("saw-40rpm", ("body", "rod", "0.11 0 0"),
     "crank is 10 % longer from pin crank-pin to pin shaft: 110 mm instead of 100 mm"),
    ("saw-40rpm", ("body", "slider", "0 0.001 0"),
     "slide is 1.11 % longer from pin shaft to the line of pin slider-pin: 91 mm instead of 90 mm"),
    ("saw-40rpm", ("site", "M", "0.16 0 0"), "rod is 6.67 % longer from pin crank-pin to M: 160 mm instead of 150 mm"),
    ("watt-straight-line", ("body", "left", "0 0.001 0"), None),
])  # fmt: skip
def test_a_length_that_is_off_is_named_with_its_size(
    name: str, change: tuple[str, str, str], words: str | None
) -> None:
    seen = found(name, changed(exported(name), *change))
    assert seen
    assert words is None or words in seen


def test_a_coupler_that_is_short_is_why_a_four_bar_cannot_turn(tmp_path: Path) -> None:
    short = (CASES / "four-bar-short.xml").read_text()
    expected = ["coupler is 42.3 % shorter from pin a to pin b: 150 mm instead of 260 mm"]
    assert found(MEANT, short, sites={"P": "P"}) == expected
    asked = ("--scene", MEANT, "--crank", "crank", "--point", "P=site:P")
    done = conrod("check", str(CASES / "four-bar-short.xml"), *asked, "--html", str(tmp_path / "page.html"))
    assert done.returncode == 1, done.stderr
    words = " ".join(done.stdout.split())
    assert f"It is not {MEANT} as it stands: it goes no further than with crank at 127.95 deg" in words
    assert f"against {MEANT}, {expected[0]}" in words
    assert "dead centre" not in words
    # Its page has it in motion as far as it goes.
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "its crank turned as far as it goes" in page


def test_models_of_other_links_are_not_compared() -> None:
    # A slide where the machine has a pin, a link too many, and joints that are none of a plane.
    saw = exported("saw-40rpm")
    pinned = saw.replace('<joint name="slide" type="slide" axis="1 0 0"', '<joint name="slide" axis="0 0 1"')
    flap = saw.replace("</worldbody>", '<body><joint name="flap" axis="0 0 1"/><geom size="1"/></body></worldbody>')
    ball = saw.replace('<joint name="crank-pin" type="hinge" axis="0 0 1"', '<joint name="crank-pin" type="ball"')
    for text in (pinned, flap, ball):
        assert text != saw
        assert found("saw-40rpm", text) is None
    assert graph_of(scene("cam-follower").mechanism()) is None


@pytest.mark.parametrize(("aside", "differences"), [(1e-4, []), (1e-2, None)])
def test_connects_of_model_in_mm_are_one_pin_when_in_line(aside: float, differences: list[str] | None) -> None:
    # A second connect, 20 mm along the pin's axis: rounding of six digits is 3e-4 mm there.
    text = scale_lengths(exported("saw-40rpm"), 1e3)
    for site, x in (("slider-pin.rod", 300.0 + aside), ("slider-pin.slider", 0.0)):
        text = replace_once(
            text, f'<site name="{site}"', f'<site name="second.{site}" pos="{x!r} 0 20"/><site name="{site}"'
        )
    second = '<connect name="second" site1="second.slider-pin.rod" site2="second.slider-pin.slider"/></equality>'
    assert found("saw-40rpm", replace_once(text, "</equality>", second)) == differences


def flat_links(text: str) -> LinkGraph:
    tree = tree_of(model := mujoco.MjModel.from_xml_string(text), model.qpos0)
    graph = links_of(tree, "crank", {"B": tree.points["B"]})
    assert graph is not None
    return graph


def welded_tip(place: str) -> str:
    """The four-bar whose coupler ends in a body of its own, welded to it, 0.1 m before its far pin."""
    site = '<site name="B" pos="0.25 0 0"/>'
    tip = f"""<body name="tip" pos="0.15 0 0" euler="0 0 0.5"><joint name="seam" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/><site name="B" pos="{place}"/></body>"""
    weld = '<weld name="seam" body1="coupler" body2="tip" anchor="0.03 0.02 0"/></equality>'
    return replace_once(replace_once(four_bar(frame=""), site, tip), "</equality>", weld)


@pytest.mark.parametrize(("share", "pins"), [(1e-6, 4), (0.0, 5)])
def test_connects_at_one_place_are_one_pin_below_a_distance(
    share: float, pins: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A distance that is exactly the limit, as 0 is of 0, is not below it."""
    monkeypatch.setattr("conrod.models.check.model_links.SAME_PIN_DISTANCE", share)
    twice = replace_once(four_bar(frame=""), "</equality>", '<connect name="again" site1="B" site2="C"/></equality>')
    assert len([edge for edge in flat_links(twice).edges if edge.kind == "pin"]) == pins


def test_welded_links_are_one_when_anchor_is_on_the_second() -> None:
    plain = flat_links(four_bar(frame=""))
    # The tip is turned by half a radian on the coupler.
    end = f"{0.1 * math.cos(0.5)!r} {-0.1 * math.sin(0.5)!r} 0"
    made = flat_links(welded_tip(end))
    assert set(made.links) == set(plain.links) == {GROUND, "crank", "coupler", "rocker"}
    assert link_differences(made, plain) == ()
    longer = f"{0.11 * math.cos(0.5)!r} {-0.11 * math.sin(0.5)!r} 0"
    seen = link_differences(flat_links(welded_tip(longer)), plain)
    assert seen
    assert seen[0].words == "coupler is 4 % longer from pin coupler to pin pin: 260 mm instead of 250 mm"


@pytest.mark.parametrize("bodies", ['body1="block"', 'body1="world" body2="block"'])
def test_link_welded_to_world_is_ground_at_either_end(bodies: str) -> None:
    plain = flat_links(four_bar(frame=""))
    start, end = four_bar(frame="").split('<body name="rocker" pos="0.35 0 0"')
    joints = "".join(f'<joint name="{n}" type="slide" axis="{a}"/>' for n, a in (("x", "1 0 0"), ("y", "0 1 0")))
    block = f"""<body name="block" pos="0.25 0.05 0" euler="0 0 0.5">{joints}<joint name="spin" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>"""
    # The rocker's pivot stays where it is in the world.
    cos, sin = math.cos(0.5), math.sin(0.5)
    place = f"{0.1 * cos - 0.05 * sin!r} {-0.1 * sin - 0.05 * cos!r} 0"
    text = f'{start}{block}<body name="rocker" pos="{place}"{end}'
    text = replace_once(text, "</body>\n    </body></worldbody>", "</body></body>\n    </body></worldbody>")
    made = flat_links(replace_once(text, "</equality>", f'<weld name="foot" {bodies}/></equality>'))
    assert set(made.links) == set(plain.links)
    assert link_differences(made, plain) == ()


@pytest.mark.parametrize(("across", "words"), [
    (0.02, []),
    (0.021, ["slide is 1.11 % longer from pin shaft to the line of pin slider-pin: 91 mm instead of 90 mm"]),
])  # fmt: skip
def test_slide_has_its_direction_when_its_link_is_welded_on(across: float, words: list[str]) -> None:
    # The slider's origin lies 20 mm below its pin, and its frame is another than that of the block it is welded to.
    text = changed(exported("saw-40rpm"), "body", "slider", "0 -0.02 0")
    for site in ("C", "slider-pin.slider"):
        text = changed(text, "site", site, f"0 {across!r} 0")
    joints = "".join(f'<joint name="{n}" type="slide" axis="{a}"/>' for n, a in (("x", "1 0 0"), ("y", "0 1 0")))
    block = f"""<body name="block" pos="0.05 0.03 0" euler="0 0 0.5">{joints}<joint name="spin" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/></body></worldbody>"""
    text = replace_once(
        replace_once(text, "</worldbody>", block), "</equality>", '<weld body1="block" body2="slider"/></equality>'
    )
    assert found("saw-40rpm", text) == words


def test_what_should_be_at_one_place_is_said_so() -> None:
    one = LinkDifference("crank", ("pin A", "pin B"), 0.0035, 0.0)
    assert one.words == "crank has pin A 3.5 mm from pin B, where they should be at one place"


def test_more_than_three_differences_are_counted() -> None:
    text = exported("saw-40rpm")
    for change in (
        ("site", "slider-pin.rod", "0.303 0 0"), ("body", "rod", "0.11 0 0"), ("site", "M", "0.16 0 0"),
        ("body", "slider", "0 0.001 0"),
    ):  # fmt: skip
        text = changed(text, *change)
    model = mujoco.MjModel.from_xml_string(text)
    asked = ModelRequest("crank", (PointPlace("C", "site", "C"), PointPlace("M", "site", "M")), 1, 0)
    (words,) = scene_causes(model, ("saw-40rpm", scene("saw-40rpm")), asked)
    crank = "crank is 10 % longer from pin crank-pin to pin shaft: 110 mm instead of 100 mm"
    assert words.startswith(f"against saw-40rpm, {crank}; ")
    assert words.endswith("; 2 more distances differ")
    assert words.count(" instead of ") == 3


# -- axes --------------------------------------------------------------------------------------------------------------


TILT = math.radians(0.05)
# Of the rod in its reference pose: its frame is turned by this, so that a tilt about the slide is across both.
SINE, COSINE = 0.3, -math.sqrt(1.0 - 0.3**2)


@pytest.mark.parametrize(("joint", "axis", "words"), [
    # Of two hinges either may be the one that is tilted, unless the slide is across one of them alone.
    ('name="crank-pin" type="hinge" axis="0 0 1"', (TILT * SINE, TILT * COSINE, 1.0),
     "the axes of crank and crank-pin are 0.05 deg apart"),
    ('name="crank-pin" type="hinge" axis="0 0 1"', (TILT, 0.0, 1.0),
     "the axis of crank-pin is 0.05 deg off that of crank"),
    ('name="slide" type="slide" axis="1 0 0"', (1.0, 0.0, TILT),
     "the axis of slide is 0.05 deg off the plane across that of crank"),
])  # fmt: skip
def test_an_axis_that_is_tilted_out_of_the_plane_is_named(
    joint: str, axis: tuple[float, ...], words: str, tmp_path: Path
) -> None:
    saw = exported("saw-40rpm")
    tree = tree_of(model := mujoco.MjModel.from_xml_string(saw), model.qpos0)
    assert list(tilted_axes(tree)) == []
    text = saw.replace(joint, re.sub(r'axis="[^"]*"', f'axis="{" ".join(map(repr, axis))}"', joint))
    tree = tree_of(model := mujoco.MjModel.from_xml_string(text), model.qpos0)
    assert list(tilted_axes(tree)) == [words]
    path = tmp_path / "saw.xml"
    path.write_text(text)
    done = conrod("check", str(path), "--scene", "saw-40rpm", "--crank", "crank", "--point", "C=C", "--point", "M=M")
    assert done.returncode != 0
    assert words in done.stdout + done.stderr


@pytest.mark.parametrize(("joint", "along"), [
    ('name="slide" type="slide" axis="1 0 0"', 0.1), ('name="crank-pin" type="hinge" axis="0 0 1"', 0.9),
])  # fmt: skip
def test_a_joint_is_planar_when_its_tilt_is_below_the_limit(
    joint: str, along: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A tilt that is exactly the limit is not below it."""
    axis = f'axis="{math.sqrt(1.0 - along**2)!r} 0 {along!r}"'
    text = replace_once(exported("saw-40rpm"), joint, re.sub(r'axis="[^"]*"', axis, joint))
    tree = tree_of(model := mujoco.MjModel.from_xml_string(text), model.qpos0)
    tilted = next(one for one in tree.joints if f'name="{one.name}"' in joint)
    share = _PlanarModel(tree, "crank").axial_share(tilted.body, tilted.axis)
    assert share == pytest.approx(along)
    tilt = share if along < 0.5 else 1.0 - share
    for limit, planar in ((tilt, False), (tilt + 1e-12, True)):
        monkeypatch.setattr("conrod.models.check.model_links.AXIS_TOLERANCE", limit)
        assert (links_of(tree, "crank", {}) is not None) is planar


def test_axes_are_compared_in_the_pose_of_the_keyframe() -> None:
    # Tilted about the slide, the pin is across it, as the crank is; a radian further it is not.
    saw = replace_once(exported("saw-40rpm"), '<key name="start" qpos="0 0 0"', '<key name="turned" qpos="0 1 0"')
    axis = " ".join(map(repr, (TILT * SINE, TILT * COSINE, 1.0)))
    old = 'name="crank-pin" type="hinge" axis="0 0 1"'
    model = mujoco.MjModel.from_xml_string(replace_once(saw, old, old.replace("0 0 1", axis)))
    asked = ModelRequest("crank", (PointPlace("C", "site", "C"), PointPlace("M", "site", "M")), 1, 0)
    apart, off = "the axes of crank and crank-pin are 0.05 deg apart", "the axis of crank-pin is 0.05 deg off that of"
    for keyframe, words in (("qpos0", apart), ("turned", off), (None, off)):
        causes = list(scene_causes(model, ("saw-40rpm", scene("saw-40rpm")), replace(asked, keyframe=keyframe)))
        assert [one.startswith(words) for one in causes] == [True], keyframe


def test_lengths_differ_when_a_keyframe_turns_a_tilted_pin() -> None:
    # About its tilted pin the rod turns out of the plane, in which it is then shorter.
    saw = replace_once(exported("saw-40rpm"), '<key name="start" qpos="0 0 0"', '<key name="turned" qpos="0 0 1"')
    old = 'name="crank-pin" type="hinge" axis="0 0 1"'
    model = mujoco.MjModel.from_xml_string(replace_once(saw, old, old.replace("0 0 1", "0 0.2 1")))
    asked = ModelRequest("crank", (PointPlace("C", "site", "C"), PointPlace("M", "site", "M")), 1, 0)
    for keyframe, differ in (("qpos0", False), ("turned", True), (None, True)):
        causes = list(scene_causes(model, ("saw-40rpm", scene("saw-40rpm")), replace(asked, keyframe=keyframe)))
        assert any(one.startswith("against saw-40rpm, rod is ") for one in causes) is differ, keyframe


def test_refusal_has_no_causes_when_its_keyframe_is_unknown() -> None:
    saw = exported("saw-40rpm")
    pinned = replace_once(saw, '<joint name="slide" type="slide" axis="1 0 0"', '<joint name="slide" axis="0 0 1"')
    model, asked = mujoco.MjModel.from_xml_string(pinned), ModelRequest("crank", (PointPlace("C", "site", "C"),), 1, 0)
    known, unknown = (
        list(refusal_causes(model, ("saw-40rpm", scene("saw-40rpm")), replace(asked, keyframe=keyframe)))
        for keyframe in ("start", "begin")
    )
    assert known == ["it has other joints than saw-40rpm: 3 hinges, 1 connect in place of 3 pins, 1 slide"]
    assert unknown == []  # the study says that there is none


# -- a slide that is tilted in its plane, and an offset ----------------------------------------------------------------

SAW = ("--scene", "saw-40rpm", "--crank", "crank", "--point", "C=C", "--point", "M=M")
TILTED = ('type="slide" axis="1 0 0"', 'type="slide" axis="1 0.00872687 0"')
ASIDE = ('name="slider" pos="0 0 0"', 'name="slider" pos="0 0.001 0"')
EITHER, GIVEN = "It may be as well that the slide is tilted by 0.5 deg", "the slide is tilted by 0.5 deg from where"


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize(("edit", "rotation", "said", "not_said"), [
    # The offset grows by the slider's 0.186 m from the shaft's foot, times the tilt.
    (TILTED, (), ("offset is 1.8 % too long: 91.62", EITHER), (GIVEN,)),
    (TILTED, ("--rotation", "0"), (GIVEN, "slide is 1.8 % longer from pin shaft to the line of pin slider"), (EITHER,)),
    (ASIDE, (), ("offset is 1.1 % too long: 91 mm",), ("is tilted",)),
    (ASIDE, ("--rotation", "0"), ("offset is 1.1 % too long: 91 mm",), ("is tilted",)),
], ids=["tilt", "tilt-in-a-given-frame", "offset", "offset-in-a-given-frame"])  # fmt: skip
def test_tilted_slide_and_offset_are_told_apart_or_both_named(
    edit: tuple[str, str], rotation: tuple[str, ...], said: tuple[str, ...], not_said: tuple[str, ...],
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setattr("conrod.models.check.study.LABELS", ("as it is",))
    path = tmp_path / "saw.xml"
    path.write_text(replace_once(exported("saw-40rpm"), *edit))
    done = conrod("check", str(path), *SAW, *rotation)
    assert done.returncode == 1
    for words in said:
        assert words in done.stdout
    for words in not_said:
        assert words not in done.stdout


def test_tilted_slide_is_told_from_offset_on_ground_of_two_pins() -> None:
    text = exported("six-bar")
    (axis,) = re.findall(r'name="slide" type="slide" axis="([^"]*)"', text)
    x, y = (float(value) for value in axis.split()[:2])
    seen = found("six-bar", text.replace(axis, f"{x - 0.01 * y!r} {y + 0.01 * x!r} 0"))
    assert seen
    assert seen[0] == "slide is tilted by 0.573 deg on ground"
    start = re.search(r'<body name="slider" pos="([^"]*)"', text)
    assert start
    px, py = (float(value) for value in start[1].split()[:2])
    aside = found("six-bar", changed(text, "body", "slider", f"{px - 0.001 * y!r} {py + 0.001 * x!r} 0"))
    assert aside
    assert not any("tilted" in words for words in aside)
    assert all(words.startswith("slide is ") for words in aside)


# -- other joints, and pins that are apart across the plane ------------------------------------------------------------


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize(("edits", "status", "words"), [
    # A ball that its loops keep in the plane does no harm, and is said.
    ([('name="A" type="hinge"', 'name="A" type="ball"')], 0, "It has other joints than six-bar: 1 slide, 3 hinges"),
    ([('name="C" type="hinge"', 'name="C" type="ball"')], 2, "it has other joints than six-bar: 1 slide, 3 hinges"),
    ([], 0, ""),
])  # fmt: skip
def test_other_joints_are_said_whether_they_do_harm_or_not(
    edits: list[tuple[str, str]], status: int, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("conrod.models.check.study.LABELS", ("as it is",))
    text = re.sub(r"(?s)<keyframe>.*</keyframe>", "", exported("six-bar"))
    for edit in edits:
        text = replace_once(text, *edit)
    path = tmp_path / "six.xml"
    path.write_text(text)
    done = conrod("check", str(path), "--scene", "six-bar", "--crank", "crank", "--point", "D=D", "--point", "B=B")
    assert done.returncode == status, done
    assert ("has other joints" in done.stdout + done.stderr) == bool(words)
    assert words in done.stdout + done.stderr


def test_a_pin_whose_halves_are_apart_along_the_hinges_is_named() -> None:
    saw = exported("saw-40rpm")
    model = mujoco.MjModel.from_xml_string(saw)
    assert list(axial_gaps(tree_of(model, model.qpos0))) == []
    text = replace_once(
        saw, '<site name="slider-pin.rod" pos="0.3 0 0"', '<site name="slider-pin.rod" pos="0.3 0 0.001"'
    )
    model = mujoco.MjModel.from_xml_string(text)
    words = ["slider-pin ties points that are 1 mm apart along the axes of its hinges"]
    assert list(axial_gaps(tree_of(model, model.qpos0))) == words
