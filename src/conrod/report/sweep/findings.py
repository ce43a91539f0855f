"""What a sweep shows, in sentences made from its numbers; a sentence whose numbers are missing is not said."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from conrod.engines.presets import STOCK
from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.sweep.bands import Row, preset_rows, rows_of
from conrod.report.sweep.choice import preset_curve
from conrod.report.sweep.economy import economies
from conrod.report.sweep.naming import listed, with_unit
from conrod.report.sweep.setting_tables import SWITCHED, variation_name
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.results import COMPLETED, SweepStudy

if TYPE_CHECKING:
    from conrod.studies.sweep.observed_orders import ObservedOrders
    from conrod.studies.sweep.sensitivity import Sensitivity, Variation

BIAS, NO_BIAS = "error_bias", "0"
# A factor nearer to one than this is no dependence worth a sentence.
SAME = 1.05


def found_in(study: SweepStudy) -> list[str]:
    """The main findings, one paragraph each."""
    return [
        *_plateaus(study),
        *_causes(study),
        *_dependences(study),
        *_unnoticed(study),
        *_shares(study),
        *_biases(study),
        *economies(study),
    ]


# -- plateaus ----------------------------------------------------------------------------------------------------------


def _plateaus(study: SweepStudy) -> Iterator[str]:
    for engine in study.engines:
        orders = _orders_of_preset(study, engine, STOCK)
        if orders is None:
            continue
        levels = {q: orders.orders[q].plateau for q in QUANTITIES}
        said = [f"the {q} error at {with_unit(level, q)}" for q, level in levels.items() if level is not None]
        if said:
            finest = max(p.steps_per_revolution for p in orders.points if p.errors is not None)
            yield (
                f"**The stock settings of {engine_title(engine)} stop getting better** ({orders.label}). Refining the "
                f"step alone, up to {finest} steps per revolution, leaves {listed(said)}: no smaller step helps."
            )


def _orders_of_preset(study: SweepStudy, engine: str, preset: str) -> ObservedOrders | None:
    curve = preset_curve(study, engine, preset)
    if curve is None:
        return None
    return next((o for o in study.orders if (o.engine, o.label) == (engine, curve.rule)), None)


# -- causes ------------------------------------------------------------------------------------------------------------


def _causes(study: SweepStudy) -> Iterator[str]:
    """Parts of the stock settings' position error, as far as all runs that tell them apart completed."""
    for budget in (b for b in study.budgets if b.preset == STOCK):
        norms = {part.name: part.norms["position"] for part in budget.parts if part.norms is not None}
        if not {"total", "iteration", "step", "model"} <= norms.keys():
            continue
        model = budget.part("model")
        told = model.named and norms["model"].told_from_zero
        law = f", where the engine's documented law gives {with_unit(model.predicted, 'position')}" * told
        sizes = {
            name: with_unit(norm.max, "position") if norm.told_from_zero else "what is not told from zero"
            for name, norm in norms.items()
        }
        yield (
            f"**What {engine_title(budget.engine)}'s stock error is made of.** Of {sizes['total']} in position, "
            f"the model's softness alone makes {sizes['model']}{law}; the step {sizes['step']}; the iteration "
            f"{sizes['iteration']} ({budget.settings.get('steps_per_revolution')} steps per revolution)."
        )


# -- masses and gravity ------------------------------------------------------------------------------------------------


def _dependences(study: SweepStudy) -> Iterator[str]:
    for engine in study.engines:
        own = [s for s in study.sensitivities if s.engine == engine]
        stock = [s for s in own if s.preset == STOCK]
        said = [phrase for s in stock for v in _changed(s) if (phrase := _phrase(s, v))]
        if not said:
            continue
        text = (
            f"**What {engine_title(engine)}'s stock error depends on.** The exact motion depends on no mass and no "
            f"gravity. The error does: {'; '.join(said)}."
            if _depends(stock[0])
            else f"**{engine_title(engine)}'s stock error hardly depends on {_varied(stock[0])}**: {'; '.join(said)}."
        )
        others = [phrase for s in own if s.preset != STOCK and (phrase := _largest(s))]
        yield text + (f" Of the other presets: {'; '.join(others)}." if others else "")


def _changed(sensitivity: Sensitivity) -> list[Variation]:
    """Variations that say something: not where the drive faltered."""
    return [v for v in sensitivity.variations[1:] if v.outcome != COMPLETED or v.drive_kept]


def _varied(sensitivity: Sensitivity) -> str:
    return "masses and gravity" if any(v.name == SWITCHED for v in sensitivity.variations) else "masses"


