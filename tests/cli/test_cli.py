"""What a user types, and sees."""

from __future__ import annotations

import csv
import doctest
import io
import json
import math
import re
import shlex
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest
from command_line import conrod, conrod_process, error_lines
from described import FOUR_BAR, SLIDER_CRANK
from table_files import write_file

from conrod.cli import VERBS, cli
from conrod.cli.options import FAMILY_HELP, FINDINGS_HELP, SHARED
from conrod.exact.linkage import instant_quantities
from conrod.scenes import SCENES, Saw, catalogue_scene
from conrod.scenes.described_scene import read_scene

# A run of a tenth of a second.
QUICK = ("validate", "saw-40rpm", "--engine", "pymunk", "--preset", "tuned", "--steps-per-rev", "100")


@pytest.mark.parametrize("option", SHARED)
def test_an_option_means_the_same_in_every_verb(option: str) -> None:
    context = click.Context(cli)
    commands = [cli.get_command(context, name) for name in VERBS]
    options = [one for command in commands if command is not None for one in command.params if option in one.opts]
    assert options
    # A study of scenes takes a list of values, which makes a family of machines; what is of one machine does not.
    # What is judged is written for build servers too.
    others = {"--set": {FAMILY_HELP}, "--json": {FINDINGS_HELP}}
    helps = {SHARED[option]["help"], *others.get(option, ())}
    assert {one.help for one in options} == helps
    assert len({(one.metavar, one.multiple, one.default, str(one.type)) for one in options}) == 1


def test_command_in_its_own_process_has_same_output_and_status() -> None:
    # All other tests run the command line in their own process.
    arguments = (*QUICK, "--tolerance", "position=1e-9")
    alone, here = conrod_process(*arguments), conrod(*arguments)
    assert alone.returncode == here.returncode == 1
    assert (alone.stdout, error_lines(alone)) == (here.stdout, error_lines(here))
    assert alone.stdout or alone.stderr


def test_stock_is_judged_with_exit_status_only_when_asked() -> None:
    command = ("validate", "saw-40rpm", "--engine", "pymunk", "--preset", "stock")
    assert "measured, not judged" in conrod(*command).stdout
    asked = conrod(*command, "--tolerance", "position=0.1,velocity=0.1")
    assert asked.returncode == 0
    assert "not judged" not in asked.stdout
    exceeded = conrod(*command, "--tolerance", "position=1e-9")
    assert exceeded.returncode == 1
    assert "OUT OF TOLERANCE" in exceeded.stdout


def test_exported_csv_has_units_and_the_exact_whole_pass() -> None:
    done = conrod("export", str(FOUR_BAR), "--format", "csv", "--steps-per-rev", "360")
    headings, *rows = csv.reader(io.StringIO(done.stdout))
    assert headings[:4] == ["time [s]", "crank_angle [rad]", "A.x [m]", "A.y [m]"]
    values = np.array(rows, dtype=float)
    assert len(values) == 71
    # Time 0 is that of crank angle 0, as in runs.
    assert values[[0, -1], :2] == pytest.approx(np.radians([[-10.0 / 60.0, -10.0], [60.0 / 60.0, 60.0]]))
    exact = read_scene(FOUR_BAR).reference(values[:, 0]).point("A")
    assert np.array_equal(values[:, 2:4], exact.position)
    assert np.array_equal(values[:, 8:10], exact.jerk)


