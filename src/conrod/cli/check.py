"""`conrod.check`: what `conrod validate` does, from Python; nothing is printed."""

from __future__ import annotations

import dataclasses
import io
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from conrod.cli.baseline import Holding
from conrod.cli.options import refuse
from conrod.cli.runner import Runner
from conrod.cli.validate import check_file
from conrod.cli.validate_file import MODEL, TABLE, Subject, held_file, part_of, subject_of
from conrod.cli.validate_loops import LOOPS, is_spatial, judge_file, judge_machine, question_of
from conrod.cli.validate_request import MODELS, TABLES, CheckOptions, ModelOptions, Request, TableOptions
from conrod.cli.validate_scenes import held_scenes, measured_of, print_verdicts, scene_verdict
from conrod.errors import InvalidInput, unknown_choice
from conrod.mjcf.loops.results import LoopStudy
from conrod.own.models.results import ModelStudy
from conrod.own.tables.study import TableStudy
from conrod.report.validation import KIND
from conrod.report.writer import document_text
from conrod.scenes import Scene
from conrod.studies.frame.baseline import Held
from conrod.studies.frame.resolve_arguments import select_scene
from conrod.studies.frame.result import SceneResults

if TYPE_CHECKING:
    import mujoco

# A value as the command line takes it, a number in SI, several in a list, or by name.
AnyStudy: TypeAlias = ModelStudy | LoopStudy | TableStudy | SceneResults[Any]
Given: TypeAlias = str | Path | float | Sequence[str] | Mapping[str, Any] | None
# How each is shown and put in words.
SCENES = Subject(KIND, lambda *_: None, lambda study: print_verdicts([study]), scene_verdict, 0.0)
SUBJECTS = {ModelStudy: MODEL, LoopStudy: LOOPS, TableStudy: TABLE}
# Options that are keywords, beside those of models and tables, and of baselines.
OF_RUNS = ("engine", "preset", "steps_per_rev", "revolutions", "assignments", "tolerance")


@dataclass(frozen=True)
class Checked:
    """The answer of `check`.

    Attributes:
        study: all that was found, as objects.
        baseline: how that compares with the baseline that was named; None where none was.
    """

    study: AnyStudy
    baseline: Held | None = None

    @property
    def in_law(self) -> bool | None:
        """True if all that was judged is within tolerance, a baseline apart; None where nothing was judged."""
        results = getattr(self.study, "results", None)
        judged = results is None or any(one.passed is not None for one in results)
        return self.study.passed if judged else None

    @property
    def passed(self) -> bool | None:
        """True where `conrod validate` ends with status 0 and something was judged; None where nothing was."""
        if self.baseline is None or self.in_law is False:
            return self.in_law
        return self.baseline.passed

    @property
    def verdict(self) -> str:
        """The answer in a few sentences, the first of which says it."""
        return self._subject.verdict(self.study)

    @property
    def text(self) -> str:
        """All that `conrod validate` prints."""
        with redirect_stdout(io.StringIO()) as printed:
            self._subject.show(self.study)
        return "\n".join([printed.getvalue(), *([self.baseline.text] if self.baseline else [])])

    @property
    def json(self) -> str:
        """Content that `--json` writes."""
        study, subject = self.study, self._subject
        part = study.name if isinstance(study, SceneResults) else part_of(subject, Path(study.file))
        return document_text(subject.kind, {part: study})

    @property
    def _subject(self) -> Subject:
        return SUBJECTS.get(type(self.study), SCENES)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} passed={self.passed}: {self.verdict.split('. ')[0].rstrip('.')}>"


def check(
    subject: str | Path | Scene | mujoco.MjModel | mujoco.MjSpec | Mapping[str, Any] | Any,
    scene: str | Path | Scene | None = None,
    **keywords: Given,
) -> Checked:
    """Judge engines on a scene, or a MuJoCo model or a table against one, as `conrod validate` does.

    The keywords are that command's options. What it takes as NAME=VALUE is a mapping here, a list is one, and a number
    without a unit is SI: `point={"C": "site:tip"}, tolerance={"position": 1e-4}, set={"crank": "80 mm"}`.

    Args:
        subject: a scene (a name, a mechanism file, or a `Scene`), a model (the path of an MJCF or binary file, or one
            in memory), an FMU (its path), or a table (the path of a file, a data frame, or a mapping of numpy
            arrays (T,), with `C` of shape (T, 2) for `C.x` and `C.y`).
        scene: the machine that a model or a table is to be, as a name, a mechanism file, or a `Scene`; none for a model
            whose joints are driven by laws, `drive={"hip": "60rpm"}` (docs/closed-loops.md).
        keywords: `baseline` is the file of an earlier run that this one is compared with, written where there is none;
            `accept` writes it again (docs/ci.md).

    Raises:
        InvalidInput: the subject, the scene or a keyword cannot be used.
    """
    asked = _request(keywords)
    if isinstance(subject, str) and is_spatial(subject):
        return Checked(judge_machine(subject, question_of(asked)))
    if asked.drives or (isinstance(scene, str) and is_spatial(scene)):
        asked = dataclasses.replace(asked, scene=None if scene is None else str(scene))
        if not isinstance(subject, str | Path):
            return _check_in_memory(subject, "", asked, LOOPS)
        check_file(Path(subject))
        return Checked(judge_file(Path(subject), None, asked))
    if scene is None:
        return _check_scene(subject, asked)
    machine = scene if isinstance(scene, Scene) else str(scene)
    if isinstance(subject, str | Path):
        path = Path(subject)
        check_file(path)
        return _check_file(subject_of(path), path, machine, asked)
    return _check_in_memory(subject, machine, asked)


