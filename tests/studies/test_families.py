"""Families of machines: lists of parameters' values, a member each, with a name, a row and runs of its own."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import command_line
import numpy as np
import pytest
from catalogue import SAW
from command_line import conrod

from conrod import InvalidInput, family
from conrod.cli.outputs import reproduction
from conrod.engines import engine_named
from conrod.execution.case import pursue
from conrod.execution.families import MAX_MEMBERS, VALUE_SIGN, member_name, split_values
from conrod.execution.resolve_arguments import arguments_of_members, scene, select_scenes
from conrod.execution.result import Plan
from conrod.report.table import cell_text
from conrod.report.writer import part_order
from conrod.scenes import CamFollower
from conrod.studies.validation.results import SceneStudy
from conrod.studies.validation.study import ValidationCase, validation_study
from conrod.studies.validation.tables import family_table, results_to_print

BASES, FLANKS = ("36mm", "46mm"), ("88mm", "98mm", "108mm")
LISTS = [f"base_radius={','.join(BASES)}", f"flank_radius={','.join(FLANKS)}"]


def refusal(*assignments: str, scenes: tuple[str, ...] = ("cam-follower",)) -> str:
    with pytest.raises(InvalidInput) as raised:
        select_scenes(scenes, assignments)
    return str(raised.value)


# -- members -----------------------------------------------------------------------------------------------------------


def test_family_has_a_named_member_for_each_combination() -> None:
    found = select_scenes(["cam-follower"], [*LISTS, "speed=2"])
    assert list(found) == [
        f"cam-follower-base_radius={base}-flank_radius={flank}" for base, flank in itertools.product(BASES, FLANKS)
    ]
    lengths = [(one.base_radius, one.flank_radius) for one in found.values() if isinstance(one, CamFollower)]
    assert np.allclose(lengths, list(itertools.product((0.036, 0.046), (0.088, 0.098, 0.108))), rtol=1e-15)
    assert {one.parameters["speed"] for one in found.values()} == {2.0}  # one value is that of all
    assert all(VALUE_SIGN in name for name in found)


def test_api_makes_the_members_of_the_command_line() -> None:
    cams = family("cam-follower", base_radius=BASES, flank_radius=",".join(FLANKS), speed=2.0)
    assert cams == select_scenes(["cam-follower"], [*LISTS, "speed=2"])
    assert list(family(SAW, crank=np.array([0.08, 0.09]))) == [f"{SAW.kind}-crank=0.08", f"{SAW.kind}-crank=0.09"]
    assert family(("mine", SAW), crank="80 mm") == {"mine": SAW.with_parameters(crank=0.08)}
    for given, says in {
        (): "crank: give at least one value",
        (0.08, "80mm"): "crank: '0.08' and '80mm' are the same value: give each once",
        (True,): "crank = 'True' is not a number",
    }.items():
        with pytest.raises(InvalidInput, match=f"^{says}"):
            family("saw-40rpm", crank=given)
    with pytest.raises(InvalidInput, match="unknown parameter 'crnk': did you mean 'crank'"):
        family("saw-40rpm", crnk=(1.0, 2.0))


def test_list_is_for_those_scenes_that_have_the_parameter() -> None:
    assert list(select_scenes(["saw-40rpm", "cam-follower"], ["crank=80mm,90mm"])) == [
        "saw-40rpm-crank=80mm", "saw-40rpm-crank=90mm", "cam-follower",
    ]  # fmt: skip


def test_member_has_a_name_that_a_file_can_have() -> None:
    slow, fast = family("saw-40rpm", speed=["4 rad/s", "2.5 rev/s"])
    assert (slow, fast) == ("saw-40rpm-speed=4rad_s", "saw-40rpm-speed=2.5rev_s")
    assert member_name("saw", {"rod_inertia": "0.02 kg m²"}) == "saw-rod_inertia=0.02kgm2"


def test_members_stand_in_the_order_of_their_numbers() -> None:
    names = [f"cam-follower-flank_radius={value}mm" for value in ("72.5", "88", "108")]
    assert sorted({*names}, key=part_order) == names
    assert sorted([*names, "cam-follower", "web-cutter"], key=part_order)[0] == "cam-follower"


def test_member_has_runs_of_its_own_shared_with_its_like() -> None:
    cases = [
        ValidationCase(name, one, "pymunk", "tuned", Plan(100, 1.0))
        for name, one in family("saw-40rpm", crank=["80mm", "90mm"]).items()
    ]
    alone = scene("saw-40rpm", crank="80mm")
    assert len({case.key for case in cases}) == 2
    assert cases[0].key == ValidationCase("saw-40rpm", alone, "pymunk", "tuned", Plan(100, 1.0)).key


# -- what cannot be used -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("assignment", "says"),
    {
        "base_radius=36mm,,46mm": "base_radius = '36mm,,46mm': value 2 of 3 is empty",
        "base_radius=36mm,": "base_radius = '36mm,': value 2 of 2 is empty",
        "base_radius=36mm,3.6cm": "base_radius: '36mm' and '3.6cm' are the same value: give each once",
        "base_radius=36mm,46kg": "base_radius = '46kg': 'kg' is not a unit of m; give for instance 80mm, 0.08 or 3.2in",
        "base_radius=36mm,wide": "base_radius = 'wide' is not a number; give for instance 80mm, 0.08 or 3.2in",
        "flank_radius=72,5mm": "flank_radius = '72,5mm': decimals are written with a point, as in '72.5mm'; in a list",
        "preload=20,25": "preload = '20,25': decimals are written with a point, as in '20.25'; in a list",
        "base_radius=36mm,120mm": "cam-follower-base_radius=120mm: centre_distance = 0.08 m gives no cam",
    }.items(),
)
def test_list_is_refused_in_a_line_that_names_the_value(assignment: str, says: str) -> None:
    assert refusal(assignment).startswith(says)


def test_list_of_plain_numbers_is_taken() -> None:
    assert split_values("preload", "20.0,25.0") == ("20.0", "25.0")
    assert split_values("preload", "20,25,30") == ("20", "25", "30")
    assert split_values("crank", "80 mm") == "80 mm"


def test_family_of_too_many_is_refused_with_numbers() -> None:
    many = ",".join(f"{k}.0" for k in range(1, 401))
    assert refusal(f"preload={many}", f"follower_mass={many}") == (
        "cam-follower: 400 of preload x 400 of follower_mass are 160000 machines, which are too many: there may be 1000"
    )
    several = ",".join(f"{k}.0" for k in range(1, MAX_MEMBERS))
    scenes = ("saw-40rpm", "saw-500rpm")
    assert refusal(f"speed={several}", scenes=scenes) == "1998 machines are too many: there may be 1000"


@pytest.mark.parametrize("command", ["show", "invariances"])
def test_verb_that_takes_one_machine_refuses_a_list(command: str) -> None:
    verb, *options = command.split()
    assert command_line.refusal(verb, "saw-40rpm", *options, "--set", "crank=80mm,90mm") == (
        "conrod: --set crank=80mm,90mm: one machine is taken here, not a family: give one value; `conrod validate` and "
        "`conrod sweep` take a list"
    )
    with pytest.raises(InvalidInput, match=r"^--set crank=80mm,90mm: one machine is taken here"):
        scene("saw-40rpm", crank="80mm,90mm")


# -- runs, verdicts and tables -----------------------------------------------------------------------------------------

SLIPPED = "cam-follower-base_radius=36mm-flank_radius=98mm"


def cams_in_pymunk(monkeypatch: pytest.MonkeyPatch) -> dict[str, SceneStudy]:
    """Findings on three cams, of which the engine runs the second with a flank radius 1 mm too long."""
    engine, cams = engine_named("pymunk"), family("cam-follower", base_radius=BASES[:1], flank_radius=FLANKS)
    run = engine.run

    def run_slipped(self: Any, machine: Any, *arguments: Any, **more: Any) -> Iterator[Any]:
        slipped = machine.with_parameters(flank_radius=machine.flank_radius + 1e-3)
        return run(slipped if machine == cams[SLIPPED] else machine, *arguments, **more)

    monkeypatch.setattr(type(engine), "run", run_slipped)
    study = validation_study(cams, [engine], {"pymunk": ("tuned",)}, Plan(1500, 1.0))
    (found,) = pursue([study], lambda cases: {case.key: case.perform() for case in cases})
    return {one.name: one for one in found}


def test_slip_in_one_member_is_out_of_tolerance_by_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    found = cams_in_pymunk(monkeypatch)
    assert [name for name, study in found.items() if not study.passed] == [SLIPPED]
    table = family_table(list(found.values()))
    assert table.headings == ("member", "pymunk kinematic mode", "pymunk tuned", "verdict")
    verdicts = {cell_text(row[0]): cell_text(row[-1]) for row in table.rows}
    assert verdicts == dict.fromkeys(found, "within tolerance") | {SLIPPED: "OUT OF TOLERANCE: pymunk tuned"}
    # The error of what is out of tolerance is shown in full, under the table of the family.
    shown = [part for part in results_to_print(list(found.values())) if not isinstance(part, str)]
    assert [[cell_text(row[0]) for row in part.rows] for part in shown[:2]] == [[*found], [SLIPPED]]  # type: ignore[union-attr]
    # What is only measured is said so, and is no verdict.
    measured = replace(found[SLIPPED], results=(replace(found[SLIPPED].results[1], passed=None),))
    assert cell_text(family_table([measured]).rows[0][-1]) == "not judged"
    assert "measured, not judged: pymunk tuned" in list(results_to_print([measured]))
    assert not [part for part in results_to_print(list(found.values())) if isinstance(part, str)]


# -- the command that makes a report again -----------------------------------------------------------------------------


def test_command_of_a_member_names_its_parameters(tmp_path: Any) -> None:
    options = {"--set": (*LISTS, "speed=2 rad/s"), "--preset": "tuned"}
    again = reproduction("validate", ["cam-follower", "six-bar"], options, ("--out", tmp_path))
    member = "cam-follower-base_radius=46mm-flank_radius=98mm"
    settings = "--set base_radius=46mm --set flank_radius=98mm --set 'speed=2 rad/s'"
    assert again.command_for(member) == f"conrod validate cam-follower {settings} --preset tuned --out {tmp_path}"
    assert again.command_for("six-bar").startswith("conrod validate six-bar --set 'speed=2 rad/s' --preset")
    assert again.command_for_all(again.typed) == (
        f"conrod validate cam-follower six-bar --set {LISTS[0]} --set {LISTS[1]} --set 'speed=2 rad/s' --preset tuned "
        f"--out {tmp_path}"
    )
    # Each of these commands is of the member itself.
    words = arguments_of_members(["cam-follower"], LISTS)[member]
    assert select_scenes(words[:1], [words[2], words[4]])["cam-follower"] == select_scenes(words[:1], LISTS)[member]
    assert arguments_of_members(["cam-follower"], ["speed=2"]) == {}
    assert reproduction("validate", ["six-bar"], {"--set": ("speed=2",)}, ("--out", tmp_path)).command_for(
        "six-bar"
    ) == (f"conrod validate six-bar --set speed=2 --out {tmp_path}")


@pytest.mark.slow
def test_family_is_a_row_and_a_page_each(tmp_path: Any) -> None:
    told = ("--engine", "pymunk", "--preset", "stock", "--steps-per-rev", "200", "--jobs", "1")
    saws, names = (
        ("validate", "saw-40rpm", "--set", "crank=80mm,100mm", *told),
        "saw-40rpm-crank=80mm saw-40rpm-crank=100mm",
    )
    ended = conrod(*saws, "--tolerance", "position=0.006", "--out", str(tmp_path), ledger=tmp_path / "ledger.sqlite")
    assert ended.returncode == 1, ended
    lines = [line for line in ended.stdout.splitlines() if line.startswith("saw") and "tolerance" in line.lower()]
    shown = [line.split() for line in lines]
    within = {line[0]: "within" in line for line in shown[:2]}
    assert within == dict(zip(names.split(), (True, False), strict=True)), ended.stdout
    assert {page.stem for page in tmp_path.glob("saw*.md")} == set(names.split())
