"""Sparse elimination against LAPACK, on matrices of the kinds that mechanisms have and on others."""

from __future__ import annotations

import numpy as np
import pytest

from conrod.exact.elimination import Elimination, Entry

SAMPLES = 7


def matrix_with(loops: int, seed: int) -> list[dict[int, Entry]]:
    """Rows of numbers +-1 below a shuffled diagonal, and a few whose entries change from sample to sample."""
    random = np.random.default_rng(seed)
    size = 6 + loops
    rows: list[dict[int, Entry]] = []
    for i in range(size - loops):
        row: dict[int, Entry] = {j: random.normal(size=SAMPLES) for j in range(i) if random.random() < 0.4}
        rows.append({size - 1: 0.0, **row, i: float(random.choice([-1.0, 1.0]))})
    rows += [{j: random.normal(size=SAMPLES) for j in range(size)} for _ in range(loops)]
    order, columns = random.permutation(size), random.permutation(size)
    return [{int(columns[j]): value for j, value in rows[i].items()} for i in order]


def dense_matrix(rows: list[dict[int, Entry]]) -> np.ndarray:
    matrix = np.zeros((SAMPLES, len(rows), len(rows)))
    for i, row in enumerate(rows):
        for j, value in row.items():
            matrix[:, i, j] = value
    return matrix


@pytest.mark.parametrize("loops", [0, 1, 2, 3])
@pytest.mark.parametrize("seed", range(2))
def test_elimination_agrees_with_lapack(loops: int, seed: int) -> None:
    rows = matrix_with(loops, seed)
    right = np.random.default_rng(seed + 100).normal(size=(len(rows), SAMPLES))
    right[0] = 0.0
    matrix, factors = dense_matrix(rows), Elimination(rows, SAMPLES)
    plain, transposed = (
        np.linalg.solve(some, right.T[:, :, None])[:, :, 0] for some in (matrix, np.swapaxes(matrix, 1, 2))
    )
    np.testing.assert_allclose(factors.solve([0.0, *right[1:]]), plain, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(factors.solve_transposed(list(right)), transposed, rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(np.sign(factors.determinant()), np.sign(np.linalg.det(matrix)))
    # Negative control: the matrix itself has other solutions.
    assert loops == 0 or np.abs(plain - transposed).max() > 1e-3


@pytest.mark.parametrize("loops", [1, 2])
def test_elimination_is_not_finite_only_for_singular_samples(loops: int) -> None:
    rows = matrix_with(loops, 3)
    changing = [row for row in rows if all(isinstance(value, np.ndarray) for value in row.values())]
    for row in changing:
        for value in row.values():
            assert isinstance(value, np.ndarray)
            value[2] = 0.0
    solution = Elimination(rows, SAMPLES).solve([np.ones(SAMPLES)] * len(rows))
    assert not np.isfinite(solution[2]).all()
    assert loops > 1 or np.isfinite(np.delete(solution, 2, axis=0)).all()
    assert np.sign(Elimination(rows, SAMPLES).determinant())[2] == 0.0


def test_elimination_takes_no_pivot_that_may_be_rounding() -> None:
    # A slide along y has the normal (-1, 6e-17): elimination along the second would lose all digits.
    rows: list[dict[int, Entry]] = [{0: -1.0, 1: 6e-17}, {0: 0.3, 1: np.ones(SAMPLES)}]
    solution = Elimination(rows, SAMPLES).solve([1.0, 2.0])
    np.testing.assert_allclose(solution, np.tile([-1.0, 2.3], (SAMPLES, 1)), rtol=1e-15)


def test_elimination_of_empty_column_is_singular() -> None:
    # Of a link without length: what it is turned by moves nothing.
    rows = [{0: np.ones(2), 1: 0.0}, {0: 2.0 * np.ones(2), 1: 0.0}]
    factors = Elimination(rows, 2)
    assert not np.isfinite(factors.solve([1.0, 1.0])).all()
    assert (np.sign(factors.determinant()) == 0.0).all()
    # Negative control.
    assert np.isfinite(Elimination([{0: np.ones(2)}, {0: 2.0 * np.ones(2), 1: 1.0}], 2).solve([1.0, 1.0])).all()
