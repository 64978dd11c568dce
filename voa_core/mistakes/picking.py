"""Even selections of indices, for searches that cannot afford all of them."""

import numpy as np
from numpy.typing import NDArray


def evenly(count: int, most: int) -> NDArray[np.intp]:
    """Select at most `most` of `count` indices, evenly spaced, the first and the last among them; (k,)."""
    if count <= most:
        return np.arange(count)
    return np.unique(np.round(np.linspace(0, count - 1, most)).astype(np.intp))
