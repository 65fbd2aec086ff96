"""Lanes in another order; of the eight children of a BVH8 node also sorted, packed and chosen, at any lane width."""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from glimt.kernel import host_features
from glimt.lanes.ops import call
from glimt.lanes.types import INT1, INT32, broadcast, lanes_type

_I32X8 = lanes_type("i32", 8)
_NETWORK = (((0, 1), (2, 3), (4, 5), (6, 7)), ((0, 2), (1, 3), (4, 6), (5, 7)), ((1, 2), (5, 6)),
            ((0, 4), (1, 5), (2, 6), (3, 7)), ((2, 4), (3, 5)), ((1, 2), (3, 4), (5, 6)))
"""Batcher's odd-even mergesort: pairs to be put in order, stage by stage."""


def _order(lanes):
    return ir.Constant(ir.VectorType(INT32, len(lanes)), lanes)


@intrinsic
def numbers8(typing_context):
    """Return 0, 1, … 7 as i32."""
    return _I32X8(), lambda context, builder, sig, args: _order(list(range(8)))


@intrinsic
def sort8(typing_context, x):
    """Return eight integers, the greatest first."""
    def emit(context, builder, sig, args):
        values = args[0]
        for pairs in _NETWORK:
            partner, first = list(range(8)), list(range(8))
            for a, b in pairs:
                partner[a], partner[b], first[b] = b, a, b + 8
            other = builder.shuffle_vector(values, values, _order(partner))
            greater = builder.select(builder.icmp_signed(">", values, other), values, other)
            smaller = builder.select(builder.icmp_signed("<", values, other), values, other)
            values = builder.shuffle_vector(greater, smaller, _order(first))
        return values

    return _I32X8(x), emit


_NIBBLES = [4 * k for k in range(8)]


@intrinsic
def pack8(typing_context, x):
    """Return the lowest three bits of eight integers in an int32, four bits apart, the first ones lowest."""
    def emit(context, builder, sig, args):
        apart = builder.shl(builder.and_(args[0], _order([7] * 8)), _order(_NIBBLES))
        return call(builder, "llvm.vector.reduce.or.v8i32", INT32, [apart])

    return types.int32(x), emit


@intrinsic
def unpack8(typing_context, word):
    """Return the eight numbers that `pack8` has put in an int32."""
    def emit(context, builder, sig, args):
        word = context.cast(builder, args[0], sig.args[0], types.int32)
        repeated = broadcast(context, builder, word, types.int32, _I32X8)
        return builder.and_(builder.lshr(repeated, _order(_NIBBLES)), _order([7] * 8))

    return _I32X8(word), emit


@intrinsic
def compress8(typing_context, x, condition):
    """Return those of eight integers for which a condition holds, side by side; anything after them."""
    def emit(context, builder, sig, args):
        rest = ir.Constant(x.register, ir.Undefined)
        return call(builder, "llvm.experimental.vector.compress.v8i32", x.register, [*args, rest])

    return x(x, condition), emit


@intrinsic
def shuffle(typing_context, x, index):
    """Return x[index[0]], x[index[1]], … of as many lanes; only the lowest bits of an index count."""
    def emit(context, builder, sig, args):
        if x.count == 8 and "avx2" in host_features():
            return call(builder, f"llvm.x86.avx2.perm{'ps' if x.kind == 'f32' else 'd'}", x.register, args)
        if x.count == 16 and "avx512f" in host_features():
            return call(builder, f"llvm.x86.avx512.permvar.{'sf' if x.kind == 'f32' else 'si'}.512", x.register, args)
        low = builder.and_(args[1], ir.Constant(sig.args[1].register, [x.count - 1] * x.count))
        result = ir.Constant(x.register, ir.Undefined)
        for k in range(x.count):
            value = builder.extract_element(args[0], builder.extract_element(low, INT32(k)))
            result = builder.insert_element(result, value, INT32(k))
        return result

    return x(x, index), emit


@intrinsic
def numbers_in_fours(typing_context, word):
    """Return the numbers of the lowest bits set in an int32, each in four lanes; 0 where there are no more of them."""
    lanes = lanes_type("i32")

    def emit(context, builder, sig, args):
        left, numbers = args[0], ir.Constant(lanes.register, ir.Undefined)
        for k in range(lanes.count // 4):
            zeros = call(builder, "llvm.cttz.i32", INT32, [left, INT1(1)])
            number = builder.select(builder.icmp_signed("!=", left, INT32(0)), zeros, INT32(0))
            numbers = builder.insert_element(numbers, number, INT32(k))
            left = builder.and_(left, builder.sub(left, INT32(1)))
        return builder.shuffle_vector(numbers, numbers, _order([k // 4 for k in range(lanes.count)]))

    return lanes(types.int32), emit
