"""Reaching a Dask scheduler, and refusing one that cannot carry conrod's cells."""

from __future__ import annotations

import logging
import re
import warnings
from collections.abc import Mapping
from typing import Any

from conrod.errors import InvalidInput


def connected(address: str, patience: float) -> Any:
    """A Dask client of the scheduler at an address.

    Args:
        patience: how long to wait for an answer [s].

    Raises:
        InvalidInput: the address is none, Dask is not installed, nothing answers, or versions do not match.
    """
    if not re.fullmatch(r"(tcp|tls)://[^/\s]+:\d{1,5}", address):
        raise InvalidInput(f"cluster {address!r}: give the scheduler's address, such as tcp://192.168.0.7:8786")
    try:
        import distributed
    except ImportError:
        raise InvalidInput("a cluster needs Dask: pip install 'conrod[cluster]'") from None
    # What Dask would log of a lost connection is said in one line by the error.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    with warnings.catch_warnings():
        # A difference that matters is refused below; Dask warns in a table of all that differs.
        warnings.simplefilter("ignore")
        try:
            client: Any = distributed.Client(address, timeout=patience, set_as_default=False)  # type: ignore[no-untyped-call]
        except (OSError, ValueError, ImportError) as error:
            raise InvalidInput(f"no cluster answers at {address}: {one_line(error)}") from None
    try:
        _check_versions(client.get_versions(), address)
    except BaseException:
        client.close()
        raise
    return client


def _check_versions(versions: Mapping[str, Any], address: str) -> None:
    """Refuse other versions of what carries cells to and fro; engines are compared cell by cell."""
    here = _carriers(versions["client"])
    places = {"scheduler": versions["scheduler"], **versions["workers"]}
    for place, told in places.items():
        for package, wanted in here.items():
            found = _carriers(told)[package]
            if found != wanted:
                who = place if place == "scheduler" else f"worker {place}"
                raise InvalidInput(
                    f"the cluster at {address} has other versions: {package} {found} on its {who}, {wanted} here"
                )


def _carriers(told: Mapping[str, Any]) -> dict[str, str]:
    packages = told["packages"]
    python = ".".join(str(packages["python"]).split(".")[:2])
    return {"python": python, "dask": str(packages["dask"]), "distributed": str(packages["distributed"])}


def one_line(error: BaseException) -> str:
    """What an error says, without its line breaks."""
    return " ".join(str(error).split()) or type(error).__name__
