"""`--unit` of lint and harden: a model in millimetres is judged as the same one in metres is."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from command_line import conrod, refusal

from conrod.models.harden.results import HardenedModel
from conrod.models.harden.study import harden_file
from conrod.models.lint.findings import Finding
from conrod.models.lint.linting import lint

# A slider-crank, open by 2 mm, whose pin is as soft as MuJoCo makes it; u units are a metre.
SLIDER = """<mujoco><option timestep="0.001" gravity="0 0 {g!r}"/>
  <default><geom type="capsule" size="{r!r}" density="{d!r}" contype="0" conaffinity="0"/></default><worldbody>
  <body name="crank"><joint name="crank" axis="0 1 0"/><geom fromto="0 0 0 0 0 {a!r}"/>
    <body name="rod" pos="0 0 {a!r}"><joint name="pin" axis="0 1 0"/><geom fromto="0 0 0 {b!r} 0 -{a!r}"/>
      <site name="end" pos="{b!r} 0 -{a!r}"/></body></body>
  <body name="slider" pos="{c!r} 0 0"><joint name="slide" type="slide" axis="1 0 0"/><geom fromto="0 0 0 {a!r} 0 0"/>
    <site name="lug"/></body></worldbody>
  <equality><connect name="closure" site1="end" site2="lug" solimp="0.9 0.95 {w!r}"/></equality></mujoco>"""


def written(folder: Path, u: float) -> Path:
    file = folder / "slider.xml"
    text = SLIDER.format(g=-9.81 * u, r=0.01 * u, d=2000.0 / u**3, a=0.1 * u, b=0.3 * u, c=0.302 * u, w=0.001 * u)
    file.write_text(text, encoding="utf-8")
    return file


def findings(folder: Path, u: float, unit: float) -> dict[str, Finding]:
    return {one.rule: one for one in lint(written(folder, u), seconds=0.3, unit=unit).findings}


def test_lint_finds_in_millimetres_what_it_finds_in_metres(tmp_path: Path) -> None:
    metres, millimetres = findings(tmp_path, 1.0, 1.0), findings(tmp_path, 1e3, 1e-3)
    assert {"open-start", "soft-closure"} <= millimetres.keys() == metres.keys()
    for rule in ("open-start", "soft-closure"):
        assert millimetres[rule].what == metres[rule].what
    # What is pasted is in the file's unit: the slide's place, and the width of the impedance.
    poses = [np.array(one["open-start"].fix.split('"')[1].split(), dtype=float) for one in (metres, millimetres)]
    np.testing.assert_allclose(poses[1], poses[0] * [1.0, 1.0, 1e3], rtol=1e-6, atol=1e-9)
    assert 'solimp="0.9999 0.9999 0.001 ' in metres["soft-closure"].fix
    assert 'solimp="0.9999 0.9999 1 ' in millimetres["soft-closure"].fix
    # Control: taken for metres, it is open by 2 m.
    assert "by up to 2e+03 mm" in findings(tmp_path, 1e3, 1.0)["open-start"].what
    assert "by up to 2 mm" in metres["open-start"].what


def test_harden_runs_in_metres_and_writes_the_unit_of_the_file(tmp_path: Path) -> None:
    def hardened(u: float, unit: float) -> HardenedModel:
        return harden_file(written(tmp_path, u), seconds=0.1, unit=unit)

    metres, millimetres = hardened(1.0, 1.0), hardened(1e3, 1e-3)
    assert millimetres.size == pytest.approx(metres.size, rel=1e-9)
    assert millimetres.start_opening == pytest.approx(metres.start_opening, rel=1e-6)
    before = [found.variants[0].openings for found in (metres, millimetres)]
    assert before[0]
    assert before[1] == pytest.approx(before[0], rel=1e-3)
    assert hardened(1e3, 1.0).start_opening == pytest.approx(1e3 * metres.start_opening, rel=1e-6)  # control
    assert millimetres.content is not None
    (tmp_path / "hard.mjb").write_bytes(millimetres.content)
    assert mujoco.MjModel.from_binary_path(str(tmp_path / "hard.mjb")).body("slider").pos[0] == pytest.approx(302.0)


@pytest.mark.parametrize("verb", ["lint", "harden"])
def test_a_unit_is_taken_by_its_name(verb: str, tmp_path: Path) -> None:
    file = written(tmp_path, 1e3)
    assert "unknown unit of a model's lengths 'mn': did you mean 'm'? choose from cm, inch, m, mm" in refusal(
        verb, str(file), "--unit", "mn"
    )
    words = conrod(verb, str(file), "--unit", "mm", "--seconds", "0.05").stdout
    assert ("2 mm" if verb == "lint" else "open by 2.0 mm") in words
