"""The connection to a Dask scheduler, refused where it cannot carry conrod's cases, and the calls on its workers.

A call has a process of its own beside its Dask worker, as on this machine.
"""

from __future__ import annotations

import asyncio
import logging
import pickle
import platform
import re
import threading
import warnings
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import version
from typing import Any

from conrod.errors import InvalidInput
from conrod.studies.execution.worker_process import Limits, WorkerDied, WorkerProcesses
from conrod.studies.frame.case import Case

# As Dask's own programs take them, from its configuration.
CERTIFICATES = ("CA_FILE", "CLIENT__CERT", "CLIENT__KEY")

_lock = threading.Lock()
_processes: dict[Limits, WorkerProcesses] = {}


def answer(call: bytes, limits: Limits, expected: Sequence[Mapping[str, Any]]) -> tuple[bool, Any]:
    """Return True and a call's result, or False and what it raised.

    The call goes through a process of its own, so that what a cell does to its process costs neither this worker nor
    the cells beside it, and takes its time limit from its own start.

    Args:
        call: pickled function, arguments and named arguments. As bytes, because the scheduler would otherwise open it.
        expected: identities of the cells among the arguments, as the caller finds them.
    """
    try:
        function, arguments, named = pickle.loads(call)
        _check(expected, identities(arguments))
        return True, _workers(limits).call(function, *arguments, **named)
    except (InvalidInput, WorkerDied, TimeoutError, MemoryError) as error:
        return False, error
    except Exception as error:  # the call's own, of whatever kind
        # Dask would open it while it unpickles the message; a caller without the module could not read even that.
        return False, RuntimeError(f"{type(error).__name__} on {platform.node()}: {error}")


def identities(arguments: Sequence[Any]) -> list[dict[str, Any]]:
    """Identities, on this machine, that determine the results of the cells among some arguments."""
    versions = {"conrod": version("conrod")}
    return [{**versions, **cell.identity()} for cell in arguments if isinstance(cell, Case)]


def _check(expected: Sequence[Mapping[str, Any]], found: Sequence[Mapping[str, Any]]) -> None:
    for there, here in zip(expected, found, strict=True):
        for name in there:
            if here.get(name) != there[name]:
                raise InvalidInput(
                    f"the cluster's worker on {platform.node()} would run another cell: {there['engine']} run with "
                    f"{name} {here.get(name)!r} there and {there[name]!r} here; install the same versions on both"
                )


def _workers(limits: Limits) -> WorkerProcesses:
    with _lock:
        return _processes.setdefault(limits, WorkerProcesses(limits))


def connected(address: str, patience: float) -> Any:
    """A Dask client of the scheduler at an address.

    Args:
        patience: how long to wait for an answer [s].

    Raises:
        InvalidInput: the address is none, Dask is not installed, nothing answers, versions do not match, or a tls://
            address has no certificates in Dask's configuration.
    """
    if not re.fullmatch(r"(tcp|tls)://[^/\s]+:\d{1,5}", address):
        raise InvalidInput(f"cluster {address!r}: give the scheduler's address, such as tcp://192.168.0.7:8786")
    try:
        import distributed
    except ImportError:
        raise InvalidInput("a cluster needs Dask: pip install 'conrod[cluster]'") from None
    # What Dask would log of a lost connection is said in one line by the error; each of these has a level of its own.
    for name in ("distributed", "distributed.client", "tornado.application"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    security = distributed.Security()  # type: ignore[no-untyped-call]  # Dask has no types
    try:
        _greet(address, patience, _certified(security, address))
        with warnings.catch_warnings():
            # A difference that matters is refused below; Dask warns in a table of all that differs.
            warnings.simplefilter("ignore")
            client: Any = distributed.Client(address, timeout=patience, security=security, set_as_default=False)  # type: ignore[no-untyped-call]
    except InvalidInput:
        raise
    except (OSError, ValueError, ImportError) as error:
        raise InvalidInput(f"no cluster answers at {address}: {one_line(error.__cause__ or error)}") from None
    try:
        check_versions(client.get_versions(), address)
    except BaseException:  # Ctrl-C, too: a client that is left open has threads that go on
        client.close()
        raise
    return client


def _certified(security: Any, address: str) -> dict[str, Any]:
    """What a connection needs: for tls://, the certificates of Dask's configuration.

    Raises:
        InvalidInput: there are none, or they cannot be read.
    """
    names = ", ".join(f"DASK_DISTRIBUTED__COMM__TLS__{name}" for name in CERTIFICATES)
    if address.startswith("tls") and not all((security.tls_ca_file, security.tls_client_cert, security.tls_client_key)):
        raise InvalidInput(f"cluster {address}: TLS takes files from Dask's configuration: set {names}")
    try:
        connection: dict[str, Any] = security.get_connection_args("client")
    except OSError as error:
        raise InvalidInput(
            f"cluster {address}: the files that {names} name cannot be used: {one_line(error)}"
        ) from None
    return connection


def _greet(address: str, patience: float, connection: Mapping[str, Any]) -> None:
    """Ask who is there. Dask's client itself waits without end for one that accepts a connection and says nothing.

    Raises:
        OSError: nobody, or nobody who answers in time.
        ValueError: somebody else.
    """

    import distributed

    async def ask() -> Any:
        async with distributed.rpc(address, connection_args=connection) as there:  # type: ignore[no-untyped-call]  # Dask has no types
            return await there.identity()

    async def ask_in_time() -> Any:
        return await asyncio.wait_for(ask(), patience)

    # In a thread of its own: a notebook's has a loop that runs already.
    with ThreadPoolExecutor(1) as aside:
        try:
            given = aside.submit(asyncio.run, ask_in_time()).result()
        except TimeoutError:
            raise TimeoutError(f"nothing for {patience:g} s") from None
    if given.get("type") != "Scheduler":
        raise ValueError(f"a {given.get('type')} is there, not a scheduler")


def check_versions(versions: Mapping[str, Any], address: str) -> None:
    """Refuse other versions of what carries cells to and fro; engines are compared cell by cell.

    Args:
        versions: of client, scheduler and workers, as Dask gives them.

    Raises:
        InvalidInput: names the package, the place and both versions.
    """
    here = _carriers(versions["client"])
    places = {"scheduler": versions["scheduler"], **versions["workers"]}
    for place, given in places.items():
        for package, wanted in here.items():
            found = _carriers(given)[package]
            if found != wanted:
                who = place if place == "scheduler" else f"worker {place}"
                raise InvalidInput(
                    f"the cluster at {address} has other versions: {package} {found} on its {who}, {wanted} here"
                )


def _carriers(given: Mapping[str, Any]) -> dict[str, str]:
    packages = given["packages"]
    python = ".".join(str(packages["python"]).split(".")[:2])
    return {"python": python, "dask": str(packages["dask"]), "distributed": str(packages["distributed"])}


def one_line(error: BaseException) -> str:
    """Message of an error, without its line breaks."""
    return " ".join(str(error).split()) or type(error).__name__
