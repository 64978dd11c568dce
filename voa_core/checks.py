"""Checks of the values that callers give: shapes, finiteness, signs, names."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from voa_core.errors import InvalidInput, UnknownName

Floats = NDArray[np.float64]


def float_array(field: str, values: ArrayLike, shape: tuple[int | None, ...]) -> Floats:
    """Copy values to a float64 array of `shape` (None: any length); raises InvalidInput for other shapes or types."""
    wanted = "x".join("n" if size is None else str(size) for size in shape) or "a number"
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidInput(field, f"numbers of shape {wanted}", type(values).__name__) from error
    if array.ndim != len(shape) or any(
        want is not None and have != want for have, want in zip(array.shape, shape, strict=True)
    ):
        raise InvalidInput(field, f"shape {wanted}", f"shape {'x'.join(map(str, array.shape)) or '()'}")
    return array


def finite_array(field: str, values: ArrayLike, shape: tuple[int | None, ...]) -> Floats:
    """Copy values to a read-only float64 array of `shape` (None: any length) with finite entries.

    Raises:
        InvalidInput: the values are no numbers, have another shape, or an entry is NaN or infinite.
    """
    array = float_array(field, values, shape)
    if not np.isfinite(array).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise InvalidInput(field, "finite numbers", f"{array[where]} at {list(where)}")
    array.setflags(write=False)
    return array


def number(
    field: str,
    value: float,
    *,
    above: float | None = None,
    at_least: float | None = None,
    below: float | None = None,
) -> float:
    """Convert a value to a finite float within the limits; raises InvalidInput otherwise."""
    value = float(value)
    if above is not None and not value > above:
        expected = f"a number above {above}"
    elif at_least is not None and not value >= at_least:
        expected = f"a number of at least {at_least}"
    elif below is not None and not value < below:
        expected = f"a number below {below}"
    elif not math.isfinite(value):
        expected = "a finite number"
    else:
        return value
    raise InvalidInput(field, expected, repr(value))


def unique_names(what: str, names: Sequence[str]) -> tuple[str, ...]:
    """Convert names to a tuple of at least one, none empty, none twice; raises InvalidInput otherwise."""
    names = tuple(names)
    if not names:
        raise InvalidInput(what, "at least one", "none")
    seen: set[str] = set()
    for name in names:
        if not name:
            raise InvalidInput(what, "names that are not empty", "an empty name")
        if name in seen:
            raise InvalidInput(what, "names that differ", f"{name!r} twice")
        seen.add(name)
    return names


def indices(what: str, names: Sequence[str], known: Sequence[str]) -> NDArray[np.intp]:
    """Find the index of each name in `known`, (k,); raises UnknownName, or InvalidInput for no name or one twice."""
    position = {name: index for index, name in enumerate(known)}
    for name in unique_names(what, names):
        if name not in position:
            raise UnknownName(what, name, known)
    return np.array([position[name] for name in names], dtype=np.intp)


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """Make an array read-only, and return that same array."""
    array.setflags(write=False)
    return array
