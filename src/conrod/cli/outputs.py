"""Files that a verb writes, a report's folder and a JSON document, and the command that makes the report again."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from conrod.cli.say import say
from conrod.report.folder import ReportFolder
from conrod.report.kind import Kind
from conrod.report.reproduction import SCENE, Reproduction
from conrod.report.writer import Draw, document_text, report_batch
from conrod.studies.frame.files import files_to_write, folder_to_write, single, write_together

F = TypeVar("F")


@dataclass(frozen=True)
class Outputs(Generic[F]):
    """Files that --out and --json name.

    Attributes:
        kind: of the report.
        folder, file: None where not asked for.
    """

    kind: Kind[F]
    folder: Path | None
    file: Path | None

    def write(
        self,
        findings: Mapping[str, F],
        command: Reproduction | None = None,
        options: Mapping[str, Any] | None = None,
        draw: Draw = map,
    ) -> None:
        """Write all files or none, and print where the report is; arguments as of `report_batch`."""
        batches = [single(self.file, document_text(self.kind, findings))] if self.file else []
        if self.folder:
            assert command is not None
            batches.append(report_batch(self.kind, findings, self.folder, command, options, draw))
        write_together(batches)
        if self.folder:
            say(f"report: {self.folder / self.kind.first_page(findings)}")


def outputs(
    kind: Kind[F],
    parts: Iterable[str],
    out: str | None,
    document: str | None,
    given: Mapping[str, Path] | None = None,
) -> Outputs[F]:
    """Check what --out and --json name: nothing else may be lost by them.

    Args:
        parts: of the report.
        given: files that the user gave to be read, by what they are called.

    Raises:
        InvalidInput: names the file that is in the way.
    """
    file = files_to_write({"--json": document}, given).get("--json")
    folder = None if out is None else folder_to_write(out, "--out")
    if folder:
        ReportFolder(folder, kind).check(parts, file, *(given or {}).values())
    return Outputs(kind, folder, file)


def reproduction(
    command: str,
    subjects: Sequence[str] | Mapping[str, str],
    options: Mapping[str, object],
    assignments: Sequence[str],
    folder: Path | None,
) -> Reproduction | None:
    """The command that makes a report again, for the report to print; None where none is written.

    Args:
        subjects: scenes as they were typed, or files by the names of their pages.
        options: by name; those that are None were not given, of a tuple each value was.
        assignments: what was given with --set.
    """
    from conrod.studies.frame.resolve_arguments import typed_names

    if folder is None:
        return None
    words = ["conrod", command, SCENE]
    for name, value in options.items():
        given = value if isinstance(value, tuple) else () if value is None else (value,)
        for one in given:
            # A whole number without the point that a float has.
            words += [name, shlex.quote(str(int(one) if isinstance(one, float) and one.is_integer() else one))]
    for assignment in assignments:
        words += ["--set", shlex.quote(assignment)]
    text = " ".join([*words, "--out", shlex.quote(str(folder))])
    return Reproduction(text, subjects if isinstance(subjects, Mapping) else typed_names(subjects))
