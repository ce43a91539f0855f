"""Releases of an engine, each installed in a separate environment, and runs in them.

An environment is a folder in the cache folder; it is created once, completely or not at all, and never upgraded. It
holds the engine with its requirements, and the numpy version of this process. Everything else, conrod included, is
imported from the paths of this process (`WorkerProcess`), so that two environments differ only by the engine.
"""

from __future__ import annotations

import hashlib
import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version as version_of
from pathlib import Path
from types import TracebackType
from typing import Any, ClassVar, Self

import platformdirs

from conrod.comparison.fingerprint import Fingerprint
from conrod.comparison.trajectory import Outcome
from conrod.engines import engine_named
from conrod.errors import InvalidInput
from conrod.execution.run import RunCase, RunResult, measure
from conrod.execution.worker_process import CallLimits, WorkerDied, WorkerProcess
from conrod.system import interpreter_in, other_writer, real_path

INSTALL_TIMEOUT = 600.0  # [s] for a command of an installation
IMPORT_TIMEOUT = 120.0  # [s] for the import of an engine


def install_requirements(folder: Path, requirements: Sequence[str]) -> None:
    """Create an environment and install requirements with pip, from wheels only.

    Raises:
        InvalidInput: the installation failed; has the installer's message in one line.
    """
    _run_command([sys.executable, "-m", "venv", str(folder)])
    _run_command(
        [str(interpreter_path(folder)), "-m", "pip", "install", "--quiet", "--only-binary", ":all:", *requirements]
    )


def release_interpreter(engine: str, requirement: str, version: str) -> str:
    """Return the interpreter of a release's environment, which is created if missing.

    Args:
        engine: name of the engine.
        requirement: requirement for pip, such as mujoco==3.6.0.
        version: version that the engine has to report.

    Raises:
        InvalidInput: the environment cannot be created, or its engine cannot be imported or has another version.
    """
    folder = real_path(platformdirs.user_cache_path("conrod") / "environments")
    requirements = (requirement, f"numpy=={version_of('numpy')}")
    python = f"{sys.implementation.name}{platform.python_version()}"
    digest = hashlib.sha256("\n".join((*requirements, python, sys.base_prefix)).encode()).hexdigest()[:8]
    place = folder / f"{requirement.replace('==', '-')}-{python}-{digest}"
    if place.is_dir():
        check_no_other_writer(interpreter_path(place).parent)
        return str(interpreter_path(place))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        check_no_other_writer(folder)
        # Created elsewhere and renamed, so that it is complete or missing; of two processes the first succeeds.
        with tempfile.TemporaryDirectory(prefix=".making-", dir=folder) as name:
            made = Path(name) / "made"
            install_requirements(made, requirements)
            found = imported_version(str(interpreter_path(made)), engine)
            if found != version:
                raise InvalidInput(f"{requirement} calls itself {found}")
            made.rename(place)
    except OSError as error:
        if not place.is_dir():
            raise InvalidInput(f"cannot write into {folder}: {error.strerror or error}") from None
    return str(interpreter_path(place))


def check_no_other_writer(folder: Path) -> None:
    """Raise an error if another user may write into a folder of programs.

    Raises:
        InvalidInput: the folder, or one above it, belongs to another user, or all users may write into it.
    """
    if why := other_writer(folder):
        raise InvalidInput(f"no engine is run from {folder}: {why}; name a folder of your own in XDG_CACHE_HOME")


def imported_version(interpreter: str, engine: str) -> str:
    """Return the version of an engine in an environment, by importing it there.

    Raises:
        InvalidInput: the import fails, crashes or takes too long; says how, in one line.
    """
    worker = WorkerProcess(CallLimits(timeout=IMPORT_TIMEOUT), interpreter=interpreter)
    try:
        return worker.call(_engine_version, engine)
    except (WorkerDied, TimeoutError, ImportError, AttributeError, OSError) as error:
        raise InvalidInput(f"it cannot be imported: {type(error).__name__}: {error}") from None
    finally:
        worker.end()


