"""Mechanism files: what stands in them is what is read, and what cannot be used is refused by its place."""

from __future__ import annotations

import math
import os
from collections import Counter
from pathlib import Path
from typing import Any

import mutants
import numpy as np
import pytest
from described import CATALOGUE, FOUR_BAR, SHIPPED, SLIDER_CRANK, shuffle_declarations, tables, with_entry

from conrod.errors import InvalidInput
from conrod.execution.local import call_isolated
from conrod.mechanism.mechanism import GROUND, Prismatic, Revolute
from conrod.scenes.described_scene import read_scene, scene_from_tables


def refusal(given: dict[str, Any]) -> str:
    with pytest.raises(InvalidInput) as told:
        scene_from_tables(given)
    assert "\n" not in str(told.value)
    return str(told.value)


def test_numbers_with_units_become_si() -> None:
    mechanism = read_scene(SLIDER_CRANK).mechanism()
    assert [body.name for body in mechanism.bodies] == ["crank", "rod", "slider"]
    assert [joint.name for joint in mechanism.joints] == ["shaft", "crank-pin", "slider-pin", "slide"]
    pin, slide = mechanism.joints[1], mechanism.joints[3]
    assert isinstance(pin, Revolute)
    assert (pin.a, pin.point_a, pin.b, pin.point_b) == ("crank", (0.3, 0.0), "rod", (0.0, 0.0))
    assert isinstance(slide, Prismatic)
    assert (slide.a, slide.direction) == (GROUND, 0.0)


def test_uniform_bar_and_disc_have_textbook_inertia() -> None:
    rod = read_scene(SLIDER_CRANK).mechanism().body("rod")
    assert rod.inertia == pytest.approx(5.0 * 0.56**2 / 12.0, rel=1e-15)
    assert rod.centre_of_gravity == (0.28, 0.0)
    disc = {"uniform": "disc", "radius": "200 mm", "mass": 3, "points": {"A": [0.3, 0]}}
    assert scene_from_tables(with_entry(SLIDER_CRANK, "bodies.crank", disc)).mechanism().body(
        "crank"
    ).inertia == pytest.approx(0.06)


@pytest.mark.parametrize("path", [SLIDER_CRANK, CATALOGUE / "six-bar.toml", CATALOGUE / "planetary-gear.toml"])
def test_order_of_declaration_does_not_matter(path: Path) -> None:
    usual, other = read_scene(path), scene_from_tables(shuffle_declarations(tables(path), 1))
    assert other.mechanism() == usual.mechanism()
    assert other.parameters_text == usual.parameters_text
    angles = np.linspace(*usual.kinematics.span, 9)
    for name, point in usual.motion(angles, usual.speed).points.items():
        assert np.array_equal(other.motion(angles, usual.speed).point(name).jerk, point.jerk)


def test_drawn_points_make_the_same_machine() -> None:
    drawn = tables(SLIDER_CRANK)
    drawn["drawn"] = True
    del drawn["start"]
    drawn["bodies"]["rod"]["points"] = {"A": [0.3, 0], "B": [0.86, 0], "G": [0.58, 0]}
    drawn["bodies"]["slider"] |= {"points": {"B": [0.86, 0]}, "centre_of_gravity": [0.86, 0]}
    drawn["joints"]["slider-pin"]["connects"] = ["rod.B", "slider.B"]
    drawn["joints"]["slide"]["slider"] = "slider.B"
    drawn["observed"]["B"] = "slider.B"
    usual, angle = read_scene(SLIDER_CRANK), np.linspace(0.0, 6.0, 25)
    ours, theirs = usual.motion(angle, 30.0).point("B"), scene_from_tables(drawn).motion(angle, 30.0).point("B")
    assert np.abs(ours.position - theirs.position).max() < 1e-14


def test_start_pose_picks_the_branch() -> None:
    other = scene_from_tables(with_entry(SLIDER_CRANK, "start.rod.turn", "180 deg"))
    assert other.motion(0.0, 30.0).point("B").position[0, 0] == pytest.approx(0.3 - 0.56)


UNUSABLE = [
    ("bodies.rod.mass", "-1 kg", "bodies.rod.mass = -1 kg is out of range"),
    ("bodies.rod.mass", math.nan, "bodies.rod.mass = nan is not a finite number"),
    ("bodies.rod.mass", True, "bodies.rod.mass = true is not a number"),
    ("bodies.rod.mas", 1, "unknown field in bodies.rod 'mas'"),
    ("bodies.rod.inertia", 1, "bodies.rod.inertia: a uniform bar has its own"),
    ("bodies.rod.ends", ["A", "C"], "unknown point in bodies.rod.ends 'C'"),
    ("bodies.rod.points.B", [0, 0], "the ends of the uniform bar are one and the same place"),
    ("bodies.rod.points.turn", [1, 0], "cannot be a point's name"),
    ("bodies.ground", {"mass": 1, "inertia": 1}, "the ground does not move"),
    ("bodies.a b", {"mass": 1, "inertia": 1}, "'a b' cannot be a name"),
    ("bodies.extra", {"mass": 1, "inertia": 1}, "bodies.extra: no joint holds it"),
    ("bodies", 3, "bodies = 3: a table is wanted"),
    ("joints.crank-pin.connects", ["crank.A", "crank"], "it joins 'crank' with itself"),
    ("joints.crank-pin.connects", ["crank.A", "rood.A"], "unknown body in joints.crank-pin.connects[1] 'rood'"),
    ("joints.crank-pin.kind", "revolut", "unknown joints.crank-pin.kind 'revolut'"),
    ("joints.crank-pin", None, "mobility 3: 3 x 3 moving bodies - 2 x 3 lower - 0 higher pairs"),
    ("joints.slide.direction", None, "joints.slide: there is no 'direction', which is needed"),
    ("driver.joint", "crank-pin", "the crank's revolute joint with the ground is wanted"),
    ("driver.speed", 0, "driver.speed = 0 rad/s is out of range"),
    ("driver.speed", "5 Hz", "Hz may mean"),
    ("driver.speed", "60,5 rpm", "driver.speed = '60,5 rpm': dec"),
    ("driver.from", 0, "driver: there is no 'to'"),
    ("start.crank", {"turn": 0}, "start.crank: leave it out: driver.start tells its turn"),
    ("start", None, "start.rod.origin = [0, 0], or the same of slider"),
    ("start.rod", {}, "start.rod: where it is at crank angle 0 does not follow"),
    ("observed.B", "ground.O12", "a point of the ground does not move"),
    ("observed.rod", "rod.G", "observed.rod: a body has this name"),
    ("output", None, "there is no 'output'"),
    ("title", "a\u0007b", "cannot be printed"),
    ("name", "../saw", "cannot be a name"),
    ("forces.f", {"body": "rodd", "force": [0, 1]}, "did you mean 'rod'?"),
]  # fmt: skip


