"""A sweep made by hand: few points with round numbers, two failures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any

from conrod.comparison.convergence import observed_order
from conrod.exact.motion import QUANTITIES
from conrod.scenes import SCENES
from conrod.studies.sweep.findings import SweepStudy, SweptPoint, SweptRule

STEPS = (20, 100, 500, 2500)

# -- a sweep made by hand: rule, preset, cost of a step [s], errors of position at STEPS ------------------------

STOCK = ("Euler, solref 0.02 s, solimp stock", "stock", 2e-6)
HARD = ("RK4, solref T/10, hardened 1e-9", "hardened", 8e-6)
FAST = ("implicitfast, solref 2 h", None, 2.6e-6)
BIASED = ("error_bias stock, 10 iterations", "stock", 1e-6)
EXACT = ("error_bias 0, 10 iterations", "tuned", 1e-6)
RULES: Mapping[str, Sequence[tuple[Any, tuple[float | None, ...]]]] = {
    "mujoco": (
        (STOCK, (None, 0.041, 0.0402, 0.0401)),
        (HARD, (4e-4, 7e-7, 1.1e-9, 2e-12)),
        (FAST, (4e-3, 1.6e-4, 6.4e-6, 2.6e-7)),
    ),
    "pymunk": ((BIASED, (None, 0.04, 0.008, 0.0016)), (EXACT, (0.025, 1e-3, 4e-5, 1.6e-6))),
}


def errors_of(error: float | None) -> dict[str, float] | None:
    return None if error is None else {"position": error, "velocity": 2.0 * error, "acceleration": 3.0 * error}


def points(engine: str) -> list[SweptPoint]:
    found: list[SweptPoint] = []
    for (rule, preset, step), errors in RULES[engine]:
        for n, error in zip(STEPS, errors, strict=True):
            label, sizes = f"{engine[0].upper()}{len(found) + 1}", errors_of(error)
            # What a failed run cost must not be believed: it is made absurd here.
            seconds = 1e3 if error is None else step * n
            found.append(
                SweptPoint(
                    label=label,
                    key=f"key-{label}",
                    engine=engine,
                    rule=rule,
                    preset=preset,
                    steps_per_revolution=n,
                    outcome="opened" if sizes is None else "completed",
                    reason="the loop is open" if sizes is None else "",
                    errors=sizes,
                    cost=seconds,
                    ratio=seconds / 1e-6,
                )
            )
    return found


# A fit takes longer than all the rest of the study.
fitted = cache(observed_order)


def rules(engine: str) -> Iterator[SweptRule]:
    for (name, *_), errors in RULES[engine]:
        known = [(n, errors_of(error)) for n, error in zip(STEPS, errors, strict=True)]
        completed = [(n, sizes) for n, sizes in known if sizes is not None]
        steps = tuple(n for n, _ in completed)
        orders = {q: fitted(steps, tuple(sizes[q] for _, sizes in completed)) for q in QUANTITIES}
        yield SweptRule(engine, name, orders)


def handmade_sweep() -> SweepStudy:
    """The sweep."""
    scene = SCENES["saw-500rpm"]
    return SweepStudy(
        name="saw-500rpm",
        title=scene.title,
        parameters=dict(scene.parameters),
        one_pass=False,
        grid="coarse",
        engines={"mujoco": "4.0.0", "pymunk": "7.3.1"},
        unsupported={"newcomer": "newcomer has no grid of settings"},
        machine="a machine",
        rules=(*rules("mujoco"), *rules("pymunk")),
        points=(*points("mujoco"), *points("pymunk")),
    )
