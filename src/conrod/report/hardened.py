"""Effects of hardening a model, as a table and in words."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from conrod.mjcf.harden.results import HardenedModel, Orders, Touching, Variant
from conrod.report import numbers
from conrod.report.table import Cell, Table, Toned, table

MOST_LOOPS, MM = 12, 1e3
ALWAYS = (
    "mj_setConst makes the weights anew and so undoes this: run the lines again after it, or after changing masses "
    "in a way that calls it",
    "for double precision only: in single precision (MJX, Warp, a float32 build) keep the model as it is",
    "a binary model is read by the version of MuJoCo that wrote it; the lines above are for every version",
)


def run_words(found: HardenedModel) -> list[str]:
    """The runs, and how far the loops are open at their start."""
    shown = {numbers.SHOWN_UNITS[unit]: value for unit, value in (found.start_opening or {}).items()}
    opened = ", ".join(f"{_figure(factor * value)} {unit}" for (unit, factor), value in shown.items())
    begin = "the runs start with them closed" if found.start_closed else "and so the runs start"
    return [
        f"{found.path}: MuJoCo {found.mujoco}, {found.seconds:.4g} s in steps of {found.timestep:g} s from "
        f"{found.start}; size {MM * found.size:.4g} mm",
        f"its loops are open by {opened} there; {begin}",
    ]


def figures_table(found: HardenedModel) -> Table:
    """Figures of the model as it is, with its weights alone scaled, and hardened."""
    names = tuple(variant.name for variant in found.variants)
    return table(("", *names), _rows(found), names, "largest in the run")


def _rows(found: HardenedModel) -> Iterator[list[Cell]]:
    variants = found.variants
    yield ["steps completed", *(_completed(v) for v in variants)]
    for k, loop in enumerate(found.loops[:MOST_LOOPS]):
        unit, factor = numbers.SHOWN_UNITS[loop.unit]
        values = (None if v.openings is None else factor * v.openings[k] for v in variants)
        yield [f"opening of {loop.kind} {loop.name} [{unit}]", *map(_figure, values)]
    if len(found.loops) > MOST_LOOPS:
        yield [f"... and {len(found.loops) - MOST_LOOPS} loops more (--json has them)", *[""] * len(variants)]
    yield ["largest opening over size", *(_figure(v.opening_over_size) for v in variants)]
    yield ["  order in the step", *(_orders(v.closing) for v in variants)]
    yield ["drift from the reference [mm]", *(_drift(found, v.drift) for v in variants)]
    yield ["  order in the step", *(_orders(v.drift) for v in variants)]
    yield ["energy, change over exchanged", *(_figure(v.energy) for v in variants)]
    touching = [v.touching for v in variants]
    if any(one and (one.contacts or one.limits) for one in touching):
        yield [
            "contacts at once, penetration [mm]",
            *(_counted(one, "contacts", "penetration", MM) for one in touching),
        ]
        yield ["limits passed at once, by [rad, m]", *(_counted(one, "limits", "excess") for one in touching)]
    yield ["solver iterations", *("-" if v.iterations is None else f"{v.iterations:.1f}" for v in variants)]


def reading_words(found: HardenedModel) -> list[str]:
    """Explanation of the figures."""
    drift = "drift: none, the reference (hardened, RK4, a sixteenth of the step) breaks off"
    if found.reference_known_to is not None and found.travel is not None:
        drift = (
            "drift: of any body's centre of gravity, from the hardened model under RK4 at a sixteenth of the step, "
            f"which is known to {_figure(MM * found.reference_known_to)} mm (-: less than that); travel "
            f"{MM * found.travel:.3g} mm"
        )
    without = ", ".join(found.energy_without)
    energy = f"of copies without {without}" if without else "nothing takes or gives any"
    lines = [
        drift,
        f"energy: {energy}" + (f"; not measured: {found.energy_note}" if found.energy_note else ""),
        f"weights: times {found.factor:g} for {', '.join(found.scaled)}",
        f"harden with them: {', '.join(found.touching_scaled) or 'no geom that collides, no limit'}",
    ]
    if found.cost is not None:
        cost = found.cost
        lines.append(
            f"cost of a step, hardened over as it is: {cost.ratio:.2f} (quartiles {cost.low:.2f} to {cost.high:.2f}), "
            f"{1e6 * cost.seconds:.3g} µs on this machine"
        )
    return lines


def closing_words(file: Path | None) -> list[str]:
    """Notes on every hardened model, and where it was written."""
    written = f"the hardened model: {file}" if file else "nothing written: -o FILE.mjb writes the model"
    return [*(f"note: {note}" for note in ALWAYS), written]


def _completed(variant: Variant) -> Cell:
    return str(variant.steps) if variant.broke is None else Toned(f"{variant.steps}, then {variant.broke}", "bad")


def _orders(orders: Orders | None) -> str:
    if orders is None:
        return "-"
    if orders.claimed is not None:
        return f"{orders.claimed:.2f}"
    if all(pair is None for pair in orders.pairs):
        return "-"
    return ", ".join("-" if pair is None else f"{pair:z.1f}" for pair in orders.pairs)


def _drift(found: HardenedModel, drift: Orders | None) -> str:
    if drift is None or found.reference_known_to is None or drift.values[0] <= found.reference_known_to:
        return "-"
    return _figure(MM * drift.values[0])


def _counted(touching: Touching | None, number: str, most: str, factor: float = 1.0) -> str:
    if touching is None:
        return "-"
    count = getattr(touching, number)
    return f"{count}, {_figure(factor * getattr(touching, most))}" if count else "none"


def _figure(value: float | None) -> str:
    return "-" if value is None else numbers.measured(value)
