"""Begin a project of one's own: a mechanism file, a test and a workflow for a build server."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from conrod.errors import InvalidInput
from conrod.execution.writing import Batch, write_together

# Where each file of `project/` is written, below the project's folder.
PLACES = {
    "mechanism.toml": Path("mechanism.toml"),
    "test_mechanism.py.txt": Path("test_mechanism.py"),
    "physics.yml": Path(".github", "workflows", "physics.yml"),
}


def begin_project(folder: str | Path = ".") -> tuple[Path, ...]:
    """Write the files that a project begins with; return their paths.

    Args:
        folder: folder of the project, made where there is none.

    Raises:
        InvalidInput: one of the files is there already, or the folder is none; nothing is written then.
    """
    place = Path(folder)
    if place.exists() and not place.is_dir():
        raise InvalidInput(f"{place}: it is a file: give the folder of the project")
    paths = [place / name for name in PLACES.values()]
    if there := [str(path) for path in paths if path.exists() or path.is_symlink()]:
        raise InvalidInput(f"{', '.join(there)}: there already; nothing is overwritten: give another folder")
    batches = list[Batch]()
    for name, path in PLACES.items():
        target = place / path
        text = files("conrod.guide.init").joinpath("project", name).read_text("utf-8")
        batches.append(Batch(target.parent, {target.name: text}))
    write_together(batches)
    return tuple(paths)
