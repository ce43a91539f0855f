"""The end of a command by an internal error: one line and an exit status, never a traceback.

Exit status 1 says "out of tolerance" alone. `CONROD_DEBUG=1` shows the traceback.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from conrod.system import address_space_limit

# Exit statuses: 1 and 2 are those of a verdict and of bad usage.
USAGE, INTERNAL, INTERRUPTED, BROKEN_PIPE = 2, 3, 130, 141
DEBUG = "CONROD_DEBUG"
MAX_ERROR_CHARACTERS = 300  # characters of what an error says
HOME = Path(__file__).parent


class OutputClosed(Exception):
    """Error raised when the reader of the output has closed it.

    It is no BrokenPipeError: on that, click and rich exit with status 1, which says "out of tolerance".
    """


def run_guarded(run: Callable[[], object]) -> None:
    """Run a program and exit with its status; an error exits with a status other than a verdict's."""
    status: Any
    try:
        status = run()
    except SystemExit as ended:
        status = ended.code
    except MemoryError:
        os.write(2, f"conrod: {out_of_memory()}\n".encode())
        status = USAGE
    except BaseException as error:
        status = _report_ending(error)
    if status == INTERRUPTED:
        # After an interrupt in a text that was executed, as dataclasses are made, `python -m` ends itself by SIGINT in
        # place of the status; the next text has it forget that.
        exec("")
    sys.exit(_flush_outputs(status))


def out_of_memory() -> str:
    """Say that memory ran out, with the limit on address space, if any."""
    limit = address_space_limit()
    allowed = "" if limit is None else f"; {limit >> 20} MiB are allowed here (ulimit -v)"
    return f"out of memory: fewer --steps-per-rev or --revolutions{allowed}"


def _report_ending(error: BaseException) -> int:
    """Print in one line the error that ended the program; return its exit status."""
    from conrod.errors import InvalidInput

    one = first_error(error)
    if isinstance(error, BaseExceptionGroup) and error.split(type(one))[1] is not None:
        one = error  # several kinds
    if isinstance(one, BrokenPipeError | OutputClosed):
        return BROKEN_PIPE
    if isinstance(one, InvalidInput):
        _print_error(f"conrod: {one}")
        return USAGE
    if not isinstance(one, KeyboardInterrupt):
        _print_traceback(error)
    if _comes_of_interrupt(one):
        _print_error("conrod: interrupted")
        return INTERRUPTED
    _print_error(crash_line(error))
    return INTERNAL


def _comes_of_interrupt(error: BaseException) -> bool:
    """True if an error is an interrupt, or what became of one: libraries turn one while they load into their own error.

    Where Ctrl-C or SIGTERM stops a half-made import, an extension raises ImportError, and a class RuntimeError.
    """
    one: BaseException | None = error
    while one is not None and not isinstance(one, KeyboardInterrupt):
        one = one.__cause__ or one.__context__
    return one is not None


def _print_traceback(error: BaseException) -> None:
    """Print the traceback of an internal error if `CONROD_DEBUG` is set."""
    if os.environ.get(DEBUG, "0") not in ("", "0"):
        import traceback

        _print_error("".join(traceback.format_exception(error)))


def crash_line(error: BaseException) -> str:
    """One line on an internal error: its kind, its place in conrod, and how to report it."""
    where = _error_location(error)
    what = f"internal error: {error_text(error)}{f' in {where}' if where else ''}"
    return f"conrod: {what}. This is no verdict: report it to conrod's authors with the command; {DEBUG}=1 says more"


def error_text(error: BaseException) -> str:
    """Kind and text of an error on one line of bounded length."""
    one, name = first_error(error), type(error).__name__
    try:
        words = " ".join(str(one).split())
    except Exception:  # an engine's own, which may raise anything
        words = "its text cannot be had"
    shown = "".join(letter if letter.isprintable() else "?" for letter in words)
    inner = f"{type(one).__name__}: " if one is not error else ""
    return f"{name}: {inner}{shown[:MAX_ERROR_CHARACTERS]}".rstrip(": ")


def first_error(error: BaseException) -> BaseException:
    """The first error of a group, or of nested groups."""
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    return error


def _error_location(error: BaseException) -> str:
    """Module and line of conrod that raised an error; empty if none did."""
    trace, found = first_error(error).__traceback__, ""
    while trace is not None:
        file = Path(trace.tb_frame.f_code.co_filename)
        if file.is_relative_to(HOME) and file != Path(__file__):
            found = f"{file.relative_to(HOME)}:{trace.tb_lineno}"
        trace = trace.tb_next
    return found


def _print_error(text: str) -> None:
    try:
        print(text, file=sys.stderr, flush=True)
    except (OSError, ValueError, AttributeError):  # there is nobody to read it
        return


def _flush_outputs(status: Any) -> Any:
    """Flush both outputs; return the status, or another if the printed text could not be written."""
    for stream in (sys.stdout, sys.stderr):
        try:
            if stream is not None:
                stream.flush()
        except OSError as error:
            discard_output(stream)
            if status in (None, 0, 1) and not isinstance(error, BrokenPipeError):
                _print_error(f"conrod: {error.strerror or error}: standard output")
                status = USAGE
            elif status in (None, 0, 1):
                status = BROKEN_PIPE
    return status


def discard_output(stream: object) -> None:
    """Redirect a stream that cannot be written to the null device, so that closing it raises nothing."""
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())  # type: ignore[attr-defined]
    except (OSError, ValueError, AttributeError):
        return
