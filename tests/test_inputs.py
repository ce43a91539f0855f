"""Wrong inputs are named, healthy ones raise no alarm: a fast sample of `make inputs`, and how answers are judged."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from command_line import conrod

from docs.studies.inputs.__main__ import BEGIN, END, KINDS, all_inputs, misses, section, table
from docs.studies.inputs.input import Answer, Input, answer_of, judge

INPUTS = {f"{one.kind}: {'healthy' if one.healthy else 'wrong'}: {one.name}": one for one in all_inputs()}
# Of each kind some that take a second or so.
SAMPLE = (
    "lengths of a model: wrong: rod 0.01 % longer",
    "joints and axes: wrong: a crank that there is none of",
    "closures: healthy: stiff enough, by lint",
    "starts and keyframes: wrong: a start nearer to another assembly",
    "drives, speeds, actuators: wrong: a hinge's law in mm/s",
    "drives, speeds, actuators: wrong: a joint that there is none of",
    "what acts besides: wrong: a stop in the way of the crank",
    "columns, units and clocks of tables: wrong: degrees in a column of radians",
    "columns, units and clocks of tables: wrong: a cell that is no number",
    "columns, units and clocks of tables: healthy: six digits",
    "sensors: wrong: an encoder's zero off by 3 deg",
    "sensors: healthy: noise of 0.1 mm, measured",
    "mechanism files: wrong: a field that is misspelt",
    "mechanism files: healthy: another rod",
    "printed values, FMUs, settings: wrong: all of the other sign",
    "printed values, FMUs, settings: healthy: printed in three digits",
)


def test_each_kind_has_ten_wrong_and_ten_healthy_inputs() -> None:
    counts = Counter((one.kind, one.healthy) for one in INPUTS.values())
    assert len(KINDS) == 10
    assert set(counts.values()) == {10}
    assert len({one.key for one in INPUTS.values()}) == 200


@pytest.mark.parametrize("name", SAMPLE)
def test_wrong_input_is_named_and_healthy_one_raises_no_alarm(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = INPUTS[name]
    for file, content in given.files.items():
        (tmp_path / file).write_bytes(content if isinstance(content, bytes) else content.encode())
    monkeypatch.chdir(tmp_path)
    done = conrod(*given.arguments)
    answer = answer_of(done.returncode, done.stdout, done.stderr)
    assert judge(given, answer) in ("named rightly", "no alarm"), answer


WRONG = Input("k", "n", {}, (), r"\brod\b", False, (1, 2))
HEALTHY = replace(WRONG, healthy=True, expected="within", statuses=(0,))


@pytest.mark.parametrize(
    ("given", "status", "output", "verdict"),
    [
        (WRONG, 1, "the rod is too long", "named rightly"),
        (WRONG, 2, "conrod: no rod", "named rightly"),
        (WRONG, 2, "conrod: no rod\nand a second line", "named otherwise"),
        (WRONG, 1, "none of the common causes reproduces the difference", "unknown said"),
        (WRONG, 1, "the crank is too long", "named otherwise"),
        (WRONG, 0, "the rod is too long", "silent"),
        (WRONG, 1, "Traceback (most recent call last)", "traceback"),
        (WRONG, 3, "the rod", "traceback"),
        (WRONG, -1, "no answer within 300 s", "traceback"),
        (HEALTHY, 0, "within tolerance", "no alarm"),
        (HEALTHY, 0, "measured", "not said to be measured"),
        (HEALTHY, 1, "within tolerance", "alarm"),
        (HEALTHY, 0, "within tolerance, likely cause: mm for m", "alarm"),
    ],
)
def test_answers_are_judged_by_status_and_words(given: Input, status: int, output: str, verdict: str) -> None:
    answer = Answer(status, output, output)
    assert judge(given, answer) == verdict
    missed = misses({given.key: answer}, [given])
    assert bool(missed) is (verdict not in ("named rightly", "unknown said", "no alarm"))


def test_progress_lines_are_no_part_of_an_answer() -> None:
    answer = answer_of(
        1,
        "\nthe rod is too long\n",
        "runs: 1 to do\nm.xml: running (stops itself after 600 s; Ctrl-C stops now)\nnote\n",
    )
    assert answer.first == "the rod is too long"
    assert answer.output == "\nthe rod is too long\nnote"


def test_detection_page_has_the_tables_of_all_inputs() -> None:
    page = (Path(__file__).parents[1] / "docs" / "detection.md").read_text(encoding="utf-8")
    kept = page[page.index(BEGIN) : page.index(END)]
    for one in INPUTS.values():
        assert f"| {one.kind} | 10 |" in kept
    found = {one.key: Answer(1, one.expected, one.expected) for one in INPUTS.values()}
    asked = list(INPUTS.values())
    assert table(found, asked, True)[-1] == "| all | 100 | 0 | 0 | 100 | 0 |"
    assert section(found, asked).count("\n- alarm: ") == 100
