"""The report of a sweep: every cell is in it, every name is explained, every sentence has its numbers."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from handmade import FAST, SENSITIVITY, STEPS, convergence, handmade_sweep, measurement
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from conrod.errors import InvalidInput
from conrod.report import numbers
from conrod.report.charts.canvas import drawing_style, on_log_grid, svg_text
from conrod.report.folder import ReportFolder
from conrod.report.reproduction import Reproduction
from conrod.report.sweep import writer
from conrod.report.sweep.bands import Pooled, rows_of, shares_table
from conrod.report.sweep.budgets import budget_tables
from conrod.report.sweep.document import DRAWN, check_sweep_folder
from conrod.report.sweep.failures import failures_table
from conrod.report.sweep.findings import found_in
from conrod.report.sweep.fronts import labelled_table
from conrod.report.sweep.placing import placed_points
from conrod.report.sweep.point_names import Box, placed_names
from conrod.report.sweep.refinement_orders import orders_figure, orders_table
from conrod.report.sweep.setting_tables import transfers_table
from conrod.report.sweep.work_precision import work_precision_figure
from conrod.report.sweep.writer import sweep_report_batch
from conrod.report.tables import table
from conrod.report.validation.report import KIND
from conrod.scenes import SCENES
from conrod.studies.frame.files import Batch, write_together
from conrod.studies.frame.measurement import QUANTITIES, Measurement
from conrod.studies.recommend.transfer import Transfer
from conrod.studies.sweep.grid_convergence import Share
from conrod.studies.sweep.observed_orders import order_of
from conrod.studies.sweep.results import SweepStudy, SweptPoint

COMMAND = Reproduction("conrod sweep {scene} --out reports/sweep")
LABEL = re.compile(r"[MP]\d+")


@pytest.fixture(scope="module")
def study() -> SweepStudy:
    return handmade_sweep()


@pytest.fixture(scope="module")
def batch(study: SweepStudy, tmp_path_factory: pytest.TempPathFactory) -> Batch:
    """The whole report, rendered once."""
    return sweep_report_batch([study], tmp_path_factory.mktemp("sweep"), COMMAND)


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures by name alone: drawing them is what takes long."""

    def named(study: SweepStudy) -> dict[str, str]:
        return {name: "<svg/>" for name in DRAWN if name != "work-precision" or placed_points(study)}

    monkeypatch.setattr(writer, "sweep_figures", named)


def drawn(study: SweepStudy) -> Figure:
    with drawing_style():
        figure = work_precision_figure(study)
    assert figure is not None
    return figure


def untimed(study: SweepStudy) -> SweepStudy:
    return replace(study, points=tuple(replace(p, timing=None) for p in study.points))


def changed(study: SweepStudy, label: str, **fields: Any) -> SweepStudy:
    return replace(study, points=tuple(replace(p, **fields) if p.label == label else p for p in study.points))


def texts(axes: Axes) -> set[str]:
    return {text.get_text() for text in axes.texts}


# -- the work-precision diagram ----------------------------------------------------------------------------------------


def strips(figure: Figure) -> list[Axes]:
    return [axes for axes in figure.axes if axes.get_ylabel() == "did not\ncomplete"]


def panel(figure: Figure, quantity: str) -> Axes:
    return next(axes for axes in figure.axes if axes.get_ylabel().startswith(f"{quantity} error"))


def test_a_failed_cell_is_drawn(study: SweepStudy) -> None:
    failed = [p for p in study.points if not p.completed]
    (strip,) = strips(drawn(study))
    assert len(strip.lines) == len(failed) == 2
    assert [label.get_text() for label in strip.get_yticklabels()] == ["opened"]
    # Negative controls: one failure fewer is one marker fewer, and without any there is no strip.
    one = changed(study, failed[0].label, measurement=measurement(0.04))
    assert len(strips(drawn(one))[0].lines) == 1
    assert strips(drawn(changed(one, failed[1].label, measurement=measurement(0.04)))) == []


