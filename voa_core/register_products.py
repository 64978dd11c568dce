"""Products of matrices by blocks that stay in vector registers, in instructions that no loop of numba becomes.

A block of sums, six grasps by as many scans as four (or two) registers hold, is kept in registers while all poses of
a block are added to it: each weight that is loaded serves six grasps. A compiler does not find this in a loop over
arrays, so the instructions are written here. They are written for every size of registers that processors of the kind
have, and the processor at hand takes those for its own, also from kernels that were compiled for any of them.

numba compiles a kernel again when the kernel's own file changes: after a change of this file, touch `choice_kernels`.
"""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple, cast

from llvmlite import binding, ir
from numba import config, types
from numba.extending import intrinsic

from voa_core.kernels import Array

ROWS = 6
"""Grasps of a block."""
PANEL_BYTES = 256
"""Size of the weights of one pose in a panel, a power of 2: of 64 scans in float32, of 32 in float64."""
_INDEX, _INT, _BYTE = ir.IntType(64), ir.IntType(32), ir.IntType(8)
_TO_READ, _INTO_SECOND_CACHE, _DATA = _INT(0), _INT(2), _INT(1)
_FUSED = ("contract",)  # a multiplication and an addition become one instruction where the processor has it


class Registers(NamedTuple):
    """Vector registers of processors.

    Attributes:
        features: that such a processor has beyond those that the kernels are compiled for, by LLVM's names.
        without: features of newer ones, which it may lack whatever its name says.
        size: of each register, in bytes.
        across: how many hold one row of a block; six rows of them, and the numbers they are multiplied by, fit.
    """

    features: tuple[str, ...]
    without: tuple[str, ...]
    size: int
    across: int


_OF_X86 = (
    Registers((), (), 16, 2),
    Registers(("avx2", "fma"), ("avx512f",), 32, 2),
    Registers(("avx512f",), (), 64, 4),
)
_OF_OTHERS = (Registers((), (), 16, 4),)


def versions_of(triple: str) -> tuple[Registers, ...]:
    """Versions of the registers of a kind of processor, from the oldest on.

    Args:
        triple: of LLVM, such as "x86_64-unknown-linux-gnu".
    """
    return _OF_X86 if triple.startswith(("x86", "i")) else _OF_OTHERS


@cache
def version_at_hand() -> int:
    """Index of the newest version of the registers that this processor has."""
    has = binding.get_host_cpu_features()
    versions = versions_of(binding.get_process_triple())
    return max(i for i, version in enumerate(versions) if all(has.get(name, False) for name in version.features))


