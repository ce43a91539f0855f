"""What a model has otherwise than the machine it is to be is named, with what it does; of a healthy one nothing."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space.motion import DrivenTree
from conrod.mjcf.loops.differences import Comparison, compared
from conrod.mjcf.loops.reading import laws_of, machine_tree, tree_of
from conrod.mjcf.loops.results import Question
from conrod.mjcf.loops.study import study
from conrod.scenes.space import MACHINES

TIMES = np.linspace(0.0, 1.0, 25)
Edit = Callable[[ET.Element], None]


def named(root: ET.Element, tag: str, name: str) -> ET.Element:
    return next(one for one in root.iter(tag) if one.get("name") == name)


def shifted(tag: str, name: str, field: str, change: Callable[[Array], Array]) -> Edit:
    def edit(root: ET.Element) -> None:
        one = named(root, tag, name)
        values = np.array([float(x) for x in str(one.get(field)).split()])
        one.set(field, " ".join(repr(float(x)) for x in change(values)))

    return edit


def without_a_loop(root: ET.Element) -> None:
    equality = root.find("equality")
    assert equality is not None
    equality.remove(equality[0])


def with_a_loop_twice(root: ET.Element) -> None:
    equality = root.find("equality")
    assert equality is not None
    ET.SubElement(equality, equality[0].tag, {**equality[0].attrib, "name": "again"})


def edited(machine: str, edit: Edit | None) -> str:
    root = ET.fromstring(MACHINES[machine]().mjcf)
    if edit is not None:
        edit(root)
    return ET.tostring(root, encoding="unicode")


def comparison(machine: str, mjcf: str) -> Comparison:
    """A model against a machine, by the exact motions of both."""
    model = mujoco.MjModel.from_xml_string(mjcf)
    tree = tree_of(model, model.qpos0)
    laws, held = laws_of(model, tree, Question(dict(MACHINES[machine]().drives)))
    driven = DrivenTree(tree, laws, held)
    driven.go(driven.assembled(), 1.0)
    return compared(machine, tree, machine_tree(machine), laws, held, driven.motion(TIMES, order=2))


TILT = np.tan(np.radians(0.1))
DEFECTS: dict[str, tuple[str, Edit, str]] = {
    "a leg 0.1 % long": (
        "rssr", shifted("site", "rod_end", "pos", lambda v: 1.001 * v),
        "rod is 0.1 % longer to rocker_pin: 420.42 mm instead of 420 mm",
    ),
    "an axis 0.1 deg off": (
        "rssr", shifted("joint", "output", "axis", lambda v: v + np.array([0.0, TILT, 0.0])),
        "the axis of output is 0.1 deg off",
    ),
    "a closure anchored 0.1 mm off": (
        "rssr", shifted("site", "rocker_pin", "pos", lambda v: v + np.array([0.0, 1e-4, 0.0])),
        "rocker_pin is 0.1 mm off its place on rocker",
    ),
    "a loop twice": (
        "tilted-slider-crank", with_a_loop_twice, "again is a loop more"
    ),
}  # fmt: skip


@pytest.mark.parametrize("defect", DEFECTS)
def test_a_planted_defect_is_named_with_what_it_moves(defect: str) -> None:
    machine, edit, words = DEFECTS[defect]
    found = comparison(machine, edited(machine, edit))
    assert found.differences == (words,)
    if defect == "a loop twice":
        return  # which moves nothing
    assert found.off is not None
    assert found.off > 1e-5


@pytest.mark.parametrize("machine", ["rssr", "bennett"])
def test_nothing_of_a_healthy_model_is_named(machine: str) -> None:
    found = comparison(machine, edited(machine, None))
    assert found.differences == ()
    assert not found.other_branch
    assert found.off is not None
    assert found.off < 1e-12


def test_another_branch_is_told_from_other_numbers() -> None:
    found = comparison("rssr", MACHINES["rssr"](branch=-1.0).mjcf)
    assert found.other_branch
    assert found.differences == ()


@pytest.mark.parametrize(
    ("machine", "edit", "words"),
    [
        ("bennett", shifted("joint", "coupler", "axis", lambda v: v + TILT * np.cross(v, [0.3, 0.5, 0.2])),
         "the axis of coupler"),
        ("rssr", without_a_loop, "it has no closed loop; against rssr: loop rocker_pin is missing"),
    ],
    ids=["an axis that lets it move no more", "its only loop missing"],
)  # fmt: skip
def test_a_defect_that_stops_the_study_is_named_in_its_line(
    machine: str, edit: Edit, words: str, tmp_path: Path
) -> None:
    path = tmp_path / "own.xml"
    path.write_text(edited(machine, edit), encoding="utf-8")
    with pytest.raises(InvalidInput, match=words) as error:
        study(path, Question(dict(MACHINES[machine]().drives), machine=machine), "own")
    assert f"against {machine}" in str(error.value)