def test_each_way_of_ending_has_its_lane(study: SweepStudy) -> None:
    label = next(p.label for p in study.points if not p.completed)
    (strip,) = strips(drawn(changed(study, label, measurement=Measurement("diverged"))))
    assert [text.get_text() for text in strip.get_yticklabels()] == ["diverged", "opened"]


def test_a_failed_cell_stands_at_the_cost_of_its_steps(study: SweepStudy) -> None:
    place = next(p for p in placed_points(study) if not p.point.completed and p.point.engine == "mujoco")
    assert place.estimated
    assert place.cost == pytest.approx(2e-6 * 20)  # not the 1000 s that its timing says


def test_a_rule_that_never_completes_stands_at_the_median_cost_of_its_engine(study: SweepStudy) -> None:
    never = replace(
        study,
        points=tuple(replace(p, measurement=measurement(None)) if p.rule == FAST[0] else p for p in study.points),
    )
    place = next(p for p in placed_points(never) if p.point.rule == FAST[0])
    assert place.cost == pytest.approx(8e-6 * 20)  # of 3 runs with 2 and 4 runs with 8 microseconds a step


def test_the_front_in_the_figure_is_the_front_of_the_data(study: SweepStudy) -> None:
    figure = drawn(study)
    for quantity in QUANTITIES:
        for engine, hue in (("mujoco", "#0072B2"), ("pymunk", "#D55E00")):
            # A front by its definition, not by the code that is tested.
            own = [p for p in study.points if p.engine == engine and p.completed]
            front = [p for p in own if not any(beats(other, p, quantity) for other in own)]
            wanted = sorted((p.cost or 0.0, p.error(quantity) or 0.0) for p in front)
            lines = [x for x in panel(figure, quantity).lines if (x.get_linewidth(), x.get_color()) == (2.2, hue)]
            assert len(lines) == 1
            assert lines[0].get_xydata() == pytest.approx(on_log_grid(np.array(wanted)))


def beats(one: SweptPoint, other: SweptPoint, quantity: str) -> bool:
    costs = [(p.cost or 0.0, p.error(quantity) or 0.0) for p in (one, other)]
    return costs[0] != costs[1] and all(a <= b for a, b in zip(*costs, strict=True))


def named_in(figure: Figure) -> set[str]:
    return {text for axes in figure.axes for text in texts(axes) if LABEL.fullmatch(text)}


def explained_in(text: str) -> set[str]:
    return {row.split("|")[1].strip() for row in text.splitlines()[2:]}


def test_every_labelled_point_is_in_the_table(study: SweepStudy) -> None:
    names, explained = named_in(drawn(study)), explained_in(labelled_table(study))
    assert names == explained
    assert {p.label for q in QUANTITIES for e in study.engines for p in study.front(q, e)} == names
    # Negative control: a row that is missing is noticed.
    short = "\n".join(labelled_table(study).splitlines()[:-1])
    assert names - explained_in(short)


def test_every_point_is_drawn_and_identified(study: SweepStudy) -> None:
    assert {p.point.label for p in placed_points(study)} == {p.label for p in study.points}
    axes = panel(drawn(study), "position")
    seen = np.concatenate([np.asarray(line.get_xydata()) for line in axes.lines])
    for point in (p for p in study.points if p.completed):
        at = on_log_grid(np.array([point.cost, point.error("position")], dtype=float))
        assert np.isclose(seen, at, rtol=1e-9).all(axis=1).any(), point.label


@pytest.mark.usefixtures("undrawn")
def test_without_timings_there_is_no_diagram_and_no_sentence_about_cost(study: SweepStudy, tmp_path: Path) -> None:
    assert work_precision_figure(untimed(study)) is None
    batch = sweep_report_batch([untimed(study)], tmp_path, COMMAND)
    assert "work-precision.svg" not in str(batch.files["saw-500rpm.md"])
    assert "No run was timed" in str(batch.files["saw-500rpm.md"])
    assert not [text for text in found_in(untimed(study)) if "cheapest" in text]
    assert [text for text in found_in(study) if "cheapest" in text]