def _check_file(kind: Subject, path: Path, machine: str | Scene, asked: Request) -> Checked:
    holding = None if kind is LOOPS else Holding.of(asked, dict([select_scene(machine, asked.assignments)]))
    study = kind.judge(path, machine, asked)
    return Checked(study, held_file(holding, kind.judge, path, asked, study))


def _check_in_memory(subject: Any, machine: str | Scene, asked: Request, kind: Subject = MODEL) -> Checked:
    """Judge a model in memory in a process of its own, too, which takes a file."""
    with tempfile.TemporaryDirectory() as folder:
        model, table = Path(folder, "model.mjb"), Path(folder, "table.npz")
        try:
            if (columns := _columns_of(subject)) is not None:
                np.savez(table, allow_pickle=False, **_arrays(columns))
                checked = _check_file(TABLE, table, machine, asked)
            else:
                from conrod.own.models.loading import save_model

                save_model(subject, model)
                checked = _check_file(kind, model, machine, asked)
        except InvalidInput as error:
            said = str(error).replace(str(model), "the model").replace(str(table), "the table")
            raise type(error)(said) from None
    named: Any = {"file": "the table" if isinstance(checked.study, TableStudy) else "the model"}
    return dataclasses.replace(checked, study=dataclasses.replace(checked.study, **named))


def _check_scene(subject: Any, asked: Request) -> Checked:
    if isinstance(subject, str | Path) and not str(subject).lower().endswith(MODELS + TABLES):
        subject = str(subject)
    elif not isinstance(subject, Scene):
        shown = subject if isinstance(subject, str | Path) else f"a {type(subject).__name__}"
        raise InvalidInput(f"{shown}: say with scene=... what machine it is; `conrod show` lists them")
    refuse(asked, "a scene: it is for a file", ModelOptions, TableOptions)
    scenes = dict([select_scene(subject, asked.assignments)])
    measured, holding = measured_of(asked, scenes), Holding.of(asked, scenes)
    with tempfile.TemporaryDirectory() as folder:
        # What is tested is run: no result of an earlier day answers for it.
        own = dataclasses.replace(asked, ledger=str(Path(folder, "ledger.sqlite")), fresh=True, jobs=1)
        with redirect_stderr(io.StringIO()), Runner.of(own) as runner:
            found = runner.pursue(measured.study)
            return Checked(found[0], held_scenes(holding, asked, found, runner))


def _columns_of(subject: Any) -> Mapping[str, Any] | None:
    """Columns by name of a mapping or a data frame (pandas, polars, pyarrow); None of what has none."""
    if isinstance(subject, Mapping):
        return subject
    names = getattr(subject, "column_names", getattr(subject, "columns", None))
    return None if names is None else {str(name): subject[name] for name in names}


def _arrays(given: Mapping[str, Any]) -> dict[str, Any]:
    """Arrays by name; raises InvalidInput where one is none."""
    arrays = {str(name): np.asarray(value) for name, value in given.items()}
    for name, array in arrays.items():
        # The last two are numpy's own keywords.
        if array.dtype.kind not in "fiu" or array.ndim == 0 or name in ("file", "allow_pickle"):
            raise InvalidInput(f"the table: {name!r}: an array of numbers is wanted, by the name of a column")
    return arrays


def _request(keywords: Mapping[str, Given]) -> Request:
    """Keywords as the options of their names; raises InvalidInput for one that is none."""
    ours = {one.name for kind in (ModelOptions, TableOptions, CheckOptions) for one in dataclasses.fields(kind)}
    fields = {
        keyword_of(one): one
        for one in dataclasses.fields(Request)
        if one.name in (ours - {"invariances"}).union(OF_RUNS)
    }
    for name in keywords:
        if name not in fields:
            raise unknown_choice("keyword", name, fields)
    return Request(**{fields[name].name: _typed(fields[name], x) for name, x in keywords.items() if x is not None})


def keyword_of(option: dataclasses.Field[Any]) -> str:
    """The keyword of `check` that an option of `conrod validate` is."""
    return str(option.metadata["option"]).lstrip("-").replace("-", "_")


def _typed(option: dataclasses.Field[Any], value: Any) -> Any:
    """A value as the command line gives it."""
    if {"type", "is_flag"} & {*option.metadata}:
        return value
    parts = [f"{name}={one}" for name, one in value.items()] if isinstance(value, Mapping) else value
    parts = [str(parts)] if isinstance(parts, str) or not isinstance(parts, Sequence) else [str(one) for one in parts]
    return tuple(parts) if option.metadata.get("multiple") else ",".join(parts)
