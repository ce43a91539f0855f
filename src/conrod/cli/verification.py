"""`conrod validate .. --report FILE`: a verification report on what was found, and all that belongs beside it."""

from __future__ import annotations

import json
from collections.abc import Collection
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from conrod.cli.options import TimedRunOptions, as_given, refuse
from conrod.cli.outputs import reproduction
from conrod.cli.say import say
from conrod.cli.validate_invariances import of_file, of_scene
from conrod.cli.validate_request import MODELS, Request, VerificationOptions
from conrod.errors import InvalidInput, named_values
from conrod.mechanism.units import parse_quantity
from conrod.mjcf.invariances.results import InvarianceStudy
from conrod.own.files import check_readable, files_of_model
from conrod.own.models.references import ALL_LENGTHS
from conrod.own.models.study import ModelStudy
from conrod.own.tables.columns import request
from conrod.own.tables.estimation import parse_estimate
from conrod.own.tables.reading import read_table
from conrod.own.tables.study import study_table
from conrod.report.folder import ReportFolder
from conrod.report.limits.report import KIND as LIMITS
from conrod.report.saved import plain, restore
from conrod.report.verification import beside
from conrod.report.verification.findings import Change, Verification, changes
from conrod.report.verification.page import data_of, digest_of, is_unchanged, sealed_page
from conrod.report.verification.sections import sections
from conrod.scenes import Scene
from conrod.studies.execution.isolation import confined
from conrod.studies.frame.files import files_to_write
from conrod.studies.frame.result import SceneResults
from conrod.studies.frame.writing import single, write_together
from conrod.studies.limits.results import LimitStudy

NOT_SHOWN = ("report", "assignments", "out", "document", "html", "baseline", "accept")


