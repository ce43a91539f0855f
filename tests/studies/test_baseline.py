"""Baselines: what rounding leaves is no drift, and anything else is, with its size; files that are none are refused."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, cast

import pytest

from conrod.engines import engine_named, environment
from conrod.errors import InvalidInput
from conrod.execution.baseline import (
    BAND_DEVIATIONS,
    SPEED_FACTORS,
    BandedNumber,
    Baseline,
    BaselineComparison,
    BaselineLine,
    Drift,
    KeptCost,
    OtherBaseline,
    check_same_request,
    compare_baselines,
    read_baseline,
    with_bands,
    write_baseline,
)
from conrod.execution.baseline_check import BaselineCheck, baseline_line, scene_lines
from conrod.execution.paired_timing import PairedTiming
from conrod.execution.result import SceneResults
from conrod.execution.run_cost import cost_of_run
from conrod.scenes import SCENES, Scene, scene_named
from conrod.studies.free_motion.results import MotionResult
from conrod.studies.validation.results import Tolerance, ValidationResult

ERROR, SPREAD = 4.6446e-5, 3e-13
FILE = Path("b.json")


def found(position: float = ERROR, **fields: Any) -> dict[str, BaselineLine]:
    numbers = {"position": BandedNumber(position, 0.0), "order of position": BandedNumber(2.0, 0.0)}
    return {"mujoco tuned": replace(BaselineLine("completed", True, numbers, {"tolerance": 0.0}), **fields)}


def baseline(results: dict[str, BaselineLine], **fields: Any) -> Baseline:
    return replace(Baseline({"scene": ["saw"], "preset": "tuned"}, "ab", {"mujoco": "4.0.0"}, results), **fields)


OTHERS = [found(ERROR + SPREAD), found(ERROR - SPREAD)] * 2  # which are rounded otherwise


@cache
def kept() -> Baseline:
    return with_bands(baseline(found()), OTHERS, {})


def drifts(now: dict[str, BaselineLine]) -> tuple[Drift, ...]:
    return compare_baselines(FILE, kept(), baseline(now)).drifts


def test_the_band_is_what_runs_that_round_otherwise_leave() -> None:
    position, order = kept().results["mujoco tuned"].numbers.values()
    assert BAND_DEVIATIONS * SPREAD <= position.band < 10.0 * BAND_DEVIATIONS * SPREAD
    # In the digits that are rounding's, and one more: files of two machines differ in few places.
    assert position.value == 4.6446e-05
    # What does not change by these at all still has eight last bits of 1.
    assert order.band == pytest.approx(1e-14)
    assert len({*SPEED_FACTORS, 1.0}) == len(OTHERS) + 1
    # A run that the speed does not drive takes the rounding of one that stands for it.
    alone = {"own": found()["mujoco tuned"]}
    own = with_bands(baseline(found() | alone), [one | alone for one in OTHERS], {"own": "mujoco tuned"})
    assert own.results["own"].numbers["position"].band == position.band


def test_drift_is_beyond_its_band_and_comes_with_version_changes() -> None:
    held = compare_baselines(FILE, kept(), baseline(found(ERROR + 0.9e-10), made_with={"mujoco": "4.0.1"}))
    assert (held.passed, held.drifts, held.text) == (True, (), "")
    held = compare_baselines(FILE, kept(), baseline(found(2.0 * ERROR), made_with={"mujoco": "4.0.1"}))
    assert held.text.splitlines()[-1] == "the baseline was made with mujoco 4.0.0, now 4.0.1"


@pytest.mark.parametrize(("change", "better"), [(1e-8, False), (-1e-8, True)])
def test_drift_counts_digits_worse_or_better(change: float, better: bool) -> None:
    (drift,) = drifts(found(ERROR + change))
    assert (drift.what, drift.better) == ("position", better)
    assert drift.digits == pytest.approx(2.0, abs=0.01)
    assert f"was 4.645e-05: {'better' if better else 'worse'}, drifted by 2.0 digits" in str(drift)


def test_outcome_order_and_result_are_drifts_when_they_differ() -> None:
    assert str(drifts(found(outcome="diverged", numbers={}))[0]) == "mujoco tuned: outcome diverged, was completed"
    lost = {"position": BandedNumber(ERROR, 0.0)}
    assert str(drifts(found(numbers=lost))[0]) == "mujoco tuned: order of position none, was 2"
    assert [drift.result for drift in drifts({"new": found()["mujoco tuned"]})] == ["mujoco tuned", "new"]
    # The same words, and another rule for the preset's settings.
    assert str(drifts(found(settings={"tolerance": 1e-8}))[0]) == "mujoco tuned: tolerance 1e-8, was 0.0"
    assert drifts(found(numbers=lost | {"order of position": BandedNumber(1.0, 0.0)}))[0].better is None


def test_rotations_are_no_drift_from_a_baseline_without_them() -> None:
    def with_rotation(size: float) -> dict[str, BaselineLine]:
        numbers = found()["mujoco tuned"].numbers
        return found(numbers={**numbers, "rotation": BandedNumber(size, 0.0)})

    assert drifts(with_rotation(ERROR)) == ()
    later = with_bands(baseline(with_rotation(ERROR)), [with_rotation(ERROR + SPREAD)] * len(SPEED_FACTORS), {})
    (drift,) = compare_baselines(FILE, later, baseline(with_rotation(2.0 * ERROR))).drifts
    assert (drift.what, drift.better) == ("rotation", False)
    assert [one.what for one in compare_baselines(FILE, later, baseline(found())).drifts] == ["rotation"]


def test_error_below_rounding_is_noise_until_it_leaves_it() -> None:
    noise = with_bands(baseline(found(1e-15)), [found(2e-15)] * len(SPEED_FACTORS), {})
    assert compare_baselines(FILE, noise, baseline(found(9e-13))).passed
    assert not compare_baselines(FILE, noise, baseline(found(2e-12))).passed


def test_a_baseline_comes_back_from_its_file_a_number_on_a_line(tmp_path: Path) -> None:
    file = tmp_path / "made" / "b.json"
    write_baseline(file, kept())
    assert read_baseline(file).results["mujoco tuned"] == kept().results["mujoco tuned"]
    assert '"position": { "value": 4.6446e-05, "band": 1e-10 }' in file.read_text(encoding="utf-8")
    assert [one.name for one in file.parent.iterdir()] == ["b.json"]


# -- bands -------------------------------------------------------------------------------------------------------------


def banded(value: float, *others: float) -> BandedNumber:
    """Band of a position error that comes out as others at other speeds."""
    line = BaselineLine("completed", True, {"position": BandedNumber(value, 0.0)}, {})
    runs = [{"a": replace(line, numbers={"position": BandedNumber(one, 0.0)})} for one in others]
    return with_bands(baseline({"a": line}), runs, {}).results["a"].numbers["position"]


def test_band_is_a_power_of_ten_above_fifty_deviations_or_8_bits() -> None:
    # The deviation from the first run is sqrt((3^2 + 4^2) / 2) 1e-9 = 3.54e-9, times 49.46 is 1.75e-7.
    assert banded(0.0123456789, 0.0123456789 + 3e-9, 0.0123456789 - 4e-9) == BandedNumber(0.0123457, 1e-6)
    # Eight last bits are 1.8e-15: of 1 for smaller numbers, else of the number.
    assert banded(0.0, 0.0) == BandedNumber(0.0, 1e-14)
    assert banded(0.5, 0.5).band == 1e-14
    assert banded(-6000.0, -6000.0) == BandedNumber(-6000.0, 1e-10)
    # A number smaller than its band keeps one digit.
    assert banded(1.26e-9, 1e-6) == BandedNumber(1e-9, 1e-4)


# -- drift in words ----------------------------------------------------------------------------------------------------


def line(outcome: str = "completed", **numbers: float) -> BaselineLine:
    return BaselineLine(outcome, True, {name: BandedNumber(one, 1e-6) for name, one in numbers.items()}, {})


def test_drifts_have_a_line_per_result_with_the_largest_first() -> None:
    before = baseline(
        {
            "a": line(position=1e-3, velocity=2e-3, total=3e-3),
            "b": line(position=1e-3),
            "c": line("diverged"),
            "d": line(position=1e-3, velocity=2e-3),
        },
        made_with={"mujoco": "4.0.0", "numpy": "2", "gone": "1"},
    )
    now = baseline(
        {
            "a": line(position=1.01e-3, velocity=2.1e-3, total=3e-3),
            "b": line(position=0.9e-3),
            "c": line(),
            "e": line(position=1e-3),
            "d": line(velocity=3e-3),
        },
        made_with={"mujoco": "4.0.1", "numpy": "2"},
    )
    found = compare_baselines(FILE, before, now)
    assert (found.file, found.passed, found.written) == (FILE, False, False)
    assert found.text.splitlines() == [
        "drifted from the baseline b.json:",
        "  a: velocity 0.0021, was 0.002: worse, drifted by 2.0 digits (position too)",
        "  b: position 0.0009, was 0.001: better, drifted by 2.0 digits",
        "  c: outcome completed, was diverged",
        "  d: position none, was 0.001 (velocity too)",
        "  e: result there, was none",
        "the baseline was made with mujoco 4.0.0, now 4.0.1, gone 1, now None",
    ]
    assert "  e: result none, was there" in compare_baselines(FILE, now, before).text.splitlines()


@pytest.mark.parametrize(
    ("was", "now", "words"),
    [
        (0.0, 0.0312345, "0.0312, was 0: drifted by 4.5 digits"),
        (-1.0, -2.0, "-2, was -1: drifted by 6.0 digits"),  # orders below 0 are no rounding
        (2.0, 2.000002, "2.000002, was 2: drifted by 0.3 digits"),
        (2.0, 20.0, "20, was 2: drifted by 7.3 digits"),
    ],
)
def test_a_drift_is_written_in_the_digits_that_differ(was: float, now: float, words: str) -> None:
    before, after = (baseline({"a": line(**{"order of position": one})}) for one in (was, now))
    assert compare_baselines(FILE, before, after).text.splitlines()[1] == f"  a: order of position {words}"


def test_a_comparison_says_what_was_written() -> None:
    assert BaselineComparison(FILE).passed
    first, again = (BaselineComparison(FILE, written=True, accepted=accepted) for accepted in (False, True))
    assert (first.passed, again.passed) == (False, True)
    assert first.text == "no baseline yet: b.json is written, look at it, keep it, run again"
    assert again.text == "baseline b.json is written"
    other = BaselineComparison(FILE, versions=("mujoco 1, now 2",))
    assert (other.passed, other.text) == (True, "")
    drifted = replace(other, drifts=(Drift("a", "outcome", "completed", "opened"),))
    assert (drifted.passed, replace(drifted, accepted=True).passed) == (False, True)


# -- requests and files ------------------------------------------------------------------------------------------------


def test_baseline_of_another_request_is_refused_with_differences() -> None:
    before = baseline({}, of={"scene": ["saw"], "steps": 100, "crank": 0.1, "same": 1})
    check_same_request(FILE, before, baseline({}, of={"scene": ["cam"]}))  # the hash decides

    def refusal(of: Mapping[str, Any]) -> str:
        with pytest.raises(OtherBaseline) as raised:
            check_same_request(FILE, before, baseline({}, of=of, hash="cd"))
        return str(raised.value)

    end = "(b.json; accept it to have it written again)"
    assert refusal({"scene": ["cam"], "steps": 100, "same": 1}) == (
        f'the baseline is of something else: scene ["saw"], here ["cam"]; crank 0.1, here null {end}'
    )
    assert refusal({"scene": ["cam"], "steps": 200, "more": 1, "same": 1}) == (
        'the baseline is of something else: scene ["saw"], here ["cam"]; steps 100, here 200; crank 0.1, here null; '
        f"... {end}"
    )
    assert refusal(before.of) == f"the baseline is of something else: another scene of that name {end}"


def test_a_file_that_is_no_baseline_is_refused_with_the_reason(tmp_path: Path) -> None:
    file = tmp_path / "b.json"

    def refusal(text: str | None) -> str:
        if text is not None:
            file.write_text(text, encoding="utf-8")
        with pytest.raises(InvalidInput) as raised:
            read_baseline(file)
        return str(raised.value).replace(str(file), "b.json")

    assert refusal(None) == "cannot read b.json: No such file or directory"
    for text in ("{", "[1]", "{}", "[" * 100_000):
        assert refusal(text) == "b.json is no baseline of conrod"
    write_baseline(file, kept())
    document = json.loads(file.read_text(encoding="utf-8"))
    assert refusal(json.dumps(document | {"conrod_baseline": 2})) == (
        "b.json is a baseline of schema 2, and this conrod reads 1: delete it"
    )
    assert refusal(json.dumps({"conrod_baseline": 1})).startswith("b.json is a damaged baseline, delete it: ")
    damaged = "b.json is a damaged baseline, delete it: mujoco tuned: "
    odd = "the band of position is {}: it has to be above 0, and finite"
    for key, value, words in (
        ("value", float("inf"), "position is inf, no number"),
        ("band", 0.0, odd.format(0.0)),
        ("band", -1.0, odd.format(-1.0)),
        ("band", float("inf"), odd.format("inf")),
    ):
        changed = json.loads(json.dumps(document))
        changed["results"]["mujoco tuned"]["numbers"]["position"][key] = value
        assert refusal(json.dumps(changed)) == damaged + words


# -- the check of a study ----------------------------------------------------------------------------------------------

SAW: Scene = SCENES["saw-40rpm"]


def prepared(file: Path | None, *, accept: bool = False, **words: Any) -> Any:
    return BaselineCheck.prepare(file, {"saw": SAW}, {"preset": "tuned"} | words, accept=accept)


def check(check: BaselineCheck, position: float = ERROR, **bands_like: str) -> BaselineComparison:
    """Check one result, which the speed moves by `SPREAD` a last bit."""
    return check.compare(
        [position],
        lambda scenes: [[position + SPREAD * (one["saw"].speed / SAW.speed - 1.0) / 2.0**-52] for one in scenes],
        lambda results: found(*results) | {"own": found(ERROR)["mujoco tuned"]},
        bands_like,
    )


def test_baseline_is_of_the_given_options_and_the_machine(tmp_path: Path) -> None:
    file = tmp_path / "b.json"
    made = prepared(file, none=None, empty="", nothing=(), zero=0, steps=100)
    parameters = {f"saw.{name}": value for name, value in SAW.parameters.items()}
    assert made.now.of == {"scene": ["saw"], "preset": "tuned", "zero": 0, "steps": 100} | parameters
    assert (made.now.made_with | environment(), set(made.now.made_with)) == (
        made.now.made_with,
        {"conrod", *environment()},
    )
    assert (made.file, made.accept, made.scenes, made.before, made.now.results) == (file, False, {"saw": SAW}, None, {})
    # The digest is of both: another option, or another machine of the name.
    other = BaselineCheck.prepare(file, {"saw": SAW.with_parameters(crank=0.09)}, {"preset": "tuned"}, accept=False)
    assert other is not None
    assert len({one.now.hash for one in (prepared(file), prepared(file, steps=100), other)}) == 3
    assert prepared(file).now.hash == prepared(str(file), more=None).now.hash


def test_study_is_repeated_at_each_factor_of_the_speed(tmp_path: Path) -> None:
    asked: list[Mapping[str, Scene]] = []

    def find(scenes: Sequence[Mapping[str, Scene]]) -> list[list[float]]:
        asked.extend(scenes)
        return [[ERROR]] * len(scenes)

    prepared(tmp_path / "b.json").compare([ERROR], find, lambda results: found(*results))
    assert [one["saw"].speed for one in asked] == [SAW.speed * factor for factor in SPEED_FACTORS]
    assert len({one["saw"].speed for one in asked} | {SAW.speed}) == 5


def test_without_a_file_there_is_nothing_to_check_or_to_accept(tmp_path: Path) -> None:
    assert prepared(None) is None
    with pytest.raises(InvalidInput, match=r"^--accept: it is for a baseline, name its file with --baseline$"):
        prepared(None, accept=True)
    (tmp_path / "file").write_text("")
    with pytest.raises(InvalidInput, match="is a file, not a folder"):
        prepared(tmp_path / "file" / "b.json")


def test_a_check_writes_compares_and_accepts(tmp_path: Path) -> None:
    file = tmp_path / "b.json"
    assert check(prepared(file), own="mujoco tuned", absent="nowhere") == BaselineComparison(file, written=True)
    written = read_baseline(file).results
    # Two last bits either way: the deviation is SPREAD sqrt((4 + 1 + 1 + 4) / 4), times 49.46 is 2.3e-11.
    assert written["mujoco tuned"].numbers["position"] == BandedNumber(ERROR, 1e-10)
    assert written["own"].numbers["position"].band == 1e-10
    # The same again passes, and a baseline is not written again for nothing.
    state = file.read_bytes()
    assert check(prepared(file)) == BaselineComparison(file)
    assert check(prepared(file, accept=True)) == BaselineComparison(file, accepted=True)
    drifted = check(prepared(file), 2.0 * ERROR)
    assert (drifted.passed, [one.result for one in drifted.drifts]) == (False, ["mujoco tuned"])
    assert file.read_bytes() == state
    accepted = check(prepared(file, accept=True), 2.0 * ERROR)
    assert (accepted.passed, accepted.written, accepted.drifts) == (True, True, drifted.drifts)
    assert read_baseline(file).results["mujoco tuned"].numbers["position"].value == 2.0 * ERROR
    # One of another request is refused, unless it is accepted: then it is written again without a comparison.
    with pytest.raises(OtherBaseline, match=r"steps null, here 100"):
        prepared(file, steps=100)
    assert check(prepared(file, accept=True, steps=100)) == BaselineComparison(file, written=True, accepted=True)
    assert read_baseline(file).of["steps"] == 100


def result(scene: str, preset: str | None, **facts: Any) -> ValidationResult:
    sizes = {q: {"max": size, "rms": 0.5 * size, "final": 0.0} for q, size in (("position", 1e-5), ("velocity", 3e-5))}
    errors = {"C": sizes | {"acceleration": None, "total": None}}
    given: dict[str, Any] = {"errors": errors, "settings": {"preset": preset, "timestep": 0.1}} | facts
    return ValidationResult(
        scene=scene, engine="mujoco", engine_version="1", preset=preset, mode="dynamic", parameters={},
        revolutions=1.0, tolerance=Tolerance(position=1e-4), passed=True, **given,
    )  # fmt: skip


def lines_of(*results: Sequence[ValidationResult]) -> dict[str, BaselineLine]:
    return scene_lines([SceneResults(one[0].scene, SAW, tuple(one)) for one in results])


def test_lines_of_a_baseline_are_results_by_engine_and_preset() -> None:
    tuned = result("saw", "tuned", order={"position": 2.0, "velocity": None})
    own = result("saw", None)
    failed = result("saw", "stock", outcome="diverged")
    lines = lines_of([tuned, own, failed])
    assert list(lines) == ["mujoco tuned", "mujoco kinematic", "mujoco stock"]
    sizes = {"position": 1e-5, "velocity": 3e-5}
    assert lines["mujoco tuned"] == baseline_line(
        "completed", True, sizes | {"velocity_rms": 1.5e-5, "order of position": 2.0}, {"timestep": 0.1}
    )
    assert lines["mujoco kinematic"] == baseline_line("completed", True, sizes, {"timestep": 0.1})
    assert lines["mujoco stock"] == BaselineLine("diverged", True, {}, {"timestep": 0.1})
    # Of several scenes each line has its scene's name.
    assert list(lines_of([own], [result("cam", None)])) == ["saw mujoco kinematic", "cam mujoco kinematic"]


def test_a_line_has_the_sizes_that_are_numbers() -> None:
    sizes = {"a": 1.0, "b": None, "c": float("nan"), "d": float("inf")}
    assert baseline_line("opened", None, sizes) == BaselineLine("opened", None, {"a": BandedNumber(1.0, 0.0)}, {})


def test_a_line_has_no_settings_when_its_result_has_none() -> None:
    motion: Any = MotionResult(
        scene="saw", engine="mujoco", engine_version="1", preset="tuned", motion="free", exact=cast(Any, None),
        step=0.1, seconds=1.0, leaving=0.01, tolerance={}, outcome="opened",
    )  # fmt: skip
    line = scene_lines([SceneResults("saw", SAW, (motion,))])["mujoco tuned"]
    assert line == BaselineLine("opened", None, {}, {})


# -- costs -------------------------------------------------------------------------------------------------------------


def priced(ratio: float, spread: float = 0.05) -> dict[str, KeptCost]:
    return {"mujoco tuned": KeptCost(ratio, ratio - spread, ratio + spread)}


@pytest.mark.parametrize(
    ("ratio", "allowed", "fails"),
    [(2.0, 1.5, True), (2.0, None, False), (1.1, 1.5, False), (1.55, 1.5, False), (0.5, 1.0, False)],
)
def test_cost_fails_where_its_whole_interval_is_above(
    ratio: float, allowed: float | None, fails: bool, tmp_path: Path
) -> None:
    file = tmp_path / "b.json"
    write_baseline(file, replace(kept(), costs=priced(1.0)))
    check = BaselineCheck(file, False, {}, read_baseline(file), baseline(found()))
    held = check.compare([found()], list, lambda one: one[0], costs=priced(ratio), cost_ratio=allowed)
    assert held.passed is not fails
    assert f"mujoco tuned: costs {ratio:.2f} of the baseline's" in held.text
    assert held.text.startswith("too slow: ") is fails
    # Motion is judged all the same, and accepting keeps the costs of now.
    moved = found(2.0 * ERROR)
    assert not check.compare([moved], list, lambda one: one[0], costs=priced(1.0), cost_ratio=allowed).passed
    assert (
        replace(check, accept=True)
        .compare([found()], lambda _: [[found()]] * 4, lambda one: one[0], costs=priced(ratio))
        .passed
    )
    assert read_baseline(file).costs == priced(ratio)


def test_baseline_without_costs_says_how_to_keep_them(tmp_path: Path) -> None:
    file = tmp_path / "b.json"
    write_baseline(file, kept())
    assert "costs" not in file.read_text(encoding="utf-8")
    check = BaselineCheck(file, False, {}, read_baseline(file), baseline(found()))
    assert check.compare([found()], list, lambda one: one[0]).passed
    with pytest.raises(OtherBaseline, match="has no costs: accept it with --cost-ratio"):
        check.compare([found()], list, lambda one: one[0], costs=priced(1.0))
    text = json.dumps(
        {
            "conrod_baseline": 1,
            **json.loads(file.read_bytes()),
            "costs": {"a": {"ratio": 1.0, "low": -1.0, "high": 2.0}},
        }
    )
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InvalidInput, match="no interval above 0"):
        read_baseline(file)


def test_cost_of_a_run_is_a_ratio_to_the_reference_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    made = list[Any]()

    def planted(one: Any, other: Any) -> PairedTiming:
        made.append((one(), other()))
        return PairedTiming(3.0, 2.9, 3.1, 1.0, 1.0, 24)

    monkeypatch.setattr("conrod.execution.run_cost.time_stepper_pair", planted)
    for name, timed in (("saw-40rpm", True), ("swinging-four-bar", False)):  # the latter makes one pass
        scene = scene_named(name)
        timing = cost_of_run(scene, engine_named("mujoco").presets["stock"](scene, 100))
        assert (timing is not None) is timed
    assert len(made) == 1
    assert all(callable(stepper) for stepper in made[0])
