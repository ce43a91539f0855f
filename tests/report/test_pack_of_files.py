"""A pack of a mechanism file holds the file, and is read and judged by as that of a scene in closed form."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from conrod import InvalidInput
from conrod.own.tables.estimation import estimate
from conrod.own.tables.study import TableStudy, study_table
from conrod.report.pack.contents import pack_files, read_parameters
from conrod.scenes.catalogue import catalogue_scene, catalogue_text
from conrod.scenes.described_scene import DescribedScene, read_scene
from conrod.studies.frame.resolve_arguments import machine_text
from tests.support.command_line import conrod
from tests.support.table_files import read

MACHINES = ("swinging-four-bar", "slider-crank")
PASS = MACHINES[0]


def longer(name: str) -> DescribedScene:
    scene = catalogue_scene(name)
    place = next(p for p, v in scene.parameters.items() if p.endswith(".x") and p.startswith("bodies.") and v > 0.0)
    return scene.with_parameters(**{place: 1.01 * scene.parameters[place], "speed": -0.5 * scene.speed})


@cache
def packed(name: str, scene: DescribedScene) -> Mapping[str, str | bytes]:
    """Made once, without the drawing: that takes longer than all the rest."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("conrod.report.pack.contents.mechanism_svg", lambda _: "<svg/>")
        return pack_files(name, scene, 90, 2, catalogue_text(name).encode())


def unpacked(name: str, scene: DescribedScene, folder: Path) -> Path:
    for file, content in packed(name, scene).items():
        (folder / file).parent.mkdir(exist_ok=True)
        (folder / file).write_bytes(content.encode() if isinstance(content, str) else content)
    return folder


def judged(pack: Path, scene: DescribedScene, file: str = "trajectory.csv") -> TableStudy:
    return study_table(file, scene.kind, scene, read(pack / file, scene))


@pytest.mark.parametrize("name", MACHINES)
def test_the_pack_of_a_file_gives_the_scene_and_its_trajectory_has_no_error(name: str, tmp_path: Path) -> None:
    scene = longer(name)
    pack = unpacked(name, scene, tmp_path)
    found = read_parameters(pack / "parameters.json")
    assert found == scene
    assert isinstance(found, DescribedScene)
    for file in ("trajectory.csv", "trajectory.npz"):
        study = judged(pack, found, file)
        assert (study.largest("total") or 0.0) < 1e-12
        assert (study.largest("acceleration") or 0.0) < 1e-11
        assert not [note for note in study.notes if "spans less" in note]
    # Negative control: against the file's own numbers it is off.
    own = scene.as_described.with_parameters(speed=scene.speed)
    assert (judged(pack, own).largest("total") or 0.0) > 1e-3


def test_the_page_says_what_was_given_anew_and_where_the_pass_goes(tmp_path: Path) -> None:
    scene = catalogue_scene(PASS).with_parameters(**{"bodies.crank.mass": 3.0})
    page = (unpacked(PASS, scene, tmp_path) / "README.md").read_text(encoding="utf-8")
    assert "`conrod validate YOUR.csv --scene machine.toml --set bodies.crank.mass=3.0`" in page
    assert "in one pass from crank angle -0.174532925199" in page
    assert "over the pass**" in page
    assert "revolutions" not in page.replace("revolutions over", "")
    assert (tmp_path / "machine.toml").read_bytes() == catalogue_text(PASS).encode()
    turning = (unpacked(MACHINES[1], catalogue_scene(MACHINES[1]), tmp_path) / "README.md").read_text(encoding="utf-8")
    assert "over two revolutions**" in turning
    assert "--set" not in turning


def test_a_pack_without_its_file_or_with_another_one_is_refused(tmp_path: Path) -> None:
    pack = unpacked(PASS, catalogue_scene(PASS), tmp_path)
    text = (pack / "machine.toml").read_text(encoding="utf-8")
    document = json.loads((pack / "parameters.json").read_text(encoding="utf-8"))
    del document["parameters"]["speed"]
    (pack / "fewer.json").write_text(json.dumps(document), encoding="utf-8")
    with pytest.raises(InvalidInput, match="there is no speed"):
        read_parameters(pack / "fewer.json")
    (pack / "machine.toml").write_text(text.replace("bodies.crank", "bodies.driver"), encoding="utf-8")
    with pytest.raises(InvalidInput, match=r"machine\.toml: "):
        read_parameters(pack / "parameters.json")
    (pack / "machine.toml").unlink()
    with pytest.raises(InvalidInput, match=r"machine\.toml: it cannot be read"):
        read_parameters(pack / "parameters.json")


def test_the_clock_of_a_pass_counts_from_crank_angle_zero(tmp_path: Path) -> None:
    scene = catalogue_scene(PASS)
    pack = unpacked(PASS, scene, tmp_path)
    reading = read(pack / "trajectory.csv", scene)
    observed = reading.observed
    assert observed.times[0] == pytest.approx(scene.kinematics.span[0] / scene.speed, abs=1e-15)
    assert observed.angle is not None
    np.testing.assert_allclose(observed.angle, scene.speed * observed.times, atol=1e-14)
    late = replace(reading, observed=replace(observed, times=observed.times - observed.times[0]))
    with pytest.raises(InvalidInput, match=r"from crank angle 0 to .* deg, out of the pass from -10 to 60 deg"):
        study_table("late.csv", PASS, scene, late)
    with pytest.raises(InvalidInput, match="only frame can be estimated"):
        estimate(observed, scene, ("time",))
    assert math.isclose(estimate(observed, scene, ("frame",)).alignment.rotation, 0.0, abs_tol=1e-12)


@pytest.mark.slow
def test_a_slip_in_a_table_of_a_pass_is_named(tmp_path: Path) -> None:
    scene = catalogue_scene(PASS)
    reading = read(unpacked(PASS, scene, tmp_path) / "trajectory.csv", scene)
    points = {
        point: {quantity: replace(samples, values=1e3 * samples.values) for quantity, samples in quantities.items()}
        for point, quantities in reading.observed.points.items()
    }
    study = study_table("mm.csv", PASS, scene, replace(reading, observed=replace(reading.observed, points=points)))
    assert [cause.text for cause in study.causes] == ["lengths are 1000 times too large: mm taken for m"]


def test_the_file_of_what_was_named_goes_into_the_pack(tmp_path: Path) -> None:
    assert machine_text("saw-40rpm") is None
    assert machine_text(PASS) == catalogue_text(PASS).encode()
    assert machine_text("four-bar-chain-3") == catalogue_text("four-bar-chain-3").encode()
    own = tmp_path / "own.toml"
    own.write_bytes(catalogue_text(PASS).encode())
    assert machine_text(str(own)) == own.read_bytes()
    done = conrod("export", "own.toml", "--format", "pack", "-o", "pack", "--set", "speed=-100rpm", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    found = read_parameters(tmp_path / "pack/parameters.json")
    assert isinstance(found, DescribedScene)
    assert found.as_described == read_scene(own)
    assert dict(found.given_anew) == {"speed": pytest.approx(-100.0 * math.pi / 30.0, rel=1e-15)}