def _engine_version(engine: str) -> str:
    """Return the version of an engine in this process."""
    return engine_named(engine).version


def interpreter_path(folder: Path) -> Path:
    """Return the path of an environment's interpreter."""
    return interpreter_in(folder)


def _run_command(command: Sequence[str]) -> None:
    """Run a command that installs a release; raises InvalidInput with its first error line.

    It runs in an empty folder, so that settings of a project in the working folder do not apply.
    """
    with tempfile.TemporaryDirectory() as aside:
        try:
            done = subprocess.run(
                command,
                capture_output=True,
                text=True,
                timeout=INSTALL_TIMEOUT,
                cwd=aside,
                check=False,
                errors="replace",
            )
        except subprocess.TimeoutExpired:
            raise InvalidInput(f"{Path(command[0]).name} has not ended after {INSTALL_TIMEOUT:g} s") from None
    if done.returncode:
        said = (done.stderr or done.stdout).splitlines()
        # pip prints the error first, and hints after it.
        errors = [line.removeprefix("ERROR: ") for line in said if line.startswith("ERROR: ")]
        raise InvalidInput(next(iter(errors), " ".join(said)) or f"{command[0]} ended with {done.returncode}")


class ReleaseProcesses:
    """Processes of an engine's releases, each started at its first call; they end with the context."""

    def __init__(self, engine: str, requirement: Callable[[str], str], timeout: float) -> None:
        """Start no process yet.

        Args:
            engine: name of the engine.
            requirement: requirement for pip of a version, such as mujoco==3.6.0.
            timeout: longest wall time of a call [s].
        """
        self._engine, self._requirement, self._limits = engine, requirement, CallLimits(timeout=timeout)
        self._processes: dict[tuple[str, int], WorkerProcess] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for process in self._processes.values():
            process.end()

    def call(self, version: str, process: int, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call a function in the process of a release with this number; return the result.

        Raises:
            InvalidInput: the release cannot be installed, or the function refuses its input.
            WorkerDied, TimeoutError: the process ended, or the call took too long; the next call starts another one.
        """
        key = version, process
        if key not in self._processes:
            python = release_interpreter(self._engine, self._requirement(version), version)
            self._processes[key] = WorkerProcess(self._limits, interpreter=python)
        try:
            return self._processes[key].call(function, *arguments)
        except (WorkerDied, TimeoutError):
            self._processes.pop(key).end()
            raise


# -- runs --------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class ReleaseResult(RunResult):
    """A run in a release, with fingerprints of its states and outputs, by their names."""

    bits: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class VersionCase(RunCase):
    """A run in a release of its engine, performed in a process that has this release.

    Attributes:
        version: version of the engine.
    """

    study: ClassVar[str] = "versions"
    result_type: ClassVar[type[Any]] = ReleaseResult

    version: str

    @property
    def engine_version(self) -> str:
        return self.version

    def perform(self) -> ReleaseResult:
        engine, bits = engine_named(self.settings.engine), Fingerprint()
        if engine.version != self.version:
            raise InvalidInput(f"{engine.name} {engine.version} was to run what is for {self.version}")
        try:
            # The ledger keeps no predicted errors of releases.
            measured = vars(measure(self, bits.add)) | {"prediction": None}
            return ReleaseResult(**measured, bits=bits.digests())
        except InvalidInput:
            raise
        except (AttributeError, TypeError) as error:
            # A release lacks something that conrod uses, and `compat` does not know of.
            return ReleaseResult(Outcome.UNSUPPORTED.slug, f"conrod cannot drive it: {type(error).__name__}: {error}")
        except Exception as error:  # of any kind: an old release may fail in any way
            return ReleaseResult(Outcome.CRASHED.slug, f"{type(error).__name__}: {' '.join(str(error).split())}")