@dataclass(frozen=True)
class Dossier:
    """A verification report that is to be written; its options were checked before any run.

    Attributes:
        before: the unchanged report that stands in the file's place; None where there is none.
        uncertainties: standard, by length or `measured` [m].
    """

    asked: Request
    subject: Path
    file: Path
    before: bytes | None
    uncertainties: dict[str, float]

    @classmethod
    def of(cls, asked: Request, parts: Collection[str]) -> Dossier | None:
        """The report that is asked for, if any, on what is judged.

        Raises:
            InvalidInput: it cannot be made, or something would be lost by it.
        """
        if asked.report is None:
            refuse(asked, "no --report", VerificationOptions)
            return None
        if len(parts) != 1 or not asked.subjects:
            raise InvalidInput("--report: a verification report is on one machine or file: name it")
        read = {f"the input {name}": Path(name) for name in (*asked.subjects, asked.scene, asked.measured) if name}
        given = {name: path for name, path in read.items() if path.is_file()}
        file = files_to_write({"--json": asked.document, "--html": asked.html, "--report": asked.report}, given)
        path = file["--report"]
        before = path.read_bytes() if path.exists() else None
        try:
            unchanged = before is None or is_unchanged(before)
        except InvalidInput as error:
            raise InvalidInput(f"cannot write {path}: {error}, and would be lost") from None
        if not unchanged:
            raise InvalidInput(f"cannot write {path}: it was changed after it was written; give another name")
        if asked.measured is not None:
            check_readable(Path(asked.measured))
        sizes = named_values(asked.uncertainties, "--uncertainty", "a length and its standard uncertainty: rod=0.1mm")
        known = {name: parse_quantity(f"--uncertainty {name}", size, "m") for name, size in sizes.items()}
        return cls(asked, Path(asked.subjects[0]), path, before, known)

    def write(self, study: Any, verdict: str) -> None:
        """Write the report on a study, and say where it is; one that says the same stays as it is."""
        report = self._without_places(self._report(study, verdict))
        if self.before is not None:
            old = data_of(self.before)
            changed = changes(old, report)
            record = (*old.record, *([Change(digest_of(self.before), report.made, changed)] if changed else []))
            report = replace(report, made=report.made if changed else old.made, record=record)
        write_together([single(self.file, sealed_page(report))])
        say(f"report: {self.file}")

    def _report(self, study: Any, verdict: str) -> Verification:
        scene: Scene | None = getattr(study, "scene", None)
        name, data = self.subject.name, self.uncertainties.get(beside.DATA)
        found, deviations = sections(study)
        lengths = {length: size for length, size in self.uncertainties.items() if length != beside.DATA}
        found["inputs"] = beside.inputs(self._files(), scene)
        found["parameters"], moves, place = beside.parameters(scene, lengths, _off(study))
        engines = [one.engine for one in getattr(study, "results", ())] or ["mujoco"] * self._is(MODELS)
        found["software"] = beside.software(engines)
        for section, (content, off) in {
            "validation": beside.validation(study, self._measured(scene), (place, data)),
            "validity": beside.validity(self._limits(scene), scene),
            "invariances": beside.invariant(self._invariances(scene, study)),
        }.items():
            found[section] = content
            deviations += off
        given, target = as_given(self.asked, TimedRunOptions, *NOT_SHOWN), ("--report", self.file)
        again = reproduction("validate", {name: str(self.subject)}, given, self.asked.assignments, target)
        made = f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC"
        deviations += [*moves, *([verdict] if study.passed is False else [])]
        return Verification(name, verdict, made, again.of(name), found, tuple(deviations))

    def _is(self, endings: tuple[str, ...]) -> bool:
        return self.subject.name.lower().endswith(endings)

    @property
    def _typed(self) -> list[str]:
        """Files that were named, as typed."""
        drives = [drive.partition("=table:")[2] for drive in self.asked.drives]
        named = (
            str(self.subject),
            self.asked.scene,
            self.asked.measured,
            *drives,
            self.asked.limits,
            self.asked.report,
        )
        return [name for name in dict.fromkeys(named) if name]

    def _without_places(self, report: Verification) -> Verification:
        """The same with names of files, and not the folders that they are in, which are a user's own affair."""
        text = json.dumps(plain(report))
        for typed in self._typed:
            text = text.replace(json.dumps(typed)[1:-1], json.dumps(Path(typed).name)[1:-1])
        return restore(Verification, json.loads(text))

    def _files(self) -> list[Path]:
        """The files that were read."""
        paths = [Path(name) for name in self._typed if Path(name).is_file() and name != self.asked.report]
        return [one for path in paths for one in (files_of_model(path) if path.suffix.lower() in MODELS else [path])]

    def _measured(self, scene: Scene | None) -> Any:
        if self.asked.measured is None:
            return None
        if scene is None:
            raise InvalidInput("--measured: measurements are compared with a scene: name it with --scene")
        path, points = Path(self.asked.measured), tuple(scene.lengths)
        reading = confined(read_table, path, points, request(self.asked.columns, self.asked.units, points))
        estimated = () if self.asked.estimate is None else parse_estimate(self.asked.estimate)
        return study_table(path.name, scene.kind, scene, reading, estimated)

    def _limits(self, scene: Scene | None) -> LimitStudy | None:
        if self.asked.limits is None or scene is None:
            return None
        folder = ReportFolder(Path(self.asked.limits), LIMITS)
        wanted = self.asked.scene or str(self.subject)
        if wanted not in folder.entries:
            known = ", ".join(folder.entries) or "nothing"
            raise InvalidInput(f"--limits {self.asked.limits}: it has no limits of {wanted}, but of {known}")
        return restore(LIMITS.findings, folder.values(wanted))

    def _invariances(self, scene: Scene | None, study: Any) -> InvarianceStudy | str:
        """Those of the model, or why there are none."""
        asked = replace(self.asked, seconds=None)
        try:
            if self._is(MODELS):
                return of_file(self.subject.name, self.subject, asked, ())
            if scene is None or not isinstance(study, SceneResults):
                return "they are those of a MuJoCo model file, or of the model of a planar scene"
            return of_scene(self.subject.name, scene, asked)
        except InvalidInput as error:
            return str(error)


def _off(study: Any) -> dict[str, float]:
    """By how much lengths of a user's model are too long [m], where that explains its paths."""
    found = study.identity.explanations[:1] if isinstance(study, ModelStudy) else ()
    lengths = [one for explanation in found for one in explanation.lengths]
    return {one.name: one.found - one.expected for one in lengths if one.name != ALL_LENGTHS}
