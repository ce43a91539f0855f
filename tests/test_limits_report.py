"""The report of limits: quiet runs come first, boundaries are drawn where they are, and it renders from its file."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from conrod.errors import InvalidInput
from conrod.files import Batch, write_together
from conrod.report.canvas import drawing_style
from conrod.report.limits import writer
from conrod.report.limits.axis_scale import AxisScale, place
from conrod.report.limits.axis_section import axis_section
from conrod.report.limits.boundaries_table import boundaries_table, refusals
from conrod.report.limits.boundary_chart import boundary_chart, preset_lanes
from conrod.report.limits.determinism_table import determinism_table
from conrod.report.limits.document import check_limits_folder, earlier_limits, rounded
from conrod.report.limits.error_chart import POSITION, TORQUE, error_chart
from conrod.report.limits.findings import findings
from conrod.report.limits.gallery_table import gallery_table
from conrod.report.limits.long_run_figure import long_run_figure
from conrod.report.limits.marks import LEVEL_COLOURS, OUTCOME_MARKS, QUIET_COLOUR
from conrod.report.limits.merging import merged
from conrod.report.limits.plain_words import sentences
from conrod.report.limits.quiet_table import quiet_ranges, quiet_summary, quiet_table
from conrod.report.limits.steps_table import steps_table
from conrod.report.limits.writer import limits_report_again, limits_report_batch
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.axis import Scale
from conrod.studies.limits.grade import Level
from conrod.studies.limits.results import Walk
from conrod.studies.limits.study import LimitStudy
from conrod.studies.limits.walk import CRITERIA, boundary_of
from conrod.trajectory import Outcome
from limit_studies import (
    SCENE,
    exhibit,
    limit_study,
    listed,
    long_run,
    mass_walks,
    nearness_walks,
    of_axis,
    pose_walks,
    probe,
    regularisation_walks,
    renamed,
    same_again,
    steps_walks,
    walked,
)

COMMAND = "conrod limits {scene} --out reports/limits"
GALLERY = (exhibit("completed"), exhibit("opened", quiet=True, solver="stopped after 0 iterations"))


@pytest.fixture(scope="module")
def study() -> LimitStudy:
    return limit_study()


@pytest.fixture(scope="module")
def batch(study: LimitStudy, tmp_path_factory: pytest.TempPathFactory) -> Batch:
    """The whole report, rendered once."""
    return limits_report_batch([study], GALLERY, tmp_path_factory.mktemp("limits"), COMMAND)


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures by name alone: drawing them is what takes long."""
    monkeypatch.setattr(writer, "limits_figures", lambda study: {w.axis: "<svg/>" for w in study.walks if w.probes})


def quietened(walks: Sequence[Walk]) -> list[Walk]:
    """The same walks, had every engine warned."""
    return [
        replace(
            walk,
            probes=tuple(replace(p, quiet=False) for p in walk.probes),
            boundaries=tuple(replace(b, quiet=False) for b in walk.boundaries),
        )
        for walk in walks
    ]


# -- the boundary chart ------------------------------------------------------------------------------------------------


def charted(walks: Sequence[Walk]) -> Axes:
    with drawing_style():
        figure = boundary_chart(preset_lanes(walks))
    assert figure is not None
    return figure.axes[0]


def bars(axes: Axes, lane: int) -> list[tuple[str, float, float]]:
    """Colour, left and right end of the bars of a lane."""
    found = [patch for patch in axes.patches if isinstance(patch, Rectangle)]
    inside = [p for p in found if p.get_y() < lane < p.get_y() + p.get_height()]
    return [(to_hex(p.get_facecolor()), p.get_x(), p.get_x() + p.get_width()) for p in inside]


def test_a_bar_changes_its_colour_at_the_boundary() -> None:
    # Places are decades, so a bar's left end in numbers is its right end in the figure.
    (safe, leaves, first), (rough, breaks, _), (unbounded, last, _) = bars(charted(steps_walks()), 1)
    assert [safe, rough, unbounded] == [LEVEL_COLOURS[level] for level in ("safe", "rough", "unbounded")]
    assert [round(10.0**end, -1) for end in (first, last)] == [20000, 0]
    assert 59.0 < 10.0**leaves < 60.0
    assert 24.0 < 10.0**breaks < 25.0


