"""`conrod.check`: what `conrod validate FILE` does, from Python; nothing is printed."""

from __future__ import annotations

import dataclasses
import io
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from conrod.cli.validate import check_file
from conrod.cli.validate_file import MODEL, TABLE, Subject, subject_of
from conrod.cli.validate_request import Request
from conrod.errors import InvalidInput
from conrod.own.models.study import ModelStudy
from conrod.own.tables.study import TableStudy
from conrod.report.writer import document_text
from conrod.scenes import Scene

if TYPE_CHECKING:
    import mujoco

# A value as the command line takes it, a number in SI, several in a list, or by name.
Given: TypeAlias = str | float | Sequence[str] | Mapping[str, Any] | None


@dataclass(frozen=True)
class Checked:
    """The answer of `check`.

    Attributes:
        study: all that was found, as objects.
    """

    study: ModelStudy | TableStudy

    @property
    def passed(self) -> bool | None:
        """True where `conrod validate` ends with status 0 and something was judged; None where nothing was."""
        return self.study.passed

    @property
    def verdict(self) -> str:
        """The answer in a few sentences, the first of which says it."""
        return self._subject.verdict(self.study)

    @property
    def text(self) -> str:
        """All that `conrod validate` prints."""
        with redirect_stdout(io.StringIO()) as printed:
            self._subject.show(self.study)
        return printed.getvalue()

    @property
    def json(self) -> str:
        """What `--json` writes."""
        return document_text(self._subject.kind, {self._subject.part(Path(self.study.file)): self.study})

    @property
    def _subject(self) -> Subject:
        return MODEL if isinstance(self.study, ModelStudy) else TABLE

    def __repr__(self) -> str:
        return f"<{type(self).__name__} passed={self.passed}: {self.verdict.split('. ')[0].rstrip('.')}>"


def check(
    subject: str | Path | mujoco.MjModel | Mapping[str, Any],
    scene: str | Path | Scene,
    *,
    crank: str | None = None,
    point: Given = None,
    plane: str | None = None,
    rotation: str | float | None = None,
    crank_zero: str | float | None = None,
    length_unit: str | None = None,
    keyframe: str | int | None = None,
    touching: Given = None,
    ctrl: Given = None,
    column: Given = None,
    unit: Given = None,
    estimate: Given = None,
    revolutions: int | None = None,
    tolerance: Given = None,
    set: Given = None,
) -> Checked:
    """Judge a MuJoCo model or a table against a machine, as `conrod validate FILE --scene SCENE` does.

    The keywords are that command's options. What it takes as NAME=VALUE is a mapping here, a list is one, and a number
    without a unit is SI: `point={"C": "site:tip"}, tolerance={"position": 1e-4}, set={"crank": "80 mm"}`.

    Args:
        subject: a model (the path of an MJCF or binary file, or compiled), or a table (the path of a file, or a mapping
            of numpy arrays (T,), with `C` of shape (T, 2) for `C.x` and `C.y`).
        scene: the machine that it is to be: a name, a mechanism file, or a scene.

    Raises:
        InvalidInput: the subject, the scene or a keyword cannot be used.
    """
    asked = _request({name: value for name, value in locals().items() if name not in ("subject", "scene")})
    machine = scene if isinstance(scene, Scene) else str(scene)
    if isinstance(subject, str | Path):
        path = Path(subject)
        check_file(path)
        return Checked(subject_of(path).judge(path, machine, asked))
    with tempfile.TemporaryDirectory() as folder:
        # Also what is in memory is judged in processes of its own, which take files.
        model, table = Path(folder, "model.mjb"), Path(folder, "table.npz")
        try:
            if isinstance(subject, Mapping):
                np.savez(table, allow_pickle=False, **_columns(subject))
                study: ModelStudy | TableStudy = TABLE.judge(table, machine, asked)
            else:
                from conrod.own.models.loading import save_model

                save_model(subject, model)
                study = MODEL.judge(model, machine, asked)
        except InvalidInput as error:
            raise InvalidInput(str(error).replace(str(model), "the model").replace(str(table), "the table")) from None
    return Checked(dataclasses.replace(study, file="the table" if isinstance(study, TableStudy) else "the model"))


def _columns(given: Mapping[str, Any]) -> dict[str, Any]:
    """Arrays by name; raises InvalidInput where one is none."""
    arrays = {str(name): np.asarray(value) for name, value in given.items()}
    for name, array in arrays.items():
        # The last two are numpy's own keywords.
        if array.dtype.kind not in "fiu" or array.ndim == 0 or name in ("file", "allow_pickle"):
            raise InvalidInput(f"the table: {name!r}: an array of numbers is wanted, by the name of a column")
    return arrays


def _request(keywords: Mapping[str, Given | int]) -> Request:
    """Keywords as the options of their names."""
    fields = {keyword_of(one): one for one in dataclasses.fields(Request) if one.metadata}
    return Request(**{fields[name].name: _typed(fields[name], x) for name, x in keywords.items() if x is not None})


def keyword_of(option: dataclasses.Field[Any]) -> str:
    """The keyword of `check` that an option of `conrod validate` is."""
    return str(option.metadata["option"]).lstrip("-").replace("-", "_")


def _typed(option: dataclasses.Field[Any], value: Any) -> Any:
    """A value as the command line gives it."""
    if "type" in option.metadata:
        return value
    parts = [f"{name}={one}" for name, one in value.items()] if isinstance(value, Mapping) else value
    parts = [str(parts)] if isinstance(parts, str) or not isinstance(parts, Sequence) else [str(one) for one in parts]
    return tuple(parts) if option.metadata.get("multiple") else ",".join(parts)
