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
from conrod.mjcf.loops.differences import Comparison, compared
from conrod.mjcf.loops.reading import machine_tree
from conrod.mjcf.loops.results import Question
from conrod.mjcf.loops.study import _Bench, study
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


def edited(machine: str, edit: Edit) -> str:
    root = ET.fromstring(MACHINES[machine]().mjcf)
    edit(root)
    return ET.tostring(root, encoding="unicode")


def comparison(machine: str, mjcf: str) -> Comparison:
    """A model against a machine, by the exact motions of both."""
    question = Question(dict(MACHINES[machine]().drives), seconds=1.0)
    own = _Bench.of(mujoco.MjModel.from_xml_string(mjcf), question).machine
    return compared(machine, own.tree, machine_tree(machine), own.laws, own.held, own.motion(TIMES, order=2))


TILT = np.tan(np.radians(0.1))
DEFECTS: dict[str, tuple[Edit, str]] = {
    "a leg 0.1 % long": (
        shifted("site", "rod_end", "pos", lambda v: 1.001 * v),
        "rod is 0.1 % longer to rocker_pin: 420.42 mm instead of 420 mm",
    ),
    "an axis 0.1 deg off": (
        shifted("joint", "output", "axis", lambda v: v + np.array([0.0, TILT, 0.0])),
        "the axis of output is 0.1 deg off",
    ),
    "a closure anchored 0.1 mm off": (
        shifted("site", "rocker_pin", "pos", lambda v: v + np.array([0.0, 1e-4, 0.0])),
        "rocker_pin is 0.1 mm off its place on rocker",
    ),
}  # fmt: skip


@pytest.mark.parametrize("defect", DEFECTS)
def test_a_planted_defect_is_named_with_what_it_moves(defect: str) -> None:
    edit, words = DEFECTS[defect]
    found = comparison("rssr", edited("rssr", edit))
    assert found.differences == (words,)
    assert found.off > 1e-5


@pytest.mark.parametrize("branch", [1.0, -1.0])
def test_another_branch_is_told_from_other_numbers_and_nothing_of_a_healthy_model_is_named(branch: float) -> None:
    found = comparison("rssr", MACHINES["rssr"](branch=branch).mjcf)
    assert found.other_branch == (branch < 0.0)
    assert (found.off < 1e-12) == (branch > 0.0)
    assert found.differences == ()


def test_a_defect_that_stops_the_study_is_named_in_its_line(tmp_path: Path) -> None:
    path = tmp_path / "own.xml"
    path.write_text(edited("rssr", without_a_loop), encoding="utf-8")
    with pytest.raises(InvalidInput, match="it has no closed loop; against rssr: loop rocker_pin is missing"):
        study(path, Question(dict(MACHINES["rssr"]().drives), machine="rssr"), "own")
