"""Execution of cases: what determines a run, its result, the ledger, processes, and files that are written."""

from typing import Any

import conrod.engines


def _load_hosted(name: str) -> Any:
    from conrod.execution.hosted_engine import host_engine

    return host_engine(name)


# A process that pursues studies runs engines of other packages in separate processes; a worker loads them itself.
conrod.engines.load_plugin = _load_hosted
