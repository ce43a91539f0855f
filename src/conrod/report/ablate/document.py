"""The report on ingredients for machines: `results.json`, from which all its pages are made, and it is known by."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from conrod.report import numbers
from conrod.report.folder import check_beside, check_own_folder, document_in, holds_document
from conrod.report.names import FIGURES, FILE, INDEX, page_file
from conrod.studies.ablate.results import AblationStudy

SCHEMA = 1
# Inputs, written as they are; everything else that is a fraction was measured.
INPUTS = {"parameters", "settings", "revolutions"}
MEASURED_DIGITS = 4
SCENE_KEYS = {"conrod", "environment", "commands", "study"}

Entry = dict[str, Any]  # of a scene: SCENE_KEYS


def scene_entry(study: AblationStudy, earlier: Entry | None, made_with: Mapping[str, str], command: str) -> Entry:
    """What the document says of a scene.

    Args:
        earlier: what it said before, if anything; engines that the study did not look at stay.
        made_with: the environment of the new runs.
        command: what reproduces them.
    """
    whole, commands = study, [command]
    if earlier is not None:
        whole = merged(AblationStudy.of(earlier["study"]), study)
        if whole != study:
            commands = list(dict.fromkeys([*earlier["commands"], command]))
    return {
        "conrod": version("conrod"),
        "environment": dict(made_with),
        "commands": commands,
        "study": _rounded(whole.as_dict()),
    }


def merged(earlier: AblationStudy, new: AblationStudy) -> AblationStudy:
    """The new study with the engines that the earlier one looked at besides; none of another machine's."""
    if (earlier.kind, dict(earlier.parameters)) != (new.kind, dict(new.parameters)):
        return new
    known = {found.engine: found for found in earlier.engines} | {found.engine: found for found in new.engines}
    return replace(new, engines=tuple(known.values()))


def document_text(scenes: Mapping[str, Entry]) -> str:
    """The JSON document."""
    return json.dumps({"schema": SCHEMA, "ablations": scenes}, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _rounded(value: Any, given: bool = False) -> Any:
    """What was measured in few significant digits, inputs as they are."""
    match value:
        case float():
            return value if given else numbers.rounded(value, MEASURED_DIGITS)
        case Mapping():
            return {str(key): _rounded(part, given or key in INPUTS) for key, part in value.items()}
        case list() | tuple():
            return [_rounded(part, given) for part in value]
        case _:
            return value


# -- the report that a folder holds ----------------------------------------------------------------------------------


def earlier_ablations(directory: Path) -> dict[str, Entry]:
    """Scenes of the report of this kind that a folder already holds; none where it holds none."""
    try:
        document = document_in(directory / FILE)
        scenes = document["ablations"] if document["schema"] == SCHEMA else {}
        return {name: scene for name, scene in scenes.items() if _is_whole(scene)}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


def _is_whole(scene: Mapping[str, Any]) -> bool:
    """Whether an entry can be read back; one of another version of conrod may not."""
    try:
        AblationStudy.of(scene["study"])
    except (KeyError, TypeError, AttributeError):
        return False
    return scene.keys() >= SCENE_KEYS


def check_ablate_folder(directory: Path, scenes: Collection[str]) -> None:
    """Refuse a folder in which a report on the ingredients of some scenes would replace what is not such a report's.

    Raises:
        InvalidInput: names the file that is in the way.
    """
    pages = [INDEX, FILE, *(page_file(scene) for scene in scenes)]
    found = (path for scene in scenes for path in (directory / FIGURES).glob(f"{scene}-*.svg"))
    drawn = [path.relative_to(directory).as_posix() for path in found]
    own = holds_document(directory / FILE, {"schema", "ablations"})
    check_own_folder(directory, pages, drawn, FIGURES, own, "a report on ingredients")


def check_ablate_apart(document: Path, directory: Path, scenes: Iterable[str]) -> None:
    """Refuse a file that is one of those that such a report consists of, or is in its way.

    Raises:
        InvalidInput: names the file.
    """
    pages = [page_file(scene) for scene in (*scenes, *earlier_ablations(directory))]
    # Its folder of figures is the report's own.
    check_beside(document, directory, [INDEX, FILE, *pages, f"{FIGURES}/{document.name}"])