@pytest.mark.parametrize(
    "walks", [steps_walks(), nearness_walks(), regularisation_walks()[:1]], ids=lambda w: w[0].axis
)
def test_the_harmless_end_is_on_the_left(walks: Sequence[Walk]) -> None:
    scale = AXES[walks[0].axis].scale
    left, right = charted(walks).get_xlim()
    harmless, hopeless = (place(scale, p.value) for p in (walks[0].probes[0], walks[0].probes[-1]))
    assert abs(left - harmless) < abs(left - hopeless)
    assert abs(right - hopeless) < abs(right - harmless)


def test_two_ways_from_one_value_share_a_bar() -> None:
    axes = charted(mass_walks())
    assert [text.get_text() for text in axes.get_yticklabels()] == ["MuJoCo stock", "pymunk stock"]
    left, right = axes.get_xlim()
    assert left < -6.0 < 6.0 < right
    spans = sorted((start, end) for _, start, end in bars(axes, 0))
    assert all(one[1] == pytest.approx(other[0]) for one, other in pairwise(spans))


def red_lines(axes: Axes) -> int:
    return sum(line.get_color() == QUIET_COLOUR for line in axes.lines)


def test_quiet_stretches_stand_out_and_only_they() -> None:
    walks = steps_walks()
    quiet = sum(probe.quiet for walk in walks for probe in walk.probes)
    assert quiet > 0
    assert red_lines(charted(walks)) == 5  # wrong and opened with MuJoCo; wrong, flipped and opened with pymunk
    assert red_lines(charted(quietened(walks))) == 0


def test_every_run_is_a_tick_and_every_way_of_failing_has_its_mark() -> None:
    walks = steps_walks()
    axes = charted(walks)
    ticks = sum(len(collection.get_paths()) for collection in axes.collections)
    assert ticks == sum(len(walk.probes) for walk in walks)
    drawn = {line.get_marker() for line in axes.lines} - {"None"}
    ended = {probe.outcome for walk in walks for probe in walk.probes} - {"completed"}
    assert drawn == {OUTCOME_MARKS[outcome] for outcome in ended}


def legend_of(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_the_legend_names_what_occurs_and_nothing_else() -> None:
    with drawing_style():
        figure = boundary_chart(preset_lanes(mass_walks()))
    assert figure is not None
    assert legend_of(figure) == [
        "safe",
        "rough",
        "wrong",
        "unbounded",
        "quiet: nothing says so",
        "exploded",
        "a run",
    ]


def test_levels_are_told_apart_without_colour() -> None:
    def lightness(colour: str) -> float:
        return sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), to_rgb(colour), strict=True))

    shades = [lightness(LEVEL_COLOURS[level.slug]) for level in Level]
    assert all(lighter - darker > 0.1 for lighter, darker in pairwise(shades))


def test_every_failure_has_a_mark_of_its_own() -> None:
    failures = {outcome.slug for outcome in Outcome} - {Outcome.COMPLETED.slug}
    assert set(OUTCOME_MARKS) == failures
    assert len(set(OUTCOME_MARKS.values())) == len(failures)


@pytest.mark.parametrize("axis", AXES.values(), ids=lambda axis: axis.name)
def test_every_axis_can_be_drawn_from_end_to_end(axis: object) -> None:
    assert isinstance(axis, type(AXES["steps"]).__mro__[1])
    if axis.scale is Scale.LISTED:
        walks = [listed(axis.name, "mujoco", "stock", [probe(v, "safe", "completed", False, 1e-3) for v in (0.0, 1.0)])]
        with drawing_style():
            figure = error_chart(walks)
        assert figure is not None
        axes = figure.axes[0]
    else:
        part = (axis.hopeless, "safe", "completed", False, 1e-3)
        axes = charted([walked(axis.name, "mujoco", "stock", axis.harmless, [part], axis.scale)])
    assert axes.get_xlabel() == axis.label
    assert 2 <= len(axes.get_xticks()) <= 16
    low, high = sorted(axes.get_xlim())
    assert all(low <= tick <= high for tick in axes.get_xticks())


