"""Environments of single releases of an engine, in the cache folder: made once, whole or not at all, never upgraded.

An environment holds the engine and what it requires, with the numpy of this process. All else, conrod included, is
imported from where this process has it (`WorkerProcess`), so that two environments differ by the engine alone.
"""

from __future__ import annotations

import hashlib
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import time
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
MAKING = ".making-"
ABANDONED = 3600.0  # [s] after which a folder that is still being made is nobody's
FRAME = re.compile("[\u00d7\u2500-\u25ff]+")  # around what uv says

Make = Callable[[Path, Sequence[str]], None]


def install(folder: Path, requirements: Sequence[str]) -> None:
    """Make an environment with some requirements, by uv, or without it by venv and pip; wheels alone are taken.

    Raises:
        InvalidInput: what the installer says, in one line.
    """
    beside = Path(sys.executable).with_name("uv")
    uv = str(beside) if beside.is_file() else shutil.which("uv")
    python, wheels = python_of(folder), ("--only-binary", ":all:")
    if uv is not None:
        _run([uv, "venv", "--quiet", "--python", sys.executable, str(folder)])
        _run([uv, "pip", "install", "--quiet", *wheels, "--python", str(python), *requirements])
    else:
        _run([sys.executable, "-m", "venv", str(folder)])
        _run([str(python), "-m", "pip", "install", "--quiet", *wheels, *requirements])


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
            self._put(place, lambda folder: self._checked(folder, requirements, engine, version))
        return str(python_of(place))

    def _checked(self, folder: Path, requirements: Sequence[str], engine: str, version: str) -> None:
        self.make(folder, requirements)
        found = imported_version(str(python_of(folder)), engine)
        if found != version:
            raise InvalidInput(f"{requirements[0]} calls itself {found}")

    def _put(self, place: Path, fill: Callable[[Path], None]) -> None:
        """Make a folder elsewhere and rename it, so that it is there whole or not at all; of two the first counts."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            for left in self.folder.glob(f"{MAKING}*"):
                if time.time() - left.stat().st_mtime > ABANDONED:
                    shutil.rmtree(left, ignore_errors=True)
            making = Path(tempfile.mkdtemp(prefix=MAKING, dir=self.folder))
        except OSError as error:
            raise InvalidInput(f"cannot write into {self.folder}: {error.strerror or error}") from None
        try:
            fill(making / "made")
            (making / "made").rename(place)
        except OSError as error:
            if not place.is_dir():
                raise InvalidInput(f"cannot make {place}: {error.strerror or error}") from None
        finally:
            shutil.rmtree(making, ignore_errors=True)


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
        except OSError as error:
            raise InvalidInput(f"{command[0]}: {error.strerror or error}") from None
    if done.returncode:
        raise InvalidInput(_said(done.stderr or done.stdout) or f"{Path(command[0]).name} ended with {done.returncode}")


def _said(text: str) -> str:
    """What an installer says, in one line: the first error of pip, or all of uv without its hints."""
    errors = [line.removeprefix("ERROR: ") for line in text.splitlines() if line.startswith("ERROR: ")]
    words = errors[0] if errors else FRAME.sub(" ", text.partition("\n\n")[0].partition("hint:")[0])
    return " ".join(words.split())
