"""The folder of a report: files that it owns, files that it must not replace, and findings as JSON.

JSON is written in reproducible digits, and laid out so that two versions can be compared line by line.
"""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Iterable, Mapping
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, TypeVar

import msgspec

from conrod.comparison.plain_values import plain_values, restore
from conrod.errors import InvalidInput
from conrod.execution.files import is_folder, is_special_file
from conrod.report import numbers
from conrod.scenes import SCENES, Scene
from conrod.system import real_path

if TYPE_CHECKING:
    from conrod.report.kind import Kind


def check_other_file(file: Path, folder: Path, names: Iterable[str]) -> None:
    """Refuse to write a file over a file of a report, or in place of the report's folder.

    Args:
        names: names of the report's files in the folder.

    Raises:
        InvalidInput: names the file.
    """
    home, wanted = real_path(folder), real_path(file)
    # Compared without case: on some systems readme.md is README.md.
    if str(wanted).casefold() in {str(home / name).casefold() for name in names}:
        raise InvalidInput(f"cannot write {file}: the report in {folder} has a file of that name")
    if wanted in (home, *home.parents):
        raise InvalidInput(f"cannot write {file}: it is where the folder {folder} has to be")


MAX_JSON_BYTES = 50_000_000  # of a JSON file of a report: ten times the largest that conrod ever wrote


def read_document(file: Path) -> Any:
    """Read a report's JSON file.

    Raises:
        InvalidInput: the file is larger than any report.
        OSError: it cannot be read.
        ValueError: the file is no JSON, or has values that conrod never writes: NaN, infinities, halves of characters.
    """
    if (size := file.stat().st_size) > MAX_JSON_BYTES:
        raise InvalidInput(
            f"{file}: {size / 1e6:.0f} MB; conrod writes at most {MAX_JSON_BYTES / 1e6:.0f} MB into such a file"
        )
    try:
        text = file.read_text(encoding="utf-8")
        found = json.loads(text, parse_constant=_refuse_number, parse_float=_finite_number)
        if "\\u" in text:
            json.dumps(found, ensure_ascii=False).encode()
        return found
    except RecursionError:
        raise ValueError("lists in lists without end") from None


def _finite_number(text: str) -> float:
    return number if math.isfinite(number := float(text)) else _refuse_number(text)


def _refuse_number(text: str) -> float:
    raise ValueError(f"{text} is no number that conrod writes")


SUBFOLDERS = ("figures", "data")
# Names that conrod gives to files of a report. A file of another name is not touched, even if the document lists it.
REPORT_FILE_NAME = re.compile(r"(figures/[^/]+\.svg|data/[^/]+\.json|[^/]+\.(md|json))")
# Key of a document while the files of its report are being replaced: hashes of the new data, and the document before.
UNFINISHED = "unfinished"


class _PartEntry(msgspec.Struct):
    """A part in a report's document."""

    title: str
    command: str
    conrod: str
    summary: dict[str, Any]
    page: str
    data: str
    files: list[str]


class _ReportDocument(msgspec.Struct):
    """Fields that every report's document has."""

    conrod: str
    environment: dict[str, str]
    command: str | None
    files: list[str]
    parts: dict[str, _PartEntry]