def test_nearness_has_ticks_down_to_the_last_nine() -> None:
    scale = AxisScale.of(Scale.NEARNESS, nearness_walks())
    ticks = scale.ticks()
    assert ticks[0] == 0.1
    assert ticks[-1] == pytest.approx(1.0 - 1e-9, abs=1e-12)


# -- errors along an axis ----------------------------------------------------------------------------------------------


def panels(walks: Sequence[Walk], *of: object, ruler: bool = False) -> list[Axes]:
    with drawing_style():
        figure = error_chart(walks, of or (POSITION,), ruler)  # type: ignore[arg-type]  # panels
    assert figure is not None
    return figure.axes


def test_the_drive_torque_has_a_panel_where_it_is_known() -> None:
    axes = panels(regularisation_walks(), TORQUE, POSITION)
    assert [a.get_ylabel() for a in axes] == ["drive torque error, max / peak", "position error, max / L"]
    # Negative control: steps have no torque, and no empty panel either.
    assert len(panels(steps_walks(), TORQUE, POSITION)) == 1


def test_the_reference_is_drawn_where_it_is_in_doubt() -> None:
    def black(walks: Sequence[Walk]) -> int:
        return sum(line.get_color() == "black" for line in panels(walks, ruler=True)[0].lines)

    assert black(nearness_walks()) == 1
    assert black(steps_walks()) == 0


def test_runs_of_a_list_that_did_not_complete_stand_above_it() -> None:
    def above(walks: Sequence[Walk]) -> int:
        return sum(line.get_marker() == OUTCOME_MARKS["flipped"] for line in panels(walks)[0].lines)

    assert above(pose_walks()) == 3
    assert above(pose_walks()[1:]) == 0


def test_long_runs_show_loop_error_and_both_clocks() -> None:
    with drawing_style():
        figure = long_run_figure([long_run("mujoco", "tuned", revolutions=1e6)])
    assert figure is not None
    loop, phase = figure.axes
    assert len(loop.lines) == 1
    assert len([line for line in phase.lines if line.get_color() == "black"]) == 1
    assert len(phase.lines) == 2
    assert loop.get_xlim()[1] > 1e6
    assert long_run_figure([]) is None


# -- words -------------------------------------------------------------------------------------------------------------


def test_the_page_says_safe_here_wrong_but_quiet_there_broken_there() -> None:
    said = sentences(steps_walks())
    assert said[0] == (
        "MuJoCo `stock`: rough down to 200 steps, **wrong but quiet** from 199 to 31 steps, **broken but quiet** "
        "(opened) from 30 to 12 steps, unbounded (diverged) from 11 steps on."
    )
    # Presets that behave alike are told once.
    assert "MuJoCo `tuned`; pymunk `tuned`: safe down to 60 steps" in said[1]
    assert len(said) == 4


def test_a_warning_makes_a_wrong_run_loud() -> None:
    said = " ".join(sentences(quietened(steps_walks())))
    assert "quiet" not in said
    assert "wrong, and the engine warns from 199 to 31 steps" in said


def test_both_directions_are_told_apart() -> None:
    said = sentences(mass_walks())
    assert [text for text in said if "towards 1e+06: safe up to 30" in text]
    assert [text for text in said if "towards 1e-06: safe down to 0.01" in text]


def test_presets_that_fail_alike_at_other_values_are_told_together_where_that_is_short() -> None:
    walks = [
        walked("mass-ratio", "mujoco", preset, 1.0, ((good, "safe", "completed", False, 1e-4), (1e6, *EXPLODED)))
        for preset, good in (("stock", 10.0), ("tuned", 100.0))
    ]
    (said,) = sentences(walks)
    assert "safe up to 10 (`stock`) or 100 (`tuned`), unbounded (exploded) from 10.15 (`stock`) or" in said


EXPLODED = ("unbounded", "exploded", False, None)