def test_axes_have_units_and_each_engine_its_own_reference(study: SweepStudy) -> None:
    labels = [axes.get_xlabel() for axes in drawn(study).axes]
    assert "CPU time of a simulated revolution" in labels
    assert len([text for text in labels if "reference loop (1.0 µs each)" in text]) == 2


@pytest.mark.parametrize("count", [2, 12, 30])
def test_names_of_points_do_not_overlap(count: int) -> None:
    at = [(60.0 + 9.0 * k, 320.0 - 9.0 * k) for k in range(count)]
    names = placed_names(["M123"] * count, at, at, [], (600.0, 350.0), 6.5)
    boxes = [Box(x + n.offset[0], y + n.offset[1], 8.5, 3.9) for (x, y), n in zip(at, names, strict=True)]
    assert not [(a, b) for k, a in enumerate(boxes) for b in boxes[:k] if a.touches(b)]
    # Negative control: at one fixed place beside each of close points, they would.
    fixed = [Box(x, y + 2.0 * k, 8.5, 3.9) for k, (x, y) in enumerate([(50.0, 50.0)] * count)]
    assert [(a, b) for k, a in enumerate(fixed) for b in fixed[:k] if a.touches(b)]


# -- findings ----------------------------------------------------------------------------------------------------------


def sentence(study: SweepStudy, part: str) -> str | None:
    return next((text for text in found_in(study) if part in text), None)


@pytest.mark.parametrize(
    ("part", "without"),
    [
        ("stop getting better", lambda s: replace(s, orders=())),
        ("stock error is made of", lambda s: replace(s, budgets=())),
        ("stock error depends on", lambda s: replace(s, sensitivities=())),
        ("study of convergence alone", lambda s: replace(s, both_ways=())),
        ("How often that band", lambda s: replace(s, grid_convergence=())),
        ("The order of pymunk", lambda s: replace(s, orders=())),
        ("cheapest setting of MuJoCo", untimed),
    ],
)
def test_a_sentence_is_not_said_without_its_numbers(
    study: SweepStudy, part: str, without: Callable[[SweepStudy], SweepStudy]
) -> None:
    assert sentence(study, part) is not None
    assert sentence(without(study), part) is None


def test_plateaus_are_said_of_quantities_that_have_one(study: SweepStudy) -> None:
    text = sentence(study, "stop getting better") or ""
    assert "position error at 0.040 L" in text
    assert "acceleration error at 0.12 ω² L" in text
    assert "2500 steps" in text
    # Negative control: an error that falls has no plateau, and then nothing is said.
    falls = order_of(STEPS, [1.0 / n for n in STEPS])
    falling = tuple(replace(o, orders=dict.fromkeys(QUANTITIES, falls)) for o in study.orders)
    assert sentence(replace(study, orders=falling), "stop getting better") is None


def test_the_cheapest_and_what_it_is_cheaper_than_are_computed(study: SweepStudy) -> None:
    text = sentence(study, "cheapest setting of MuJoCo") or ""
    assert "at 100 steps per revolution (M6): 800 µs" in text
    assert "(M12): 6.5 ms, **8.1 times as much**" in text
    assert "their least error is 0.040 L" in text
    # Negative control: another cost is another factor.
    dear = next(p for p in study.points if p.label == "M12").timing
    assert dear is not None
    slower = changed(study, "M12", timing=replace(dear, seconds_per_revolution=2.0 * dear.seconds_per_revolution))
    assert "**16 times as much**" in (sentence(slower, "cheapest setting of MuJoCo") or "")


def test_an_engine_that_does_not_get_there_says_how_near_it_comes(study: SweepStudy) -> None:
    assert "1.6e-6 L" in (sentence(study, "No setting of pymunk") or "")