@intrinsic
def write_products(_context: Any, scores: Any, weights: Any, sums: Any, _turn: Any, _turns: Any, _version: Any) -> Any:
    """`add_products`, as numba compiles it: the types of its arguments give its signature and its writer."""

    def write(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> Any:
        arrays = [
            context.make_array(kind)(context, builder, argument)
            for kind, argument in zip(signature.args[:3], arguments[:3], strict=True)
        ]
        poses = builder.extract_value(arrays[0].shape, 0)
        given = [*(array.data for array in arrays), poses, *arguments[3:5]]
        number = ir.FloatType() if weights.dtype == types.float32 else ir.DoubleType()
        after, other = builder.append_basic_block(), builder.append_basic_block()
        choice = builder.switch(arguments[5], other)
        for index, registers in enumerate(versions_of(builder.module.triple)):
            own = builder.append_basic_block()
            choice.add_case(index, own)
            builder.position_at_end(own)
            builder.call(_function(builder.module, number, registers), given)
            builder.branch(after)
        builder.position_at_end(other)
        builder.unreachable()
        builder.position_at_end(after)
        return context.get_dummy_value()

    return types.void(scores, weights, sums, types.intp, types.intp, types.intp), write


def _add_products(scores: Array, weights: Array, sums: Array, _turn: int, _turns: int, _version: int) -> None:
    sums += scores.T @ weights


add_products: Callable[[Array, Array, Array, int, int, int], None] = (
    _add_products if config.DISABLE_JIT else cast(Any, write_products)  # type: ignore[attr-defined]  # numba sets it
)
"""Add sum_p scores[p, x] weights[p, j] to sums[x, j].

All arrays lie row by row in memory, without gaps: scores (c, ROWS) with c at least 1, weights (c, w) of which a row
takes PANEL_BYTES, and sums (ROWS, w). Each sum begins at 0 and is then added, which rounds less than one long sum.

What follows the weights in memory is fetched into a cache meanwhile, for it is multiplied next: a part of it in each of
the turns, counted from 0, in which the same weights are multiplied. The last arguments are `turn`, `turns` and
`version`, which is that of the registers at hand.
"""


def _function(module: ir.Module, number: ir.Type, registers: Registers) -> ir.Function:
    """Write `add_products` of numbers of a type as a function of its own, for a version of the registers."""
    name = f"add_products.{number}.{registers.size}"
    if name in module.globals:
        return module.globals[name]
    array = number.as_pointer()
    function = ir.Function(module, ir.FunctionType(ir.VoidType(), [array, array, array, *3 * [_INDEX]]), name)
    function.linkage = "internal"
    if registers.features:  # llvmlite has no way to an attribute with a value
        wanted = ",".join([*(f"+{each}" for each in registers.features), *(f"-{each}" for each in registers.without)])
        set.add(function.attributes, f'"target-features"="{wanted}"')
    builder = ir.IRBuilder(function.append_basic_block())
    _Writer(builder, number, registers).write(*function.args)
    builder.ret_void()
    return function


class _Writer:
    """Writes the instructions of `add_products`.

    Args:
        builder: at the place to write to.
        number: type of the numbers, of 4 or 8 bytes.
        registers: of the processor.
    """

    def __init__(self, builder: ir.IRBuilder, number: ir.Type, registers: Registers) -> None:
        self._builder = builder
        self._bytes = 4 if isinstance(number, ir.FloatType) else 8
        self._vector = ir.VectorType(number, registers.size // self._bytes)
        self._width = PANEL_BYTES // self._bytes
        self._across = registers.across
        name, fetched = "llvm.prefetch.p0", ir.FunctionType(ir.VoidType(), [_BYTE.as_pointer(), _INT, _INT, _INT])
        self._fetch = builder.module.globals.get(name) or ir.Function(builder.module, fetched, name)

    def write(self, scores: Any, weights: Any, sums: Any, poses: Any, turn: Any, turns: Any) -> None:
        """Write one loop over the poses for each part of a panel's row that fits into registers."""
        builder, count = self._builder, self._vector.count
        step = builder.udiv(_INDEX(PANEL_BYTES), turns)
        ahead = builder.mul(poses, builder.add(_INDEX(PANEL_BYTES), builder.mul(turn, step)))
        for first in range(0, self._width, self._across * count):
            totals = self._write_loop(scores, weights, poses, first, (ahead, step))
            for x, own in enumerate(totals):
                for v, total in enumerate(own):
                    place = self._at(sums, _INDEX(x * self._width + first + v * count))
                    before = builder.load(place, align=self._bytes)
                    builder.store(builder.fadd(before, total), place, align=self._bytes)

    def _write_loop(self, scores: Any, weights: Any, poses: Any, first: int, fetched: Any) -> list[list[Any]]:
        """Write a loop over the poses; returns the sums of each row of the block."""
        builder = self._builder
        before, loop, after = builder.basic_block, builder.append_basic_block(), builder.append_basic_block()
        builder.branch(loop)
        builder.position_at_end(loop)
        pose = builder.phi(_INDEX)
        sums = [[builder.phi(self._vector) for _ in range(self._across)] for _ in range(ROWS)]
        if first == 0:
            self._write_fetches(weights, pose, *fetched)
        row = builder.add(builder.mul(pose, _INDEX(self._width)), _INDEX(first))
        places = (builder.add(row, _INDEX(v * self._vector.count)) for v in range(self._across))
        own = [builder.load(self._at(weights, place), align=self._bytes) for place in places]
        totals = []
        for x, each in enumerate(sums):
            score = builder.load(builder.gep(scores, [builder.add(builder.mul(pose, _INDEX(ROWS)), _INDEX(x))]))
            factor = self._in_all_lanes(score)
            products = (builder.fmul(factor, weight, flags=_FUSED) for weight in own)
            totals.append([builder.fadd(total, part, flags=_FUSED) for total, part in zip(each, products, strict=True)])
        following = builder.add(pose, _INDEX(1))
        pose.add_incoming(_INDEX(0), before)
        pose.add_incoming(following, loop)
        for each, new in zip(sums, totals, strict=True):
            for total, added in zip(each, new, strict=True):
                total.add_incoming(ir.Constant(self._vector, None), before)
                total.add_incoming(added, loop)
        builder.cbranch(builder.icmp_signed("<", following, poses), loop, after)
        builder.position_at_end(after)
        return totals

    def _write_fetches(self, weights: Any, pose: Any, ahead: Any, step: Any) -> None:
        """Fetch the next `step` bytes, two cache lines at most; `ahead` is where this turn's part begins."""
        builder = self._builder
        begin = builder.add(ahead, builder.mul(pose, step))
        start = builder.bitcast(weights, _BYTE.as_pointer())
        for offset in (_INDEX(0), builder.lshr(step, _INDEX(1))):
            place = builder.gep(start, [builder.add(begin, offset)])
            builder.call(self._fetch, [place, _TO_READ, _INTO_SECOND_CACHE, _DATA])

    def _at(self, numbers: Any, index: Any) -> Any:
        return self._builder.bitcast(self._builder.gep(numbers, [index]), self._vector.as_pointer())

    def _in_all_lanes(self, number: Any) -> Any:
        undefined = ir.Constant(self._vector, ir.Undefined)
        lanes = ir.Constant(ir.VectorType(_INT, self._vector.count), None)
        one = self._builder.insert_element(undefined, number, _INT(0))
        return self._builder.shuffle_vector(one, undefined, lanes)
