"""Share of mutmut's mutants that the tests killed, by module; exit status 1 below the bar (`make mutants`)."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path

BAR = 0.95
# Exit codes that mutmut keeps: a failed test, an error within pytest, a limit of time, a process that died. What was
# not run, or that no test reaches, is not killed.
KILLED = {1, 3, 24, 36, 152, 255, -24, -11, -9}


@dataclass(frozen=True)
class Module:
    """Mutants of a module."""

    name: str
    survivors: tuple[str, ...]
    count: int

    @property
    def share(self) -> float:
        """Of the mutants, those that were killed."""
        return 1.0 - len(self.survivors) / self.count


def modules(folder: Path) -> list[Module]:
    """Modules that have mutants, from the `.meta` files that mutmut leaves below a folder."""
    found = []
    for file in sorted(folder.rglob("*.py.meta")):
        codes = json.loads(file.read_text(encoding="utf-8"))["exit_code_by_key"]
        survivors = tuple(key for key, code in codes.items() if code not in KILLED)
        if codes:
            found.append(Module(str(file.relative_to(folder)).removesuffix(".meta"), survivors, len(codes)))
    return found


def main(folder: str) -> int:
    """Print the share of each module, and those that survived."""
    found = modules(Path(folder))
    for one in found:
        print(f"{one.name}: {one.count - len(one.survivors)} of {one.count} killed, {100.0 * one.share:.1f} %")
        print(*(f"    survived: {name}" for name in one.survivors), sep="\n")
    low = [one.name for one in found if one.share < BAR]
    if low or not found:
        print(f"below {100.0 * BAR:g} %: {', '.join(low) or 'no mutants in ' + folder}", file=sys.stderr)
    return int(bool(low) or not found)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
