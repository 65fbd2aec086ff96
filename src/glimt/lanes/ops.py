"""Operators and functions on lanes."""

import operator

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.errors import RequireLiteralValue
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin

from glimt.kernel import host_features
from glimt.lanes.types import INT8, INT16, INT32, Lanes, as_lanes, lanes_type

CONTRACT = ("contract", "nsz")
"""Flags of + - *: a*b+c may become a fused multiply-add. Never nnan or ninf: slab tests rely on infinity."""

_HAS_FMA = bool(host_features() & {"fma", "neon", "fullfp16"})
_HAS_RCP14 = {"avx512f", "avx512vl"} <= host_features()


def suffix(lanes):
    """Return LLVM's suffix for intrinsics on this type."""
    return f"v{lanes.count}{'f32' if lanes.kind == 'f32' else 'i32'}"


def call(builder, name, result, arguments):
    """Emit a call of the LLVM intrinsic `name`."""
    kind = ir.FunctionType(result, [a.type for a in arguments])
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), arguments)


# ---- operators ----------------------------------------------------------------------------------------------------

def _type_operator(symbol, result):
    @infer_global(symbol)
    class LanesOperator(AbstractTemplate):
        def generic(self, args, kws):
            vectors = [a for a in args if isinstance(a, Lanes)]
            if vectors and all(a is vectors[0] or isinstance(a, types.Number) for a in args):
                return signature(result(vectors[0]), *args)
            return None


def _binary(symbol, emit, result=lambda lanes: lanes):
    _type_operator(symbol, result)

    def lower(context, builder, sig, args):
        lanes = next(t for t in sig.args if isinstance(t, Lanes))
        x, y = (as_lanes(context, builder, a, t, lanes) for a, t in zip(args, sig.args, strict=True))
        return emit(builder, lanes.kind, x, y)

    for pair in ((Lanes, Lanes), (Lanes, types.Number), (types.Number, Lanes)):
        lower_builtin(symbol, *pair)(lower)


def _unary(symbol, emit):
    _type_operator(symbol, lambda lanes: lanes)
    lower_builtin(symbol, Lanes)(lambda context, builder, sig, args: emit(builder, sig.args[0].kind, args[0]))


def _compare(symbol, sign):
    def emit(builder, kind, x, y):
        return builder.fcmp_ordered(sign, x, y) if kind == "f32" else builder.icmp_signed(sign, x, y)

    _binary(symbol, emit, lambda lanes: lanes_type("mask", lanes.count))


_binary(operator.add, lambda b, k, x, y: b.fadd(x, y, flags=CONTRACT) if k == "f32" else b.add(x, y))
_binary(operator.sub, lambda b, k, x, y: b.fsub(x, y, flags=CONTRACT) if k == "f32" else b.sub(x, y))
_binary(operator.mul, lambda b, k, x, y: b.fmul(x, y, flags=CONTRACT) if k == "f32" else b.mul(x, y))
_binary(operator.truediv, lambda b, k, x, y: b.fdiv(x, y))
_binary(operator.and_, lambda b, k, x, y: b.and_(x, y))
_binary(operator.or_, lambda b, k, x, y: b.or_(x, y))
_binary(operator.xor, lambda b, k, x, y: b.xor(x, y))
_binary(operator.lshift, lambda b, k, x, y: b.shl(x, y))
_binary(operator.rshift, lambda b, k, x, y: b.ashr(x, y))
_unary(operator.neg, lambda b, k, x: b.fneg(x) if k == "f32" else b.neg(x))
_unary(operator.invert, lambda b, k, x: b.not_(x))
for _symbol, _sign in ((operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">="),
                       (operator.eq, "=="), (operator.ne, "!=")):
    _compare(_symbol, _sign)


# ---- functions of one or more lanes -------------------------------------------------------------------------------

def _function(emit, arity):
    """Make an intrinsic whose arguments are lanes of one type or scalars."""
    def typed(arguments):
        lanes = next((t for t in arguments if isinstance(t, Lanes)), None)
        if lanes is None:
            return None

        def lower(context, builder, sig, args):
            return emit(builder, lanes, *(as_lanes(context, builder, a, t, lanes)
                                          for a, t in zip(args, sig.args, strict=True)))

        return lanes(*arguments), lower

    if arity == 1:
        return intrinsic(lambda typing_context, x: typed((x,)))
    if arity == 2:
        return intrinsic(lambda typing_context, x, y: typed((x, y)))
    return intrinsic(lambda typing_context, x, y, z: typed((x, y, z)))


