"""A pack holds all that another tool needs, of a scene in closed form as of a file, and is judged by one figure."""

from __future__ import annotations

import cmath
import json
import math
import zipfile
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from command_line import conrod
from table_files import read_file

from conrod import InvalidInput
from conrod.execution.resolve_arguments import mechanism_file_bytes
from conrod.mechanism.mechanism import Prismatic, Revolute
from conrod.models.export.pack import PAGES, mechanism_document, pack_files
from conrod.models.tables.errors import TableComparison
from conrod.models.tables.estimation import estimate
from conrod.models.tables.study import study_table
from conrod.scenes import SCENES, Scene, catalogue_scene, catalogue_text
from conrod.scenes.described_scene import DescribedScene, read_scene

MACHINES = ("swinging-four-bar", "slider-crank")
PASS = MACHINES[0]
OTHER = {
    "shear-press": {"speed": -4.0},
    "saw-40rpm": {"crank": 0.0812345678901234},
    "saw-500rpm": {"rod_mass": 1.0 / 3.0},
    "cam-follower": {"flank_radius": 0.2},
}


@cache
def pack_contents(name: str, scene: Scene) -> Mapping[str, str | bytes]:
    """Made once, without the drawing: that takes longer than all the rest."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("conrod.models.export.pack.mechanism_svg", lambda _: "<svg/>")
        return pack_files(name, scene, 90, 2, mechanism_file_bytes(name))


def write_pack(name: str, scene: Scene, folder: Path) -> Path:
    for file, content in pack_contents(name, scene).items():
        (folder / file).parent.mkdir(exist_ok=True)
        (folder / file).write_bytes(content.encode() if isinstance(content, str) else content)
    return folder


def lengthened_scene(name: str) -> DescribedScene:
    scene = catalogue_scene(name)
    place = next(p for p, v in scene.parameters.items() if p.endswith(".x") and p.startswith("bodies.") and v > 0.0)
    return scene.with_parameters(**{place: 1.01 * scene.parameters[place], "speed": -0.5 * scene.speed})


def scene_in(pack: Path) -> Scene:
    """The scene of a pack, by the values in its parameters' file and the mechanism file beside it."""
    document = json.loads((pack / "parameters.json").read_text(encoding="utf-8"))
    kinds: dict[str, Scene] = {scene.kind: scene for scene in SCENES.values()}
    usual = read_scene(pack / "machine.toml") if "machine" in document else kinds[document["kind"]]
    given = {name: entry["value"] for name, entry in document["parameters"].items()}
    assert given.keys() == usual.parameters.keys()
    return usual.with_parameters(**{name: value for name, value in given.items() if value != usual.parameters[name]})


@pytest.mark.parametrize("name", ["saw-40rpm", "cam-follower", *MACHINES])
def test_pack_gives_its_scene_back_and_an_exact_trajectory(name: str, tmp_path: Path) -> None:
    given: Scene = (
        lengthened_scene(name) if name in MACHINES else SCENES[name].with_parameters(**OTHER.get(name, {"speed": 3.0}))
    )
    usual = catalogue_scene(name).with_parameters(speed=given.speed) if name in MACHINES else SCENES[name]
    pack = write_pack(name, given, tmp_path)
    judge = scene_in(pack)
    assert judge == given != usual
    assert judge.mechanism() == given.mechanism()
    file = "trajectory.csv"
    study = study_table(file, name, judge, read_file(pack / file, judge))
    assert name == PASS or study.revolutions == pytest.approx(2.0, abs=1e-12)
    assert not [note for note in study.notes if "spans less" in note]
    for quantity in ("total", "position", "velocity", "acceleration"):
        bound = 1e-13 if name in SCENES else 1e-11 if quantity == "acceleration" else 1e-12
        assert (study.largest(quantity) or 0.0) < bound
    # Negative control: against the machine that ships it is off, where the motion is another one.
    if name != "saw-500rpm":
        other = study_table(file, name, usual, read_file(pack / file, usual))
        assert (other.largest("total") or 0.0) > 1e-3


def test_pack_mechanism_matches_scene_and_start_closes_pins() -> None:
    mechanism = SCENES["shear-press"].mechanism()
    document = json.loads(json.dumps(mechanism_document(mechanism)))
    assert [(body["name"], body["mass"]) for body in document["bodies"]] == [(b.name, b.mass) for b in mechanism.bodies]
    kinds = {"revolute": Revolute, "prismatic": Prismatic}
    assert [kinds[joint["kind"]] for joint in document["joints"]] == [type(joint) for joint in mechanism.joints]
    starts = {body["name"]: body["start_pose"] for body in document["bodies"]} | {"ground": [0.0, 0.0, 0.0]}
    for joint in document["joints"]:
        if joint["kind"] == "revolute":
            ends = [_place_point(starts[joint[side]], joint[f"point_{side}"]) for side in "ab"]
            assert abs(ends[0] - ends[1]) < 1e-3 * max(SCENES["shear-press"].lengths.values())


