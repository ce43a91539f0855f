"""Studies: what is run, and what comes out."""

from typing import Any

from conrod import engines


def _hosted(name: str) -> Any:
    from conrod.studies.execution.hosting import host

    return host(name)


# A process that pursues studies has engines of other packages in processes of their own; a worker takes that back.
engines.load_plugin = _hosted
