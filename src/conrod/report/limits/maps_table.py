"""How many of its nodes each map took, and of what its areas are."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from conrod.report import numbers
from conrod.report.styles import engine_title
from conrod.report.tables import table
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.grade import Level
from conrod.studies.limits.maps import LimitMap, standing

HEAD = ["engine", "preset", "across", "upwards", "nodes", "runs", "share"]
STANDINGS = list(dict.fromkeys(standing(level.slug) for level in Level))


def maps_table(maps: Sequence[LimitMap]) -> str:
    """A row for each map; nothing where there is none."""
    return table([*HEAD, *(f"{name} nodes" for name in STANDINGS)], [_row(found) for found in maps])


def _row(found: LimitMap) -> list[str]:
    counted = Counter(standing(found.at((i, j)).level) for i in range(len(found.x)) for j in range(len(found.y)))
    return [
        engine_title(found.engine),
        found.preset,
        AXES[found.x_axis].title,
        AXES[found.y_axis].title,
        str(found.nodes),
        str(len(found.runs)),
        numbers.percent(found.share),
        *(numbers.percent(counted[name] / found.nodes) for name in STANDINGS),
    ]