@pytest.mark.parametrize(("place", "value", "expected"), UNUSABLE, ids=[f"{p}-{e[:30]}" for p, _, e in UNUSABLE])
def test_file_error_names_the_place(place: str, value: Any, expected: str) -> None:
    assert expected in refusal(with_entry(SLIDER_CRANK, place, value))


def test_blocked_crank_is_refused_with_its_range() -> None:
    given = tables(FOUR_BAR)
    del given["driver"]["from"], given["driver"]["to"]
    told = refusal(given)
    assert "cannot turn fully" in told
    # The printed instant is at 60.39 deg, the limits of the input are +-88.86 deg, and its angle counts clockwise.
    assert "it reaches -28.4" in told
    assert "to 149." in told


def test_start_that_leads_to_other_branch_is_refused() -> None:
    assert "leads to an assembly where it is" in refusal(with_entry(SLIDER_CRANK, "start.rod.turn", "89 deg"))


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "it is empty; `conrod init`"),
        (b"# only a remark", "there is no 'name'"),
        (b"name = ", "it is no TOML"),
        (b"\xff\xfe", "no text in UTF-8"),
        (b"a = " + b"[" * 5000, "too deep"),
        (b"[" + b"a." * 130_000 + b"a]", "line 1: names of more than 20 parts"),
        (b"x = 1\ny = { " + b'"\\"=]". ' * 25_000 + b"a = 1 }", "line 2: names of more than 20 parts"),
        (b"a = " + b"9" * 5000, "line 1: names of more than 20 parts and numbers of 1000 digits"),
        (b"#" * 300_000, "too large"),
        (b"name = 1979-05-27", "name = a date: a text is wanted"),
    ],
    ids=["empty", "remark", "broken", "bytes", "deep", "long name", "quoted", "digits", "large", "date"],
)
def test_file_error_names_the_file(tmp_path: Path, content: bytes, expected: str) -> None:
    path = tmp_path / "machine.toml"
    path.write_bytes(content)
    with mutants.in_time(str(path), 2.0), pytest.raises(InvalidInput) as told:
        read_scene(path)
    assert str(told.value).startswith(f"{path}: ")
    assert expected in str(told.value)


# -- mutated copies of the files that ship: one clear line, or a mechanism that both engines take --------------------

FEW, MANY = 2, 100  # of each file


def test_mutated_files_are_refused_in_one_line_or_move() -> None:
    ends: Counter[str] = Counter()
    for path in SHIPPED:
        ends += mutants.count_outcomes(path, range(FEW), engines=False)
    # Negative control: the mutants get through to motion, and not all of them do.
    assert ends["valid"] > 5
    assert ends["refused"] > 5


def test_mutated_files_that_move_do_not_crash_an_engine() -> None:
    answer = call_isolated(mutants.count_outcomes, SHIPPED[-1], range(5), True, timeout=300.0)
    assert isinstance(answer, Counter), answer


@pytest.mark.slow
@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_many_mutated_files_are_refused_or_move(path: Path) -> None:
    answer = call_isolated(mutants.count_outcomes, path, range(10_000, 10_000 + MANY), True, timeout=1200.0)
    assert isinstance(answer, Counter), answer


def test_mutation_test_detects_hang() -> None:
    # Negative control of the time limit.
    with pytest.raises(TimeoutError), mutants.in_time("a loop", 0.05):
        sum(k for k in iter(int, 1))


def test_windows_line_ends_change_nothing(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_bytes(SHIPPED[-1].read_bytes().replace(b"\n", b"\r\n"))
    assert read_scene(path).parameters_text == read_scene(SHIPPED[-1]).parameters_text


def test_read_scene_refuses_paths_that_are_no_files(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "loop.toml").symlink_to("loop.toml")
    (tmp_path / "nowhere.toml").symlink_to("none.toml")
    for path in (*tmp_path.glob("*.toml"), Path("/dev/zero"), Path("/dev/null"), tmp_path / ("a" * 300)):
        with mutants.in_time(str(path)), pytest.raises(InvalidInput) as told:
            read_scene(path)
        mutants.one_line(told.value)
    (tmp_path / "link.toml").symlink_to(SHIPPED[0])
    assert read_scene(tmp_path / "link.toml").kind == SHIPPED[0].stem
