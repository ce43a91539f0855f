"""Lengths of the machine that a table was not made with, fitted to it: one, or two where no one suffices."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.models.tables.consistency import noise_of
from conrod.models.tables.errors import ALL_ERRORS, TableComparison
from conrod.models.tables.slides import EXPLAINED_SHARE, Hypothesis

LENGTH, LENGTHS = "length", "lengths"  # kinds of causes, of one number and of two
GROUND_POINT, GROUND = "ground point", "ground."  # kind of a coordinate of the ground, and how its name begins
MAX_FIT_ROWS = 240  # evenly spread rows that lengths are fitted to
PROBE_SIZE = 1e-5  # of the machine's size, by which a length is changed to see its effect
MAX_LENGTH_CHANGE = 0.5  # of the machine's size: beyond it is another machine
MAX_FITTED = 3  # sets of lengths that are fitted, the most likely first
MAX_LENGTHS = 20  # of a machine whose coordinates that are 0 are doubted as well
MAX_PAIRED_LENGTHS = 12  # of a machine of which pairs are tried
MAX_ALIGNMENT = 0.999  # cosine of the effects of a length and of a turn of the crank, above which they are one
GAUSS_NEWTON_STEPS, SMALL_STEP = 6, 1e-9  # and the share of the machine's size that ends them
SMOOTH_SHARE = 0.01  # share of the differences that a length may leave but for noise: other slips look alike to 5 %
MAX_NOISE_FACTOR = 1.5  # of the noise of what is left, up to which it is nothing but noise
ALIKE_FACTOR = 2.0  # lengths that leave so many times as much as the best cannot be told from it


def length_hypotheses(table: TableComparison) -> Iterator[Hypothesis]:
    """Yield the table as judged with the length that best explains it, or else with two lengths."""
    name = next((one for one in ("position", "velocity", "acceleration") if table.points(one)), None)
    if name is None:
        return
    search = _LengthSearch(table.thin_rows(MAX_FIT_ROWS), name)
    size = float(np.linalg.norm(search.start))
    for kind, count in ((LENGTH, 1), (LENGTHS, 2)):
        names = list(search.slopes)
        if len(names) < count or (count > 1 and len(names) > MAX_PAIRED_LENGTHS):
            return
        fits = [one for some in search.most_likely(count) if (one := search.fit(some)) is not None]
        if not fits:
            continue
        least = min(left for _, left in fits)
        ranked = sorted(fits, key=lambda one: one[1])
        if least > EXPLAINED_SHARE * size or (least > SMOOTH_SHARE * size and not search.is_noise(ranked[0][0])):
            continue
        words = [search.words(values) for values, left in ranked if left <= ALIKE_FACTOR * least + 1e-12 * size]
        text = words[0] if len(words) == 1 else f"{words[0]} (or {', or '.join(words[1:])})"
        scene = table.scene.with_nearby_parameters(**ranked[0][0])
        on_ground = count == 1 and next(iter(ranked[0][0])).startswith(GROUND)
        yield GROUND_POINT if on_ground else kind, text, replace(table, scene=scene), ALL_ERRORS
        return


@dataclass(frozen=True)
class _LengthSearch:
    """A table of few rows, and the error that lengths are fitted to."""

    table: TableComparison
    name: str

    @cached_property
    def size(self) -> float:
        """Largest length of the machine [m]."""
        scene = self.table.scene
        return max(abs(scene.parameters[one]) for one, facts in scene.parameter_facts().items() if facts.unit == "m")

    @cached_property
    def start(self) -> Array:
        """Differences (N,) of the table from the machine as it is, normalised."""
        return self.differences({})

    def differences(self, values: dict[str, float]) -> Array:
        """Differences (N,) of the table from the machine with changed lengths [m], normalised as before."""
        scene = self.table.scene.with_nearby_parameters(**values) if values else self.table.scene
        other = replace(self.table, scene=scene)
        parts = [
            other.difference(self.name, point) / self.table.normalising_size(self.name, point)
            for point in self.table.points(self.name)
        ]
        return np.column_stack(parts).ravel()

    @cached_property
    def slopes(self) -> dict[str, Array]:
        """Derivatives (N,) of the differences by each length that can be changed and matters [1/m], one-sided.

        A coordinate across the crank turns it: that is a crank zero or a time offset, and no length.
        """
        found, probe = dict[str, Array](), PROBE_SIZE * self.size
        turned = self.table.angle_derivatives(self.name).ravel() if self.name == "position" else np.zeros(1)
        lengths = [one for one, facts in self.table.scene.parameter_facts().items() if facts.unit == "m"]
        if len(lengths) > MAX_LENGTHS:
            lengths = [one for one in lengths if self.table.scene.parameters[one] != 0.0]
        for name in lengths:
            try:
                slope = (self.differences({name: self.table.scene.parameters[name] + probe}) - self.start) / probe
            except (InvalidInput, ArithmeticError, np.linalg.LinAlgError):
                continue
            size = float(np.linalg.norm(slope)) * float(np.linalg.norm(turned))
            if np.linalg.norm(slope) > 0.0 and not (size and abs(float(slope @ turned)) > MAX_ALIGNMENT * size):
                found[name] = slope
        return found

    def slope(self, name: str, values: dict[str, float]) -> Array:
        """Derivative (N,) of the table's differences by a length [1/m], by a central difference."""
        probe = PROBE_SIZE * self.size
        ends = [self.differences(values | {name: values[name] + by}) for by in (probe, -probe)]
        return np.asarray((ends[0] - ends[1]) / (2.0 * probe))

    def most_likely(self, count: int) -> list[tuple[str, ...]]:
        """Sets of `count` lengths that explain most of the differences to first order, best first."""

        def residual_norm(names: tuple[str, ...]) -> float:
            form = np.column_stack([self.slopes[name] for name in names])
            return float(np.linalg.norm(self.start - form @ np.linalg.lstsq(form, self.start, rcond=None)[0]))

        return sorted(combinations(self.slopes, count), key=residual_norm)[:MAX_FITTED]

    def fit(self, names: Sequence[str]) -> tuple[dict[str, float], float] | None:
        """Fit lengths by Gauss-Newton, p -= r / (dr/dp); return them [m] and the residual's norm, or None."""
        usual = {name: self.table.scene.parameters[name] for name in names}
        values = dict(usual)
        try:
            off = self.start
            for step in range(GAUSS_NEWTON_STEPS):
                slopes = [self.slopes[name] if step == 0 else self.slope(name, values) for name in names]
                by, _, rank, _ = np.linalg.lstsq(np.column_stack(slopes), off, rcond=1e-6)
                if rank < len(names):
                    return None
                values = {name: values[name] - float(one) for name, one in zip(names, by, strict=True)}
                if any(abs(values[name] - usual[name]) > MAX_LENGTH_CHANGE * self.size for name in names):
                    return None
                off = self.differences(values)
                if float(np.abs(by).max()) <= SMALL_STEP * self.size:
                    break
        except (InvalidInput, ArithmeticError, np.linalg.LinAlgError):
            return None  # the changed machine cannot be assembled, or does not come to where the crank would be
        return values, float(np.linalg.norm(off))

    def is_noise(self, values: dict[str, float]) -> bool:
        """True if the residual of fitted lengths is noise, as large as its third differences imply."""
        left = self.differences(values).reshape(len(self.table.times), -1)
        noise = [noise_of(column) for column in left.T]
        return float(np.sqrt(np.mean(left**2))) <= MAX_NOISE_FACTOR * float(np.sqrt(np.mean(np.square(noise))))

    def words(self, values: dict[str, float]) -> str:
        """Say how far lengths are off: 'rod is 0.1 % too long: 300.3 mm instead of 300 mm'."""
        from conrod.models.check.identity import FoundLength
        from conrod.models.check.report import length_words

        return " and ".join(
            length_words(FoundLength(name, self.table.scene.parameters[name], found)) for name, found in values.items()
        )
