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

    from conrod.engines import engine_named, engine_names
    from conrod.engines.capabilities import MEANINGS, Lacking, capability
    from conrod.engines.registry import OPTIONAL, origin_of
    from conrod.errors import InvalidInput
    from conrod.report.table import table
    from conrod.report.terminal import console, print_lines, print_table

    found, broken = {}, []
    for name in (*engine_names(), *OPTIONAL):
        try:
            found[name] = engine_named(name)
        except InvalidInput as error:
            broken.append(Text(f"{error} ({origin_of(name)})", "red"))
    rows = [
        ("version", *(one.version for one in found.values())),
        ("from", *map(origin_of, found)),
        ("presets", *(", ".join(one.presets) for one in found.values())),
    ]
    for kind, meaning in MEANINGS.items():
        able = [not isinstance(capability(one, kind), Lacking) for one in found.values()]
        rows.append((meaning, *("yes" if has else "unsupported" for has in able)))
    print_table(console(), table(("", *found), rows))
    print_lines(console(), broken)
