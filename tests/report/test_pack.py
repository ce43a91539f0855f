"""A pack holds all that another tool needs, and what comes back is judged by the one figure that counts."""

from __future__ import annotations

import io
import json
import math
import zipfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from conrod import InvalidInput
from conrod.mechanism.mechanism import CamContact, Prismatic, Revolute
from conrod.own.tables.study import study_table
from conrod.report.pack.contents import PAGES, mechanism_document, pack_files, pack_to_write, read_parameters
from conrod.report.pack.readme import worth_meeting
from conrod.scenes import SCENES, Saw, Scene
from tests.support.command_line import conrod
from tests.support.table_files import read

OTHER = {
    "shear-press": {"speed": -4.0},
    "saw-40rpm": {"crank": 0.0812345678901234},
    "saw-500rpm": {"rod_mass": 1.0 / 3.0},
    "cam-follower": {"flank_radius": 0.2},
}


@cache
def packed(name: str, scene: Scene) -> Mapping[str, str | bytes]:
    """Made once, without the drawing: that takes longer than all the rest."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("conrod.report.pack.contents.mechanism_svg", lambda _: "<svg/>")
        return pack_files(name, scene, 90, 2)


def unpacked(name: str, scene: Scene, folder: Path) -> Path:
    for file, content in packed(name, scene).items():
        (folder / file).parent.mkdir(exist_ok=True)
        (folder / file).write_bytes(content.encode() if isinstance(content, str) else content)
    return folder


@pytest.mark.parametrize("name", SCENES)
def test_a_pack_gives_its_scene_back_and_its_trajectory_has_no_error(name: str, tmp_path: Path) -> None:
    scene = SCENES[name].with_parameters(**OTHER.get(name, {"speed": 3.0}))
    pack = unpacked(name, scene, tmp_path)
    judge = read_parameters(pack / "parameters.json")
    assert judge == scene != SCENES[name]
    assert judge.mechanism() == scene.mechanism()
    for file in ("trajectory.csv", "trajectory.npz"):
        study = study_table(file, name, judge, read(pack / file, judge))
        assert study.revolutions == pytest.approx(2.0, abs=1e-12)
        for quantity in ("total", "position", "velocity", "acceleration"):
            assert (study.largest(quantity) or 0.0) < 1e-13
        # Negative control: against the machine that ships it is off, where the motion is another one.
        if name != "saw-500rpm":
            other = study_table(file, name, SCENES[name], read(pack / file, SCENES[name]))
            assert (other.largest("total") or 0.0) > 1e-3


def test_parameters_that_are_none_are_refused(tmp_path: Path) -> None:
    path = unpacked("saw-40rpm", Saw(), tmp_path) / "parameters.json"
    document = json.loads(path.read_text())
    for change, message in (
        ({"kind": "sow"}, "unknown kind of scene 'sow': choose from .* did you mean 'saw'"),
        ({"parameters": document["parameters"] | {"rodd": {"value": 1.0}}}, "unknown parameter 'rodd'"),
        ({"parameters": {"rod": {"value": 1.0}}}, "there is no crank, "),
        ({"parameters": {"rod": 1.0}}, "does not hold the parameters of a pack"),
        ({"parameters": document["parameters"] | {"rod": {"value": -1.0}}}, "out of range"),
    ):
        path.write_text(json.dumps(document | change))
        with pytest.raises(InvalidInput, match=message):
            read_parameters(path)


@pytest.mark.parametrize("name", SCENES)
def test_the_mechanism_in_a_pack_is_the_scenes(name: str) -> None:
    mechanism = SCENES[name].mechanism()
    document = json.loads(json.dumps(mechanism_document(mechanism)))
    assert [body["name"] for body in document["bodies"]] == [body.name for body in mechanism.bodies]
    assert [body["mass"] for body in document["bodies"]] == [body.mass for body in mechanism.bodies]
    kinds = {"revolute": Revolute, "prismatic": Prismatic, "cam contact": CamContact}
    assert [kinds[joint["kind"]] for joint in document["joints"]] == [type(joint) for joint in mechanism.joints]
    # The start poses close every pin, by the document alone.
    places = {body["name"]: body["start_pose"] for body in document["bodies"]} | {"ground": [0.0, 0.0, 0.0]}
    for joint in document["joints"]:
        if joint["kind"] == "revolute":
            ends = [_placed(places[joint[side]], joint[f"point_{side}"]) for side in "ab"]
            assert ends[0] == pytest.approx(ends[1], abs=1e-3 * max(SCENES[name].lengths.values()))


def _placed(pose: list[float], point: list[float]) -> tuple[float, float]:
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return pose[0] + c * point[0] - s * point[1], pose[1] + s * point[0] + c * point[1]


@pytest.mark.parametrize("name", ["saw-40rpm", "cam-follower"])
def test_errors_worth_meeting_are_what_engines_promise(name: str) -> None:
    found = worth_meeting(SCENES[name])
    sizes = [one.position for one in found]
    assert sizes == sorted(sizes, reverse=True)
    assert (sizes[0], sizes[-1]) == (1e-2, 1e-12)
    promised = [one.meaning for one in found[1:-1]]
    assert any("mujoco" in text for text in promised)
    assert any("pymunk" in text for text in promised)
    # Hardening is not for contact.
    assert any("hardened" in text for text in promised) == (name == "saw-40rpm")


def test_the_readme_says_what_to_solve_and_how_it_is_judged() -> None:
    scene = SCENES["saw-500rpm"].with_parameters(crank=0.08)
    page = packed("saw-500rpm", scene)["README.md"]
    assert isinstance(page, str)
    # What a closed solution needs is in the page alone.
    for words in (
        "| `crank` | 80 | mm |",
        "| `rod` | 300 | mm |",
        "| `offset` | 90 | mm |",
        "at a constant 52.3598775598298",
    ):
        assert words in page
    for words in ("largest position error over L, over two revolutions", "## What to solve", "`crank` about the joint"):
        assert words in page
    assert "`conrod validate YOUR.csv --scene saw-500rpm --set crank=0.08`" in page
    assert "{" not in page
    assert "--set" not in str(packed("saw-500rpm", SCENES["saw-500rpm"])["README.md"])


def test_the_arcs_of_a_cam_are_where_the_page_says(tmp_path: Path) -> None:
    scene = SCENES["cam-follower"]
    pack = unpacked("cam-follower", scene, tmp_path)
    assert "directions of its outward normal" in (pack / "README.md").read_text()
    joints = json.loads((pack / "mechanism.json").read_text())["joints"]
    arcs = next(joint for joint in joints if joint["kind"] == "cam contact")["profile"]["arcs"]
    # By that reading each arc begins where the one before ends.
    for one, following in zip(arcs, arcs[1:] + arcs[:1], strict=True):
        assert _on(one, one["stop"]) == pytest.approx(_on(following, following["start"]), abs=1e-12)


def _on(arc: dict[str, Any], normal: float) -> tuple[float, float]:
    x, y = arc["centre"]
    return x + arc["radius"] * math.cos(normal), y + arc["radius"] * math.sin(normal)


def test_a_pack_is_a_folder_or_an_archive_of_the_same(tmp_path: Path) -> None:
    for place in ("pack", "pack.zip"):
        done = conrod("export", "saw-40rpm", "--format", "pack", "-o", place, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    files = {str(p.relative_to(tmp_path)): p.read_bytes() for p in (tmp_path / "pack").rglob("*") if p.is_file()}
    with zipfile.ZipFile(tmp_path / "pack.zip") as archive:
        assert {name: archive.read(name) for name in archive.namelist()} == files
        assert all(entry.external_attr >> 16 == 0o644 for entry in archive.infolist())
    assert {f"pack/{name}" for name in PAGES} <= set(files)
    assert files["pack/figures/mechanism.svg"].rstrip().endswith(b"</svg>")
    trajectory = np.loadtxt(io.BytesIO(files["pack/trajectory.csv"]), delimiter=",", skiprows=1)
    assert len(trajectory) == 2 * 360 + 1
    # Again over itself, and the same bytes.
    once = (tmp_path / "pack.zip").read_bytes()
    for place in ("pack", "pack.zip"):
        assert conrod("export", "saw-40rpm", "--format", "pack", "-o", place, cwd=tmp_path).returncode == 0
    assert (tmp_path / "pack.zip").read_bytes() == once


def test_the_trajectory_of_a_pack_is_as_long_as_asked_for(tmp_path: Path) -> None:
    command = ("export", "saw-40rpm", "--format", "pack", "-o", "p", "--steps-per-rev", "20", "--revolutions", "3")
    assert conrod(*command, cwd=tmp_path).returncode == 0
    assert len((tmp_path / "p/trajectory.csv").read_text().splitlines()) == 1 + 61


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--format", "pack"), "name it with -o DIR or -o FILE.zip"),
        (("--format", "pack", "-o", "mine"), "it holds a README.md that is not of a pack"),
        (("--format", "pack", "-o", "p", "--steps-per-rev", "0"), "--steps-per-rev = 0 is out of range"),
        (("--format", "pakc"), "unknown format 'pakc': choose from csv, mjcf, npz, pack; did you mean 'pack'?"),
    ],
)
def test_a_pack_that_cannot_be_written_writes_nothing(arguments: tuple[str, ...], message: str, tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/README.md").write_text("my notes\n")
    done = conrod("export", "saw-40rpm", *arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert message in done.stderr
    assert [p.name for p in tmp_path.rglob("*")] == ["mine", "README.md"]
    assert (tmp_path / "mine/README.md").read_text() == "my notes\n"


def test_an_earlier_pack_may_be_replaced_and_a_lone_folder_used(tmp_path: Path) -> None:
    unpacked("saw-40rpm", Saw(), tmp_path)
    assert pack_to_write(str(tmp_path)) == tmp_path
    (tmp_path / "parameters.json").write_text("{}")
    with pytest.raises(InvalidInput, match="that is not of a pack"):
        pack_to_write(str(tmp_path))