def test_orders_with_and_without_bias(study: SweepStudy) -> None:
    text = sentence(study, "The order of pymunk") or ""
    assert "at order 1.0" in text
    assert "at order 2.0" in text


def test_dependence_on_masses_and_gravity(study: SweepStudy) -> None:
    text = sentence(study, "stock error depends on") or ""
    assert "slider_mass x 0.01 (0.06 kg) it is 0.25 times" in text
    assert "slider_mass x 100 (600 kg) the run ends as `opened`" in text
    assert "with gravity off it stays as it is" in text
    # A run whose drive faltered says nothing.
    base, light, *others = SENSITIVITY.variations
    faltering = replace(SENSITIVITY, variations=(base, replace(light, drive=1e-3), *others))
    assert "x 0.01" not in (sentence(replace(study, sensitivities=(faltering,)), "stock error") or "")


def test_the_verdict_on_a_study_of_convergence_follows_the_share(study: SweepStudy) -> None:
    text = sentence(study, "study of convergence alone") or ""
    assert "would not have noticed" in text
    assert "9 % of 100 cells" in text
    held = (convergence("mujoco", "stock", Share(95, 5, 0, 0, 0, 1.25)),)
    assert "would have noticed" in (sentence(replace(study, both_ways=held), "convergence alone") or "")


# -- tables ------------------------------------------------------------------------------------------------------------


def test_shares_are_pooled_by_cells_not_by_rules(study: SweepStudy) -> None:
    alone = rows_of(study)[0].by_quantity["position"]
    assert (alone.rules, alone.told, alone.at_rounding) == (2, 200, 7)
    assert alone.share == pytest.approx(108 / 200)
    assert alone.ratio == pytest.approx(0.65)
    assert "**54 %**" in shares_table(study)
    assert Pooled(0, 0, 0, 5, 0, 0, ()).share is None


def test_a_cause_is_named_only_where_the_law_gives_the_size(study: SweepStudy) -> None:
    lines = budget_tables(study).splitlines()
    model = next(line for line in lines if line.startswith("| model"))
    knob = next(line for line in lines if line.startswith("| regularisation"))
    assert "| the law's |" in model
    assert "not named: the law does not" in knob
    assert "The law: regularisation (1 - d) A f." in lines
    assert "`hardening` none to 1e-9" in knob
    assert "not known (converged: opened)" in next(line for line in lines if line.startswith("| stabilisation"))
    assert "not told from zero" in next(line for line in lines if line.startswith("| iteration"))


def test_failures_are_listed_with_their_steps(study: SweepStudy) -> None:
    rows = failures_table(study).splitlines()[2:]
    assert len(rows) == 2
    assert "1 of 4 | 20: opened" in rows[0]
    healthy = replace(study, points=tuple(replace(p, measurement=measurement(0.1)) for p in study.points))
    assert failures_table(healthy) == ""


def test_every_rule_has_its_order_plateau_and_floor(study: SweepStudy) -> None:
    rows = orders_table(study).splitlines()[2:]
    assert len(rows) == len({p.rule for p in study.points})
    assert "plateau at 0.040" in rows[0]
    assert len(orders_table(study, presets_only=True).splitlines()[2:]) == 4


def test_failed_runs_stand_above_the_orders(study: SweepStudy) -> None:
    def failed(some: SweepStudy) -> bool:
        with drawing_style():
            figure = orders_figure(some)
        assert figure is not None
        return "did not complete" in texts(figure.axes[0])

    assert failed(study)
    whole = tuple(replace(o, points=tuple(p for p in o.points if p.errors is not None)) for o in study.orders)
    assert not failed(replace(study, orders=whole))


