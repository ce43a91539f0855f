"""Workers that are forked from a process with all libraries: to load them anew takes longer than most calls.

That process is started once by whoever runs the tests, and serves nobody else. What a worker does, how it is called
and how it ends is the same; how it starts is for the tests that have the fixture `started_anew`.
"""

from __future__ import annotations

import ctypes
import os
import pickle
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

PR_SET_CHILD_SUBREAPER = 36  # prctl(2)
LENGTH = struct.Struct("=I")
PYTHON = sys.executable
# What most calls need.
LOADED = (
    "conrod.engines.mujoco.engine",
    "conrod.engines.pymunk.engine",
    "conrod.execution.run",
    "conrod.execution.worker",
    "conrod.models.check.study",
    "conrod.models.lint.linting",
    "conrod.models.tables.study",
)


def forking_subprocess() -> Any:
    """The module `subprocess`, whose `Popen` forks a worker where it can."""
    return SimpleNamespace(**{**vars(subprocess), "Popen": start_worker})


def start_worker(
    command: Sequence[str], *, stdout: int, pass_fds: Sequence[int], env: Mapping[str, str], **how: Any
) -> Any:
    """What `subprocess.Popen` does for a `WorkerProcess`; it is asked where the worker has another Python."""
    if command[:-1] != [PYTHON, "-P", "-c"] or not hasattr(socket, "send_fds") or sys.platform != "linux":
        return subprocess.Popen(command, stdout=stdout, pass_fds=pass_fds, env=env, **how)
    read, write = os.pipe()
    try:
        (descriptor,) = pass_fds
        pid = _server().fork([write, descriptor], (command[-1], descriptor, dict(env), os.getcwd()))
    finally:
        os.close(write)
    return ForkedProcess(pid, read)


class ForkedProcess:
    """A process that this one has not started, and is the parent of, as `WorkerProcess` uses it."""

    def __init__(self, pid: int, output: int) -> None:
        self.pid, self.stdout = pid, open(output, "rb", buffering=0)  # noqa: SIM115, whoever reads it closes it
        self.returncode: int | None = None
        self._lock = threading.Lock()

    def poll(self) -> int | None:
        with self._lock:
            if self.returncode is None:
                ended, status = os.waitpid(self.pid, os.WNOHANG)
                if ended:
                    self.returncode = os.waitstatus_to_exitcode(status)
        return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        give_up = None if timeout is None else time.monotonic() + timeout
        while (status := self.poll()) is None:
            if give_up is not None and time.monotonic() > give_up:
                raise subprocess.TimeoutExpired("worker", timeout or 0.0)
            time.sleep(0.001)
        return status

    def kill(self) -> None:
        if self.poll() is None:
            os.kill(self.pid, signal.SIGKILL)


class _Server:
    """The process that forks; one request at a time."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._socket, theirs = socket.socketpair()
        from conrod import ONE_THREAD, SAFE_PATH
        from conrod.execution.worker_process import import_path

        # It imports from where this process does, as a worker that is started does.
        code = (
            f"import sys; path = sys.path.copy(); sys.path[:0] = {[str(Path(__file__).parent), *import_path()]!r}; "
            f"import {__name__} as m; exec(m.serve({theirs.fileno()}, path))"
        )

        self._process = subprocess.Popen(
            [PYTHON, "-P", "-c", code],
            stdin=subprocess.DEVNULL,
            pass_fds=[theirs.fileno()],
            env={**os.environ, **ONE_THREAD, **SAFE_PATH, "PYTHONPATH": ""},
            start_new_session=True,
        )
        theirs.close()

    def fork(self, descriptors: Sequence[int], request: Any) -> int:
        """Fork a child of this process, and return its number.

        Args:
            descriptors: file descriptors of its output and of its owner's connection.
            request: its code, the number of the second descriptor in it, its environment and folder.
        """
        content = pickle.dumps(request)
        with self._lock, _adopting_orphans():
            socket.send_fds(self._socket, [LENGTH.pack(len(content))], descriptors)
            self._socket.sendall(content)
            (pid,) = LENGTH.unpack(_receive(self._socket, LENGTH.size))
        return int(pid)


@cache
def _server() -> _Server:
    return _Server()


@contextmanager
def _adopting_orphans() -> Iterator[None]:
    """Be the parent of a process below this one whose own parent ends meanwhile."""
    set_option = ctypes.CDLL(None).prctl
    set_option(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    try:
        yield
    finally:
        set_option(PR_SET_CHILD_SUBREAPER, 0, 0, 0, 0)


def _receive(connection: socket.socket, length: int) -> bytes:
    made = b""
    while len(made) < length:
        if not (part := connection.recv(length - len(made))):
            raise EOFError
        made += part
    return made


# -- the process that forks --------------------------------------------------------------------------------------------


def serve(descriptor: int, path: list[str]) -> str:
    """Fork a child for each request, and return in it, with the code that it is to run.

    Args:
        path: what Python searches without `PYTHONPATH`.
    """
    import gc
    import importlib

    for name in LOADED:
        importlib.import_module(name)
    gc.freeze()
    connection = socket.socket(fileno=descriptor)
    while True:
        header, given, _, _ = socket.recv_fds(connection, LENGTH.size, 2)
        if not header:
            os._exit(0)
        code, number, environment, folder = pickle.loads(_receive(connection, *LENGTH.unpack(header)))
        told, tell = os.pipe()
        between = os.fork()
        if between == 0 and (child := os.fork()):
            os.write(tell, LENGTH.pack(child))
            os._exit(0)
        if between == 0:
            connection.close()
            os.close(told)
            os.close(tell)
            _become(given, number, environment, folder, path)
            return str(code)
        os.waitpid(between, 0)  # the parent of its child is then whoever has asked
        connection.sendall(os.read(told, LENGTH.size))
        for one in (told, tell, *given):
            os.close(one)


def _become(given: Sequence[int], number: int, environment: dict[str, str], folder: str, path: Sequence[str]) -> None:
    """Have the descriptors, the environment and the folder of a process that `subprocess.Popen` has started."""
    os.setsid()
    output, connection = given
    for standard in (1, 2):
        os.dup2(output, standard)
    if connection != number:
        os.dup2(connection, number, inheritable=False)
    for one in {output, connection} - {number}:
        os.close(one)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.path[:] = [*filter(None, environment.get("PYTHONPATH", "").split(os.pathsep)), *path]
    sys.argv = ["-c"]