@pytest.mark.usefixtures("undrawn")
def test_report_overwrites_an_earlier_report_and_its_results(tmp_path: Path) -> None:
    # Negative control of the refusals above; also of a report behind a link.
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real")
    for _ in range(2):
        done = conrod(*QUICK, "--out", "link", "--json", "link/all.json", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        assert (tmp_path / "link").is_symlink()
        assert {"README.md", "all.json", "data", "figures", "results.json", "saw-40rpm.md"} == {
            path.name for path in (tmp_path / "real").iterdir()
        }


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("name", "raised", "status", "words"),
    [
        ("conrod.report.figure.Figure.svg", KeyboardInterrupt, 130, "interrupted"),
        (
            "conrod.execution.runner.pursue",
            MemoryError,
            2,
            "out of memory: fewer --steps-per-rev or --revolutions",
        ),
        ("os.fsync", OSError(28, "No space left on device"), 2, "No space left on device: "),
    ],
)
def test_stopped_command_leaves_no_file_and_a_short_message(
    name: str, raised: Any, status: int, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: object) -> None:
        raise raised

    monkeypatch.setattr(name, stop)
    done = conrod(*QUICK, "--out", "new/report", "--json", "all.json", cwd=tmp_path)
    assert done.returncode == status
    assert error_lines(done)[-1].startswith(f"conrod: {words}")
    assert len(error_lines(done)[-1]) < 200
    assert list(tmp_path.iterdir()) == []


# -- mechanism files, taken where scenes are ---------------------------------------------------------------------------


