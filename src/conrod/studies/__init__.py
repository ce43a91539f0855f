"""Studies: cases that are run, how they are run, and the findings."""

from typing import Any

from conrod import engines


def _load_hosted(name: str) -> Any:
    from conrod.studies.execution.hosted_engine import host_engine

    return host_engine(name)


# A process that pursues studies runs engines of other packages in separate processes; a worker loads them itself.
engines.load_plugin = _load_hosted
