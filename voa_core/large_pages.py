"""Arrays that lie on large pages of memory.

The system clears and maps the memory of a new array page by page, when that is first written. At 4 KiB a page this took
a third of the time of keeping the weights of 500 poses; at 2 MiB a page it takes a quarter of that. numpy requests
large pages for arrays of 4 MiB and more alone, and gets them from the first multiple of 2 MiB that the array covers.
"""

import math

import numpy as np
from numpy.typing import DTypeLike

from voa_core.kernels import Array

_PAGE = 2**21
_LEAST_USED = 0.75  # of the last page, or of the only one: the rest of it is memory that nothing uses


def zeros(shape: tuple[int, ...], dtype: DTypeLike) -> Array:
    """Make an array of zeros like `numpy.zeros`, which begins with a large page where it fills most of one."""
    size = math.prod(shape) * np.dtype(dtype).itemsize
    pages = math.ceil(size / _PAGE)
    if size < (pages - 1 + _LEAST_USED) * _PAGE:
        return np.zeros(shape, dtype)
    memory = np.zeros((pages + 1) * _PAGE, dtype=np.uint8)
    first = -memory.ctypes.data % _PAGE
    return memory[first : first + size].view(dtype).reshape(shape)
