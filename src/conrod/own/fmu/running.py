"""A run of an FMU by FMPy; to be called in a process of its own, for an FMU is native code that may do anything."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from math import isclose
from pathlib import Path
from typing import Any

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.fmu.description import MODES, Variable


@dataclass(frozen=True)
class Order:
    """A run that is asked for.

    Attributes:
        mode: of `MODES`.
        steps: of communication per revolution; None in model exchange.
        tolerance: of CVode, relative; None in co-simulation.
        start, stop: [s].
        count: of samples from start to stop.
    """

    mode: str
    steps: int | None
    tolerance: float | None
    start: float
    stop: float
    count: int

    def __str__(self) -> str:
        setting = f"{self.steps} steps a turn" if self.tolerance is None else f"CVode at {self.tolerance:.0e}"
        return f"{self.mode}, {setting}"


def simulate(_: Path, folder: str, order: Order, variables: Sequence[Variable]) -> Array:
    """Run an unpacked FMU from its initialisation to the end.

    Returns:
        Time and variables (T, 1 + variables), in the FMU's units.

    Raises:
        InvalidInput: a call of it failed, or it ended before its time.
    """
    import fmpy

    said = deque[str](maxlen=1)

    def log(*arguments: Any) -> None:
        said.append(arguments[-1].decode(errors="replace"))

    try:
        result = fmpy.simulate_fmu(
            folder, fmi_type=MODES[order.mode], start_time=order.start, stop_time=order.stop,
            output_interval=(order.stop - order.start) / order.count, relative_tolerance=order.tolerance,
            output=[variable.array for variable in variables], logger=log, record_events=False, remote_platform=None,
        )  # fmt: skip
    except Exception as error:  # of FMPy, CVode and ctypes; the FMU's own words say more than its status
        reason = " ".join([*str(error).split(), *"".join(said).split()])
        raise InvalidInput(f"{order.mode} failed: {reason}") from None
    times, rows = result["time"], len(result)
    if not isclose(times[-1], order.stop, rel_tol=1e-9, abs_tol=1e-9 * (order.stop - order.start)):
        raise InvalidInput(f"{order.mode} failed: it ended at {times[-1]:.6g} s of {order.stop:.6g} s")
    return np.column_stack([times, *(result[one.array].reshape(rows, -1)[:, one.index] for one in variables)])