def test_mechanism_file_is_validated_in_both_engines(tmp_path: Path) -> None:
    file = str(write_file(tmp_path, SLIDER_CRANK.read_text(), "own.toml"))
    done = conrod("validate", file, "--preset", "tuned", "--steps-per-rev", "100", "--json", "r.json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    (part,) = json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))["parts"].values()
    ends = {(one["scene"], one["engine"], one["outcome"]) for one in part["findings"]["results"]}
    assert ends == {("slider-crank", engine, "completed") for engine in ("mujoco", "pymunk")}


def test_show_prints_description_and_assumptions_as_plain_text(tmp_path: Path) -> None:
    text = re.sub(r"(?m)^source = .*$", 'source = "a [/b] source [red] <b> & -- c -->"', SLIDER_CRANK.read_text())
    text = re.sub(r'(?ms)^description = (""".*?"""|[^\n]*)\n|^assumptions = \[.*?^\]\n', "", text)
    told = 'description = "A [bold] {speed} machine [/x]."\nassumptions = ["no friction [/y]", "stiff links"]\n'
    path = str(write_file(tmp_path, f"{told}{text}", "own.toml"))
    shown = conrod("show", path, "--set", "bodies.rod.points.B.x=600mm", "--set", "speed=20rpm").stdout
    assert "source: a [/b] source [red] <b> & -- c -->" in shown
    assert "A [bold] {speed} machine [/x]." in shown
    assert "assumed:\n  - no friction [/y]\n  - stiff links\n" in shown
    assert re.search(r"slider +slide +600 mm +0, 180 ", shown)
    assert "references: generic Newton solver" in shown
    # What to type next is of the same machine.
    more = shlex.join([path, "--set", "bodies.rod.points.B.x=600mm", "--set", "speed=20rpm"])
    assert f"draw it: conrod show {more} --svg own.svg\nnext: conrod validate {more}" in shown.replace(" \n", " ")
    # Negative control: a scene in closed form has both rulers.
    assert "references: closed form" in conrod("show", "saw-40rpm").stdout
    # Nor does a model.
    assert ET.fromstring(conrod("export", path, "--format", "mjcf").stdout).tag == "mujoco"


# -- what `conrod show` tells of a linkage, against closed forms, and its JSON -----------------------------------------

DOCUMENT = Path(__file__).parents[2] / "docs" / "linkages.md"
CRANK, ROD, OFFSET = 0.1, 0.3, 0.09  # of the saw [m]


def show_document(*arguments: str, folder: Path) -> dict[str, Any]:
    done = conrod("show", *arguments, "--json", "out.json", cwd=folder)
    assert done.returncode == 0, done.stderr
    document: dict[str, Any] = json.loads((folder / "out.json").read_text())
    return document


def test_greatest_pressure_angle_of_the_cam_matches_its_lift(tmp_path: Path) -> None:
    (angle,) = show_document("cam-follower", folder=tmp_path)["turn"]["transmission"]
    scene = SCENES["cam-follower"]
    # For a follower that moves through the shaft, tan(pressure angle) = (ds/dt) / s with s from the shaft.
    here = np.linspace(0.0, 2.0 * np.pi, 200_001)
    moved = scene.motion(here, 1.0).point("roller")
    exact = float(np.abs(np.arctan2(moved.velocity[:, 1], moved.position[:, 1])).max())
    greatest = max(0.5 * math.pi - angle["least"]["value"], angle["greatest"]["value"] - 0.5 * math.pi)
    assert greatest == pytest.approx(exact, abs=1e-9)
    assert angle["through"] == "cam"
    # Negative control: without the base circle the same formula gives another angle.
    wrong = np.arctan2(moved.velocity[:, 1], moved.position[:, 1] - moved.position[0, 1] + 0.03)
    assert abs(float(np.abs(wrong).max()) - exact) > 0.01


@pytest.mark.parametrize("degrees", ["130", "-75.5"])
def test_show_at_an_angle_matches_slider_crank_closed_form(degrees: str, tmp_path: Path) -> None:
    here = show_document("saw-40rpm", f"--angle={degrees} deg", folder=tmp_path)["instant"]
    angle, saw = math.radians(float(degrees)), Saw(speed=40.0 * 2.0 * math.pi / 60.0)
    w, height = saw.speed, CRANK * math.sin(angle) - OFFSET
    down = math.sqrt(ROD**2 - height**2)
    # The rod from pin to slider, to the left: -rod sin(turn of it) = height of the pin.
    rod_speed = CRANK * math.cos(angle) * w / down
    rod_change = (height * rod_speed**2 - CRANK * math.sin(angle) * w**2) / down
    links = {link["link"]: link for link in here["links"]}
    assert links["rod"]["rate"][2] == pytest.approx(rod_speed, rel=1e-11)
    assert links["rod"]["acceleration"][2] == pytest.approx(rod_change, rel=1e-11)
    motion = saw.motion(angle, w)
    for name, point in here["points"]["points"].items():
        exact = motion.point(name)
        assert point["velocity"][0] == pytest.approx(list(exact.velocity[0]), abs=1e-13)
        assert point["acceleration"][0] == pytest.approx(list(exact.acceleration[0]), abs=1e-12)


def test_show_writes_centres_and_parts_as_the_api_gives_them(tmp_path: Path) -> None:
    here = show_document("inverted-slider-crank", "--angle=1 rad", folder=tmp_path)["instant"]
    scene = catalogue_scene("inverted-slider-crank")
    found = instant_quantities(scene.kinematics, 1.0, scene.speed)
    assert here["sliding"] == [{**vars(one), **_lists(one)} for one in found.sliding]
    assert here["relative"] == [{**vars(one), **_lists(one)} for one in found.relative]
    places = {tuple(centre["links"]): (centre["place"], centre["direction"]) for centre in here["centres"]}
    assert places == {c.links: (None if c.place is None else c.place.tolist(), c.direction) for c in found.centres}
    assert places["block", "link"][0] is None


def _lists(one: object) -> dict[str, Any]:
    return {name: value.tolist() for name, value in vars(one).items() if isinstance(value, np.ndarray)}


def test_python_of_the_linkages_page_runs() -> None:
    examples = doctest.DocTestParser().get_doctest(DOCUMENT.read_text(), {}, "linkages.md", str(DOCUMENT), 0)
    assert len(examples.examples) >= 5
    assert doctest.DocTestRunner().run(examples).failed == 0


def test_example_of_the_linkages_page_is_what_show_prints() -> None:
    example = DOCUMENT.read_text().split("```text\n")[1].split("```")[0].rstrip("\n")
    printed = [line.rstrip() for line in conrod("show", "saw-40rpm", "--angle", "60deg").stdout.splitlines()]
    assert "\n".join(printed).endswith(example)
    assert example.startswith("crank: turns fully")
