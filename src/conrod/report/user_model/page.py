"""The page on a user's model."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import quote

from conrod.report import numbers
from conrod.report.tables import paragraphs, table
from conrod.report.user_model import run_words, words
from conrod.report.user_model.document import document_file, figure_file
from conrod.studies.user_model.study import EXACT_SOLVER, OWN, ModelStudy

METHOD = (
    "The file was only read. *Kinematic mode*: the crank is held at 180 angles of a turn, and the model's own closures "
    "(a cam: the distance of its geoms) place the rest; nothing moves in time. *Dynamic mode*: a copy of the compiled "
    "model is driven at the scene's speed from the exact start, at its own timestep; errors are taken at the crank "
    "angle, rate and angular acceleration that it reached. `tuned` and `hardened` are the same model with conrod's "
    "presets at that timestep. The origin of the frame is the crank's axis; what else of the frame was not given was "
    "fitted to the exact motion."
)
BLIND = (
    "**Masses, inertias and gravity** do not show in the motion of a driven linkage; they are not judged.",
    "**Points that were not given** are not judged, nor is anything that does not move them.",
    "**What cannot be told from paths**: which of several lengths is wrong where they leave the same trace; and the "
    "machine seen from behind from its mirror image. `--plane` says from which side it is seen.",
)


def model_page(study: ModelStudy, command: str) -> str:
    """The page in Markdown.

    Args:
        command: what reproduces it.
    """
    scan = study.scan
    blocks = [
        f"# {Path(study.file).name}: is it {study.scene_name}?",
        f"**{words.verdict(study)}**",
        f"Model `{scan.name}`, crank `{study.question.crank}`, "
        + ", ".join(f"{place.point} = `{place}`" for place in study.question.places)
        + f". Reproduced by `{command}`, with MuJoCo {scan.engine_version}. Results: "
        f"[{document_file(study.file)}]({quote(document_file(study.file))}).",
        METHOD,
        f"![Distance from the exact paths, and errors of the runs]({quote(figure_file(study.file))})",
        "## Is it the machine?",
        "Frame:\n\n" + _list(words.frame(study)),
        "Wiring:\n\n" + _list(words.wiring(study)),
        f"Paths, held to {numbers.measured(study.kinematic_tolerance)} of the travel:\n\n" + _list(words.paths(study)),
        "## How accurate are its own settings?",
        f"As it is: {run_words.own_settings(study)}.",
        _list(list(scan.remarks)),
        _runs(study),
        _list(run_words.drive(study)),
        "## What this cannot see",
        _list(list(BLIND)),
    ]
    return paragraphs(*blocks) + "\n"


def _list(lines: list[str]) -> str:
    return "\n".join(f"- {line}" for line in lines)


def _runs(study: ModelStudy) -> str:
    if not study.runs:
        return ""
    turns = numbers.quantity(study.revolutions)
    drawn = (
        "" if EXACT_SOLVER not in study.runs else f"; the figure has `{OWN}` as it is with the solver tolerance at 0"
    )
    return paragraphs(f"Largest errors over {turns} revolutions{drawn}:", table(run_words.HEAD, run_words.rows(study)))
