"""A slide of the machine that is tilted or offset, fitted to a table: each alone, and both where neither suffices."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Joint, Prismatic
from conrod.models.tables.columns import AXES, MOTION
from conrod.models.tables.errors import ERRORS, TableComparison

# Kind and text of a cause, the table without it, names of the errors that it can be behind.
Hypothesis: TypeAlias = tuple[str, str, TableComparison, Collection[str]]

PROBE_SIZE = 1e-4  # [rad], or of the machine's size, by which a slide is moved to see its effect
GAUSS_NEWTON_STEPS = 3  # of Newton iteration from there
MAX_SLIDE_CHANGE = 0.2  # [rad], or of the machine's size: beyond it the slide is another one
EXPLAINED_SHARE = 0.05  # share of a difference that one change alone may leave, for the two together not to be tried


def slide_hypotheses(table: TableComparison) -> Iterator[Hypothesis]:
    """Undo a fitted offset or tilt of each slide on the ground."""
    name = next((one for one in ("position", "velocity", "acceleration") if table.points(one)), None)
    for joint in table.scene.kinematics.mechanism.joints:
        if name is None or not isinstance(joint, Prismatic) or joint.a != GROUND:
            continue
        size, explained = float(np.linalg.norm(table.normalised_differences(name))), False
        for kind, which in (("slide offset", (0,)), ("slide tilt", (1,)), ("slide", (0, 1))):
            if kind == "slide" and explained:
                continue  # a second unknown makes what is left smaller, and says no more
            found = _fit_slide(table, joint, which, name)
            if found is None:
                continue
            (by, turn), undone = found
            explained |= float(np.linalg.norm(undone.normalised_differences(name))) <= EXPLAINED_SHARE * size
            yield kind, f"the slide {joint.name!r} is {_slide_words(by, turn, which)}", undone, ERRORS


def _slide_words(offset: float, tilt: float, parts: tuple[int, ...]) -> str:
    """Describe a slide by its offset [m], part 0, and its tilt [rad], part 1, as far as they are among `parts`."""
    side = "left" if offset > 0.0 else "right"
    words = (f"offset by {1e3 * abs(offset):.4g} mm to the {side} of its direction",
             f"tilted by {math.degrees(tilt):.4g} deg about its point on the ground")  # fmt: skip
    return " and ".join(words[k] for k in parts)


def _fit_slide(
    table: TableComparison, joint: Prismatic, which: tuple[int, ...], name: str
) -> tuple[tuple[float, float], TableComparison] | None:
    """Fit the offset [m] and tilt [rad] of a slide to a table; return them and the table without them, or None.

    Gauss-Newton on the normalised differences r(p) of the table from the changed machine: p -= r / (dr/dp).
    """
    units = np.array([table.scene.kinematics.size, 1.0])
    found, slopes = np.zeros(2), np.zeros((table.normalised_differences(name).size, 2))
    try:
        for k in which:
            probe = np.zeros(2)
            probe[k] = PROBE_SIZE * units[k]
            moved = (
                _undo_slide_change(table, joint, probe).normalised_differences(name).ravel()
                - table.normalised_differences(name).ravel()
            )
            slopes[:, k] = moved / probe[k]
        if not np.all(np.linalg.norm(slopes[:, which], axis=0) > 0.0):
            return None
        for _ in range(GAUSS_NEWTON_STEPS):
            off = _undo_slide_change(table, joint, found).normalised_differences(name).ravel()
            found[list(which)] -= np.linalg.lstsq(slopes[:, which], off, rcond=None)[0]
            if np.any(np.abs(found) > MAX_SLIDE_CHANGE * units):
                return None
        return (float(found[0]), float(found[1])), _undo_slide_change(table, joint, found)
    except (InvalidInput, ArithmeticError, np.linalg.LinAlgError):
        return None  # the changed machine does not come to where the crank would then be


def _undo_slide_change(table: TableComparison, joint: Prismatic, change: Array) -> TableComparison:
    """Subtract from a table the change of exact motion that an offset [m] and tilt [rad] of a slide make."""
    if not change.any():
        return table
    solver = table.scene.kinematics
    mechanism = solver.mechanism

    def move_slide(one: Joint) -> Joint:
        """Offset and tilt the fitted slide; return any other joint unchanged."""
        if one.name != joint.name:
            return one
        normal = np.array([-math.sin(joint.direction), math.cos(joint.direction)])
        x, y = np.asarray(joint.point_a) + change[0] * normal
        return replace(joint, point_a=(float(x), float(y)), direction=joint.direction + float(change[1]))

    other = Kinematics(replace(mechanism, joints=tuple(map(move_slide, mechanism.joints))), solver)
    usual, orders = table.derivatives_by_angle, table.motion_orders
    moved = other.point_derivatives(other.derivatives(table.angle, orders[-1]))
    values = dict(table.values)
    for point in table.scene.lengths:
        for order in orders:
            letter, _ = MOTION[list(MOTION)[order]]
            by = (moved[point][order] - usual[point][order]) * table.scene.speed**order
            for k, axis in enumerate(AXES):
                if (column := f"{point}.{letter}{axis}") in values:
                    values[column] = values[column] - by[:, k]
    return replace(table, values=values)
