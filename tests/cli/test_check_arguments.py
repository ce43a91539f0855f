"""What `conrod.check` and its neighbours make of arguments that are written in another way than they are taken."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from conrod import InvalidInput, check, forces, limits
from conrod.models.check.dispatch import NEW_KEYWORDS

MODEL = str(Path(__file__).parents[2] / "mjcf" / "saw-500rpm.xml")
TABLE = {"time": [0.0, 0.01], "C.x": [0.0, 1.0]}
ON_MODEL: dict[str, Any] = {"crank": "crank", "points": {"C": "site:C"}}


@pytest.mark.parametrize("old", NEW_KEYWORDS)
def test_an_old_keyword_is_answered_with_the_new_one(old: str) -> None:
    with pytest.raises(InvalidInput, match=rf"^{old}=\.\.\. is now {NEW_KEYWORDS[old]}=\.\.\.$"):
        check(MODEL, **{old: "x"})


def test_keyword_set_is_answered_with_conrod_scene() -> None:
    with pytest.raises(InvalidInput, match=r"conrod\.scene\(NAME, crank='80 mm'\)"):
        check("saw-500rpm", set={"crank": "80 mm"})


@pytest.mark.parametrize(("subject", "scene", "arguments", "message"), [
    (MODEL, "saw-500rpm", ON_MODEL | {"rotation": "90deg"}, "rotation = '90deg' is not a finite number"),
    (MODEL, "saw-500rpm", ON_MODEL | {"crank_zero": np.nan}, "crank_zero = nan is not a finite number"),
    (MODEL, "saw-500rpm", ON_MODEL | {"points": ["C=site:C"]}, "points = .*give a mapping, such as"),
    (MODEL, "saw-500rpm", ON_MODEL | {"controls": {"motor": "fast"}}, "motor=fast.*finite number"),
    (MODEL, "saw-500rpm", ON_MODEL | {"controls": ["motor=1"]}, "controls = .*give a mapping"),
    (MODEL, None, {"drives": ["crank=60rpm"]}, "drives = .*give a mapping, such as"),
    (TABLE, "saw-500rpm", {"columns": ["C.x=px"]}, "columns = .*give a mapping, such as"),
    (TABLE, "saw-500rpm", {"estimate": "fase"}, "'fase': did you mean 'phase'"),
])  # fmt: skip
def test_a_value_of_another_form_is_refused_in_one_line(
    subject: Any, scene: str | None, arguments: dict[str, Any], message: str
) -> None:
    with pytest.raises(InvalidInput, match=message) as refused:
        check(subject, scene, **arguments)
    assert "\n" not in str(refused.value)


def test_single_name_is_taken_as_a_sequence_of_one(at_once: None) -> None:
    # "mm" is not the units m and m.
    for units in ("mm", ["mm"]):
        found = check(TABLE, "saw-500rpm", units=units).study
        assert [(one.name, one.factor) for one in found.columns] == [("time", 1.0), ("C.x", 1e-3)]
    with pytest.raises(InvalidInput, match="'torqe': did you mean 'torque'"):
        forces("shear-press", quantities="torqe")
    with pytest.raises(InvalidInput, match="'step': did you mean 'steps'"):
        limits("saw-500rpm", axes="step")


def test_rotation_of_0_is_not_a_rotation_to_be_found(tmp_path: Path, at_once: None) -> None:
    asked: dict[str, Any] = {"baseline": tmp_path / "b.json", "accept": True, "revolutions": 1}
    assert check(MODEL, "saw-500rpm", **ON_MODEL, **asked, rotation=0.0).baseline.written
    asked["accept"] = False
    with pytest.raises(InvalidInput, match=r"the baseline is of something else: rotation 0\.0, here null"):
        check(MODEL, "saw-500rpm", **ON_MODEL, **asked)
