"""Releases of an engine, each in an environment of its own, and runs in them.

An environment lies in the cache folder, made once, whole or not at all, and is never upgraded. It holds the engine and
what it requires, with the numpy of this process. All else, conrod included, is imported from where this process has it
(`WorkerProcess`), so that two environments differ by the engine alone.
"""

from __future__ import annotations

import hashlib
import os
import platform
import stat
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version as version_of
from pathlib import Path
from typing import Any

import platformdirs

from conrod.engines import engine_named
from conrod.errors import InvalidInput
from conrod.runs.trajectory import Outcome
from conrod.studies.execution.worker_process import CallLimits, WorkerDied, WorkerProcess
from conrod.studies.frame.case import Measurement
from conrod.studies.frame.run import RunCase, measure
from conrod.studies.frame.writing import ROOT_UID, real_path
from conrod.studies.limits.recorders import Fingerprint

PATIENCE = 600.0  # [s] for an installation
STARTED = 120.0  # [s] for an engine to be imported


def install(folder: Path, requirements: Sequence[str]) -> None:
    """Make an environment with some requirements, by venv and pip; wheels alone are taken.

    Raises:
        InvalidInput: what the installer says, in one line.
    """
    _run([sys.executable, "-m", "venv", str(folder)])
    _run([str(python_of(folder)), "-m", "pip", "install", "--quiet", "--only-binary", ":all:", *requirements])


def interpreter(engine: str, requirement: str, version: str) -> str:
    """Path of the interpreter of an environment where an engine has a version; it is made if there is none.

    Raises:
        InvalidInput: it cannot be made, or the engine that it holds cannot be imported, or is another version.
    """
    folder = real_path(platformdirs.user_cache_path("conrod") / "environments")
    requirements = (requirement, f"numpy=={version_of('numpy')}")
    python = f"{sys.implementation.name}{platform.python_version()}"
    digest = hashlib.sha256("\n".join((*requirements, python, sys.base_prefix)).encode()).hexdigest()[:8]
    place = folder / f"{requirement.replace('==', '-')}-{python}-{digest}"
    if place.is_dir():
        check_nobody_else_writes(python_of(place).parent)
        return str(python_of(place))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        check_nobody_else_writes(folder)
        # Made elsewhere and renamed, so that it is there whole or not at all; of two the first counts.
        with tempfile.TemporaryDirectory(prefix=".making-", dir=folder) as name:
            made = Path(name) / "made"
            install(made, requirements)
            found = imported_version(str(python_of(made)), engine)
            if found != version:
                raise InvalidInput(f"{requirement} calls itself {found}")
            made.rename(place)
    except OSError as error:
        if not place.is_dir():
            raise InvalidInput(f"cannot write into {folder}: {error.strerror or error}") from None
    return str(python_of(place))


def check_nobody_else_writes(folder: Path) -> None:
    """Refuse a folder of programs where another user could have put one.

    Raises:
        InvalidInput: it, or a folder above it, is another user's, or all may write there.
    """
    for place in (folder, *folder.parents):
        found = place.lstat()
        if found.st_uid not in (os.geteuid(), ROOT_UID):
            why = f"{place} belongs to another user (uid {found.st_uid})"
        elif stat.S_ISDIR(found.st_mode) and found.st_mode & stat.S_IWOTH and not found.st_mode & stat.S_ISVTX:
            why = f"all may write into {place}"
        else:
            continue
        raise InvalidInput(f"no engine is run from {folder}: {why}; name a folder of your own in XDG_CACHE_HOME")


def imported_version(interpreter: str, engine: str) -> str:
    """Version of an engine in an environment, by importing it there.

    Raises:
        InvalidInput: that fails, in one line; or it crashes, or takes too long.
    """
    worker = WorkerProcess(CallLimits(timeout=STARTED), interpreter=interpreter)
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


# -- runs --------------------------------------------------------------------------------------------------------------

BITS_VERSION = 1  # raised when what is kept of a run comes out otherwise, or means something else, than before


@dataclass(frozen=True, kw_only=True)
class VersionCase(RunCase):
    """A run in a release of its engine, to be performed where that is installed.

    Attributes:
        version: of the engine.
    """

    version: str

    @property
    def engine_version(self) -> str:
        return self.version

    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        return super()._identity(parameters) | {"bits": BITS_VERSION}

    def perform(self) -> Measurement:
        engine, bits = engine_named(self.settings.engine), Fingerprint()
        if engine.version != self.version:
            raise InvalidInput(f"{engine.name} {engine.version} was to run what is for {self.version}")
        try:
            # Errors predicted from gaps are not asked for.
            return replace(measure(self, bits.add), prediction=None, payload={"bits": bits.digests()})
        except InvalidInput:
            raise
        except (AttributeError, TypeError) as error:
            # Of a release that has not what conrod asks of it, which no table of ours foresaw.
            return Measurement(Outcome.UNSUPPORTED.slug, f"conrod cannot drive it: {type(error).__name__}: {error}")
        except Exception as error:  # the engine's own, of whatever kind: an old release fails in its own ways
            return Measurement(Outcome.CRASHED.slug, f"{type(error).__name__}: {' '.join(str(error).split())}")