def _extreme(sign):
    def emit(builder, lanes, x, y):
        smaller = builder.fcmp_ordered(sign, x, y) if lanes.kind == "f32" else builder.icmp_signed(sign, x, y)
        return builder.select(smaller, x, y)  # as vminps and vmaxps: y where either is NaN

    return _function(emit, 2)


def _fma(builder, lanes, x, y, z):
    if not _HAS_FMA:  # the intrinsic would call libm once per lane
        return builder.fadd(builder.fmul(x, y), z)
    return call(builder, f"llvm.fma.{suffix(lanes)}", lanes.register, [x, y, z])


def _least_number(builder, lanes, x, y):
    kind = ir.FunctionType(lanes.register, [lanes.register] * 2)
    name = f"llvm.minnum.{suffix(lanes)}"
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), [x, y], fastmath=("nnan", "nsz"))


minimum, maximum = _extreme("<"), _extreme(">")
least_number = _function(_least_number, 2)
"""The smaller of two floats, neither NaN nor negative zero. What `minimum` leaves where it was loaded becomes a masked
store, which no load that follows can be served from."""
fma = _function(_fma, 3)
product = _function(lambda b, lanes, x, y: b.fmul(x, y), 2)
difference = _function(lambda b, lanes, x, y: b.fsub(x, y), 2)
sqrt, absolute, floor = (
    _function(lambda b, lanes, x, name=name: call(b, f"llvm.{name}.{suffix(lanes)}", lanes.register, [x]), 1)
    for name in ("sqrt", "fabs", "floor"))


def _approximation(name, refine, exact):
    """Make 1/x or 1/sqrt(x): 14 bits from the processor and one Newton step (about 1 ulp), else exact."""
    def emit(builder, lanes, x):
        def constant(value):
            return ir.Constant(lanes.register, [value] * lanes.count)

        if not (_HAS_RCP14 and lanes.count in (4, 8, 16)):
            return exact(builder, lanes, x, constant)
        every = INT16(-1) if lanes.count == 16 else INT8(-1)
        rough = call(builder, f"llvm.x86.avx512.{name}.ps.{32 * lanes.count}", lanes.register,
                     [x, constant(0.0), every])
        return refine(builder, x, rough, constant)

    return _function(emit, 1)


def _refine_reciprocal(builder, x, r, constant):  # r + r (1 - x r)
    error = builder.fsub(constant(1.0), builder.fmul(x, r, flags=CONTRACT), flags=CONTRACT)
    return builder.fadd(r, builder.fmul(r, error, flags=CONTRACT), flags=CONTRACT)


def _refine_reciprocal_sqrt(builder, x, r, constant):  # r + r/2 (1 - x r r)
    squared = builder.fmul(builder.fmul(x, r, flags=CONTRACT), r, flags=CONTRACT)
    error = builder.fsub(constant(1.0), squared, flags=CONTRACT)
    half = builder.fmul(r, constant(0.5), flags=CONTRACT)
    return builder.fadd(r, builder.fmul(half, error, flags=CONTRACT), flags=CONTRACT)


def _exact_reciprocal_sqrt(builder, lanes, x, constant):
    root = call(builder, f"llvm.sqrt.{suffix(lanes)}", lanes.register, [x])
    return builder.fdiv(constant(1.0), root)


reciprocal = _approximation("rcp14", _refine_reciprocal, lambda b, lanes, x, constant: b.fdiv(constant(1.0), x))
reciprocal_sqrt = _approximation("rsqrt14", _refine_reciprocal_sqrt, _exact_reciprocal_sqrt)


@intrinsic
def select(typing_context, condition, x, y):
    """Return x in the lanes of `condition`, y elsewhere."""
    lanes = next((t for t in (x, y) if isinstance(t, Lanes)), None)
    if lanes is None:
        return None

    def emit(context, builder, sig, args):
        chosen, other = (as_lanes(context, builder, a, t, lanes)
                         for a, t in zip(args[1:], sig.args[1:], strict=True))
        return builder.select(args[0], chosen, other)

    return lanes(condition, x, y), emit


# ---- between kinds ------------------------------------------------------------------------------------------------

def _conversion(kind, emit):
    @intrinsic
    def convert(typing_context, x):
        target = lanes_type(kind, x.count)
        return target(x), lambda context, builder, sig, args: emit(builder, args[0], target.register)

    return convert


to_int = _conversion("i32", lambda b, x, register: b.fptosi(x, register))
to_float = _conversion("f32", lambda b, x, register: b.sitofp(x, register))
as_int = _conversion("i32", lambda b, x, register: b.bitcast(x, register))
as_float = _conversion("f32", lambda b, x, register: b.bitcast(x, register))


