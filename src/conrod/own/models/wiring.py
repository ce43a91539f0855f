"""Joints and closures of a model, and whether it has the freedom of the machine that it is to be."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import mujoco
import numpy as np

from conrod.engines.mobility import jacobian_rank
from conrod.engines.mujoco.mobility import mobility
from conrod.errors import InvalidInput
from conrod.own.models.assembly import Assembly
from conrod.own.models.loading import listed, name_or_number
from conrod.own.models.model_facts import Wiring
from conrod.own.models.points import JOINT_KINDS
from conrod.own.models.request import Question

# A joint that takes less than this share of a free direction does not move in it.
MOVES = 1e-6


def check_freedom(assembly: Assembly, question: Question) -> None:
    """Refuse a model of another mobility than the machine's.

    A higher pair takes one freedom, when it touches: the closures alone may leave so many more.

    Raises:
        InvalidInput: tells the count, and what moves or is held.
    """
    count = mobility(assembly.model, assembly.data)
    if question.mobility <= count.freedom <= question.mobility + question.contacts:
        return
    found = f"its mobility is {count.freedom} ({count.coordinates} degrees of freedom of its joints, of which its "
    found += f"closures take {count.rank})"
    required = f"that of the machine is {question.mobility}"
    if question.contacts:
        required += f", or {question.mobility + question.contacts} where it is closed by contact"
    if count.freedom < question.mobility:
        raise InvalidInput(f"{found}, {required}: its closures hold the crank")
    moving = np.abs(assembly.left_free()).max(axis=0) > MOVES
    joints = dict.fromkeys(int(assembly.model.dof_jntid[i]) for i in np.flatnonzero(moving))
    names = listed(name_or_number(assembly.model, "joint", joint) for joint in joints)
    raise InvalidInput(f"{found}, {required}: with the crank held, {names} can still move; is a closure missing?")


def wiring(assembly: Assembly, ranks: Sequence[int]) -> Wiring:
    """Joints and closures of the model; `ranks` are those of the closures along the turn."""
    model, data = assembly.model, assembly.data
    joints = Counter(JOINT_KINDS[int(kind)] for kind in model.jnt_type)
    active = [e for e in range(model.neq) if data.eq_active[e]]
    closures = Counter(_equality_kind(model, e) for e in active)
    return Wiring(
        joints=dict(joints),
        closures=dict(closures),
        inactive=tuple(name_or_number(model, "equality", e) for e in range(model.neq) if not data.eq_active[e]),
        coordinates=int(model.nv),
        rows=len(assembly.jacobian()),
        rank=(min(ranks), max(ranks)),
        idle=tuple(name_or_number(model, "equality", e) for e in _idle(assembly, active)),
    )


def _equality_kind(model: mujoco.MjModel, equality: int) -> str:
    return str(mujoco.mjtEq(int(model.eq_type[equality])).name).removeprefix("mjEQ_").lower()


def _idle(assembly: Assembly, active: list[int]) -> list[int]:
    """Closures that take no freedom which those before them have left."""
    data, jacobian = assembly.data, assembly.jacobian()
    rows = data.efc_type[: data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY
    owners = np.asarray(data.efc_id[: data.nefc][rows])
    idle, needed, rank = list[int](), list[int](), 0
    for equality in active:
        with_it = jacobian_rank(jacobian[np.isin(owners, [*needed, equality])])
        if with_it > rank:
            needed, rank = [*needed, equality], with_it
        else:
            idle.append(equality)
    return idle
