"""`conrod validate MODEL --drive JOINT=LAW`: closed loops of any MuJoCo model, judged by its own exact motion."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from conrod.cli import waiting
from conrod.cli.options import refuse_others
from conrod.cli.validate_request import Judging, Request
from conrod.errors import InvalidInput, named_values
from conrod.exact.space.drive_laws import FORMS
from conrod.mechanism.units import check_number
from conrod.mjcf.loops.results import QUANTITIES, LoopStudy, Question
from conrod.own.files import as_outputs_must_not_be, check_readable
from conrod.own.models.request import controls_of
from conrod.report.loops import KIND, finding, how_exact, runs_table, what_moves
from conrod.report.table import Verbatim
from conrod.report.terminal import Part, said, under
from conrod.scenes.space import MACHINES, SPATIAL
from conrod.studies.execution.local import FILE_TIMEOUT, confined
from conrod.studies.frame.resolve_arguments import parse_tolerance

TAKEN = (
    *("--drive", "--ctrl", "--keyframe", "--point", "--scene", "--seconds", "--tolerance"),
    *("--engine", "--out", "--html", "--report", "--json"),
)


def judging(asked: Request) -> Judging:
    """Model files and spatial machines by their own exact motion.

    Raises:
        InvalidInput: bad usage, or a model that cannot be used.
    """
    subjects = tuple(MACHINES) if SPATIAL in asked.subjects else asked.subjects
    named = [name for name in subjects if name not in MACHINES]
    for name in named:
        check_readable(Path(name))
    question, inputs = question_of(asked), dict[str, Path]()
    parts = {name if name in MACHINES else Path(name).stem: name for name in subjects}
    if hidden := [name for name in subjects if name not in parts.values()] or subjects[len(parts) :]:
        raise InvalidInput(f"{hidden[0]}: another has the same name in the report: judge it by itself")
    for name in [*named, *([asked.scene] if asked.scene and asked.scene not in MACHINES else [])]:
        inputs |= as_outputs_must_not_be(Path(name))

    def judged(part: str, name: str) -> LoopStudy:
        with waiting(name, FILE_TIMEOUT):
            return judge_machine(name, question) if name in MACHINES else judge(Path(name), question, part)

    return Judging(
        kind=KIND,
        typed=parts,
        parts=list(parts),
        judge=lambda _, others: [[judged(*one) for one in parts.items()] for _ in others],
        told=loops_found,
        verdict=finding,
        inputs=inputs,
    )


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


def question_of(asked: Request) -> Question:
    """The question that the options ask.

    Raises:
        InvalidInput: an option that does not go with --drive, or whose value is none.
    """
    if others := [name for name in asked.engine if name != "mujoco"]:
        raise InvalidInput(f"--engine {others[0]}: unsupported, it is planar; machines in space run in mujoco")
    refuse_others(asked, "--drive", *TAKEN)
    if asked.seconds is not None:
        check_number("--seconds", asked.seconds, 1e-6, 1e6, "s")
    drives = named_values(asked.drives, "--drive", f"a joint and its law, JOINT=LAW; LAW: {FORMS}")
    if not drives and asked.scene is not None and asked.scene in MACHINES:
        drives = dict(MACHINES[asked.scene]().drives)
    points = tuple(place.removeprefix("site:").removeprefix("body:") for place in asked.points)
    allowed = {} if asked.tolerance is None else parse_tolerance(asked.tolerance, QUANTITIES)
    return Question(drives, asked.keyframe, controls_of(asked.controls), asked.seconds, points, allowed, asked.scene)


def loops_found(studies: Sequence[LoopStudy]) -> Iterator[Part]:
    """Of each model the finding, what moves, the runs and how exact they are."""
    for study in studies:
        yield said(f"{study.file}: {finding(study)}", study.passed)
        yield from (*under("what moves", what_moves(study)), *under("how exact", how_exact(study)), "")
        yield runs_table(study)
        if study.paste:
            yield from ("the cheapest settings within tolerance, to paste:", Verbatim(study.paste))
