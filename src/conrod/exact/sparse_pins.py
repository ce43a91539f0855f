"""Equations of mechanisms of many links on pins alone: all pins at once, with a sparse Jacobian.

A pin couples two bodies: of the Jacobian's 3 n columns its two rows have eight entries. One joint after the other, and
with dense matrices, the time of a configuration grows with the cube of the number n of bodies; here it grows with n.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Self

import numpy as np

from conrod.exact.jet import Jet, sine_cosine
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Mechanism, Revolute

# Solves for a right-hand side (k,), with the transposed matrix if the second argument is true.
Solver = Callable[[Array, bool], Array]
MIN_BODIES = 30  # below it, and with other joints, dense matrices are solved


class SparsePins:
    """Residual and bordered Jacobian of a mechanism's pins, at poses (T, 3 n).

    Args:
        pins: all joints of the mechanism.
        scale: size of each coordinate (3 n,) [m, m, 1].
        lengths: divisors (3 n - 1,) of the equations [m].
    """

    def __init__(self, mechanism: Mechanism, pins: Sequence[Revolute], scale: Array, lengths: Array) -> None:
        count = len(mechanism.bodies)
        index = {**mechanism.body_index, GROUND: count}
        self._scale, self._lengths, self._size = scale, lengths, 3 * count
        self._bodies = np.array([[index[pin.a], index[pin.b]] for pin in pins]).T  # (2, m)
        self._points = np.array([[pin.point_a, pin.point_b] for pin in pins]).transpose(1, 2, 0)  # (2, 2, m)
        self._arrange_entries()

    @classmethod
    def from_mechanism(cls, mechanism: Mechanism, scale: Array, lengths: Array) -> Self | None:
        """Return the pins of a mechanism; None if it has few bodies, or other joints."""
        pins = [joint for joint in mechanism.joints if isinstance(joint, Revolute)]
        large = len(mechanism.bodies) >= MIN_BODIES and len(pins) == len(mechanism.joints)
        return cls(mechanism, pins, scale, lengths) if large else None

    def _arrange_entries(self) -> None:
        """Find row and column of each entry, and their order in compressed columns; the dense row comes last."""
        count = self._bodies.shape[1]
        rows, columns = [], []
        for body in self._bodies:
            # Of the pin's x its body's x and rotation, of its y its body's y and rotation.
            for own, axis in ((0, 0), (0, 2), (1, 1), (1, 2)):
                rows.append(2 * np.arange(count) + own)
                columns.append(3 * body + axis)
        rows.append(np.full(self._size, self._size - 1))
        columns.append(np.arange(self._size))
        row, column = np.concatenate(rows), np.concatenate(columns)
        self._kept = column < self._size  # the ground does not move
        row, column = row[self._kept], column[self._kept]
        factors = self._scale[column] / np.append(self._lengths, 1.0)[row]
        factors[row == self._size - 1] = 1.0
        self._order = np.lexsort((row, column))
        self._factors, self._rows = factors[self._order], row[self._order].astype(np.int32)
        self._starts = np.searchsorted(column[self._order], np.arange(self._size + 1)).astype(np.int32)

    def _arms(self, coefficients: Sequence[Array]) -> tuple[list[Jet], list[tuple[Jet, Jet]]]:
        """Coordinates x and y of all bodies, the ground last, and arms (x, y) of both ends of each pin from them."""
        still = [np.zeros((len(c), 1)) for c in coefficients]
        x, y, phi = (
            Jet([np.concatenate([c[:, k::3], z], axis=1) for c, z in zip(coefficients, still, strict=True)])
            for k in range(3)
        )
        sine, cosine = sine_cosine(phi)
        arms = []
        for body, (px, py) in zip(self._bodies, self._points, strict=True):
            s, c = (Jet([np.take(one, body, axis=1) for one in jet.coefficients]) for jet in (sine, cosine))
            arms.append((c * px - s * py, s * px + c * py))
        return [x, y], arms

    def residual(self, coefficients: Sequence[Array]) -> Array:
        """Taylor coefficient (T, 3 n - 1), of the highest order given, of the equations along coefficients of poses."""
        places, arms = self._arms(coefficients)
        first, second = self._bodies
        found = np.empty((len(coefficients[0]), self._size - 1))
        for axis, place in enumerate(places):
            at = np.asarray(place.coefficients[-1])
            a, b = (np.asarray(arm[axis].coefficients[-1]) for arm in arms)
            found[:, axis::2] = np.take(at, second, axis=1) + b - (np.take(at, first, axis=1) + a)
        return found / self._lengths

    def solvers(self, poses: Array, border: Array) -> list[Solver | None]:
        """Solvers of the Jacobian at poses (T, 3 n) with a dense row (T, 3 n) below; None where it is singular."""
        from scipy.sparse import csc_matrix  # slow to load
        from scipy.sparse.linalg import splu

        def solver(entries: Array) -> Solver | None:
            try:
                factors = splu(csc_matrix((entries, self._rows, self._starts), shape=(self._size, self._size)))
            except RuntimeError:  # it is singular
                return None
            return lambda right, transposed: factors.solve(right, "T" if transposed else "N")

        return [solver(entries) for entries in self._bordered_entries(poses, border)]

    def _bordered_entries(self, poses: Array, border: Array) -> Array:
        """Entries (T, k) of the Jacobian with a dense row (T, 3 n) below, column by column."""
        _, arms = self._arms([poses])
        entries = []
        for sign, (x, y) in zip((-1.0, 1.0), arms, strict=True):
            ax, ay = np.asarray(x.coefficients[0]), np.asarray(y.coefficients[0])
            same = np.full_like(ax, sign)
            entries += [same, -sign * ay, same, sign * ax]
        found = np.concatenate([*entries, np.broadcast_to(border, poses.shape)], axis=1)
        return np.asarray(found[:, self._kept][:, self._order] * self._factors)
