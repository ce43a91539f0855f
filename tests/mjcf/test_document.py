"""The text of a model file, edited and compiled again: what differs is named."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from conrod.errors import InvalidInput
from conrod.mjcf.document import Document, first_difference

ARM = '<body name="arm"><joint name="turn"/><geom size="0.1" mass="1"/></body>'
MODEL = f"<mujoco><worldbody>{ARM}</worldbody></mujoco>"


@pytest.mark.parametrize(("old", "new", "different"), [
    ("arm", "leg", ""),  # names are none
    ('mass="1"', 'mass="2"', "body_inertia"),
    ("</body>", '<site name="end"/></body>', "site_bodyid"),  # of which one has none
    ("<worldbody>", '<option timestep="0.001"/><worldbody>', "option"),
])  # fmt: skip
def test_first_array_that_differs_is_named(old: str, new: str, different: str) -> None:
    one = mujoco.MjModel.from_xml_string(MODEL)
    assert first_difference(one, mujoco.MjModel.from_xml_string(MODEL.replace(old, new))) == different


def test_numbers_that_are_none_are_the_same() -> None:
    one, other = (mujoco.MjModel.from_xml_string(MODEL) for _ in "ab")
    one.jnt_range[0, 1] = np.nan
    assert first_difference(one, other) == "jnt_range"
    other.jnt_range[0, 1] = np.nan
    assert first_difference(one, other) == ""


def test_model_is_compared_with_its_text_in_another_folder(tmp_path: Path) -> None:
    for folder, mass in (("here", 1), ("there", 2), ("nowhere", 0)):
        (tmp_path / folder).mkdir()
        if mass:
            text = f"<mujoco><worldbody>{ARM}</worldbody></mujoco>".replace('mass="1"', f'mass="{mass}"')
            (tmp_path / folder / "part.xml").write_text(text, encoding="utf-8")
    file = tmp_path / "here" / "model.xml"
    file.write_bytes(b'<mujoco>\n  <include file="part.xml"/>\n</mujoco>\n<!-- the end -->\n')
    document, edits = Document(file), ['<option timestep="0.001"/>']
    assert document.text_with(edits) == (
        b'<mujoco>\n  <include file="part.xml"/>\n  <option timestep="0.001"/>\n</mujoco>\n<!-- the end -->\n'
    )
    for asked in ((), edits):
        assert document.recompile_difference(tmp_path / "here", asked) == ""
        assert document.recompile_difference(tmp_path / "there", asked) == "body_inertia"
        missing = document.recompile_difference(tmp_path / "nowhere", asked)
        assert "part.xml" in missing
        assert "\n" not in missing
    assert document.compile_with(edits).opt.timestep == 0.001


def test_model_that_is_not_that_of_its_text_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "model.xml"
    file.write_text(MODEL, encoding="utf-8")
    heavier = mujoco.MjModel.from_xml_string(MODEL.replace('mass="1"', 'mass="2"'))
    monkeypatch.setattr("conrod.mjcf.document.load_model", lambda _: heavier)
    with pytest.raises(InvalidInput) as refused:
        Document(file)
    assert str(refused.value) == f"{file}: compiled from its text it is another model (body_inertia)"
