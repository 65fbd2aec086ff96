"""Three f32 registers as one value: a point, vector or colour for each lane."""

import operator

from llvmlite import ir
from numba import types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, make_attribute_wrapper, models, register_model

from glimt.kernel import inline
from glimt.lanes.memory import broadcast_word, compress_store, load, store
from glimt.lanes.ops import CONTRACT, fma, reciprocal_sqrt
from glimt.lanes.types import Lanes, as_lanes, lanes_type

_F32 = lanes_type("f32")


class Vector3(types.Type):
    """Fields x, y, z of type f32."""

    def __init__(self):
        super().__init__(name=f"vector3x{_F32.count}")

    def __reduce__(self):
        return _vector3_type, ()


_VECTOR3 = Vector3()


def _vector3_type():
    return _VECTOR3


@register_model(Vector3)
class _Vector3Model(models.StructModel):
    def __init__(self, manager, vector):
        super().__init__(manager, vector, [(axis, _F32) for axis in "xyz"])


for _axis in "xyz":
    make_attribute_wrapper(Vector3, _axis, _axis)


def _unpack(context, builder, value, source):
    """Emit the three registers of a vector, or of lanes or a scalar meant for all three."""
    if source is _VECTOR3:
        return [builder.extract_value(value, i) for i in range(3)]
    return [as_lanes(context, builder, value, source, _F32)] * 3


def _pack(context, builder, registers):
    vector = ir.Constant(context.get_value_type(_VECTOR3), ir.Undefined)
    for i, register in enumerate(registers):
        vector = builder.insert_value(vector, register, i)
    return vector


@intrinsic
def vector3(typing_context, x, y, z):
    """Return a vector from lanes or scalars."""
    def emit(context, builder, sig, args):
        return _pack(context, builder, [as_lanes(context, builder, a, t, _F32)
                                        for a, t in zip(args, sig.args, strict=True)])

    return _VECTOR3(x, y, z), emit


@intrinsic
def scalar3(typing_context, words, index):
    """Return three consecutive words, the same in all lanes."""
    def emit(context, builder, sig, args):
        first = context.cast(builder, args[1], sig.args[1], types.intp)
        addresses = [builder.gep(args[0], [builder.add(first, first.type(k))]) for k in range(3)]
        return _pack(context, builder, [broadcast_word(context, builder, address, _F32) for address in addresses])

    return _VECTOR3(words, index), emit


@intrinsic
def select3(typing_context, condition, x, y):
    """Return x in the lanes of `condition`, y elsewhere; each a vector, lanes or a scalar."""
    def emit(context, builder, sig, args):
        chosen, other = (_unpack(context, builder, a, t) for a, t in zip(args[1:], sig.args[1:], strict=True))
        return _pack(context, builder, [builder.select(args[0], a, b) for a, b in zip(chosen, other, strict=True)])

    return _VECTOR3(condition, x, y), emit


def _operator(symbol, emit_one):
    @infer_global(symbol)
    class VectorOperator(AbstractTemplate):
        def generic(self, args, kws):
            fitting = all(a is _VECTOR3 or a is _F32 or isinstance(a, types.Number) for a in args)
            return signature(_VECTOR3, *args) if fitting and any(a is _VECTOR3 for a in args) else None

    def lower(context, builder, sig, args):
        left, right = (_unpack(context, builder, a, t) for a, t in zip(args, sig.args, strict=True))
        return _pack(context, builder, [emit_one(builder, a, b) for a, b in zip(left, right, strict=True)])

    for pair in ((Vector3, Vector3), (Vector3, Lanes), (Lanes, Vector3), (Vector3, types.Number),
                 (types.Number, Vector3)):
        lower_builtin(symbol, *pair)(lower)


_operator(operator.add, lambda b, x, y: b.fadd(x, y, flags=CONTRACT))
_operator(operator.sub, lambda b, x, y: b.fsub(x, y, flags=CONTRACT))
_operator(operator.mul, lambda b, x, y: b.fmul(x, y, flags=CONTRACT))


@inline
def load3(words, index, stride):
    """Return the vector whose components lie `stride` words apart."""
    return vector3(load(words, index), load(words, index + stride), load(words, index + 2 * stride))


@inline
def store3(words, index, stride, v):
    """Write a vector so that `load3` finds it."""
    store(words, index, v.x)
    store(words, index + stride, v.y)
    store(words, index + 2 * stride, v.z)


@inline
def compress_store3(words, index, stride, v, condition):
    """Write the lanes of a condition side by side so that `load3` finds them."""
    compress_store(words, index, v.x, condition)
    compress_store(words, index + stride, v.y, condition)
    compress_store(words, index + 2 * stride, v.z, condition)


@inline
def splat3(x):
    """Return a vector with x in all components."""
    return vector3(x, x, x)


@inline
def dot(a, b):
    """Return a · b."""
    return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z))


@inline
def cross(a, b):
    """Return a × b."""
    return vector3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


@inline
def normalize(a):
    """Return a at unit length; the squares of its components must stay within float32."""
    return a * reciprocal_sqrt(dot(a, a))
