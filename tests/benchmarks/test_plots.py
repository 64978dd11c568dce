"""Exponents are measured on the logarithms, and every law can be timed at its smallest size."""

import pytest

from tests.benchmarks import plots


def test_the_exponent_of_a_power_is_its_power() -> None:
    sizes = (10, 20, 40, 80)
    assert plots.measured_exponent(sizes, [3e-6 * size**1.7 for size in sizes]) == pytest.approx(1.7)


@pytest.mark.parametrize("law", plots.laws(), ids=lambda law: f"{law.step} over {law.over}")
def test_the_smallest_size_of_each_law_runs(law: plots.Law) -> None:
    assert tuple(law.sizes) == tuple(sorted(law.sizes))
    law.work(law.sizes[0])()
