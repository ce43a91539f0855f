"""A crash is no verdict: one line and exit status 3, in the command, in its workers, in pytest and in helpers."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from conrod.crash import crash_line, run_guarded
from conrod.errors import InvalidInput

pytest_plugins = ["pytester"]
ROOT = Path(__file__).parents[2]


class Unspeakable(Exception):
    """An engine's own error, whose text cannot be had."""

    def __str__(self) -> str:
        raise ValueError


def recurse() -> None:
    recurse()


def raise_error(error: BaseException) -> object:
    raise error


def because(error: BaseException, cause: BaseException) -> BaseException:
    """The error, raised because of another."""
    error.__cause__ = cause
    return error


def amid(error: BaseException, context: BaseException) -> BaseException:
    """The error, raised while another was handled."""
    error.__context__ = context
    return error


@pytest.mark.parametrize(
    ("error", "status", "said"),
    [
        (KeyError("x"), 3, "internal error: KeyError: 'x'"),
        (AssertionError(), 3, "internal error: AssertionError"),
        (RecursionError("maximum recursion depth exceeded"), 3, "internal error: RecursionError: maximum"),
        (ImportError("no module", name="x"), 3, "internal error: ImportError: no module"),
        (GeneratorExit(), 3, "internal error: GeneratorExit"),
        (RuntimeError("a\n\x1b[2Jb" + "c" * 5000), 3, "internal error: RuntimeError: a ?[2Jb"),
        (Unspeakable(), 3, "internal error: Unspeakable: its text cannot be had"),
        (ExceptionGroup("two", [KeyError("x"), OSError("y")]), 3, "internal error: ExceptionGroup: KeyError: 'x'"),
        (BaseExceptionGroup("two", [KeyboardInterrupt(), KeyError("x")]), 3, "internal error: BaseExceptionGroup"),
        (BaseExceptionGroup("one", [KeyboardInterrupt()]), 130, "interrupted"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (because(ImportError("initialization failed"), KeyboardInterrupt()), 130, "interrupted"),
        (amid(KeyError("x"), because(RuntimeError("half made"), KeyboardInterrupt())), 130, "interrupted"),
        (because(ImportError("initialization failed"), KeyError("x")), 3, "internal error: ImportError: init"),
        (MemoryError(), 2, "out of memory"),
        (InvalidInput("unknown 'x'"), 2, "unknown 'x'"),
        (BrokenPipeError(), 141, ""),
    ],
)
def test_no_error_ends_with_the_status_of_a_verdict(
    error: BaseException, status: int, said: str, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        run_guarded(lambda: raise_error(error))
    assert ended.value.code == status
    shown = capfd.readouterr().err
    assert shown.count("\n") == (1 if said else 0)
    assert shown.startswith(f"conrod: {said}" if said else "")
    assert len(shown) < 700
    assert "\x1b" not in shown
    assert ("This is no verdict: report it" in shown) == (status == 3)


@pytest.mark.parametrize("status", [None, 0, 1, 2])
def test_exit_status_of_a_verdict_is_kept(status: int | None) -> None:
    # Negative control.
    for run in (lambda: status, lambda: sys.exit(status)):
        with pytest.raises(SystemExit) as ended:
            run_guarded(run)
        assert ended.value.code == status


def test_too_deep_a_recursion_is_a_crash() -> None:
    with pytest.raises(SystemExit) as ended:
        run_guarded(recurse)
    assert ended.value.code == 3


def test_crash_line_names_the_place_in_conrod() -> None:
    assert " in " not in crash_line(KeyError("x")).partition("This is")[0]
    from conrod.report.table import table

    with pytest.raises(TypeError) as found:
        table(("a",), [None])  # type: ignore[list-item]
    assert " in report/table.py:" in crash_line(found.value)


# A fault of conrod, planted where a command, one of its workers or a library begins.
FAULTS = {
    "command": "import conrod.cli.console as m; m.catalogue = lambda: 1 / 0",
    "import": "import sys; sys.modules['conrod.cli.show'] = None",
    "command line": "import sys; sys.modules['conrod.cli'] = None",
    "output": "import conrod.report.terminal as m; m.print_parts = lambda *_: 1 / 0",
}


# SIGTERM at a chosen moment: while a module is looked for; while a class is made, which Python 3.11 takes for a fault
# of the class; in a text that is executed, after which Python ends itself by SIGINT.
INTERRUPT = """
import signal, sys
class Attribute:
    def __set_name__(self, owner, name):
        signal.raise_signal(signal.SIGTERM)
class Finder:
    def find_spec(name, *_):
        if name == "conrod.cli.show":
            {}
sys.meta_path.insert(0, Finder)
"""
MOMENTS = {
    "import": "signal.raise_signal(signal.SIGTERM)",
    "class": "type('Half', (), {'made': Attribute()})",
    "exec": "exec('signal.raise_signal(signal.SIGTERM)', globals())",
}


def with_fault(fault: str, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    code = f"import sys; {fault}\nsys.argv = ['conrod', *sys.argv[1:]]\nfrom conrod.__main__ import main; main()"
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True, text=True, check=False, env={**os.environ, **environment},
    )  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS)
def test_a_fault_of_conrod_is_one_line_with_status_3(fault: str) -> None:
    done = with_fault(fault, "show")
    assert (done.returncode, done.stderr.count("\n")) == (3, 1), done.stderr
    assert done.stderr.startswith("conrod: internal error: ")


@pytest.mark.parametrize("moment", MOMENTS)
def test_command_told_to_end_while_it_loads_is_interrupted(moment: str, tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(INTERRUPT.format(MOMENTS[moment]))
    done = subprocess.run(
        [sys.executable, "-m", "conrod", "show"], capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
    )  # fmt: skip
    assert (done.returncode, done.stderr.strip()) == (130, "conrod: interrupted")


def test_traceback_is_shown_for_conrod_debug() -> None:
    done = with_fault(FAULTS["command"], "show", CONROD_DEBUG="1")
    assert done.returncode == 3
    assert "Traceback" in done.stderr
    assert "ZeroDivisionError" in done.stderr


def test_a_fault_in_a_worker_is_no_verdict(tmp_path: Path) -> None:
    # The worker imports what the command does: a module that lies in front of conrod's own.
    package = tmp_path / "conrod_fault.py"
    package.write_text("from conrod.execution.run import RunCase\ndef perform(self):\n    return {}['fault']\n")
    fault = (
        f"sys.path.insert(0, {str(tmp_path)!r}); import conrod.execution.run as m, conrod_fault; "
        "import conrod.execution.worker as w; w.perform = conrod_fault.perform; "
        "import conrod.execution.runner as d; d.perform = conrod_fault.perform"
    )
    ledger = str(tmp_path / "l.sqlite")
    done = with_fault(fault, "validate", "saw-40rpm", "--preset", "tuned", "--ledger", ledger)
    assert done.returncode == 3, done.stderr
    assert "conrod: internal error: KeyError: 'fault'" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "command",
    [
        "show",
        "export saw-500rpm --format csv",
        *(pytest.param(more, marks=pytest.mark.slow) for more in ("--help", "show saw-500rpm")),
    ],
)
def test_closed_output_pipe_is_no_verdict(command: str) -> None:
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        [sys.executable, "-m", "conrod", *command.split()], stdout=write, stderr=subprocess.PIPE, text=True, check=False
    )
    os.close(write)
    assert (done.returncode, done.stderr) == (141, "")