class ReportFolder:
    """A folder with reports, and its files that belong to one kind of report.

    Attributes:
        path: path of the folder, which need not exist.
        document: content of the kind's results file; {} where there is none.
        unfinished: True if writing it was stopped; then parts and data agree, but pages may belong to earlier data.
    """

    def __init__(self, path: Path, kind: Kind[Any]) -> None:
        """Read the results file of the kind, if the folder has one.

        Raises:
            InvalidInput: the results file is not of this kind and schema.
        """
        self.path, self.kind, self.unfinished = path, kind, False
        self.document: dict[str, Any] = self._read_document()

    def _read_document(self) -> dict[str, Any]:
        file = self.path / self.kind.results
        if is_special_file(file):
            raise InvalidInput(f"cannot write into {self.path}: {self.kind.results} in it is not a regular file")
        if not file.exists():
            return {}
        try:
            found: Any = read_document(file)
        except InvalidInput:
            raise
        except (OSError, ValueError):
            found = None
        if not isinstance(found, dict) or not (found.keys() >= {"conrod", "schema"} or "kind" in found):
            raise InvalidInput(
                f"cannot write into {self.path}: it holds a {self.kind.results} that is not a conrod report"
            )
        if found.get("kind", self.kind.name) != self.kind.name:
            raise InvalidInput(f"{file}: it is a report of another kind, {found['kind']}; give another folder")
        if found.get("schema") != self.kind.schema:
            raise InvalidInput(f"{file}: it is a report of another version of conrod; remove it or give another folder")
        said = f"{file}: it was changed since conrod wrote it"
        try:
            self._check_names(said, found["files"], found["parts"].values())
            msgspec.convert(found, _ReportDocument)
            if UNFINISHED in found:
                self.unfinished, begun = True, found.pop(UNFINISHED)
                before = begun["before"] or {**found, "parts": {}}
                self._check_names(said, before["files"], before["parts"].values())
                msgspec.convert(before, _ReportDocument)
                found = self._recovered_document(found, before, begun["data"])
        except msgspec.ValidationError as error:
            raise InvalidInput(f"{said}: {error}") from None
        except (KeyError, TypeError, AttributeError) as error:
            raise InvalidInput(f"{said}: {error!r}") from None
        return dict(found)

    @staticmethod
    def _check_names(said: str, files: Iterable[str], entries: Iterable[Mapping[str, Any]]) -> None:
        """Refuse names of files that conrod never gave; raises InvalidInput."""
        names = [name for entry in entries for name in (*entry["files"], entry["data"], entry["page"])]
        for name in (*files, *names):
            if PurePath(name).is_absolute() or ".." in PurePath(name).parts:
                raise InvalidInput(f"{said}: {name} is not in its folder")
            if not REPORT_FILE_NAME.fullmatch(name):
                raise InvalidInput(f"{said}: {name!r} is no file of a report")

    def _recovered_document(
        self, found: Mapping[str, Any], before: Mapping[str, Any], data: Mapping[str, str]
    ) -> dict[str, Any]:
        """Return the document that fits the data in the folder after a write was stopped.

        Args:
            found: the document that was being written.
            before: the document before that.
            data: SHA-256 of the data of the parts that were being written.
        """
        places = {name: self.path / entry["data"] for name, entry in found["parts"].items()}
        there = {name: _sha256(file.read_bytes()) for name, file in places.items() if file.is_file()}
        new = {name for name, digest in data.items() if there.get(name) == digest}
        entries = {
            name: entry if name in new or name not in data else before["parts"].get(name)
            for name, entry in found["parts"].items()
        }
        head = found if new else before
        return {
            **head,
            "command": head["command"] if new in (set(), set(data)) else None,
            "files": found["files"],
            "parts": {name: entry for name, entry in entries.items() if entry and name in there},
        }

    @property
    def entries(self) -> dict[str, Any]:
        """Entries of the report's parts by name."""
        return dict(self.document.get("parts", {}))

    @property
    def owned(self) -> set[str]:
        """Names of the files that belong to the report."""
        parts = (entry["files"] for entry in self.entries.values())
        return {*self.document.get("files", ()), *(name for files in parts for name in files)}

    def unfinished_document(self, document: Mapping[str, Any], texts: Mapping[str, str]) -> str:
        """Return the text of the document to store while its report is being written.

        Args:
            document: the finished document.
            texts: new data of the parts that are replaced, as text.
        """
        files = (name for entry in document["parts"].values() for name in entry["files"])
        data = {name: _sha256(text.encode(errors="replace")) for name, text in texts.items()}
        begun = {"data": data, "before": self.document or None}
        return json_text({**document, "files": sorted({*self.owned, *document["files"], *files}), UNFINISHED: begun})

    def values(self, part: str) -> Any:
        """Read the saved findings of a part as plain values.

        Raises:
            InvalidInput: their file cannot be read.
        """
        name = self.entries[part]["data"]
        try:
            return read_document(self.path / name)
        except (OSError, ValueError) as error:
            raise InvalidInput(f"{self.path / name}: cannot be read: {error}") from None

    def check(self, parts: Iterable[str], *beside: Path | None) -> None:
        """Refuse the folder if a report of some parts would replace files of others.

        Args:
            beside: other output files, which must not be files of the report.

        Raises:
            InvalidInput: names the file that is in the way.
        """
        parts = tuple(parts)
        names = [self.kind.results, self.kind.index_file]
        names += [make(part) for part in parts for make in (self.kind.page_file, self.kind.data_file)]
        for sub in SUBFOLDERS:
            place = self.path / sub
            if place.is_symlink() or (place.exists() and not is_folder(place)):
                raise InvalidInput(f"cannot write into {self.path}: {sub} in it is not a folder")
            # Names of figures are known when they are drawn; what could be one of them is no link or folder.
            there = place.iterdir() if place.exists() else ()
            names += [f"{sub}/{file.name}" for file in there if file.name.startswith(parts) and is_special_file(file)]
        self.check_free(names)
        for file in beside:
            if file is not None:
                check_other_file(file, self.path, {*names, *self.owned})
                if real_path(file).parent in {real_path(self.path / sub) for sub in SUBFOLDERS}:
                    raise InvalidInput(f"cannot write {file}: that folder is the report's")

    def check_free(self, names: Iterable[str]) -> None:
        """Refuse names of existing files that the report does not own.

        Raises:
            InvalidInput: names the file.
        """
        owned = self.owned
        for name in names:
            if is_special_file(self.path / name):
                raise InvalidInput(f"cannot write into {self.path}: {name} in it is not a regular file")
            if name not in owned and (self.path / name).exists():
                raise InvalidInput(f"cannot write into {self.path}: it holds a {name} that is not of this report")


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


