"""The files of a report on a user's model, and what they must not replace.

The page on a user's model.

The report on a user's model, rendered.
"""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from urllib.parse import quote

from conrod.own.models.model_files import as_outputs_must_not_be
from conrod.own.models.study import EXACT_SOLVER, OWN, ModelStudy
from conrod.report import numbers
from conrod.report.charts.canvas import drawing_style, svg_text
from conrod.report.folder import check_own_folder, holds_document
from conrod.report.names import FIGURES
from conrod.report.saved import json_text, plain
from conrod.report.tables import paragraphs, table
from conrod.report.user_model import words
from conrod.report.user_model import words as run_words
from conrod.report.user_model.figure import model_figure
from conrod.studies.frame.files import Batch, check_apart, file_to_write, folder_to_write, single
from conrod.studies.validation.serialise import environment

SCHEMA = 2
# Of the results, by which a report is known.
KEYS = {"schema", "scene_name", "model", "identity", "runs"}


def page_file(file: str) -> str:
    """Name of the page on a model's file."""
    return f"{Path(file).stem}.md"


def figure_file(file: str) -> str:
    """Name of its figure."""
    return f"{FIGURES}/{Path(file).stem}-model.svg"


def document_file(file: str) -> str:
    """Name of its results."""
    return f"{Path(file).stem}.json"


def outputs_of(file: str, out: str | None, document: str | None) -> tuple[Path | None, Path | None]:
    """The report's folder and the JSON file, refused before any work where something would be lost by them.

    Raises:
        InvalidInput: names what is in the way.
    """
    folder = None if out is None else folder_to_write(out, "--out")
    target = None if document is None else file_to_write(document, "--json")
    files = as_outputs_must_not_be(Path(file))
    if target is not None:
        files["--json"] = target
    if folder is not None:
        own = holds_document(folder / document_file(file), KEYS)
        pages = (page_file(file), document_file(file))
        check_own_folder(folder, pages, (figure_file(file),), FIGURES, own, "a report of conrod on a model")
        files |= {f"{name} of the report": folder / name for name in (*pages, figure_file(file))}
    check_apart(files)
    return folder, target


def results_text(study: ModelStudy) -> str:
    """The results as JSON."""
    judged = {"is_machine": study.is_machine, "passed": study.passed}
    head = {"schema": SCHEMA, "conrod": version("conrod"), "environment": environment()}
    return json_text({**head, **judged, **plain(study)})


def results_file(study: ModelStudy, target: Path) -> Batch:
    """The results in a file of their own."""
    return single(target, results_text(study))


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
    model = study.model
    blocks = [
        f"# {Path(study.file).name}: is it {study.scene_name}?",
        f"**{words.verdict(study)}**",
        f"Model `{model.name}`, crank `{study.question.crank}`, "
        + ", ".join(f"{place.point} = `{place}`" for place in study.question.places)
        + f". Reproduced by `{command}`, with MuJoCo {model.engine_version}. Results: "
        f"[{document_file(study.file)}]({quote(document_file(study.file))}).",
        METHOD,
        f"![Distance from the exact paths, and errors of the runs]({quote(figure_file(study.file))})",
        "## Is it the machine?",
        "Frame:\n\n" + _list(words.frame(study)),
        "Wiring:\n\n" + _list(words.wiring(study)),
        f"Paths, held to {numbers.measured(study.kinematic_tolerance)} of the travel:\n\n" + _list(words.paths(study)),
        "## How accurate are its own settings?",
        f"As it is: {run_words.own_settings(study)}.",
        _list(list(model.remarks)),
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


def model_report_batch(study: ModelStudy, folder: Path, command: str) -> Batch:
    """Page, figure and results; nothing is written yet."""
    with drawing_style():
        drawn = svg_text(model_figure(study))
    files = {
        figure_file(study.file): drawn,
        page_file(study.file): model_page(study, command),
        document_file(study.file): results_text(study),
    }
    return Batch(folder, files)