def flickering() -> Walk:
    """Safe and opened in turn, from 100 on."""
    ends = [("safe", "completed", False, 1e-4), ("broken", "opened", True, None)]
    probes = tuple(probe(2.0**k, *ends[k % 2 if k > 3 else 0]) for k in range(12))
    return Walk("mass-ratio", SCENE, "pymunk", "stock", "", probes, tuple(boundary_of(probes, c) for c in CRITERIA))


def test_what_comes_and_goes_is_not_told_value_by_value() -> None:
    (said,) = sentences([flickering()])
    assert (
        said == "pymunk `stock`: safe up to 16, from 32 on it comes and goes: **broken but quiet** (opened) and safe."
    )
    assert "16 *" in boundaries_table([flickering()])
    assert "keep the criterion again" in boundaries_table([flickering()])
    assert " *" not in boundaries_table(steps_walks())


def test_lists_are_told_by_their_number() -> None:
    said = sentences(pose_walks())
    assert "MuJoCo `stock`: safe in 69 of 72 runs, **broken but quiet** (flipped) in 3 of 72 runs." in said
    assert "MuJoCo `tuned`; pymunk `stock`: safe throughout (72 runs)." in said


# -- what is dangerous -------------------------------------------------------------------------------------------------


def test_quiet_runs_come_first_and_those_in_one_piece_before_all(study: LimitStudy) -> None:
    ranges = quiet_ranges(study.walks)
    levels = [one.level for one in ranges]
    assert levels == sorted(levels, key=["wrong", "broken", "unbounded"].index)
    # None is lost, and none is counted twice.
    assert sum(len(one.probes) for one in ranges) == sum(p.quiet for walk in study.walks for p in walk.probes)
    assert quiet_table(quietened(study.walks)) == quiet_summary(quietened(study.walks)) == ""


def test_a_quiet_range_says_where_how_and_how_far_off() -> None:
    row = next(line for line in quiet_table(steps_walks()).splitlines() if "pymunk" in line)
    assert row == "| Steps per revolution | pymunk | stock | 79 .. 20 steps | wrong | ran to its end | 0.70 |"


def test_scattered_values_of_a_list_are_one_row() -> None:
    (one,) = quiet_ranges(pose_walks())
    assert one.where == "3 of 72: 0, 125, 250"
    assert len(one.probes) == 3


@pytest.mark.usefixtures("undrawn")
def test_the_report_names_the_quiet_runs_before_anything_else(study: LimitStudy, tmp_path: Path) -> None:
    files = limits_report_batch([study], GALLERY, tmp_path, COMMAND).files
    for name in ("README.md", f"{SCENE}.md"):
        text = str(files[name])
        assert text.index("## Wrong, and nothing says so") == text.index("## "), name
        assert "199 .. 31 steps" in text
    calm = replace(study, walks=tuple(quietened(study.walks)))
    text = str(limits_report_batch([calm], (), tmp_path, COMMAND).files[f"{SCENE}.md"])
    assert "No run was wrong without a sign of it" in text
    assert "**wrong but quiet**" not in text


def test_findings_are_made_of_the_walks() -> None:
    said = findings(steps_walks())
    assert said[1] == (
        "**Steps per revolution**, 20000 .. 2 steps: within 10 % furthest with MuJoCo `hardened` (down to 5 steps), "
        "least far with MuJoCo `stock` (down to 200 steps); 2 of 5 leave it quietly."
    )
    assert "within 10 % furthest with MuJoCo `tuned`; pymunk `tuned` (down to 25 steps)" in " ".join(
        findings([walk for walk in steps_walks() if walk.preset != "hardened"])
    )
    assert said[0].startswith("**Wrong, and nothing says so:** 15 of 86 runs, on 2 of 5 walks")
    assert findings([]) == []


# -- tables ------------------------------------------------------------------------------------------------------------


def test_steps_at_which_an_engine_leaves_and_breaks() -> None:
    rows = steps_table([*steps_walks(), *mass_walks()]).splitlines()[2:]
    assert len(rows) == 5
    assert rows[3] == (
        f"| {SCENE} | pymunk | stock | 400 (399: rough) | 80 (79: wrong, quiet) | 20 (19: flipped, quiet) | all of it |"
    )
    assert "none of it (20000: rough)" in rows[0]


