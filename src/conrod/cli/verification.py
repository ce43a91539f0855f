"""`conrod validate .. --report FILE`: a verification report on what was found, and all that belongs beside it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from conrod.cli import say
from conrod.cli.options import RUNS, as_given
from conrod.cli.outputs import reproduction
from conrod.cli.validate_invariances import of_file, of_scene
from conrod.cli.validate_request import MODELS, Judging, Request
from conrod.errors import InvalidInput, named_values
from conrod.mechanism.units import parse_quantity
from conrod.mjcf.results import InvarianceStudy
from conrod.own.files import files_of_model
from conrod.own.models.references import ALL_LENGTHS, length_names
from conrod.own.models.results import ModelStudy
from conrod.own.tables.columns import request
from conrod.own.tables.estimation import parse_estimate
from conrod.own.tables.reading import read_table
from conrod.own.tables.study import TableStudy, study_table
from conrod.report.folder import ReportFolder, restored, values_of
from conrod.report.limits.report import KIND as LIMITS
from conrod.report.verification import beside
from conrod.report.verification.beside import DATA
from conrod.report.verification.page import Change, Verification, changes, data_of, seal_of, sealed_page
from conrod.report.verification.sections import sections
from conrod.scenes import Scene
from conrod.studies.execution.local import confined
from conrod.studies.frame.files import files_to_write
from conrod.studies.frame.result import SceneResults
from conrod.studies.frame.writing import single, write_together
from conrod.studies.limits.results import LimitStudy

NOT_SHOWN = ("report", "out", "document", "html", "baseline", "accept")


@dataclass(frozen=True)
class Dossier:
    """A verification report that is to be written; all that was given for it was read before any run.

    Attributes:
        before: the unchanged report that stands in the file's place; None where there is none.
        scene: that is judged; None of a model that is its own reference.
        measured: measurements held against the exact motion.
        uncertainties: standard, by length or `measured` [m].
    """

    asked: Request
    file: Path
    before: bytes | None
    scene: Scene | None
    limits: LimitStudy | None
    measured: TableStudy | None
    uncertainties: Mapping[str, float]

    @classmethod
    def of(cls, asked: Request, work: Judging) -> Dossier:
        """The report that is asked for, on what is judged: one part.

        Raises:
            InvalidInput: it cannot be made, or something would be lost by it.
        """
        if len(work.parts) != 1 or not asked.subjects:
            raise InvalidInput("--report: a verification report is on one machine or file: name it")
        scene = next(iter(work.scenes.values()), None)
        beside = {f"the input {name}": Path(name) for name in _typed(asked)[1:] if Path(name).is_file()}
        given = {"--json": asked.document, "--html": asked.html, "--report": asked.report}
        file = files_to_write(given, beside)["--report"]
        before, uncertainties = _replaced(file), _uncertainties(asked.uncertainties, scene)
        return cls(asked, file, before, scene, _limits(asked, scene), _measured(asked, scene), uncertainties)

    def write(self, study: Any, verdict: str) -> None:
        """Write the report on a study, and say where it is; one that says the same stays as it is."""
        report = self._without_places(self._report(study, verdict))
        if self.before is not None:
            old = data_of(self.before)
            changed = changes(old, report)
            record = (*old.record, *([Change(seal_of(self.before) or "", report.made, changed)] if changed else []))
            report = replace(report, made=report.made if changed else old.made, record=record)
        write_together([single(self.file, sealed_page(report))])
        say(f"report: {self.file}")

    def _report(self, study: Any, verdict: str) -> Verification:
        scene, subject, data = self.scene, self.asked.subjects[0], self.uncertainties.get(DATA)
        found, deviations = sections(study)
        lengths = {name: size for name, size in self.uncertainties.items() if name != DATA}
        found["parameters"], moves, place = beside.parameters(scene, lengths, _off(study))
        is_model = subject.lower().endswith(MODELS)
        found["inputs"] = beside.inputs(_files(self.asked), scene)
        found["software"] = beside.software(study)
        for section, (content, off) in {
            "validation": beside.validation(study, self.measured, (place, data)),
            "validity": beside.validity(self.limits, scene),
            "invariances": beside.invariant(self._invariances(study, is_model)),
        }.items():
            found[section] = content
            deviations += off
        given, target = as_given(self.asked, RUNS, *NOT_SHOWN), ("--report", self.file)
        command = reproduction("validate", {"": subject}, given, target).of("")
        deviations += [*moves, *([verdict] if study.passed is False else [])]
        made = f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC"
        return Verification(Path(subject).name, verdict, made, command, found, tuple(deviations))

    def _invariances(self, study: Any, is_model: bool) -> InvarianceStudy | str:
        """Those of the model, or why there are none."""
        name, asked = self.asked.subjects[0], replace(self.asked, seconds=None)
        try:
            if is_model:
                return of_file(name, Path(name), asked, ())
            if self.scene is None or not isinstance(study, SceneResults):
                return "they are those of a MuJoCo model file, or of the model of a planar scene"
            return of_scene(name, self.scene, asked)
        except InvalidInput as error:
            return str(error)

    def _without_places(self, report: Verification) -> Verification:
        """The same with names of files, and not the folders that they are in, which are a user's own affair."""
        text = json.dumps(values_of(report))
        for typed in _typed(self.asked):
            text = text.replace(json.dumps(typed)[1:-1], json.dumps(Path(typed).name or typed)[1:-1])
        return restored(Verification, json.loads(text))


