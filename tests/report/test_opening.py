"""The first sentence of a report names what is far off, judged or not."""

from __future__ import annotations

from dataclasses import replace

from conrod.report.results import index_words, summary_words
from conrod.scenes import SCENES
from conrod.studies.validation.results import SceneStudy, ValidationResult
from conrod.studies.validation.tables import results_to_print
from tests.report.test_errors_in_mm import OFF, planted_run

SAW = SCENES["saw-500rpm"]


def off_by(metres: float, preset: str | None, judged: bool = True) -> ValidationResult:
    """A run of the saw that is off by a distance."""
    run = planted_run("saw-500rpm", preset)
    share = metres / OFF
    assert run.errors
    position = {p: {m: share * size for m, size in (one["position"] or {}).items()} for p, one in run.errors.items()}
    errors = {p: {**one, "position": position[p]} for p, one in run.errors.items()}
    return replace(run, errors=errors, passed=True if judged else None)


RUNS = (off_by(7.9e-3, "stock", judged=False), off_by(8e-8, "tuned"), off_by(1e-11, "hardened"))
SAID = (
    "MuJoCo as it comes (stock) is 7.9 mm off (not judged); "
    "tuned 8.0e-5 mm and hardened 1.0e-8 mm are within tolerance."
)


def test_opening_names_the_offset_of_what_is_not_judged() -> None:
    assert summary_words(RUNS, SAW.lengths) == SAID
    # Negative control: the sizes are those of the runs, and follow them.
    assert "stock) is 4.6 mm off" in summary_words([off_by(4.6e-3, "stock", judged=False), *RUNS[1:]], SAW.lengths)


def test_opening_names_what_failed_first() -> None:
    failed = replace(RUNS[1], passed=False)
    said = summary_words([RUNS[0], failed, RUNS[2]], SAW.lengths)
    assert said.startswith("1 of 2 judged results did not pass: MuJoCo tuned. MuJoCo as it comes (stock) is 7.9 mm off")
    assert said.endswith("(not judged); hardened 1.0e-8 mm is within tolerance.")


def test_opening_names_a_run_that_did_not_complete() -> None:
    ended = replace(RUNS[0], outcome="diverged", errors=None)
    said = summary_words([ended, RUNS[1]], SAW.lengths)
    assert said == "MuJoCo as it comes (stock) ended as diverged (not judged); tuned 8.0e-5 mm is within tolerance."
    assert summary_words([RUNS[0]], SAW.lengths) == "Nothing was judged. " + SAID.partition(";")[0] + "."


def test_the_prompt_begins_with_the_opening() -> None:
    study = SceneStudy("saw-500rpm", SAW, RUNS)
    assert str(next(iter(results_to_print([study])))) == f"saw-500rpm: {SAID}"


def test_index_names_the_worst_machine_of_each_engine() -> None:
    def entry(off: float, passed: bool = True) -> dict[str, object]:
        runs = [
            {"engine": "mujoco", "preset": "stock", "passed": None, "position_m": off},
            {"engine": "mujoco", "preset": "tuned", "passed": passed, "position_m": 2.7e-6},
        ]
        return {"summary": {"passed": passed, "results": runs}}

    entries = {"slow": entry(2.1e-4), "fast": entry(7.9e-3)}
    assert index_words(entries) == (
        "As they come (stock, not judged), MuJoCo is up to 7.9 mm off (fast). "
        "All that is judged is within tolerance, off by at most 0.0027 mm."
    )
    assert index_words({**entries, "bad": entry(1e-4, passed=False)}).endswith("Not passed: bad.")
