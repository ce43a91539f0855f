"""The first page of a report of limits: the dangerous runs of all machines first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from conrod.report.limits import prose
from conrod.report.limits.determinism_table import determinism_table
from conrod.report.limits.document import Entry
from conrod.report.limits.findings import findings
from conrod.report.limits.gallery_table import gallery_table
from conrod.report.limits.long_run_table import long_run_table
from conrod.report.limits.quiet_table import quiet_elsewhere, quiet_summary
from conrod.report.limits.steps_table import steps_table
from conrod.report.origin import told_origin
from conrod.report.styles import engine_title
from conrod.report.tables import paragraphs, table
from conrod.studies.limits.gallery import Exhibit
from conrod.studies.limits.study import LimitStudy

Studies = Mapping[str, LimitStudy]


def limits_index(scenes: Mapping[str, Entry], studies: Studies, gallery: Sequence[Exhibit]) -> str:
    """The index.

    Args:
        scenes: entries of the document, by name.
        studies: what they hold.
        gallery: a run for each way of ending.
    """
    walks = [walk for study in studies.values() for walk in study.walks]
    dangers = quiet_summary(walks)
    elsewhere = "\n".join(f"- {name}: {told}" for name, study in studies.items() if (told := quiet_elsewhere(study)))
    steps = steps_table(walks)
    same = determinism_table([found for study in studies.values() for found in study.determinism], with_scene=True)
    long = long_run_table([run for study in studies.values() for run in study.long_runs], with_scene=True)
    shown = gallery_table(gallery)
    blocks = [
        "# Limits",
        prose.PURPOSE,
        "\n".join(f"- [{name}]({name}.md): {study.title}" for name, study in studies.items()),
        "## Wrong, and nothing says so",
        prose.WORDS,
        prose.QUIET if dangers or elsewhere else prose.NO_QUIET,
        dangers,
        elsewhere,
        "## What was found",
        *(block for name, study in studies.items() for block in _findings(name, study)),
        *(["## Steps per revolution", prose.STEPS, steps] if steps else []),
        *(["## Every way of ending", prose.GALLERY, shown] if shown else []),
        *(["## The same again?", prose.DETERMINISM, same] if same else []),
        *(["## Long runs", prose.LONG_RUNS, long] if long else []),
        "## Made with",
        _made_with(scenes, studies),
        f"{told_origin(scenes)} [results.json](results.json) holds every run.",
    ]
    return paragraphs(*blocks) + "\n"


def _findings(name: str, study: LimitStudy) -> list[str]:
    found = findings(study.walks)
    return [f"### [{name}]({name}.md)", "\n".join(f"- {text}" for text in found)] if found else []


def _made_with(scenes: Mapping[str, Entry], studies: Studies) -> str:
    """All versions that occur: scenes that were looked at earlier stay as they were."""
    found: dict[str, set[str]] = {"conrod": {scene["conrod"] for scene in scenes.values()}}
    for study in studies.values():
        for engine, version in study.engines.items():
            found.setdefault(engine_title(engine), set()).add(version)
    shown = {engine for study in studies.values() for engine in study.engines}
    for scene in scenes.values():
        for name, version in scene["environment"].items():
            if name not in shown:
                found.setdefault(name, set()).add(version)
    return table(["what", "which"], [[name, "; ".join(sorted(versions))] for name, versions in found.items()])