T = TypeVar("T")
# Digits of arrays, which are only drawn; single numbers keep all digits.
DRAWN_DIGITS = 7
MAX_JSON_LINE = 100
# Fields of given values, not measured ones: all their digits are kept.
EXACT_FIELDS: dict[str, int | None] = dict.fromkeys(("parameters", "given_anew", "settings", "changes"))


def plain_findings(findings: Any) -> Any:
    """Convert findings to plain values; raises TypeError if they could not be restored."""
    return plain_values(findings, DRAWN_DIGITS)


def restore_findings(wanted: type[T], values: Any) -> T:
    """Restore findings from plain values; raises InvalidInput where these do not fit the type."""
    return restore(wanted, values, {Scene: _restore_scene})


def _restore_scene(values: Mapping[str, Any]) -> Scene:
    if "document" in values:
        from conrod.scenes.described_scene import DescribedScene  # what reads units takes its time to load

        return DescribedScene(values["document"], tuple(sorted(values["given_anew"].items())))
    return {scene.kind: type(scene) for scene in SCENES.values()}[values["machine"]](**values["parameters"])


def round_findings(values: Any, digits: int | None, digits_of: Mapping[str, int | None] = EXACT_FIELDS) -> Any:
    """Round fractions to the digits that another machine reproduces.

    Args:
        values: plain values.
        digits: significant digits; None keeps all.
        digits_of: other digits for the fields of some names."""
    match values:
        case _ if digits is None:
            return values
        case float():
            return numbers.round_reproducibly(values, digits)
        case dict():
            return {key: round_findings(part, digits_of.get(key, digits), digits_of) for key, part in values.items()}
        case list():
            return [round_findings(part, digits, digits_of) for part in values]
        case _:
            return values


def json_text(values: Any) -> str:
    """Return plain values as JSON with one entry a line, and each list of numbers on one line."""
    return _json_lines(values, "") + "\n"


def _json_lines(values: Any, indent: str) -> str:
    flat = json.dumps(values, ensure_ascii=False, allow_nan=False)
    if len(flat) > MAX_JSON_LINE:
        flat = json.dumps(values, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    if not isinstance(values, dict | list | tuple) or not values:
        return flat
    if len(flat) + len(indent) <= MAX_JSON_LINE or (
        not isinstance(values, dict) and not any(isinstance(part, dict | list | tuple) for part in values)
    ):
        return flat
    deeper = indent + " "
    if isinstance(values, dict):
        parts = [f"{json.dumps(key, ensure_ascii=False)}: {_json_lines(part, deeper)}" for key, part in values.items()]
        return "{\n" + ",\n".join(deeper + part for part in parts) + f"\n{indent}}}"
    return "[\n" + ",\n".join(deeper + _json_lines(part, deeper) for part in values) + f"\n{indent}]"