def test_transfers() -> None:
    found = Transfer("saw-40rpm", "mujoco", "position", 1e-5, "RK4", 100, {"shear-press": 2e-6}, 3e-5, 0.5)
    row = transfers_table([found]).splitlines()[-1]
    assert "| **no** | n/a |" in row
    assert "position 1e-5" in row
    assert "| yes |" in transfers_table([replace(found, error=3e-6)])
    assert "did not complete | **no**" in transfers_table([replace(found, error=None, best=None)])


def test_rows_keep_to_their_columns(batch: Batch) -> None:
    page = str(batch.files["saw-500rpm.md"])
    for block in page.split("\n\n"):
        if block.startswith("| "):
            widths = {len(re.findall(r"(?<!\\)\|", line)) for line in block.splitlines()}
            assert len(widths) == 1, block[:200]
    assert "|" not in table(["a"], [["b|c"]]).splitlines()[-1].replace("\\|", "")[1:-1]


# -- the files ---------------------------------------------------------------------------------------------------------


def test_the_same_study_gives_the_same_bytes(study: SweepStudy, batch: Batch) -> None:
    again = sweep_report_batch([handmade_sweep()], batch.folder, COMMAND)
    assert again.files == batch.files
    # Negative control: another measurement is seen.
    with drawing_style():
        figure = work_precision_figure(changed(study, "M6", measurement=measurement(8e-7)))
        assert figure is not None
        assert svg_text(figure) != batch.files["figures/saw-500rpm-work-precision.svg"]


def test_the_report_is_whole(batch: Batch) -> None:
    for name in ("README.md", "saw-500rpm.md"):
        links = [x for x in re.findall(r"\]\(([^)]+)\)", str(batch.files[name])) if not x.endswith("work-precision.md")]
        assert links
        assert not [link for link in links if link not in batch.files]
    drawings = [str(text) for name, text in batch.files.items() if name.startswith("figures/")]
    assert len(drawings) == len(DRAWN)
    for text in drawings:
        ElementTree.fromstring(text)
    assert "a machine" in str(batch.files["README.md"])


def test_results_identify_every_point(study: SweepStudy, batch: Batch) -> None:
    document = json.loads(str(batch.files["results.json"]))
    kept = document["sweeps"]["saw-500rpm"]["study"]["points"]
    assert [(p["label"], p["rule"], p["steps_per_revolution"]) for p in kept] == [
        (p.label, p.rule, p.steps_per_revolution) for p in study.points
    ]
    assert kept[0]["measurement"]["outcome"] == "opened"
    assert kept[5]["measurement"]["errors"]["C"]["position"]["max"] == 7e-7


@pytest.mark.usefixtures("undrawn")
def test_scenes_of_an_earlier_sweep_stay_in_the_index(study: SweepStudy, tmp_path: Path) -> None:
    write_together([sweep_report_batch([study], tmp_path, COMMAND)])
    other = replace(study, name="saw-40rpm", scene=SCENES["saw-40rpm"])
    batch = sweep_report_batch([other], tmp_path, COMMAND)
    index = str(batch.files["README.md"])
    assert "[saw-500rpm](saw-500rpm.md)" in index
    assert "not all swept by one command" in index
    assert set(json.loads(str(batch.files["results.json"]))["sweeps"]) == {"saw-40rpm", "saw-500rpm"}
    assert "saw-500rpm.md" not in batch.files


@pytest.mark.usefixtures("undrawn")
def test_a_figure_that_is_no_longer_drawn_goes(study: SweepStudy, tmp_path: Path) -> None:
    write_together([sweep_report_batch([study], tmp_path, COMMAND)])
    assert sweep_report_batch([study], tmp_path, COMMAND).obsolete == ()
    assert sweep_report_batch([untimed(study)], tmp_path, COMMAND).obsolete == (
        "figures/saw-500rpm-work-precision.svg",
    )


