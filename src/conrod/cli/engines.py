"""`conrod engines`."""

from __future__ import annotations

from conrod.cli import options


@options.verb()
def engines() -> None:
    """List the engines that are installed, where each comes from, and what it can do beside runs.

    Other packages bring engines by an entry point of the group `conrod.engines` (docs/engines.md). One that cannot be
    loaded is named with the reason, and keeps nothing else from running.
    """
    from rich.text import Text

    from conrod.engines.registry import OPTIONAL, loadable_engines
    from conrod.report.engines.tables import capabilities_table
    from conrod.report.terminal import console, print_lines, print_table

    found, left_out = loadable_engines(OPTIONAL)
    print_table(console(), capabilities_table(found))
    print_lines(console(), [Text(line, "red") for line in left_out])
