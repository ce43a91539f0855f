"""The report on ingredients: what it says, what a folder keeps of it, and that no engine is needed to make it."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from ablations import (
    COUNT,
    DOUBLED,
    MINIMAL_ERROR,
    OPEN,
    SCENE,
    ablation_study,
    alone,
    engine_study,
    ingredient,
    timing,
    variant,
)

from conrod.cli.ablate import print_ablation
from conrod.errors import InvalidInput
from conrod.report.ablate import words, writer
from conrod.report.ablate.document import check_ablate_apart, check_ablate_folder, earlier_ablations, merged
from conrod.report.ablate.figure import ingredients_figure
from conrod.report.ablate.writer import ablate_report_again, ablate_report_batch
from conrod.report.reproduction import Reproduction
from conrod.studies.ablate.cell import COUNTED
from conrod.studies.ablate.plan import Role
from conrod.studies.ablate.results import AblationStudy, EngineAblation, Gruebler, Verdict
from conrod.studies.frame.files import write_together

COMMAND = Reproduction("conrod ablate {scene} --out reports/ablate")


@pytest.fixture(scope="module")
def pages() -> dict[str, str]:
    """The files of a report of two engines."""
    study = ablation_study(engine_study(), engine_study("pymunk", "7.0.0"))
    batch = ablate_report_batch([study], Path("/nowhere"), COMMAND)
    return {name: str(text) for name, text in batch.files.items()}


def row(page: str, start: str) -> list[str]:
    """The cells of the first line of a table that begins so."""
    line = next(line for line in page.splitlines() if line.startswith(f"| {start}"))
    return [cell.strip() for cell in line.strip("|").split("|")]


def test_the_page_says_of_every_ingredient_cost_change_verdict_and_who_needs_it(pages: dict[str, str]) -> None:
    page = pages[f"{SCENE}.md"]
    costly = row(page, "`sensors`")
    assert costly[2:4] == ["1.20 (1.19 .. 1.21)", "1.30 (1.29 .. 1.31)"]
    assert costly[5] == "**costly**"
    harmful = row(page, "`noslip`")
    assert harmful[4] == "1.0e-6"
    assert harmful[5] == "**harmful** (position)"
    assert harmful[7] == "wear"
    required = row(page, "`closure`")
    assert "part of the minimal model" in required[1]
    assert required[5] == "**required** (opened)"
    assert required[7] == "drive torque, joint reactions"
    assert row(page, "`looks`")[5] == "**free**"
    assert row(page, "`looks`")[7] == "impact"
    for verdict in Verdict:
        assert f"**{verdict.slug}**: {verdict.meaning}" in page


def test_the_page_says_how_much_faster_the_minimal_model_is(pages: dict[str, str]) -> None:
    page = pages[f"{SCENE}.md"]
    assert "The minimal model is **1.80 times** as fast as the fully dressed one (1.79 .. 1.81)" in page
    assert "3.0e-11 in position, 3.0e-11 in velocity and 3.0e-11 in acceleration: they are equal within 1e-9." in page
    assert "Left out of it: `noslip`; it does harm alone." in page
    assert "1.80 (1.79 .. 1.8" in pages["README.md"]
    # Negative control: a motion that is not equal is not called so.
    found = engine_study()
    changed = {**(found.variants[5].change or {}), "velocity": 2e-9}
    other = replace(found, variants=(*found.variants[:5], replace(found.variants[5], change=changed)))
    assert "equal within" not in words.speed_up(other)
    assert "2.0e-9 in velocity" in words.speed_up(other)
    broken = replace(found.variants[5], outcome="opened", reason="a gap", change=None, cost=None)
    assert "did not run to its end: a gap" in words.speed_up(replace(found, variants=(broken,)))
    assert "no ingredient" in words.speed_up(replace(found, variants=found.variants[:1]))


def test_the_page_counts_as_gruebler_does_and_names_what_is_redundant_or_missing(pages: dict[str, str]) -> None:
    page = pages[f"{SCENE}.md"]
    assert "n = 4 links, j = 4 lower pairs, h = 0 higher pairs: 3 (n - 1) - 2 j - h = 9 - 8 = 1" in page
    minimal = row(page, "minimal, and all others")
    assert minimal[1:] == ["3", "3", "2", "1, as counted", "empty: slider-pin z", "none"]
    open_loop = row(page, "minimal - closure | 3")
    assert open_loop[4:] == ["3, **Gruebler: 1**", "none", "2, of closure"]
    assert words.redundant_text(DOUBLED) == "redundant: 2 of slider-pin/again; empty: slider-pin z"
    assert words.redundant_text(OPEN) == "none"
    assert words.missing_text(OPEN, []) == "2"
    assert f"at {COUNTED} crank angles" in page
    assert words.freedom_text(replace(COUNT, least_rank=1), 1) == "1 (2 at some poses), as counted"
    assert words.gruebler_text(Gruebler(3, 2, 1, 1)).endswith("= 6 - 4 - 1 = 1")


def test_what_makes_a_right_motion_better_is_said_to_though_it_is_not_required() -> None:
    fine = engine_study()
    rough, finer = variant(Role.MINIMAL, error=1e-5), variant(Role.ADDED, "sensors", 1e-7, 1e-5)
    costly = fine.ingredients[1]
    found = replace(fine, variants=(rough, finer))
    assert words.finer_text(found, costly) == "position 100 times as accurate with it"
    part = replace(costly, minimal=True)
    assert words.finer_text(replace(fine, variants=(replace(finer, role="minimal", ingredient=""),)), part) == ""
    lacking = replace(fine, variants=(variant(Role.MINIMAL), variant(Role.REDUCED, "sensors", 4e-9, 4e-9)))
    assert words.finer_text(lacking, part) == "position 4.0 times as accurate with it"
    # Negative controls: below 1e-9 nothing is better, no better is not said to be, and what is required is no extra.
    assert words.finer_text(fine, costly) == ""
    assert words.finer_text(replace(fine, variants=(rough, replace(finer, errors=rough.errors))), costly) == ""
    assert words.finer_text(found, replace(costly, verdict="required")) == ""


def test_every_model_is_told_with_its_errors_and_how_it_ended(pages: dict[str, str]) -> None:
    page = pages[f"{SCENE}.md"]
    for name in ("minimal", "fully dressed", "fully dressed - sensors", "fully dressed + noslip", "all ingredients"):
        assert row(page, f"{name} | `completed`")[3] in ("4.0e-11", "1.0e-6")
    assert row(page, "minimal - closure")[1] == "`opened`: a gap of 0.4 m"
    assert row(page, "minimal - closure")[3] == "n/a"


def test_the_index_has_a_column_for_every_machine(pages: dict[str, str]) -> None:
    index = pages["README.md"]
    assert "### MuJoCo" in index
    assert "### pymunk" in index
    assert row(index, "`noslip`")[2:] == ["harmful", "wear"]
    assert f"`{COMMAND.of(SCENE)}`" in index


def test_torque_and_time_saved_are_told_in_words() -> None:
    seen = alone(MINIMAL_ERROR, 0.0, 1.0)
    gravity = ingredient("gravity", (replace(seen, torque_effect="needed"),), needed_by=("wear",))
    assert words.torque_text(gravity) == "required"
    assert words.needs_text(gravity) == "drive torque, wear"
    damping = ingredient("damping", (replace(seen, torque_effect="changed", torque_change=0.02),))
    assert words.torque_text(damping) == "changes it, by 0.020"
    beside = replace(seen, torque_effect="changed", torque_change=0.03, full=True)
    both = ingredient("damping", (replace(seen, torque_effect="none"), beside))
    assert words.torque_text(both) == "changes it, by 0.030 (beside all others)"
    assert words.torque_text(ingredient("looks", (replace(seen, torque_effect="none"),))) == "no change"
    assert words.torque_text(ingredient("looks", (seen,))) == "n/a"
    assert not words.saves_time(ingredient("looks", (seen,)))
    assert words.saves_time(ingredient("a faster one", (replace(seen, cost=timing(0.8)),)))
    assert words.cost_text(timing(140.8, 20.0)) == "140.8 (120.8 .. 160.8)"
    assert words.cost_text(None) == "n/a"


def test_the_console_has_a_line_for_every_ingredient(capsys: pytest.CaptureFixture[str]) -> None:
    print_ablation([ablation_study()])
    printed = capsys.readouterr().out
    for text in ("saw-500rpm, mujoco", "noslip", "harmful (position)", "required (opened)", "costly", "1.80 times"):
        assert text in printed


def test_a_figure_names_every_ingredient_and_every_verdict() -> None:
    figure = ingredients_figure(engine_study())
    assert figure is not None
    costs, changes = figure.axes
    shown = [label.get_text() for label in costs.get_yticklabels()]
    assert shown == ["added", "looks", "sensors", "noslip", "part of the minimal model", "closure"]
    texts = [text.get_text() for text in changes.texts]
    assert [text for text in texts if "without" not in text] == ["free", "costly", "harmful", "required"]
    assert "opened without it" in texts
    low, high = costs.get_xlim()
    assert low < 1.0
    assert high > 1.3
    assert ingredients_figure(replace(engine_study(), ingredients=())) is None


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures by name alone: drawing them is what takes long."""
    monkeypatch.setattr(writer, "ablate_figures", lambda study: {found.engine: "<svg/>" for found in study.engines})