@pytest.mark.usefixtures("undrawn")
def test_a_sweep_and_a_validation_do_not_replace_each_other(study: SweepStudy, tmp_path: Path) -> None:
    check_sweep_folder(tmp_path, ["saw-500rpm"])
    write_together([sweep_report_batch([study], tmp_path / "sweep", COMMAND)])
    check_sweep_folder(tmp_path / "sweep", ["saw-500rpm"])
    with pytest.raises(InvalidInput, match="conrod"):
        ReportFolder(tmp_path / "sweep", KIND)
    (tmp_path / "results.json").write_text('{"schema": 1, "scenes": {}}')
    with pytest.raises(InvalidInput, match="not a sweep's report"):
        check_sweep_folder(tmp_path, ["saw-500rpm"])


@pytest.mark.usefixtures("undrawn")
def test_the_explanation_is_linked_where_it_can_be_reached(study: SweepStudy, tmp_path: Path) -> None:
    folder = tmp_path / "reports" / "sweep"
    assert "](../../docs/work-precision.md)" not in str(sweep_report_batch([study], folder, COMMAND).files["README.md"])
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "work-precision.md").write_text("how to read")
    assert "](../../docs/work-precision.md)" in str(sweep_report_batch([study], folder, COMMAND).files["README.md"])


def test_a_report_is_rendered_without_an_engine() -> None:
    look = "import sys; print([m for m in sys.modules if m in ('mujoco', 'pymunk')])"
    modules = {"conrod.report.sweep.writer": "[]", "conrod.engines.pymunk.space": "['pymunk'"}
    for module, found in modules.items():
        done = subprocess.run(
            [sys.executable, "-c", f"import {module}; {look}"], capture_output=True, text=True, check=True, timeout=60
        )
        # The second module is the negative control: it does load an engine, and the look sees it.
        assert done.stdout.strip().startswith(found), module


def test_times_and_shares_in_words() -> None:
    assert [numbers.duration(s) for s in (1.234e-5, 9.96e-4, 0.0123, 2.0, None)] == [
        "12 µs",
        "1.0 ms",
        "12 ms",
        "2.0 s",
        "n/a",
    ]
    assert [numbers.percent(s) for s in (0.0, 0.001, 0.5, 0.999, 1.0, None)] == [
        "0 %",
        "< 1 %",
        "50 %",
        "> 99 %",
        "100 %",
        "n/a",
    ]


# -- the page that explains --------------------------------------------------------------------------------------------

DOCS = Path(__file__).parents[2] / "docs" / "work-precision.md"
RESULTS = DOCS.parent.parent / "reports" / "sweep" / "results.json"
MEASURED_HEAD = ["settings", "steps per revolution", *QUANTITIES]


def rows_of_explanation() -> list[list[str]]:
    """The rows of all tables of measured errors."""
    rows: list[list[str]] = []
    measured = False
    for line in DOCS.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")] if line.startswith("|") else []
        measured = bool(cells) and (measured or cells == MEASURED_HEAD)
        if measured and cells != MEASURED_HEAD and not cells[0].startswith("---"):
            rows.append(cells)
    return rows


def wrong_rows(rows: list[list[str]], found: dict[tuple[str, str], list[str]]) -> list[list[str]]:
    return [row for row in rows if found.get((row[0], row[1])) != row[2:]]


def test_the_explanation_quotes_what_was_measured() -> None:
    rows = rows_of_explanation()
    assert len(rows) > 20
    if not RESULTS.exists():
        pytest.skip("no sweep has been committed")
    study = json.loads(RESULTS.read_text(encoding="utf-8"))["sweeps"]["saw-500rpm"]["study"]
    found = {(p["rule"], str(p["steps_per_revolution"])): quoted(p["measurement"]) for p in study["points"]}
    assert wrong_rows(rows, found) == []
    # Negative control: another digit is noticed.
    assert wrong_rows([[*rows[0][:-1], "0.068"]], found)


def quoted(measured: dict[str, Any]) -> list[str]:
    if measured["errors"] is None:
        return [measured["outcome"]] * len(QUANTITIES)
    return [numbers.measured(max(point[q]["max"] for point in measured["errors"].values())) for q in QUANTITIES]
