"""`conrod validate MODEL --drive JOINT=LAW`: closed loops of any MuJoCo model, judged by its own exact motion."""

from __future__ import annotations

import sys
from pathlib import Path

from rich.text import Text

from conrod.cli import FAILED
from conrod.cli.options import as_given
from conrod.cli.outputs import outputs
from conrod.cli.say import waiting
from conrod.cli.validate_request import Request
from conrod.errors import InvalidInput, named_values
from conrod.exact.space.laws import FORMS
from conrod.mechanism.units import check_number, in_prose, parse_quantity
from conrod.mjcf.loops.results import QUANTITIES, LoopStudy, Question
from conrod.own.files import as_outputs_must_not_be, check_readable
from conrod.report.loops import KIND, finding, how_exact, runs_table, what_moves
from conrod.report.terminal import console, print_lines, print_table
from conrod.studies.execution.isolation import FILE_TIMEOUT, confined
from conrod.studies.frame.writing import naming

TAKEN = ("--drive", "--ctrl", "--keyframe", "--point", "--seconds", "--tolerance", "--out", "--json")


def validate_loops(asked: Request) -> None:
    """Judge a model file, print what was found, write what is to be written; raises InvalidInput for bad usage."""
    if len(asked.subjects) > 1:
        raise InvalidInput(f"--drive is for one model at a time, not for {len(asked.subjects)}")
    path = Path(asked.subjects[0])
    check_readable(path)
    question = question_of(asked)
    files = outputs(KIND, [path.stem], asked, as_outputs_must_not_be(path))
    with waiting(path, FILE_TIMEOUT):
        found = judge(path, question)
    with naming("standard output"):
        show(found)
    files.write({path.stem: found}, "validate", {path.stem: str(path)}, asked)
    if not found.passed:
        sys.exit(FAILED)


def judge(path: Path, question: Question) -> LoopStudy:
    """The study of a file, made in a process of its own."""
    from conrod.mjcf.loops.study import study

    return confined(study, path, question, path.stem)


def question_of(asked: Request) -> Question:
    """What the options ask.

    Raises:
        InvalidInput: an option that does not go with --drive, or whose value is none.
    """
    if other := next((name for name in as_given(asked) if name not in TAKEN), None):
        raise InvalidInput(f"{other} does not go with --drive, which takes {', '.join(TAKEN[1:])}")
    if asked.seconds is not None:
        check_number("--seconds", asked.seconds, 1e-6, 1e6, "s")
    controls = named_values(
        asked.controls, "--ctrl", f"an actuator and a number, or a law of time: motor=4.19; {FORMS}"
    )
    return Question(
        named_values(asked.drives, "--drive", f"a joint and its law: JOINT={FORMS}"), asked.keyframe, controls,
        asked.seconds, tuple(place.removeprefix("site:") for place in asked.points), tolerance_of(asked.tolerance),
    )  # fmt: skip


def tolerance_of(text: str | None) -> dict[str, float]:
    """Allowed errors by quantity [SI] of a text like position=0.1mm,velocity=1e-3."""
    if text is None:
        return {}
    form = "a quantity and a size: position=0.1mm"
    found = dict[str, float]()
    for name, size in named_values(text.split(","), "--tolerance", form, "quantity", QUANTITIES).items():
        found[name] = parse_quantity(f"--tolerance {name}", size, QUANTITIES[name])
        check_number(f"--tolerance {name}", found[name], 1e-15, 1e6, in_prose(QUANTITIES[name]))
    return found


def show(study: LoopStudy) -> None:
    """Print the finding, what moves, the runs and how exact they are."""
    out = console()
    print_lines(out, [Text(f"{study.file}: {finding(study)}", "green" if study.passed else "red")])
    for title, lines in {"what moves": what_moves(study), "how exact": how_exact(study)}.items():
        print_lines(out, ("", title))
        print_lines(out, lines, indent=2)
    print_lines(out, [""])
    print_table(out, runs_table(study))
