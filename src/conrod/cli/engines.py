"""`conrod engines`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from conrod.cli import options

if TYPE_CHECKING:
    from conrod.engines import Engine
    from conrod.report.table import Table


@options.verb()
def engines() -> None:
    """List the engines that are installed, where each comes from, and what it can do beside runs.

    Other packages bring engines by an entry point of the group `conrod.engines` (docs/engines.md). One that cannot be
    loaded is named with the reason, and keeps nothing else from running.
    """
    from rich.text import Text

    from conrod.engines.registry import OPTIONAL, loadable_engines
    from conrod.report.terminal import console, print_lines, print_table

    found, left_out = loadable_engines(OPTIONAL)
    print_table(console(), capabilities_table(found))
    print_lines(console(), [Text(line, "red") for line in left_out])


def capabilities_table(engines: Sequence[Engine[Any]]) -> Table:
    """Version, origin and presets of engines, and which capabilities each has."""
    from conrod.engines.capabilities import MEANINGS, Lacking, capability
    from conrod.engines.registry import origin_of
    from conrod.report.table import table

    rows = [
        ("version", *(one.version for one in engines)),
        ("from", *(origin_of(one.name) for one in engines)),
        ("presets", *(", ".join(one.presets) for one in engines)),
    ]
    for kind, meaning in MEANINGS.items():
        able = (not isinstance(capability(one, kind), Lacking) for one in engines)
        rows.append((meaning, *("yes" if has else "unsupported" for has in able)))
    return table(("", *(one.name for one in engines)), rows)
