"""Verification reports that `conrod validate` and `conrod check` write with `--verification FILE`."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from conrod.cli import say
from conrod.cli.options import RUNS, VerificationOptions, columns_in, explicit_options, names_in
from conrod.cli.outputs import reproduction
from conrod.errors import InvalidInput, named_values
from conrod.execution.files import files_to_write
from conrod.execution.local import call_on_file
from conrod.execution.result import SceneResults
from conrod.execution.writing import single_file, write_together
from conrod.mechanism.units import parse_quantity
from conrod.models.check.references import ALL_LENGTHS, length_names
from conrod.models.check.results import ModelStudy
from conrod.models.invariances.api import invariances_of_file, invariances_of_scene
from conrod.models.invariances.results import InvarianceStudy
from conrod.models.tables.columns import column_request
from conrod.models.tables.estimation import check_estimated
from conrod.models.tables.reading import read_table
from conrod.models.tables.study import TableStudy, study_table
from conrod.report.drawing.drawing import mechanism_svg
from conrod.report.findings import Findings
from conrod.report.folder import ReportFolder, plain_findings, restore_findings
from conrod.scenes import Scene
from conrod.studies.limits.report import LIMITS_REPORT as LIMITS
from conrod.studies.limits.results import LimitStudy
from conrod.user_files import MODELS
from conrod.user_files.files import model_files
from conrod.verification import supporting_sections
from conrod.verification.page import (
    ChangeRecord,
    Verification,
    read_verification,
    sealed_page,
    statement_changes,
    valid_seal,
)
from conrod.verification.sections import study_sections
from conrod.verification.supporting_sections import MEASUREMENTS

MAX_TITLE = 120  # letters of --title
NOT_SHOWN = ("verification", "out", "document", "html", "baseline", "accept")


@dataclass(frozen=True)
class Dossier:
    """A verification report that is to be written, with its inputs, which are read before any run.

    Attributes:
        command, subject: verb, and the scene or file that it judges, as typed.
        before: the unchanged report that stands in the file's place; None where there is none.
        scene: scene that is judged; None for a model that is its own reference.
        measured: measurements compared with the exact motion.
        uncertainties: standard, by length or `measured` [m].
    """

    command: str
    subject: str
    asked: VerificationOptions
    file: Path
    before: bytes | None
    scene: Scene | None
    limits: LimitStudy | None
    measured: TableStudy | None
    uncertainties: Mapping[str, float]

    @classmethod
    def prepare(
        cls, command: str, subjects: Sequence[str], asked: VerificationOptions, scenes: Mapping[str, Scene]
    ) -> Dossier:
        """Read all that a verification report needs, before anything is run.

        Raises:
            InvalidInput: several machines are named, an input cannot be used, or the report would replace another file.
        """
        if len(subjects) != 1 or len(scenes) > 1:
            raise InvalidInput("--verification: a verification report is on one machine or file: name it")
        if asked.title is not None and not (asked.title.strip() and asked.title.isprintable()):
            raise InvalidInput(f"--title {asked.title!r}: give a line of printable letters")
        if len(asked.title or "") > MAX_TITLE:
            raise InvalidInput(f"--title: it has {len(asked.title or '')} letters; at most {MAX_TITLE} are shown")
        scene = next(iter(scenes.values()), None)
        beside = {
            f"the input {name}": Path(name) for name in _named_paths(asked, subjects[0])[1:] if Path(name).is_file()
        }
        given = {"--json": asked.document, "--html": asked.html, "--verification": asked.verification}
        file = files_to_write(given, beside)["--verification"]
        before, uncertainties = _existing_report(file), _parse_uncertainties(asked.uncertainties, scene)
        limits, measured = _read_limits(asked, subjects[0], scene), _study_measurements(asked, scene)
        return cls(command, subjects[0], asked, file, before, scene, limits, measured, uncertainties)

    def write(self, found: Findings[Any]) -> None:
        """Write the report on findings, and print where it is; an equal earlier report keeps its date."""
        report = self._without_places(self._report(found.study, found.verdict))
        if self.before is not None:
            old = read_verification(self.before)
            changed = statement_changes(old, report)
            record = (
                *old.record,
                *([ChangeRecord(valid_seal(self.before) or "", report.made, changed)] if changed else []),
            )
            report = replace(report, made=report.made if changed else old.made, record=record)
        drawing = "" if self.scene is None else mechanism_svg(self.scene)
        write_together([single_file(self.file, sealed_page(report, drawing))])
        say(f"report: {self.file}")

    def _report(self, study: Any, verdict: str) -> Verification:
        """Return the verification report of a study, all sections filled in."""
        scene, subject, data = self.scene, self.subject, self.uncertainties.get(MEASUREMENTS)
        found, deviations = study_sections(study)
        if scene is not None:
            changed = getattr(self.asked, "assignments", ())
            found = {"machine": supporting_sections.machine_section(scene, changed), **found}
        lengths = {name: size for name, size in self.uncertainties.items() if name != MEASUREMENTS}
        found["parameters"], moves, place = supporting_sections.parameters_section(
            scene, lengths, _length_deviations(study)
        )
        found["inputs"] = supporting_sections.inputs_section(_files(self.asked, subject), scene)
        found["software"] = supporting_sections.software_section(study)
        for section, (content, off) in {
            "validation": supporting_sections.validation_section(study, self.measured, (place, data)),
            "validity": supporting_sections.validity_section(self.limits, scene),
            "invariances": supporting_sections.invariances_section(self._invariances(study)),
        }.items():
            found[section] = content
            deviations += off
        given, target = explicit_options(self.asked, RUNS, *NOT_SHOWN), ("--verification", self.file)
        command = reproduction(self.command, {"": subject}, given, target).command_for("")
        deviations += [*moves, *([verdict] if study.passed is False else [])]
        made = f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC"
        name, changed = Path(subject).name, ", ".join(getattr(self.asked, "assignments", ()))
        title = self.asked.title or (f"{name} with {changed}" if changed else "")
        return Verification(name, verdict, made, command, found, tuple(deviations), title=title)

    def _invariances(self, study: Any) -> InvarianceStudy | str:
        """Invariances of the model; a sentence where it has none."""
        keyframe: str | None = getattr(self.asked, "keyframe", None)
        try:
            if self.subject.lower().endswith(MODELS):
                return invariances_of_file(self.subject, Path(self.subject), None, keyframe, ())
            if self.scene is None or not isinstance(study, SceneResults):
                return "they are those of a MuJoCo model file, or of the model of a planar scene"
            return invariances_of_scene(self.subject, self.scene, None, keyframe)
        except InvalidInput as error:
            return str(error)

    def _without_places(self, report: Verification) -> Verification:
        """The report with names of files only: folders of a user are left out."""
        text = json.dumps(plain_findings(report))
        for typed in _named_paths(self.asked, self.subject):
            text = text.replace(json.dumps(typed)[1:-1], json.dumps(Path(typed).name or typed)[1:-1])
        return restore_findings(Verification, json.loads(text))


def _named_paths(asked: VerificationOptions, subject: str) -> list[str]:
    """Files and folders that options name, as typed, the report first."""
    drives = [drive.partition("=table:")[2] for drive in getattr(asked, "drives", ())]
    named = (asked.verification, subject, getattr(asked, "scene", None), asked.measured, asked.limits, *drives)
    return [name for name in dict.fromkeys(named) if name]


def _files(asked: VerificationOptions, subject: str) -> list[Path]:
    """The files that are read."""
    paths = [Path(name) for name in _named_paths(asked, subject)[1:] if Path(name).is_file()]
    return [one for path in paths for one in (model_files(path) if path.suffix.lower() in MODELS else [path])]


def _existing_report(file: Path) -> bytes | None:
    """Return the content of a report that is to be replaced; None if the file is missing.

    Raises:
        InvalidInput: the file is no report, or was changed after it was written.
    """
    if not file.exists():
        return None
    page = file.read_bytes()
    try:
        if valid_seal(page) is None:
            raise InvalidInput("it was changed after it was written")
        read_verification(page)
    except InvalidInput as error:
        raise InvalidInput(f"cannot write {file}: {error}; give another name") from None
    return page


def _parse_uncertainties(texts: Sequence[str], scene: Scene | None) -> dict[str, float]:
    """Parse `NAME=VALUE` texts to standard uncertainties [m] of lengths and of the measurements."""
    known = [MEASUREMENTS, *(name for name in (length_names(scene) if scene else ()) if name != ALL_LENGTHS)]
    form = "a length and its standard uncertainty: rod=0.1mm"
    sizes = named_values(texts, "--uncertainty", form, "length", known)
    return {name: parse_quantity(f"--uncertainty {name}", size, "m") for name, size in sizes.items()}


def _read_limits(asked: VerificationOptions, subject: str, scene: Scene | None) -> LimitStudy | None:
    if asked.limits is None or scene is None:
        return None
    folder, wanted = ReportFolder(Path(asked.limits), LIMITS), getattr(asked, "scene", None) or subject
    if wanted not in folder.entries:
        known = ", ".join(folder.entries) or "nothing"
        raise InvalidInput(f"--limits {asked.limits}: it has no limits of {wanted}, but of {known}")
    return restore_findings(LIMITS.findings, folder.values(wanted))


def _study_measurements(asked: VerificationOptions, scene: Scene | None) -> TableStudy | None:
    if asked.measured is None:
        return None
    if scene is None:
        raise InvalidInput("--measured: measurements are compared with a scene: name it with --scene")
    path, points = Path(asked.measured), tuple(scene.lengths)
    reading = call_on_file(
        read_table, path, points, column_request(columns_in(asked.columns, points), asked.units, points)
    )
    estimated = check_estimated(names_in(asked.estimate) or ())
    return study_table(path.name, scene.kind, scene, reading, estimated)


def _length_deviations(study: Any) -> dict[str, float]:
    """Return how much too long each length of a model is [m], if that explains its paths."""
    found = study.identity.explanations[:1] if isinstance(study, ModelStudy) else ()
    lengths = [one for explanation in found for one in explanation.lengths]
    return {one.name: one.found - one.expected for one in lengths if one.name != ALL_LENGTHS}
