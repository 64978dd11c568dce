"""Products in vector registers, by every version of the registers that the processor has."""

from types import FunctionType
from typing import Any, cast

import numba
import numpy as np
import pytest
from llvmlite import binding
from numba import types
from numba.core import compiler
from numba.core.registry import cpu_target

from voa_core.kernels import Array
from voa_core.register_products import (
    PANEL_BYTES,
    ROWS,
    Registers,
    add_products,
    version_at_hand,
    versions_of,
    write_products,
)

TYPES = [np.float64, np.float32]
X86, OTHER = "x86_64-unknown-linux-gnu", "aarch64-unknown-linux-gnu"


VERSION = 0
WRITE: Any = write_products  # numba's types of it are those of its writer


def products(scores: Array, weights: Array, sums: Array, turn: int, turns: int) -> None:
    """Run a version of the products; `compiled` puts its index in the place of `VERSION`."""
    WRITE(scores, weights, sums, turn, turns, VERSION)


def products_twice(scores: Array, weights: Array, sums: Array, turn: int, turns: int) -> None:
    """Run a version of the products at two places of a kernel."""
    WRITE(scores, weights, sums, turn, turns, VERSION)
    WRITE(scores, weights, sums, turn, turns, VERSION)


def compiled(dtype: Any, version: int, function: Any = products) -> Any:
    """Compile a version of the products of numbers of a type, also in a run in which no kernel is compiled."""
    array, scope = types.Array(numba.from_dtype(np.dtype(dtype)), 2, "C"), {**globals(), "VERSION": version}
    compile_: Any = compiler.compile_extra  # numba has no types
    return compile_(
        cpu_target.typing_context,
        cpu_target.target_context,
        FunctionType(function.__code__, scope),
        (array, array, array, types.intp, types.intp),
        types.none,
        cast(Any, compiler).Flags(),
        {},
    )


def numbers_of(poses: int, dtype: Any) -> tuple[Array, Array, Array]:
    """Scores, weights, and sums to which is added."""
    random, width = np.random.default_rng(poses), PANEL_BYTES // np.dtype(dtype).itemsize
    scores, weights, sums = (random.random(shape) for shape in ((poses, ROWS), (poses, width), (ROWS, width)))
    return scores.astype(dtype), weights.astype(dtype), sums.astype(dtype)


@pytest.mark.parametrize("version", range(version_at_hand() + 1))
@pytest.mark.parametrize("dtype", TYPES)
@pytest.mark.parametrize(("poses", "turn", "turns"), [(1, 0, 1), (2, 3, 4), (64, 16, 17), (100, 299, 300)])
def test_products_are_those_of_numpy(poses: int, turn: int, turns: int, dtype: Any, version: int) -> None:
    scores, weights, sums = numbers_of(poses, dtype)
    expected = sums + scores.T.astype(np.float64) @ weights
    compiled(dtype, version).entry_point(scores, weights, sums, turn, turns)
    np.testing.assert_allclose(sums, expected, rtol=1e-14 if dtype == np.float64 else 1e-6)


@pytest.mark.parametrize("dtype", TYPES)
def test_products_are_added_whether_kernels_are_compiled_or_not(dtype: Any) -> None:
    scores, weights, sums = numbers_of(64, dtype)
    expected = sums + scores.T.astype(np.float64) @ weights

    def add(scores: Array, weights: Array, sums: Array, version: int) -> None:
        add_products(scores, weights, sums, 0, 1, version)

    cast(Any, numba).njit(add)(scores, weights, sums, version_at_hand())
    np.testing.assert_allclose(sums, expected, rtol=1e-14 if dtype == np.float64 else 1e-6)


def test_products_at_two_places_of_a_kernel_are_added_both() -> None:
    scores, weights, sums = numbers_of(10, np.float64)
    expected = sums + 2.0 * scores.T @ weights
    compiled(np.float64, version_at_hand(), products_twice).entry_point(scores, weights, sums, 0, 1)
    np.testing.assert_allclose(sums, expected, rtol=1e-14)


def test_each_version_works_on_whole_registers_of_its_size() -> None:
    for version, registers in enumerate(versions_of(binding.get_process_triple())):
        code = compiled(np.float32, version).library.get_llvm_str()
        assert f"fadd contract <{registers.size // 4} x float>" in code
        signed = [*(f"+{each}" for each in registers.features), *(f"-{each}" for each in registers.without)]
        assert not signed or f'"target-features"="{",".join(signed)}"' in code


def test_versions_are_those_of_the_kind_of_processor() -> None:
    assert [each.size for each in versions_of(X86)] == [16, 32, 64]
    assert versions_of("i686-pc-linux-gnu") == versions_of(X86)
    assert versions_of(OTHER) == (Registers((), (), 16, 4),)


@pytest.mark.parametrize(
    ("triple", "features", "version"),
    [
        (X86, {}, 0),
        (X86, {"avx2": True, "fma": False}, 0),
        (X86, {"avx2": True, "fma": True}, 1),
        (X86, {"avx2": True, "fma": True, "avx512f": False}, 1),
        (X86, {"avx2": True, "fma": True, "avx512f": True}, 2),
        (OTHER, {"sve": True}, 0),
    ],
)
def test_the_newest_version_that_a_processor_has_is_taken(
    triple: str, features: dict[str, bool], version: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(binding, "get_process_triple", lambda: triple)
    monkeypatch.setattr(binding, "get_host_cpu_features", lambda: features)
    version_at_hand.cache_clear()
    try:
        assert version_at_hand() == version
    finally:
        version_at_hand.cache_clear()