def test_full_device_is_reported_and_is_no_verdict() -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "conrod", "show"], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert done.returncode == 2
    assert done.stderr == "conrod: No space left on device: standard output\n"


def test_crash_in_golden_audits_or_benchmarks_has_status_3() -> None:
    # One after the other in one process, for most of what they do until then is to load the same modules.
    modules = ("tests.golden", "audits", "benchmarks")
    code = """
import argparse, runpy, sys
argparse.ArgumentParser.parse_args = lambda *_: 1 / 0
for module in sys.argv[1:]:
    sys.argv = [module, "check"]
    try:
        runpy.run_module(module, run_name="__main__", alter_sys=False)
    except SystemExit as ended:
        print(module, ended.code)
"""
    done = subprocess.run(
        [sys.executable, "-c", code, *modules], cwd=ROOT, capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert done.stdout.splitlines() == [f"{module} 3" for module in modules], done.stderr
    assert [("ZeroDivisionError" in line) for line in done.stderr.splitlines()] == [True] * len(modules)
    assert "Traceback" not in done.stderr


FAULTY = """
import conrod
def test_fault(conrod_check, monkeypatch):
    monkeypatch.setitem(vars(conrod), "check", lambda *_, **__: {}["fault"])
    conrod_check("saw-500rpm")
def test_other():
    assert False
"""
IN_A_WORKER = ["-p", "xdist", "-n", "1"]


def run_pytest(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, *arguments: str) -> pytest.RunResult:
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    monkeypatch.setenv("PYTHONPATH", str(ROOT / "src"))
    pytester.makepyfile(FAULTY)
    return pytester.runpytest_subprocess("-p", "pytest_conrod", "-p", "no:cacheprovider", *arguments)


@pytest.mark.parametrize("workers", [[], IN_A_WORKER])
def test_a_fault_in_a_check_of_pytest_is_an_internal_error(
    workers: list[str], pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    done = run_pytest(pytester, monkeypatch, *workers)
    assert done.ret == pytest.ExitCode.INTERNAL_ERROR
    done.stdout.fnmatch_lines(["*conrod: internal error: KeyError: 'fault'*This is no verdict*"])
    done.stdout.no_fnmatch_line("*Traceback*")


@pytest.mark.parametrize("workers", [[], pytest.param(IN_A_WORKER, marks=pytest.mark.slow)])
def test_a_test_that_fails_by_itself_is_a_failed_test(
    workers: list[str], pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Negative control.
    assert run_pytest(pytester, monkeypatch, "-k", "other", *workers).ret == pytest.ExitCode.TESTS_FAILED
