"""Compilation of kernels by numba: on first use, cached on disk, and without the GIL while they run."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile a function whose floating-point operations keep their order."""
    return cast(F, numba.njit(cache=True, nogil=True, error_model="numpy")(function))


def sum_kernel(function: F) -> F:
    """Compile a function whose sums may be reordered, so that they run in vector registers.

    Only reassociation and fused multiply-add are allowed: NaN and infinity keep their meaning.
    """
    fast = {"reassoc", "contract"}
    return cast(F, numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=fast)(function))


def frugal_kernel(function: F) -> F:
    """Compile a function that makes no arrays, so that references to the parts of arrays it passes on go uncounted.

    Counting them takes longer than a loop over some tens of numbers. Products and sums may be fused, but keep their
    order.
    """
    options: dict[str, Any] = {"fastmath": {"contract"}, "_nrt": False}
    return cast(F, numba.njit(cache=True, nogil=True, error_model="numpy", **options)(function))
