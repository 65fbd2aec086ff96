"""The lane types: vectors of float32, int32 and booleans, one LLVM ``<N x T>`` value each."""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, models, register_model

from glimt.kernel import host_lanes

LANES = host_lanes()
"""How many pixels travel in one register: 16, 8 or 4."""

INT1, INT8, INT16, INT32, INT64 = (ir.IntType(width) for width in (1, 8, 16, 32, 64))
_ELEMENTS = {"f32": ir.FloatType(), "i32": INT32, "mask": INT1}
_SCALARS = {"f32": types.float32, "i32": types.int32, "mask": types.boolean}


class Lanes(types.Type):
    """`count` values of one kind ("f32", "i32" or "mask") in a register."""

    def __init__(self, kind, count):
        self.kind, self.count = kind, count
        self.register = ir.VectorType(_ELEMENTS[kind], count)
        self.scalar = _SCALARS[kind]
        super().__init__(name=f"{kind}x{count}")

    def __reduce__(self):
        return lanes_type, (self.kind, self.count)


_known = {}


def lanes_type(kind, count=LANES):
    """Return the one `Lanes` type of this kind and width."""
    if (kind, count) not in _known:
        _known[kind, count] = Lanes(kind, count)
    return _known[kind, count]


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, lanes):
        super().__init__(manager, lanes, lanes.register)


def broadcast(context, builder, value, source, target):
    """Emit a scalar `value` of Numba type `source` as all lanes of `target`."""
    value = context.cast(builder, value, source, target.scalar)
    first = builder.insert_element(ir.Constant(target.register, ir.Undefined), value, INT32(0))
    everywhere = ir.Constant(ir.VectorType(INT32, target.count), [0] * target.count)
    return builder.shuffle_vector(first, first, everywhere)


def as_lanes(context, builder, value, source, target):
    """Emit `value`, lanes already or a scalar, as `target`."""
    return value if isinstance(source, Lanes) else broadcast(context, builder, value, source, target)


def _constructor(target):
    @intrinsic
    def construct(typing_context, value):
        def emit(context, builder, signature, arguments):
            return broadcast(context, builder, arguments[0], signature.args[0], target)

        return target(value), emit

    return construct


f32 = _constructor(lanes_type("f32"))
i32 = _constructor(lanes_type("i32"))
mask = _constructor(lanes_type("mask"))
f32x8 = _constructor(lanes_type("f32", 8))
"""Eight floats whatever the lane width: the children of a BVH8 node."""
