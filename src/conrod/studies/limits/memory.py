"""The memory that a run at an engine's limits takes: that of one piece, however long the run."""

from __future__ import annotations

from conrod.engines import ENGINES, engine_named
from conrod.errors import InvalidInput
from conrod.isolation import Ended, isolated
from conrod.process import address_space

# Beyond what a process starts with [bytes]; measured: 73 to 108 MB, the most for a cam in MuJoCo.
OF_A_RUN = 128_000_000
PATIENCE = 120.0  # [s], for a process to start


def check_memory(limit: int | None) -> None:
    """Refuse a limit in which not every run could end as it would without one.

    Args:
        limit: address space of a process [bytes]; None is none.

    Raises:
        InvalidInput: with both figures.
    """
    if limit is None:
        return
    begins_with = isolated(_at_the_start, timeout=PATIENCE)
    if isinstance(begins_with, Ended):
        return  # what stops every process is told by the first that runs a cell
    if limit < begins_with + OF_A_RUN:
        raise InvalidInput(
            f"a cell's memory limit of {limit} bytes is too little: a run may need {begins_with + OF_A_RUN}, "
            f"{begins_with} of which a process starts with"
        )


def _at_the_start() -> int:
    for name in ENGINES:
        engine_named(name)
    return address_space()
