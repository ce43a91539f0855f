"""`conrod validate MODEL --drive JOINT=LAW`: closed loops of any MuJoCo model, judged by its own exact motion."""

from __future__ import annotations

import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from rich.text import Text

from conrod.cli import FAILED, waiting
from conrod.cli.options import as_given
from conrod.cli.outputs import outputs
from conrod.cli.validate_file import Subject
from conrod.cli.validate_request import Request
from conrod.errors import InvalidInput, named_values
from conrod.exact.space.laws import FORMS
from conrod.mechanism.units import check_number, in_prose, parse_quantity
from conrod.mjcf.loops.results import QUANTITIES, LoopStudy, Question
from conrod.own.files import as_outputs_must_not_be, check_readable
from conrod.own.models.request import controls_of
from conrod.report.loops import KIND, finding, how_exact, runs_table, what_moves
from conrod.report.terminal import console, print_lines, print_table
from conrod.scenes.space import MACHINES, SPATIAL
from conrod.studies.execution.local import FILE_TIMEOUT, confined
from conrod.studies.frame.writing import naming

TAKEN = (
    "--drive",
    "--engine",
    "--ctrl",
    "--keyframe",
    "--point",
    "--scene",
    "--seconds",
    "--tolerance",
    "--out",
    "--html",
    "--report",
    "--json",
)


def is_spatial(name: str) -> bool:
    """True if a name is that of a spatial machine."""
    return name in MACHINES


def validate_loops(asked: Request) -> None:
    """Judge model files and spatial machines, print what was found, write what is to be written.

    Raises:
        InvalidInput: bad usage, or a model that cannot be used.
    """
    from conrod.cli.verification import Dossier

    subjects = tuple(MACHINES) if SPATIAL in asked.subjects else asked.subjects
    question, named = question_of(asked), [name for name in subjects if not is_spatial(name)]
    for name in named:
        check_readable(Path(name))
    parts = {name if is_spatial(name) else Path(name).stem: name for name in subjects}
    if hidden := [name for name in subjects if name not in parts.values()] or subjects[len(parts) :]:
        raise InvalidInput(f"{hidden[0]}: another has the same name in the report: judge it by itself")
    guarded = dict[str, Path]()
    for name in named:
        guarded |= as_outputs_must_not_be(Path(name))
    files, dossier = outputs(KIND, parts, asked, guarded), Dossier.of(asked, dict.fromkeys(parts))
    found = {}
    for part, name in parts.items():
        with waiting(name, FILE_TIMEOUT):
            found[part] = judge_machine(name, question) if is_spatial(name) else judge(Path(name), question, part)
    with naming("standard output"):
        for one in found.values():
            show(one)
    files.write(found, "validate", parts, asked)
    if dossier:
        dossier.write(one, finding(one))
    if not all(one.passed for one in found.values()):
        sys.exit(FAILED)


def judge_machine(name: str, question: Question) -> LoopStudy:
    """A spatial machine's own model, driven as it is made for unless laws are given."""
    machine = MACHINES[name]()
    own = replace(question, machine=name, drives=question.drives or dict(machine.drives))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"{name}.xml")
        path.write_text(machine.mjcf, encoding="utf-8")
        try:
            return replace(judge(path, own, name), file=name)
        except InvalidInput as error:
            raise InvalidInput(str(error).replace(f"{path}", name)) from None


def judge(path: Path, question: Question, name: str) -> LoopStudy:
    """The study of a file, made in a process of its own."""
    from conrod.mjcf.loops.study import study

    return confined(study, path, question, name)


def judge_file(path: Path, _: object, asked: Request) -> LoopStudy:
    """A model file as the options ask; raises InvalidInput where it or one of them cannot be used."""
    return judge(path, question_of(asked), path.stem)


def question_of(asked: Request) -> Question:
    """The question that the options ask.

    Raises:
        InvalidInput: an option that does not go with --drive, or whose value is none.
    """
    if others := [name for name in asked.engine if name != "mujoco"]:
        raise InvalidInput(f"--engine {others[0]}: unsupported, it is planar; machines in space run in mujoco")
    if other := next((name for name in as_given(asked) if name not in TAKEN), None):
        raise InvalidInput(f"{other} does not go with --drive, which takes {', '.join(TAKEN[1:])}")
    if asked.seconds is not None:
        check_number("--seconds", asked.seconds, 1e-6, 1e6, "s")
    drives = named_values(asked.drives, "--drive", f"a joint and its law, JOINT=LAW; LAW: {FORMS}")
    if not drives and asked.scene is not None and is_spatial(asked.scene):
        drives = dict(MACHINES[asked.scene]().drives)
    points = tuple(place.removeprefix("site:").removeprefix("body:") for place in asked.points)
    allowed = tolerance_of(asked.tolerance)
    return Question(drives, asked.keyframe, controls_of(asked.controls), asked.seconds, points, allowed, asked.scene)


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
    if study.paste:
        print_lines(out, ["the cheapest settings within tolerance, to paste:", study.paste], verbatim=True)


LOOPS = Subject(KIND, judge_file, show, finding, FILE_TIMEOUT)