# ---- across lanes -------------------------------------------------------------------------------------------------

@intrinsic
def bits(typing_context, lanes):
    """Return a mask as an int32, lane 0 in bit 0."""
    def emit(context, builder, sig, args):
        packed = builder.bitcast(args[0], ir.IntType(lanes.count))
        return builder.zext(packed, INT32)

    return types.int32(lanes), emit


@intrinsic
def from_bits(typing_context, number):
    """Return the mask whose lanes are the lowest bits of an int32."""
    lanes = lanes_type("mask")

    def emit(context, builder, sig, args):
        word = context.cast(builder, args[0], sig.args[0], types.int32)
        return builder.bitcast(builder.trunc(word, ir.IntType(lanes.count)), lanes.register)

    return lanes(number), emit


def _quantifier(sign, value):
    @intrinsic
    def quantify(typing_context, lanes):
        def emit(context, builder, sig, args):
            packed = builder.bitcast(args[0], ir.IntType(lanes.count))
            return builder.icmp_unsigned(sign, packed, packed.type(value))

        return types.boolean(lanes), emit

    return quantify


any_lane, all_lanes = _quantifier("!=", 0), _quantifier("==", -1)


def _reduction(name):
    @intrinsic
    def reduce(typing_context, lanes):
        def emit(context, builder, sig, args):
            kind = ir.FunctionType(lanes.register.element, [lanes.register])
            full = f"llvm.vector.reduce.{name}.{suffix(lanes)}"
            return builder.call(cgutils.get_or_insert_function(builder.module, kind, full), args, fastmath=("nnan",))

        return lanes.scalar(lanes), emit

    return reduce


lowest, highest = _reduction("fmin"), _reduction("fmax")


@intrinsic
def extract(typing_context, lanes, index):
    """Return lane `index` as a scalar."""
    def emit(context, builder, sig, args):
        return builder.extract_element(args[0], context.cast(builder, args[1], sig.args[1], types.int32))

    return lanes.scalar(lanes, index), emit


@intrinsic
def lane_numbers(typing_context):
    """Return 0, 1, 2, … as i32."""
    lanes = lanes_type("i32")
    return lanes(), lambda context, builder, sig, args: ir.Constant(lanes.register, list(range(lanes.count)))


def _bit_count(name, *flags):
    @intrinsic
    def count_bits(typing_context, x):
        kind = types.int64 if x == types.int64 else types.int32

        def emit(context, builder, sig, args):
            register = ir.IntType(kind.bitwidth)
            return call(builder, f"llvm.{name}.i{kind.bitwidth}", register, [args[0], *flags])

        return kind(kind), emit

    return count_bits


count_trailing_zeros = _bit_count("cttz", ir.IntType(1)(1))
"""The number of the lowest bit set in an int32 or int64 that is not 0."""
first_bit = _bit_count("cttz", ir.IntType(1)(0))
"""The same; 32 or 64 for 0."""
population_count = _bit_count("ctpop")
"""How many bits of an int32 or int64 are set."""


def _half(which):
    @intrinsic
    def half(typing_context, lanes):
        count = lanes.count // 2
        part = lanes_type(lanes.kind, count)
        order = ir.Constant(ir.VectorType(INT32, count), list(range(which * count, which * count + count)))
        return part(lanes), lambda context, builder, sig, args: builder.shuffle_vector(args[0], args[0], order)

    return half


lower_half, upper_half = _half(0), _half(1)


@intrinsic
def join(typing_context, lower, upper):
    """Return lanes twice as wide: those of `lower`, then those of `upper`."""
    whole = lanes_type(lower.kind, 2 * lower.count)
    order = ir.Constant(ir.VectorType(INT32, whole.count), list(range(whole.count)))
    return whole(lower, upper), lambda context, builder, sig, args: builder.shuffle_vector(*args, order)


@intrinsic
def interleave4(typing_context, x, y, z, w, part):
    """Return quarter `part` (a literal) of the sequence x0 y0 z0 w0 x1 y1 z1 w1 and so on."""
    if not isinstance(part, types.IntegerLiteral):
        raise RequireLiteralValue(part)
    count = x.count
    first = part.literal_value * count // 4
    pairs = [lane + count * half for lane in range(first, first + count // 4) for half in range(2)] * 2
    order = [2 * (k // 4) + k % 2 + (count if k % 4 > 1 else 0) for k in range(count)]

    def emit(context, builder, sig, args):
        def shuffle(a, b, lanes):
            return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(INT32, count), lanes))

        return shuffle(shuffle(args[0], args[1], pairs), shuffle(args[2], args[3], pairs), order)

    return x(x, y, z, w, part), emit
