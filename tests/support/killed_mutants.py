"""Share of mutmut's mutants that the tests killed, by module; exit status 1 below the bar (`make mutants`).

Those count that were chosen (`sampled_mutants`); all, where no choice was made. Mutants that change nothing are listed
in docs/mutants.md, each with its reason. They do not count, nor do those that were not run, but then the run is not
whole and fails. A whole run writes its counts into that page.
"""

from __future__ import annotations

import json
import re
import sys
from collections import Counter
from collections.abc import Callable, Collection, Mapping
from contextlib import chdir
from dataclasses import dataclass
from pathlib import Path

from nearest_tests import FURTHER_SECONDS, STOPPED

BAR = 0.95
PAGE = Path(__file__).parents[2] / "docs" / "mutants.md"
# Exit codes that mutmut keeps: a failed test, an error within pytest, a limit of time, a process that died. What was
# not run, or that no test reaches, is not killed.
KILLED = {1, 3, 24, 36, 152, 255, -24, -11, -9}

COUNTS = re.compile(r"(?<=<!-- counts -->\n).*?(?=<!-- end of counts -->)", re.DOTALL)  # the table in the page

Change = tuple[str, str]  # function, and part of the line as the mutant has it


@dataclass(frozen=True)
class Module:
    """Mutants of a module: names of survivors, and numbers of mutants not run, run, and in all.

    Attributes:
        bounded: survivors that not all tests were tried on, since their time was up.
    """

    name: str
    survivors: tuple[str, ...]
    unrun: int
    count: int
    of: int
    bounded: tuple[str, ...]

    @property
    def whole(self) -> bool:
        """True if all its mutants were run."""
        return self.count == self.of

    def share(self, equivalent: Mapping[str, Change]) -> float:
        """Share of killed mutants among all that change behaviour; equivalent ones are known by name."""
        same = sum(name in equivalent for name in self.survivors)
        return (self.count - len(self.survivors)) / max(self.count - same, 1)


def modules(folder: Path, chosen: Collection[str] | None = None) -> list[Module]:
    """Modules with chosen mutants, or all mutants, from the `.meta` files that mutmut leaves below a folder."""
    found = []
    for file in sorted(folder.rglob("*.py.meta")):
        every = json.loads(file.read_text(encoding="utf-8"))["exit_code_by_key"]
        codes = {key: code for key, code in every.items() if chosen is None or key in chosen}
        survivors = tuple(key for key, code in codes.items() if code not in {*KILLED, None})
        if codes:
            name, unrun = str(file.relative_to(folder)).removesuffix(".meta"), sum(c is None for c in codes.values())
            bounded = tuple(key for key, code in codes.items() if code == STOPPED)
            found.append(Module(name, survivors, unrun, len(codes) - unrun, len(every), bounded))
    return found


def chosen_mutants(folder: Path) -> set[str] | None:
    """Names of the mutants that `sampled_mutants` chose, from its file above mutmut's folder; None without one."""
    file = folder.parents[1] / "chosen.json"
    if not file.exists():
        return None
    return {name for one in json.loads(file.read_text(encoding="utf-8")).values() for name in one["names"]}


def listed_changes(page: str) -> list[Change]:
    """Changes that a page lists as rows: function, changed to, reason; several changes share a reason."""
    rows = re.findall(r"^\| `(conrod\.[\w.]+)` \| (`.+?`) \| \S.* \|$", page, re.MULTILINE)
    return [(function, change) for function, changes in rows for change in re.findall(r"`(.+?)`", changes)]


def function_of(mutant: str) -> str:
    """The function that a mutant is of, by mutmut's name for it: `m.x_f__mutmut_1`, `m.xǁClassǁf__mutmut_1`."""
    module, _, name = mutant.rpartition("__mutmut_")[0].rpartition(".")
    return f"{module}.{name[2:].replace('ǁ', '.')}"


def listed_survivors(survivors: list[str], changes: list[Change], lines: Callable[[str], str]) -> dict[str, Change]:
    """Survivors that are listed with their change; `lines` are the changed lines of a mutant."""
    of = {name: [change for change in changes if change[0] == function_of(name)] for name in survivors}
    return {name: one for name, own in of.items() if own for one in own if one[1] in lines(name)}


def changed_lines(mutant: str) -> str:
    """The lines that a mutant has in place of others."""
    from mutmut.mutation.diff_apply import find_mutant, get_diff_for_mutant

    diff: str = get_diff_for_mutant(mutant, path=find_mutant(mutant).path)
    return "\n".join(line[1:] for line in diff.splitlines() if line.startswith("+") and not line.startswith("+++"))


def counts_table(found: list[Module], same: Mapping[str, Change]) -> str:
    """Markdown table of the counts by module."""
    head = "\n| module | planted | found | change nothing | share |\n|---|---|---|---|---|\n"
    rows = (
        f"| `{one.name.removeprefix('conrod/')}` | {one.count} of {one.of} | {one.count - len(one.survivors)} | "
        f"{sum(name in same for name in one.survivors)} | {100.0 * one.share(same):.1f} % |"
        for one in found
    )
    total = sum(one.count for one in found), sum(one.of for one in found), sum(len(one.survivors) for one in found)
    return head + "\n".join(rows) + f"\n| all | {total[0]} of {total[1]} | {total[0] - total[2]} | {len(same)} | |\n\n"


def main(folder: str, page: Path = PAGE, lines: Callable[[str], str] = changed_lines) -> int:
    """Print the share of killed mutants of each module, and the survivors."""
    found, changes = (
        modules(Path(folder), chosen_mutants(Path(folder))),
        listed_changes(page.read_text(encoding="utf-8")),
    )
    with chdir(Path(folder).parents[1]):  # where mutmut finds what it wrote
        same = listed_survivors([name for one in found for name in one.survivors], changes, lines)
    for one in found:
        alike = sum(name in same for name in one.survivors)
        print(
            f"{one.name}: {one.count - len(one.survivors)} of {one.count} killed, {alike} equivalent, "
            f"{100.0 * one.share(same):.1f} %" + f", {one.unrun} not run" * (one.unrun > 0) + f" (of {one.of})"
        )
        how = dict.fromkeys(one.bounded, f"lived within {FURTHER_SECONDS:g} s of further tests")
        lived = (f"    {how.get(name, 'survived')}: {name}" for name in one.survivors if name not in same)
        print(*lived, sep="\n")
    unrun = sum(one.unrun for one in found)
    if found and not unrun:
        page.write_text(
            COUNTS.sub(lambda _: counts_table(found, same), page.read_text(encoding="utf-8")), encoding="utf-8"
        )
    counted = Counter(same.values())
    # Of a sample nobody knows whether a listed mutant was among those that were not planted.
    whole = tuple(
        f"conrod.{one.name.removesuffix('.py').replace('/', '.').removeprefix('conrod.')}."
        for one in found
        if one.whole
    )
    wrong = {
        f"below {100.0 * BAR:g} %": [one.name for one in found if one.count and one.share(same) < BAR],
        "nothing mutated in": [] if found else [folder],
        "not run, `make mutants` goes on with them": [str(unrun)] if unrun else [],
        "listed as equivalent and not among the survivors": [
            f"{function}: {line}"
            for function, line in changes
            if not unrun and function.startswith(whole) and not counted[function, line]
        ],
    }
    for what, names in wrong.items():
        print(*([f"{what}: {', '.join(names)}"] if names else []), file=sys.stderr)
    return int(any(wrong.values()))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:2]))