def test_the_solver_that_stopped_early_is_in_the_table() -> None:
    text = boundaries_table(regularisation_walks())
    assert "stopped after 0 iterations: 1e-10 .. 1e-15 (7 of 15 runs)" in text
    assert "its solver" not in boundaries_table(steps_walks())


def test_few_values_of_a_list_have_a_column_each() -> None:
    runs = [
        probe(0.0, "safe", "completed", False, 1e-3, text="double precision"),
        probe(1.0, "wrong", "completed", True, 0.2, text="single precision"),
    ]
    head, _, row = boundaries_table([listed("rounding", "mujoco", "stock", runs)]).splitlines()
    assert head.count("precision") == 2
    assert row == "| MuJoCo | stock | 0.0010 | 0.20 (quiet) |"
    assert "72" in boundaries_table(pose_walks())


def test_refusals_are_told_once_with_those_they_are_for() -> None:
    said = refusals(regularisation_walks())
    assert said == ["Not walked with pymunk `stock` and `tuned`: pymunk does not regularise."]
    section = axis_section("regularisation", regularisation_walks(), lambda name, text: "")
    assert said[0] in section
    assert "least, by 5.6e-10, at 5.623e-07" in section


def test_determinism_says_what_was_different() -> None:
    rows = determinism_table([same_again("mujoco", "stock"), same_again("pymunk", "stock", across=False)])
    one, other = rows.splitlines()[2:]
    assert one.count("identical") == 3
    assert "**different**" in other
    assert "**different**" not in one


def test_the_gallery_says_what_told_of_an_end_and_which_is_not_shown() -> None:
    warned = exhibit("diverged", warnings={"BADQACC": 1}, finite=False)
    text = gallery_table([exhibit("opened", quiet=True), warned, exhibit("crashed", finite=None)])
    assert text.index("`diverged`") < text.index("`opened`") < text.index("`crashed`")
    assert "**nothing: quiet**" in text
    assert "the engine warns: BADQACC; numbers that are not finite" in text
    assert "there is no trajectory" in text
    assert "No run shows `completed`" in text
    every = gallery_table([exhibit(outcome.slug) for outcome in Outcome])
    assert "No run shows" not in every
    assert "expected" not in every
    assert "`opened`, **expected `flipped`**" in gallery_table([exhibit("opened", expected="flipped")])


# -- the files ---------------------------------------------------------------------------------------------------------


def test_the_report_is_whole(study: LimitStudy, batch: Batch) -> None:
    for name in ("README.md", f"{SCENE}.md"):
        links = re.findall(r"\]\(([^)]+)\)", str(batch.files[name]))
        assert links
        assert not [link for link in links if link not in batch.files]
    drawings = {name: str(text) for name, text in batch.files.items() if name.endswith(".svg")}
    assert {name for name in drawings if name not in str(batch.files[f"{SCENE}.md"])} == set()
    for text in drawings.values():
        ElementTree.fromstring(text)
    for axis in {walk.axis for walk in study.walks if walk.probes}:
        assert f"figures/{SCENE}-{axis}.svg" in drawings


def test_rows_keep_to_their_columns(batch: Batch) -> None:
    for name in ("README.md", f"{SCENE}.md"):
        for block in str(batch.files[name]).split("\n\n"):
            if block.startswith("| "):
                widths = {len(re.findall(r"(?<!\\)\|", line)) for line in block.splitlines()}
                assert len(widths) == 1, block[:200]


def test_words_are_explained_once(batch: Batch) -> None:
    for name in ("README.md", f"{SCENE}.md"):
        for level in Level:
            assert str(batch.files[name]).count(f"- *{level.slug}*: {level.meaning}") == 1


def test_powers_of_ten_are_written_as_in_the_figures(batch: Batch) -> None:
    page = str(batch.files[f"{SCENE}.md"])
    assert "1 .. 1e6" in page
    assert "1 .. 1e-6" in page
    assert re.search(r"\de[+-]0\d", page) is None