def _place_point(pose: list[float], point: list[float]) -> complex:
    return complex(*pose[:2]) + cmath.exp(1j * pose[2]) * complex(*point)


def test_a_pack_is_a_folder_or_an_archive_of_the_same(tmp_path: Path) -> None:
    command = ("export", "saw-40rpm", "--format", "pack", "--steps-per-rev", "20", "--revolutions", "3", "-o")
    archives = []
    for place in ("pack", "pack.zip", "pack", "pack.zip"):  # again over itself, too
        assert conrod(*command, place, cwd=tmp_path).returncode == 0
        archives += [(tmp_path / place).read_bytes()] if place == "pack.zip" else []
    assert archives[0] == archives[1]
    files = {str(p.relative_to(tmp_path)): p.read_bytes() for p in (tmp_path / "pack").rglob("*") if p.is_file()}
    with zipfile.ZipFile(tmp_path / "pack.zip") as archive:
        assert {name: archive.read(name) for name in archive.namelist()} == files
        assert all(entry.external_attr >> 16 == 0o644 for entry in archive.infolist())
    assert {f"pack/{name}" for name in PAGES} <= set(files)
    assert files["pack/figures/mechanism.svg"].rstrip().endswith(b"</svg>")
    assert len(files["pack/trajectory.csv"].splitlines()) == 1 + 61


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--format", "pack"), "name it with -o DIR or -o FILE.zip"),
        (("--format", "pack", "-o", "mine"), "it holds a README.md that is not of a pack"),
        (("--format", "pack", "-o", "other"), "it holds a parameters.json that is not of a pack"),
        (("--format", "pack", "-o", "p", "--steps-per-rev", "0"), "--steps-per-rev = 0 is out of range"),
        (("--format", "pakc"), "unknown format 'pakc': did you mean 'pack'? choose from csv, fmu, mjcf, npz, pack"),
    ],
)
def test_a_pack_that_cannot_be_written_writes_nothing(arguments: tuple[str, ...], message: str, tmp_path: Path) -> None:
    for file, text in {"mine/README.md": "my notes\n", "other/parameters.json": "{}"}.items():
        (tmp_path / file).parent.mkdir()
        (tmp_path / file).write_text(text)
    done = conrod("export", "saw-40rpm", *arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert message in done.stderr
    assert {p.name for p in tmp_path.rglob("*")} == {"mine", "README.md", "other", "parameters.json"}
    assert (tmp_path / "mine/README.md").read_text() == "my notes\n"


# -- of a mechanism file ----------------------------------------------------------------------------------------------


def test_the_clock_of_a_pass_counts_from_crank_angle_zero(tmp_path: Path) -> None:
    scene = catalogue_scene(PASS)
    pack = write_pack(PASS, scene, tmp_path)
    reading = read_file(pack / "trajectory.csv", scene)
    values = reading.values
    assert values["time"][0] == pytest.approx(scene.kinematics.span[0] / scene.speed, abs=1e-15)
    np.testing.assert_allclose(values["crank_angle"], scene.speed * values["time"], atol=1e-14)
    late = replace(reading, values={**values, "time": values["time"] - values["time"][0]})
    with pytest.raises(InvalidInput, match=r"from crank angle 0 to .* deg, out of the pass from -10 to 60 deg"):
        study_table("late.csv", PASS, scene, late)
    with pytest.raises(InvalidInput, match="the input makes one pass"):
        estimate(TableComparison(values, scene), ("time",))


def test_pack_contains_the_mechanism_file_of_its_scene(tmp_path: Path) -> None:
    assert mechanism_file_bytes("saw-40rpm") is None
    assert mechanism_file_bytes(PASS) == catalogue_text(PASS).encode()
    own = tmp_path / "own.toml"
    own.write_bytes(catalogue_text(PASS).encode())
    assert mechanism_file_bytes(str(own)) == own.read_bytes()
    done = conrod("export", "own.toml", "--format", "pack", "-o", "pack", "--set", "speed=-100rpm", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    found = scene_in(tmp_path / "pack")
    assert isinstance(found, DescribedScene)
    assert DescribedScene(found.document) == read_scene(own)
    assert dict(found.given_anew) == {"speed": pytest.approx(-100.0 * math.pi / 30.0, rel=1e-15)}