def _typed(asked: Request) -> list[str]:
    """Files and folders that were named, as typed, that of the report first."""
    drives = [drive.partition("=table:")[2] for drive in asked.drives]
    named = (asked.report, asked.subjects[0], asked.scene, asked.measured, asked.limits, *drives)
    return [name for name in dict.fromkeys(named) if name]


def _files(asked: Request) -> list[Path]:
    """The files that are read."""
    paths = [Path(name) for name in _typed(asked)[1:] if Path(name).is_file()]
    return [one for path in paths for one in (files_of_model(path) if path.suffix.lower() in MODELS else [path])]


def _replaced(file: Path) -> bytes | None:
    """The report that another is to take the place of; raises InvalidInput where something would be lost by that."""
    if not file.exists():
        return None
    page = file.read_bytes()
    try:
        if seal_of(page) is None:
            raise InvalidInput("it was changed after it was written")
        data_of(page)
    except InvalidInput as error:
        raise InvalidInput(f"cannot write {file}: {error}; give another name") from None
    return page


def _uncertainties(texts: Sequence[str], scene: Scene | None) -> dict[str, float]:
    """Standard uncertainties [m] by length, and of the measurements."""
    known = [DATA, *(name for name in (length_names(scene) if scene else ()) if name != ALL_LENGTHS)]
    form = "a length and its standard uncertainty: rod=0.1mm"
    sizes = named_values(texts, "--uncertainty", form, "length", known)
    return {name: parse_quantity(f"--uncertainty {name}", size, "m") for name, size in sizes.items()}


def _limits(asked: Request, scene: Scene | None) -> LimitStudy | None:
    if asked.limits is None or scene is None:
        return None
    folder, wanted = ReportFolder(Path(asked.limits), LIMITS), asked.scene or asked.subjects[0]
    if wanted not in folder.entries:
        known = ", ".join(folder.entries) or "nothing"
        raise InvalidInput(f"--limits {asked.limits}: it has no limits of {wanted}, but of {known}")
    return restored(LIMITS.findings, folder.values(wanted))


def _measured(asked: Request, scene: Scene | None) -> TableStudy | None:
    if asked.measured is None:
        return None
    if scene is None:
        raise InvalidInput("--measured: measurements are compared with a scene: name it with --scene")
    path, points = Path(asked.measured), tuple(scene.lengths)
    reading = confined(read_table, path, points, request(asked.columns, asked.units, points))
    estimated = () if asked.estimate is None else parse_estimate(asked.estimate)
    return study_table(path.name, scene.kind, scene, reading, estimated)


def _off(study: Any) -> dict[str, float]:
    """By how much lengths of a user's model are too long [m], where that explains its paths."""
    found = study.identity.explanations[:1] if isinstance(study, ModelStudy) else ()
    lengths = [one for explanation in found for one in explanation.lengths]
    return {one.name: one.found - one.expected for one in lengths if one.name != ALL_LENGTHS}
