import errno
import math
import os
import pickle
import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

from voa_core.jit import KernelCache, frugal_kernel, kernel, sum_kernel

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


def double_in(folder: Path) -> Callable[[float], float]:
    """A function whose file, and so the cache of whose kernel, lies in a folder."""
    file = folder / "doubles.py"
    if not file.exists():
        file.write_text("def double(x):\n    return 2.0 * x\n", encoding="utf-8")
    made: Callable[[float], float] = runpy.run_path(str(file))["double"]
    return made


def cut(file: Path) -> None:
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])


def name_a_class_that_is_gone(file: Path) -> None:
    if file.suffix == ".nbi":
        file.write_bytes(pickle.dumps(numba.__version__) + b"cvoa_core.jit\nGone\n.")


@pytest.mark.skipif(UNCOMPILED, reason="nothing is compiled, so nothing is cached")
@pytest.mark.parametrize("damage", [lambda file: file.write_bytes(b""), cut, name_a_class_that_is_gone])
def test_a_damaged_cache_is_compiled_and_written_again(tmp_path: Path, damage: Callable[[Path], None]) -> None:
    first: Any = kernel(double_in(tmp_path))
    assert (first(1.0), sum(first.stats.cache_hits.values())) == (2.0, 0)
    files = list((tmp_path / "__pycache__").glob("*.nb?"))
    assert len(files) == 2
    for file in files:
        damage(file)
    again: Any = kernel(double_in(tmp_path))
    assert (again(1.0), sum(again.stats.cache_hits.values())) == (2.0, 0)
    third: Any = kernel(double_in(tmp_path))
    assert (third(1.0), sum(third.stats.cache_hits.values())) == (2.0, 1)


class Files:
    """Files of a cache that fail."""

    cache_path = "here"

    def __init__(self, error: Exception) -> None:
        self._error, self.flushed = error, False

    def load_overload(self, _signature: object, _target: object) -> object:
        raise self._error

    def save_overload(self, _signature: object, _compiled: object) -> None:
        raise self._error

    def flush(self) -> None:
        self.flushed = True
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))


@pytest.mark.parametrize("error", [EOFError(), AttributeError("Gone"), OSError(errno.EIO, "Input/output error")])
def test_a_cache_that_cannot_be_read_is_emptied(error: Exception) -> None:
    files = Files(error)
    cache = KernelCache(files)
    assert cache.load_overload("types", "processor") is None
    assert files.flushed
    assert cache.cache_path == "here"


def test_a_kernel_runs_on_a_full_disk_and_fails_on_one_that_is_read_only() -> None:
    for full in (errno.ENOSPC, errno.EDQUOT):
        KernelCache(Files(OSError(full, os.strerror(full)))).save_overload("types", "kernel")
    with pytest.raises(OSError, match="Read-only"):
        KernelCache(Files(OSError(errno.EROFS, os.strerror(errno.EROFS)))).save_overload("types", "kernel")