@pytest.mark.usefixtures("undrawn")
def test_parts_that_were_not_asked_for_are_left_out(study: LimitStudy, tmp_path: Path) -> None:
    whole = str(limits_report_batch([study], GALLERY, tmp_path, COMMAND).files[f"{SCENE}.md"])
    alone = str(limits_report_batch([of_axis(study, "steps")], (), tmp_path, COMMAND).files[f"{SCENE}.md"])
    for section in ("## Long runs", "## The same again?", "## Two axes at once", "## What was not walked, and why"):
        assert section in whole
        assert section not in alone
    assert "### Steps per revolution" in alone


def small(study: LimitStudy) -> LimitStudy:
    """Few figures, and a part of every kind that has none."""
    return replace(of_axis(study, "mass-ratio"), determinism=study.determinism, needs=study.needs)


def test_the_same_study_gives_the_same_bytes(study: LimitStudy, tmp_path: Path) -> None:
    batch, again = (limits_report_batch([small(limit_study())], GALLERY, tmp_path, COMMAND) for _ in range(2))
    assert again.files == batch.files
    # Negative control: another measurement is seen.
    other = replace(study, walks=tuple(quietened(study.walks)))
    assert limits_report_batch([small(other)], GALLERY, tmp_path, COMMAND).files != batch.files