# -- folders ---------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("undrawn")
def test_one_engine_after_the_other_adds_up_to_both(tmp_path: Path) -> None:
    one = Reproduction("conrod ablate {scene} --engine mujoco --out reports/ablate")
    other = Reproduction("conrod ablate {scene} --engine pymunk --out reports/ablate")
    write_together([ablate_report_batch([ablation_study()], tmp_path, one)])
    write_together([ablate_report_batch([ablation_study(engine_study("pymunk"))], tmp_path, other)])
    entry = earlier_ablations(tmp_path)[SCENE]
    kept = AblationStudy.of(entry["study"])
    assert [found.engine for found in kept.engines] == ["mujoco", "pymunk"]
    assert len(entry["commands"]) == 2
    assert (tmp_path / "figures" / f"{SCENE}-mujoco.svg").is_file()
    assert "## MuJoCo" in (tmp_path / f"{SCENE}.md").read_text()
    # A study of both again: nothing of the two remains.
    both = ablation_study(engine_study(), engine_study("pymunk"))
    write_together([ablate_report_batch([both], tmp_path, COMMAND)])
    assert earlier_ablations(tmp_path)[SCENE]["commands"] == [COMMAND.of(SCENE)]


@pytest.mark.usefixtures("undrawn")
def test_nothing_is_kept_of_another_machine_and_its_figure_goes(tmp_path: Path) -> None:
    both = ablation_study(engine_study(), engine_study("pymunk"))
    write_together([ablate_report_batch([both], tmp_path, COMMAND)])
    longer = ablation_study(parameters={"crank": 0.1, "rod": 0.5})
    assert merged(both, longer) == longer
    batch = ablate_report_batch([longer], tmp_path, COMMAND)
    assert batch.obsolete == (f"figures/{SCENE}-pymunk.svg",)
    assert ablate_report_batch([both], tmp_path, COMMAND).obsolete == ()


