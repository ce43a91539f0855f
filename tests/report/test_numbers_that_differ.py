"""Two numbers that differ are printed so that it is seen."""

import pytest

from conrod.report.numbers import unequal_quantities


@pytest.mark.parametrize(("one", "other", "texts"), [
    (0.0, -2.725, ("0", "-2.725")),
    (-2.7251, -2.72512, ("-2.7251", "-2.72512")),
    (300.0004, 300.0, ("300.0004", "300")),
    (1.0, 1.0 + 1e-13, ("1", "1.0000000000001")),
    (2.0, 2.0, ("2", "2")),
])  # fmt: skip
def test_unequal_numbers_have_the_digits_that_show_it(one: float, other: float, texts: tuple[str, str]) -> None:
    assert unequal_quantities(one, other) == texts