def test_a_saved_report_renders_without_any_engine(study: LimitStudy, tmp_path: Path) -> None:
    batch = limits_report_batch([small(study)], GALLERY, tmp_path, COMMAND)
    write_together([batch])
    for name in batch.files:
        if name != "results.json":
            (tmp_path / name).unlink()
    # In a process in which no engine can be imported; that it cannot is looked at too.
    code = (
        "import sys; from pathlib import Path\n"
        "class Absent:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name.split('.')[0] in ('mujoco', 'pymunk'): raise ImportError(name)\n"
        "sys.meta_path.insert(0, Absent())\n"
        "from conrod.files import write_together\n"
        "from conrod.report.limits.writer import limits_report_again\n"
        f"write_together([limits_report_again(Path({str(tmp_path)!r}))])\n"
        "from conrod.engines import engine_named\n"
        "try: engine_named('pymunk')\n"
        "except ImportError: print('no engine')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120)
    assert done.stdout.strip() == "no engine"
    assert {name: (tmp_path / name).read_text(encoding="utf-8") for name in batch.files} == batch.files


def test_without_a_saved_report_there_is_none_to_render(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no report of limits"):
        limits_report_again(tmp_path)


def test_values_are_kept_as_they_are_and_measurements_rounded(study: LimitStudy, batch: Batch) -> None:
    kept = LimitStudy.of(json.loads(str(batch.files["results.json"]))["limits"][SCENE]["study"])
    assert [[p.value for p in walk.probes] for walk in kept.walks] == [
        [p.value for p in walk.probes] for walk in study.walks
    ]
    assert [walk.boundaries for walk in kept.walks] == [walk.boundaries for walk in study.walks]
    assert kept.determinism == study.determinism
    assert kept.parameters == dict(study.parameters)
    assert rounded({"value": 0.123456789, "torque": 0.123456789}) == {"value": 0.123456789, "torque": 0.1235}


# -- what a folder holds -----------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("undrawn")
def test_scenes_of_an_earlier_report_stay(study: LimitStudy, tmp_path: Path) -> None:
    write_together([limits_report_batch([study], GALLERY, tmp_path, COMMAND)])
    batch = limits_report_batch([renamed(study, "saw-40rpm")], (), tmp_path, COMMAND)
    index = str(batch.files["README.md"])
    assert f"[{SCENE}]({SCENE}.md)" in index
    assert "## Every way of ending" in index  # the gallery stays as well
    assert f"{SCENE}.md" not in batch.files
    assert set(json.loads(str(batch.files["results.json"]))["limits"]) == {SCENE, "saw-40rpm"}
    assert f"`{COMMAND.replace('{scene}', f'saw-40rpm {SCENE}')}`" in index


@pytest.mark.usefixtures("undrawn")
def test_one_axis_alone_replaces_that_axis_alone(study: LimitStudy, tmp_path: Path) -> None:
    write_together([limits_report_batch([study], GALLERY, tmp_path, COMMAND)])
    again = of_axis(study, "mass-ratio")
    walks = (replace(w, probes=tuple(replace(p, key="new") for p in w.probes)) for w in again.walks)
    alone = replace(again, walks=tuple(walks))
    command = "conrod limits {scene} --axis mass-ratio --out reports/limits"
    write_together([limits_report_batch([alone], (), tmp_path, command)])
    entry = earlier_limits(tmp_path)[SCENE]
    kept = LimitStudy.of(entry["study"])
    assert [(w.axis, w.engine, w.preset) for w in kept.walks] == [(w.axis, w.engine, w.preset) for w in study.walks]
    assert {w.axis for w in kept.walks if any(p.key == "new" for p in w.probes)} == {"mass-ratio"}
    assert {w.axis for w in kept.walks if any(p.key != "new" for p in w.probes)} == {
        walk.axis for walk in study.walks if walk.probes
    } - {"mass-ratio"}
    assert kept.determinism == study.determinism
    assert len(entry["commands"]) == 2
    # The same study whole again: nothing of the two remains.
    write_together([limits_report_batch([study], (), tmp_path, COMMAND)])
    assert earlier_limits(tmp_path)[SCENE]["commands"] == [COMMAND.replace("{scene}", SCENE)]


def test_nothing_is_kept_of_another_machine_or_another_engine(study: LimitStudy) -> None:
    steps = of_axis(study, "steps")
    assert merged(study, steps) == study
    assert merged(study, replace(steps, parameters={**study.parameters, "rod": 9.0})).walks == steps.walks
    newer = merged(study, replace(steps, engines={**study.engines, "pymunk": "8.0.0"}))
    assert {walk.axis for walk in newer.walks if walk.engine == "pymunk"} == {"steps"}
    assert {walk.axis for walk in newer.walks if walk.engine == "mujoco"} == {walk.axis for walk in study.walks}
    # One engine alone leaves the other one's walks.
    mujoco = tuple(walk for walk in steps.walks if walk.engine == "mujoco")
    one = merged(study, replace(steps, walks=mujoco, engines={"mujoco": "4.0.0"}))
    assert one.walks == study.walks
    assert dict(one.engines) == dict(study.engines)


@pytest.mark.usefixtures("undrawn")
def test_a_figure_that_is_no_longer_shown_goes(study: LimitStudy, tmp_path: Path) -> None:
    write_together([limits_report_batch([study], GALLERY, tmp_path, COMMAND)])
    assert limits_report_batch([study], GALLERY, tmp_path, COMMAND).obsolete == ()
    other = replace(of_axis(study, "steps"), parameters={**study.parameters, "rod": 9.0})
    gone = limits_report_batch([other], (), tmp_path, COMMAND).obsolete
    assert f"figures/{SCENE}-nearness.svg" in gone
    assert f"figures/{SCENE}-steps.svg" not in gone


@pytest.mark.usefixtures("undrawn")
def test_a_folder_of_something_else_is_refused(study: LimitStudy, tmp_path: Path) -> None:
    check_limits_folder(tmp_path, [SCENE])
    write_together([limits_report_batch([study], (), tmp_path / "limits", COMMAND)])
    check_limits_folder(tmp_path / "limits", [SCENE])
    (tmp_path / "results.json").write_text('{"schema": 1, "sweeps": {}}')
    with pytest.raises(InvalidInput, match="not a report of limits"):
        check_limits_folder(tmp_path, [SCENE])
    (tmp_path / "limits" / "README.md").unlink()
    (tmp_path / "limits" / "README.md").mkdir()
    with pytest.raises(InvalidInput, match="not a regular file"):
        check_limits_folder(tmp_path / "limits", [SCENE])


def test_an_entry_of_another_version_is_not_taken_over(tmp_path: Path) -> None:
    document = {"schema": 1, "limits": {SCENE: {"study": {"walks": []}, "commands": []}}, "gallery": []}
    (tmp_path / "results.json").write_text(json.dumps(document))
    assert earlier_limits(tmp_path) == {}
