"""pytest plugin of conrod: the fixture `conrod_check` and its baselines. It imports conrod when the fixture is used."""

from __future__ import annotations

import hashlib
import itertools
import os
import re
import shlex
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from conrod import Findings

CRASH = ("conrod", "crashed")  # property of a test in which conrod itself failed
FOLDER, LONGEST = "conrod-baselines", 100  # characters of a file's name


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option of this plugin."""
    group = parser.getgroup("conrod", "physics engines against exact motion")
    group.addoption("--conrod-regen-all", action="store_true", help="Write changed baselines again; tests pass.")


def pytest_configure(config: pytest.Config) -> None:
    """Register the plugin that tells crashes of conrod from failed tests."""
    config.pluginmanager.register(_Crashes(), "conrod-crashes")


class _Crashes:
    """Plugin that gives a session with a crash of conrod pytest's status of an internal error."""

    def __init__(self) -> None:
        self.seen = False

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Record whether conrod crashed in a test; the report may come from another process."""
        self.seen |= any(tuple(one) == CRASH for one in report.user_properties)

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Set the exit status of a session with a crash."""
        if self.seen and session.exitstatus == pytest.ExitCode.TESTS_FAILED:
            session.exitstatus = pytest.ExitCode.INTERNAL_ERROR


@pytest.fixture
def conrod_check(request: pytest.FixtureRequest) -> Callable[..., Findings[Any]]:
    """Compare a scene, model or table with the exact motion, and with the test's baseline.

    `conrod_check(subject, scene=None, ...)` takes the arguments of `conrod.check`, and returns its findings.
    """
    files = _files(request)

    def check(subject: Any, scene: Any = None, **words: Any) -> Findings[Any]:
        __tracebackhide__ = True
        return _check(request, subject, scene, words, next(files))

    return check


def _check(
    request: pytest.FixtureRequest, subject: Any, scene: Any, words: dict[str, Any], file: Path
) -> Findings[Any]:
    __tracebackhide__ = True
    import conrod
    from conrod.execution.baseline import OtherBaseline

    try:
        accept = request.config.getoption("--conrod-regen-all")
        found = conrod.check(subject, scene, **words, baseline=file, accept=accept)
    except conrod.InvalidInput as error:
        how = f"\naccept: {_command(request)}" if isinstance(error, OtherBaseline) else ""
        raise pytest.fail.Exception(f"conrod: {error}{how}", pytrace=False) from None
    except Exception as error:
        from conrod.crash import DEBUG, crash_line

        request.node.user_properties.append(CRASH)
        if os.environ.get(DEBUG, "0") not in ("", "0"):
            raise
        raise pytest.fail.Exception(crash_line(error), pytrace=False) from None
    compared = found.baseline
    failed = [f"out of tolerance: {found.verdict}"] if found.within_tolerance is False else []
    if compared is not None and not compared.passed:
        failed.append(compared.text)
        if not compared.written and found.within_tolerance is not False:
            failed.append(f"accept: {_command(request)}")
    if failed:
        pytest.fail("conrod: " + "\n".join(failed), pytrace=False)
    return found


def _files(request: pytest.FixtureRequest) -> Iterator[Path]:
    """Yield the baseline files of a test, one per check, in the folder `conrod-baselines/MODULE`."""
    module, name = request.path, request.node.nodeid.partition("::")[2]
    function, _, parameters = name.removesuffix("]").partition("[")
    plain = "-".join(filter(None, [function.replace("::", "-"), parameters]))
    if len(plain) > LONGEST or not re.fullmatch(r"[\w.-]+", plain, re.ASCII):
        digest = hashlib.sha256(name.encode()).hexdigest()[:8]
        plain = re.sub(r"[^\w.-]+", "-", plain)[:LONGEST] + f"-{digest}"
    for k in itertools.count(1):
        yield Path(_short(module.parent / FOLDER / module.stem / f"{plain}{'' if k == 1 else f'+{k}'}.json"))


def _short(path: Path) -> str:
    return min(str(path), os.path.relpath(path), key=len)


def _command(request: pytest.FixtureRequest) -> str:
    test = "::".join([_short(request.path), request.node.nodeid.partition("::")[2]])
    return f"pytest --conrod-regen-all {shlex.quote(test)}"