def _ratios(variation: Variation) -> dict[str, float]:
    return {q: r for q in QUANTITIES if (r := variation.ratios.get(q)) is not None and r > 0.0}


def _same(ratio: float) -> bool:
    return 1.0 / SAME < ratio < SAME


def _phrase(sensitivity: Sensitivity, variation: Variation) -> str:
    name = variation_name(sensitivity, variation)
    if variation.outcome != COMPLETED:
        return f"with {name} the run ends as `{variation.outcome}`"
    ratios = _ratios(variation)
    if ratios and all(_same(r) for r in ratios.values()):
        return f"with {name} it stays as it is"
    return (
        f"with {name} it is {listed([f'{numbers.measured(r)} times ({q})' for q, r in ratios.items()])}"
        if ratios
        else ""
    )


def _depends(sensitivity: Sensitivity) -> bool:
    changed = _changed(sensitivity)
    return any(v.outcome != COMPLETED or not all(_same(r) for r in _ratios(v).values()) for v in changed)


def _largest(sensitivity: Sensitivity) -> str:
    changed = _changed(sensitivity)
    factors = [max(r, 1.0 / r) for v in changed for r in _ratios(v).values()]
    failed = [variation_name(sensitivity, v) for v in changed if v.outcome != COMPLETED]
    if not factors:
        return ""
    besides = f", and with {listed(failed)} it does not complete" if failed else ""
    return f"`{sensitivity.preset}` changes by a factor of at most {numbers.measured(max(factors))}{besides}"


# -- grid convergence index --------------------------------------------------------------------------------------------


def _unnoticed(study: SweepStudy) -> Iterator[str]:
    for row in preset_rows(study):
        shares = {q: found.share for q, found in row.by_quantity.items() if found.share is not None}
        if row.title != f"`{STOCK}`" or "position" not in shares:
            continue
        position = row.by_quantity["position"]
        lead = "would not have noticed" if shares["position"] < 0.5 else "would have noticed"
        others = [f"{numbers.percent(share)} for {q}" for q, share in shares.items() if q != "position"]
        beside = f" ({listed(others)})" if others else ""
        median = (
            "" if position.ratio is None else f" The band is {numbers.measured(position.ratio)} of the error (median)."
        )
        yield (
            f"**{engine_title(row.engine)}, stock: refining the {row.path}, a study of convergence alone {lead}.** The "
            "band of the grid convergence index holds the true position error in "
            f"{numbers.percent(shares['position'])} of {position.told} cells{beside}.{median}"
        )


def _shares(study: SweepStudy) -> Iterator[str]:
    by_engine: dict[str, list[Row]] = {}
    for row in rows_of(study):
        by_engine.setdefault(row.engine, []).append(row)
    for engine, rows in by_engine.items():
        said = [f"refining the {row.path}, in {_of_quantities(row)}" for row in rows if _of_quantities(row)]
        if said:
            yield (
                f"**How often that band can be trusted, {engine_title(engine)}**, over all settings that differ in "
                f"effect: it holds the true error, {'; '.join(said)}."
            )


def _of_quantities(row: Row) -> str:
    shares = [(q, found.share) for q, found in row.by_quantity.items() if found.share is not None]
    return listed([f"{numbers.percent(share)} of the cells ({q})" for q, share in shares]) if shares else ""


# -- pymunk's bias -----------------------------------------------------------------------------------------------------


def _biases(study: SweepStudy) -> Iterator[str]:
    """Orders of two rules that differ in their bias alone: those with most iterations of which both claim one."""
    knobs = {(p.engine, p.rule): dict(p.knobs) for p in study.points if BIAS in p.knobs}
    claimed = {
        key: order
        for orders in study.orders
        if (key := (orders.engine, orders.label)) in knobs and (order := orders.orders["position"].claimed) is not None
    }
    pairs = [
        (one, other)
        for one in claimed
        for other in claimed
        if one[0] == other[0]
        and (knobs[one][BIAS], knobs[other][BIAS]) == (STOCK, NO_BIAS)
        and {**knobs[one], BIAS: ""} == {**knobs[other], BIAS: ""}
    ]
    if pairs:
        one, other = pairs[-1]
        yield (
            f"**The order of {engine_title(one[0])}.** With the stock `{BIAS}` its position error falls at order "
            f"{numbers.order(claimed[one])} ({one[1]}); without bias at order {numbers.order(claimed[other])} "
            f"({other[1]})."
        )
