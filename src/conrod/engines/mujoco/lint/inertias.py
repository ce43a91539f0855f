"""Masses and inertias that the compiler has made others than those that are written."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from conrod.engines.mujoco.lint.bench import Bench
from conrod.engines.mujoco.lint.edits import SetOption
from conrod.engines.mujoco.lint.finding import Finding, Harm, Value
from conrod.engines.mujoco.lint.rule import Rule
from conrod.engines.mujoco.user_model.loading import listed, name_or_number
from conrod.motion import Array

SAME_MOTION = 1e-6  # of the travel: the motion of a driven machine knows of masses only by what is soft in it
# Everything by which the compiler changes what is written, turned off.
AS_WRITTEN = (
    SetOption(("compiler",), "balanceinertia", "false"),
    SetOption(("compiler",), "boundmass", "0"),
    SetOption(("compiler",), "boundinertia", "0"),
    SetOption(("compiler",), "settotalmass", "-1"),
    SetOption(("compiler",), "inertiafromgeom", "auto"),
)
SAME = 1e-9  # the sums are the same, their order may not be


def judge(bench: Bench) -> Iterator[Finding]:
    """The model compiled a second time, with what is written taken at its word."""
    model = bench.model
    try:
        written = bench.copy(AS_WRITTEN)
    except ValueError as error:
        yield _finding(bench, (), (("compiled as written", " ".join(str(error).split())),), None)
        return
    masses = ~np.isclose(model.body_mass, written.body_mass, rtol=SAME, atol=0.0)
    # Principal moments come in an order of their own.
    compiled, meant = (np.sort(one.body_inertia, axis=1) for one in (model, written))
    inertias = ~np.isclose(compiled, meant, rtol=SAME, atol=0.0).all(axis=1)
    changed = np.flatnonzero(masses | inertias)
    if not len(changed):
        return
    names = tuple(name_or_number(model, "body", int(body)) for body in changed)
    worst = int(max(changed, key=lambda body: _ratio(model.body_mass[body], written.body_mass[body])))
    evidence: tuple[tuple[str, Value], ...] = (
        ("bodies changed", len(changed)),
        ("most changed", name_or_number(model, "body", worst)),
        ("its mass as written [kg]", float(written.body_mass[worst])),
        ("its mass as compiled [kg]", float(model.body_mass[worst])),
        ("its moments as written [kg m²]", _moments(written.body_inertia[worst])),
        ("its moments as compiled [kg m²]", _moments(model.body_inertia[worst])),
    )
    yield _finding(bench, names, evidence, bench.change(AS_WRITTEN) if not bench.run.broke else None)


def _finding(
    bench: Bench, names: tuple[str, ...], evidence: tuple[tuple[str, Value], ...], change: float | None
) -> Finding:
    told = f"masses or inertias of {listed(names)} are not those that are written"
    return Finding(
        rule=RULE.name,
        subjects=names,
        what=told if names else "the compiler makes masses or inertias up, without which the model does not compile",
        harm=Harm.LATENT if change is not None and change <= SAME_MOTION else Harm.WRONG,
        evidence=(*evidence, *(() if change is None else (("change of motion as written", change),))),
        why="drive torques, reactions and free motion are those of another machine",
        fix="write every mass and inertia as it is, and take balanceinertia, boundmass, boundinertia, settotalmass and "
        "inertiafromgeom out of <compiler>",
        edits=AS_WRITTEN if names else (),
        change=change,
    )


def _ratio(one: float, other: float) -> float:
    least = max(min(one, other), 1e-300)
    return float(max(one, other) / least)


def _moments(values: Array) -> str:
    return " ".join(f"{value:.6g}" for value in np.sort(values))


RULE = Rule("changed-inertia", judge, needs_motion=False)
