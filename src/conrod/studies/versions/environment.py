"""Environments of single releases of an engine, in the cache folder: made once, whole or not at all, never upgraded.

An environment holds the engine and what it requires, with the numpy of this process. All else, conrod included, is
imported from where this process has it (`WorkerProcess`), so that two environments differ by the engine alone.
"""

from __future__ import annotations

import hashlib
import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version as version_of
from pathlib import Path

import platformdirs

from conrod.engines import engine_named
from conrod.errors import InvalidInput
from conrod.studies.execution.worker_process import Limits, WorkerDied, WorkerProcess

PATIENCE = 600.0  # [s] for an installation
STARTED = 120.0  # [s] for an engine to be imported

Make = Callable[[Path, Sequence[str]], None]


def install(folder: Path, requirements: Sequence[str]) -> None:
    """Make an environment with some requirements, by venv and pip; wheels alone are taken.

    Raises:
        InvalidInput: what the installer says, in one line.
    """
    _run([sys.executable, "-m", "venv", str(folder)])
    _run([str(python_of(folder)), "-m", "pip", "install", "--quiet", "--only-binary", ":all:", *requirements])


@dataclass(frozen=True)
class Environments:
    """Environments in a folder, by what they hold.

    Attributes:
        make: fills an empty folder; raises InvalidInput.
    """

    folder: Path = field(default_factory=lambda: platformdirs.user_cache_path("conrod") / "environments")
    make: Make = install

    def interpreter(self, engine: str, requirement: str, version: str) -> str:
        """Path of the interpreter of an environment where an engine has a version; it is made if there is none.

        Raises:
            InvalidInput: it cannot be made, or the engine that it holds cannot be imported, or is another version.
        """
        requirements = (requirement, f"numpy=={version_of('numpy')}")
        python = f"{sys.implementation.name}{platform.python_version()}"
        digest = hashlib.sha256("\n".join((*requirements, python, sys.base_prefix)).encode()).hexdigest()[:8]
        place = self.folder / f"{requirement.replace('==', '-')}-{python}-{digest}"
        if not place.is_dir():
            self._put(place, requirements, engine, version)
        return str(python_of(place))

    def _put(self, place: Path, requirements: Sequence[str], engine: str, version: str) -> None:
        """Make a folder elsewhere and rename it, so that it is there whole or not at all; of two the first counts."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(prefix=".making-", dir=self.folder) as name:
                made = Path(name) / "made"
                self.make(made, requirements)
                found = imported_version(str(python_of(made)), engine)
                if found != version:
                    raise InvalidInput(f"{requirements[0]} calls itself {found}")
                made.rename(place)
        except OSError as error:
            if not place.is_dir():
                raise InvalidInput(f"cannot write into {self.folder}: {error.strerror or error}") from None


def imported_version(interpreter: str, engine: str) -> str:
    """Version of an engine in an environment, by importing it there.

    Raises:
        InvalidInput: that fails, in one line; or it crashes, or takes too long.
    """
    worker = WorkerProcess(Limits(timeout=STARTED), interpreter=interpreter)
    try:
        return worker.call(_version, engine)
    except (WorkerDied, TimeoutError, ImportError, AttributeError, OSError) as error:
        raise InvalidInput(f"it cannot be imported: {type(error).__name__}: {error}") from None
    finally:
        worker.end()


def _version(engine: str) -> str:
    return engine_named(engine).version


def python_of(folder: Path) -> Path:
    """Path of an environment's interpreter."""
    return folder / "bin" / "python"


def _run(command: Sequence[str]) -> None:
    # From a folder of its own: a project's settings in the working folder are not for an engine's environment.
    with tempfile.TemporaryDirectory() as aside:
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=PATIENCE, cwd=aside, check=False, errors="replace"
            )
        except subprocess.TimeoutExpired:
            raise InvalidInput(f"{Path(command[0]).name} has not ended after {PATIENCE:g} s") from None
    if done.returncode:
        said = (done.stderr or done.stdout).splitlines()
        # pip says first what went wrong, and then what could be done.
        errors = [line.removeprefix("ERROR: ") for line in said if line.startswith("ERROR: ")]
        raise InvalidInput(next(iter(errors), " ".join(said)) or f"{command[0]} ended with {done.returncode}")
