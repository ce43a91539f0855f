"""Findings as build servers read them: JUnit XML, and SARIF 2.1.0."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from conrod.comparison.plain_values import json_document
from conrod.errors import COMMANDING_CHARACTERS
from conrod.report.findings import Findings, findings_passed
from conrod.report.results import engine_and_preset, verdict_words
from conrod.report.table import visible_text
from conrod.system import file_address

SARIF_SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"
OUT_OF_TOLERANCE = "out-of-tolerance"
JUNIT, SARIF = ".xml", ".sarif"  # endings by which --json knows them


@dataclass(frozen=True)
class BuildVerdict:
    """A verdict for a build server.

    Attributes:
        part: the machine or file, as it was typed.
        name: what was judged of it, such as "MuJoCo tuned".
        passed: None if it was measured alone.
        words: the verdict in words.
    """

    part: str
    name: str
    passed: bool | None
    words: str


def build_verdicts(found: Findings[Any]) -> Iterator[BuildVerdict]:
    """Yield a verdict for each result, or for a part without results, and last for the baseline."""
    for name, study in found.parts.items():
        typed = found.typed.get(name, name)
        if getattr(study, "distrust", ""):
            yield BuildVerdict(typed, "the exact motion", False, f"CANNOT BE TRUSTED: {study.distrust}")
        results = [one for one in getattr(study, "results", ()) if hasattr(one, "preset") and hasattr(one, "engine")]
        for result in results:
            yield BuildVerdict(typed, " ".join(engine_and_preset(result)), result.passed, verdict_words(result))
        if not results:
            judge = found.kind.passed or findings_passed
            yield BuildVerdict(typed, found.kind.name, judge(study), found.kind.verdict(study))
    if found.baseline is not None:
        yield BuildVerdict("baseline", "baseline", found.baseline.passed, found.baseline.text)


def junit_text(found: Findings[Any]) -> str:
    """Return findings as JUnit XML: a test case for each verdict, skipped if it has no tolerance."""
    cases = list(build_verdicts(found))
    counts = {"tests": len(cases), "failures": sum(one.passed is False for one in cases), "errors": 0}
    counts["skipped"] = sum(one.passed is None for one in cases)
    numbers = {name: str(count) for name, count in counts.items()}
    root = ElementTree.Element("testsuites", {"name": "conrod", **numbers})
    suite = ElementTree.SubElement(root, "testsuite", {"name": f"conrod {found.kind.name}", **numbers})
    for one in cases:
        names = {"classname": visible_text(one.part), "name": visible_text(one.name), "time": "0"}
        case = ElementTree.SubElement(suite, "testcase", names)
        said = visible_text(one.words)
        if one.passed is False:
            ElementTree.SubElement(
                case, "failure", {"message": said.split("\n")[0], "type": OUT_OF_TOLERANCE}
            ).text = said
        elif one.passed is None:
            ElementTree.SubElement(case, "skipped", {"message": said.split("\n")[0]})
    ElementTree.indent(root, " ")
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def sarif_text(found: Findings[Any]) -> str:
    """Return exceeded tolerances as a SARIF log, located at the judged file or the scene's name."""
    rule = {"id": OUT_OF_TOLERANCE, "shortDescription": {"text": "a judged error is larger than its tolerance"}}
    results = [
        {
            "ruleId": OUT_OF_TOLERANCE,
            "level": "error",
            "message": {"text": f"{one.part}, {one.name}: {one.words}".translate(COMMANDING_CHARACTERS)},
            "locations": [
                {
                    "physicalLocation": {
                        "artifactLocation": {"uri": file_address(Path(one.part))},
                        "region": {"startLine": 1},
                    }
                }
            ],
        }
        for one in build_verdicts(found)
        if one.passed is False
    ]
    tool = {"driver": {"name": f"conrod {found.kind.name}", "version": version("conrod"), "rules": [rule]}}
    return json_document({"$schema": SARIF_SCHEMA, "version": "2.1.0", "runs": [{"tool": tool, "results": results}]})


def results_text(file: Path, found: Findings[Any]) -> str:
    """Return findings as the ending of a file says: JUnit XML, SARIF, or conrod's own JSON."""
    ending = file.suffix.lower()
    return junit_text(found) if ending == JUNIT else sarif_text(found) if ending == SARIF else found.json
