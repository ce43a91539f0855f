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

from conrod.cli import validate_scenes
from conrod.cli.validate import holding_of, judging_of
from conrod.cli.validate_request import CHECKS, MODEL, TABLE, Judging, Request
from conrod.errors import InvalidInput, unknown_choice
from conrod.mjcf.loops.results import LoopStudy
from conrod.own.models.results import ModelStudy
from conrod.own.tables.study import TableStudy
from conrod.report.terminal import tell
from conrod.report.writer import document_text
from conrod.scenes import Scene
from conrod.studies.frame.baseline import Held
from conrod.studies.frame.resolve_arguments import select_scene
from conrod.studies.frame.result import SceneResults

if TYPE_CHECKING:
    import mujoco

AnyStudy: TypeAlias = ModelStudy | LoopStudy | TableStudy | SceneResults[Any]
# A value as the command line takes it, a number in SI, several in a list, or by name.
Given: TypeAlias = str | Path | float | Sequence[str] | Mapping[str, Any] | None
# Options that are keywords, beside those of models and tables, and of baselines.
OF_RUNS = ("engine", "preset", "steps_per_rev", "revolutions", "assignments", "tolerance")
KEYWORDS = {
    str(one.metadata["option"]).lstrip("-").replace("-", "_"): one
    for one in dataclasses.fields(Request)
    if one.name in OF_RUNS or (one.metadata.get("heading") in (MODEL, TABLE, CHECKS) and one.name != "invariances")
}


@dataclass(frozen=True)
class Checked:
    """The answer of `check`.

    Attributes:
        study: all that was found, as objects.
        baseline: how that compares with the baseline that was named; None where none was.
        work: what was judged, which shows the study.
    """

    study: AnyStudy
    baseline: Held | None
    work: Judging

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
        return self.work.verdict(self.study)

    @property
    def text(self) -> str:
        """All that `conrod validate` prints."""
        with redirect_stdout(io.StringIO()) as printed:
            tell(self.work.told([self.study]))
        return "\n".join([printed.getvalue(), *([self.baseline.text] if self.baseline else [])])

    @property
    def json(self) -> str:
        """Content that `--json` writes."""
        return document_text(self.work.kind, dict(zip(self.work.parts, [self.study], strict=True)))

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
    if isinstance(scene, Scene):
        asked = dataclasses.replace(asked, machine=scene, scene=scene.kind)
    elif scene is not None:
        asked = dataclasses.replace(asked, scene=str(scene))
    if isinstance(subject, Scene):
        return _checked(validate_scenes.judging(asked, dict([select_scene(subject, asked.assignments)])), asked)
    if isinstance(subject, str | Path):
        return _checked_file(subject, asked)
    if scene is None and not asked.drives:
        raise InvalidInput(f"a {type(subject).__name__}: say with scene=... what machine it is")
    return _checked_in_memory(subject, asked)


def _checked_file(subject: str | Path, asked: Request) -> Checked:
    asked = dataclasses.replace(asked, subjects=(str(subject),))
    return _checked(judging_of(asked), asked)


def _checked(work: Judging, asked: Request) -> Checked:
    if len(work.parts) > 1:
        raise InvalidInput(f"{asked.subjects[0]!r} stands for many machines: name one of them")
    holding = holding_of(asked, work)
    with tempfile.TemporaryDirectory() as folder, redirect_stderr(io.StringIO()):
        # What is tested is run: no result of an earlier day answers for it.
        own = dataclasses.replace(asked, ledger=str(Path(folder, "ledger.sqlite")), fresh=True, jobs=1)
        ((study,),) = work.judge(own, [work.scenes])
        return Checked(study, holding.held(work.judge, own, [study]) if holding else None, work)


def _checked_in_memory(subject: Any, asked: Request) -> Checked:
    """Judge a model or a table in memory in a process of its own, too, which takes a file."""
    with tempfile.TemporaryDirectory() as folder:
        model, table = Path(folder, "model.mjb"), Path(folder, "table.npz")
        columns = _columns_of(subject)
        named, file = ("the model", model) if columns is None else ("the table", table)
        try:
            if columns is None:
                from conrod.own.models.loading import save_model

                save_model(subject, model)
            else:
                np.savez(table, allow_pickle=False, **_arrays(columns))
            checked = _checked_file(file, asked)
        except InvalidInput as error:
            raise type(error)(str(error).replace(str(file), named)) from None
    found: Any = checked.study
    study = dataclasses.replace(found, file=named)
    part = named if columns is None else checked.work.parts[0]
    return dataclasses.replace(checked, study=study, work=dataclasses.replace(checked.work, parts=[part]))


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
    for name in keywords:
        if name not in KEYWORDS:
            raise unknown_choice("keyword", name, KEYWORDS)
    return Request(**{KEYWORDS[name].name: _typed(KEYWORDS[name], x) for name, x in keywords.items() if x is not None})


def _typed(option: dataclasses.Field[Any], value: Any) -> Any:
    """A value as the command line gives it."""
    if {"type", "is_flag"} & {*option.metadata}:
        return value
    parts = [f"{name}={one}" for name, one in value.items()] if isinstance(value, Mapping) else value
    parts = [str(parts)] if isinstance(parts, str) or not isinstance(parts, Sequence) else [str(one) for one in parts]
    return tuple(parts) if option.metadata.get("multiple") else ",".join(parts)
