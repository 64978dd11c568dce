"""Compilation of kernels by numba: on first use, cached on disk, and without the GIL while they run.

A cache on the disk that is damaged, as by a loss of power, or that names a class of another version of this package,
counts as empty: the kernel is compiled again. A kernel also runs where the disk is full. On a read-only disk a kernel
that is not in the cache is an error (deploy/decisions/0010-container.md).
"""

import errno
from collections.abc import Callable
from contextlib import suppress
from typing import Any, TypeVar, cast

import numba
from numba.core.caching import FunctionCache

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile a function whose floating-point operations keep their order."""
    return _compiled(function)


def sum_kernel(function: F) -> F:
    """Compile a function whose sums may be reordered, so that they run in vector registers.

    Only reassociation and fused multiply-add are allowed: NaN and infinity keep their meaning.
    """
    return _compiled(function, fastmath={"reassoc", "contract"})


def frugal_kernel(function: F) -> F:
    """Compile a function that makes no arrays, so that references to the parts of arrays it passes on go uncounted.

    Counting them takes longer than a loop over some tens of numbers. Products and sums may be fused, but keep their
    order.
    """
    return _compiled(function, fastmath={"contract"}, _nrt=False)


def _compiled(function: F, **options: Any) -> F:
    dispatcher: Any = numba.njit(nogil=True, error_model="numpy", **options)(function)
    files: Any = FunctionCache(function)  # type: ignore[no-untyped-call]  # numba's classes have no types
    dispatcher._cache = KernelCache(files)  # numba has no other way to a cache of one's own
    return cast(F, dispatcher)


class KernelCache:
    """The cache of a kernel on the disk, without failures where compiling the kernel again would help.

    Args:
        files: numba's own cache of the kernel.
    """

    def __init__(self, files: Any) -> None:
        self._files = files

    def __getattr__(self, name: str) -> Any:
        """Return any other attribute of the files, which numba uses too."""
        return getattr(self._files, name)

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Load the kernel for the types of its arguments; None: it must be compiled."""
        try:
            return self._files.load_overload(signature, target)
        except Exception:  # damaged bytes can raise anything when they are read
            with suppress(OSError):
                self._files.flush()
            return None

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Save a compiled kernel, unless the disk is full.

        Raises:
            OSError: the disk is read-only.
        """
        try:
            self._files.save_overload(signature, compiled)
        except OSError as error:
            if error.errno not in (errno.ENOSPC, errno.EDQUOT):
                raise