@pytest.mark.usefixtures("undrawn")
def test_other_scenes_of_the_folder_stay_in_its_index(tmp_path: Path) -> None:
    write_together([ablate_report_batch([ablation_study()], tmp_path, COMMAND)])
    batch = ablate_report_batch([ablation_study(name="saw-40rpm")], tmp_path, COMMAND)
    assert f"{SCENE}.md" not in batch.files
    index = str(batch.files["README.md"])
    assert row(index, "`noslip`")[2:] == ["harmful", "harmful", "wear"]
    assert set(json.loads(str(batch.files["results.json"]))["ablations"]) == {SCENE, "saw-40rpm"}


@pytest.mark.usefixtures("undrawn")
def test_a_folder_of_something_else_is_refused(tmp_path: Path) -> None:
    check_ablate_folder(tmp_path, [SCENE])
    write_together([ablate_report_batch([ablation_study()], tmp_path / "ablate", COMMAND)])
    check_ablate_folder(tmp_path / "ablate", [SCENE])
    (tmp_path / "results.json").write_text('{"schema": 1, "sweeps": {}}')
    with pytest.raises(InvalidInput, match="not a report on ingredients"):
        check_ablate_folder(tmp_path, [SCENE])
    with pytest.raises(InvalidInput, match="has a file of that name"):
        check_ablate_apart(tmp_path / "ablate" / f"{SCENE}.md", tmp_path / "ablate", [])


def test_an_entry_of_another_version_is_not_taken_over(tmp_path: Path) -> None:
    document = {"schema": 1, "ablations": {SCENE: {"study": {"engines": []}, "commands": []}}}
    (tmp_path / "results.json").write_text(json.dumps(document))
    assert earlier_ablations(tmp_path) == {}


WITHOUT_ENGINES = """
import sys
sys.modules["mujoco"] = sys.modules["pymunk"] = None  # importing either fails
from pathlib import Path
from conrod.report.ablate.writer import ablate_report_again
folder = Path(sys.argv[1])
batch = ablate_report_again(folder)
assert len(batch.files) == 4, list(batch.files)
for name, text in batch.files.items():
    assert (folder / name).read_text(encoding="utf-8") == text, name
"""


def test_a_report_is_rendered_again_from_its_results_without_any_engine(tmp_path: Path) -> None:
    write_together([ablate_report_batch([ablation_study()], tmp_path, COMMAND)])
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_ENGINES, str(tmp_path)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    with pytest.raises(ValueError, match="holds no report"):
        ablate_report_again(tmp_path / "nowhere")


def test_results_are_read_back_as_they_were_written() -> None:
    study = ablation_study()
    assert AblationStudy.of(json.loads(json.dumps(study.as_dict()))) == study
    found: EngineAblation = study.engines[0]
    assert found.variant(Role.DRESSED.value) is not None
    assert found.variant(Role.TAKEN.value, "nothing") is None
