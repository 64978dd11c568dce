import math
import os
from typing import Any

import numpy as np
import pytest

from voa_core.jit import frugal_kernel, kernel, sum_kernel

UNCOMPILED = os.environ.get("NUMBA_DISABLE_JIT", "0") != "0"


def total(values: Any) -> float:
    total = 0.0
    for value in values:
        total += value
    return total


@pytest.mark.parametrize("decorate", [kernel, sum_kernel, frugal_kernel])
def test_kernels_keep_the_meaning_of_infinity_and_nan(decorate: Any) -> None:
    function = decorate(total)
    assert function(np.array([1.0, 2.0, 3.5])) == 6.5
    assert function(np.array([1.0, math.inf])) == math.inf
    assert math.isnan(function(np.array([1.0, math.nan])))


@pytest.mark.parametrize("decorate", [kernel, sum_kernel, frugal_kernel])
def test_kernels_are_compiled_and_let_other_threads_run_unless_compiling_is_off(decorate: Any) -> None:
    function = decorate(total)
    if UNCOMPILED:
        assert function is total
        return
    assert function.targetoptions["nogil"]
    assert function.targetoptions["nopython"]
    assert not function.targetoptions.get("parallel", False)
