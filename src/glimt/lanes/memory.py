"""Lanes and scalars from and to memory. Indices count 4-byte words and are never checked or wrapped around."""

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.errors import RequireLiteralValue
from numba.extending import intrinsic

from glimt.kernel import host_features
from glimt.lanes.ops import suffix
from glimt.lanes.types import INT32, INT64, LANES, Lanes, as_lanes, lanes_type


def _address(context, builder, sig, args):
    """Emit the address of word args[1] of the pointer or array args[0]."""
    base, index = sig.args[:2]
    data = context.make_array(base)(context, builder, args[0]).data if isinstance(base, types.Array) else args[0]
    return builder.gep(data, [context.cast(builder, args[1], index, types.intp)])


@intrinsic
def pointer(typing_context, array):
    """Return where an array's data starts: no reference count, no bounds, cheap to pass down."""
    def emit(context, builder, sig, args):
        return context.make_array(sig.args[0])(context, builder, args[0]).data

    return types.CPointer(array.dtype)(array), emit


def _scalar_loader(result, element):
    @intrinsic
    def load_scalar(typing_context, words, index):
        def emit(context, builder, sig, args):
            address = builder.bitcast(_address(context, builder, sig, args), element.as_pointer())
            return builder.load(address, align=4)

        return result(words, index), emit

    return load_scalar


scalar = _scalar_loader(types.float32, ir.FloatType())
scalar_int = _scalar_loader(types.int32, INT32)
"""One word as a float or as an integer, whatever the array calls itself: records hold both."""


def _scalar_storer(kind, element):
    @intrinsic
    def store_one(typing_context, words, index, value):
        def emit(context, builder, sig, args):
            target = kind or sig.args[0].dtype
            address = _address(context, builder, sig, args)
            if element:
                address = builder.bitcast(address, element.as_pointer())
            builder.store(context.cast(builder, args[2], sig.args[2], target), address, align=4)
            return context.get_dummy_value()

        return types.void(words, index, value), emit

    return store_one


store_scalar, store_scalar_int = _scalar_storer(None, None), _scalar_storer(types.int32, INT32)
"""Write one word: as what the array calls itself, or as an integer."""


def _loader(count, kind="f32"):
    @intrinsic
    def load_lanes(typing_context, words, index):
        lanes = lanes_type(kind, count)

        def emit(context, builder, sig, args):
            address = _address(context, builder, sig, args)
            return builder.load(builder.bitcast(address, lanes.register.as_pointer()), align=4)

        return lanes(words, index), emit

    return load_lanes


load, load4, load8 = _loader(LANES), _loader(4), _loader(8)
load_int, load8_int = _loader(LANES, "i32"), _loader(8, "i32")


@intrinsic
def load4_repeated(typing_context, words, index):
    """Return four words over and over in all lanes."""
    lanes, four = lanes_type("f32"), lanes_type("f32", 4)

    def emit(context, builder, sig, args):
        address = _address(context, builder, sig, args)
        words_ = builder.load(builder.bitcast(address, four.register.as_pointer()), align=4)
        order = ir.Constant(ir.VectorType(INT32, lanes.count), [k % 4 for k in range(lanes.count)])
        return builder.shuffle_vector(words_, words_, order)

    return lanes(words, index), emit


def _storer():
    @intrinsic
    def store_lanes(typing_context, words, index, value):
        def emit(context, builder, sig, args):
            address = _address(context, builder, sig, args)
            builder.store(args[2], builder.bitcast(address, value.register.as_pointer()), align=4)
            return context.get_dummy_value()

        return types.void(words, index, value), emit

    return store_lanes


store = store8 = _storer()


@intrinsic
def compress_store(typing_context, words, index, value, condition):
    """Write the lanes of a condition side by side."""
    def emit(context, builder, sig, args):
        address, value = _address(context, builder, sig, args), args[2]
        function = ir.FunctionType(ir.VoidType(), [value.type, address.type, args[3].type])
        name = f"llvm.masked.compressstore.{suffix(sig.args[2])}"
        builder.call(cgutils.get_or_insert_function(builder.module, function, name), [value, address, args[3]])
        return context.get_dummy_value()

    return types.void(words, index, value, condition), emit


class _VectorAddress(ir.instructions.GEPInstr):
    """Base pointer and <N x i32> index → <N x ptr>; llvmlite's own gep types scalar indices only."""

    def __init__(self, parent, base, index, element):
        super().__init__(parent, base, [index], False, "", source_etype=element)
        self.type = ir.VectorType(ir.PointerType(), index.type.count)


def _gather_emitter(lanes):
    """Return what emits a gather of lanes from args (words, index, condition)."""
    def emit(context, builder, sig, args):
        addresses = _VectorAddress(builder.block, args[0], args[1], lanes.register.element)
        builder._insert(addresses)
        zero = ir.Constant(lanes.register, [lanes.register.element(0)] * lanes.count)
        function = ir.FunctionType(lanes.register, [addresses.type, INT32, args[2].type, lanes.register])
        name = f"llvm.masked.gather.{suffix(lanes)}.v{lanes.count}p0"
        declared = cgutils.get_or_insert_function(builder.module, function, name)
        return builder.call(declared, [addresses, INT32(4), args[2], zero])

    return emit


def _gatherer(kind):
    @intrinsic
    def gather_lanes(typing_context, words, index, condition):
        lanes = lanes_type(kind, index.count)
        return lanes(words, index, condition), _gather_emitter(lanes)

    return gather_lanes


gather, gather_int = _gatherer("f32"), _gatherer("i32")
"""words[index] in the lanes of a condition, 0 elsewhere; words is a pointer."""


def _picker(lane, one):
    """Make a look-up by an index that all lanes share (`one`) or that each has for itself, in lanes of a condition."""
    @intrinsic
    def pick(typing_context, words, index, condition):
        if isinstance(index, Lanes):
            lanes = lanes_type(lane, index.count)
            return lanes(words, index, condition), _gather_emitter(lanes)

        def emit(context, builder, sig, args):
            address = _address(context, builder, sig, args)
            if sig.return_type == types.int32:
                return builder.load(builder.bitcast(address, INT32.as_pointer()), align=4)
            return broadcast_word(context, builder, address, sig.return_type)

        return one(words, index, condition), emit

    return pick


pick, pick_int = _picker("f32", lanes_type("f32")), _picker("i32", types.int32)
"""words[index]: for an index of lanes a gather in the lanes of a condition, 0 elsewhere; for one that all lanes share
one word, by `pick` for all lanes, by `pick_int` as it is."""


@intrinsic
def gather_pairs(typing_context, words, index, condition):
    """Return (words[index], words[index + 1]) as i32 in the lanes of a condition: half the gathers of two look-ups."""
    lanes = lanes_type("i32", index.count)
    count = lanes.count
    result = types.UniTuple(lanes, 2)

    def emit(context, builder, sig, args):
        addresses = _VectorAddress(builder.block, args[0], args[1], INT32)
        builder._insert(addresses)
        pairs = ir.VectorType(INT64, count)
        zero = ir.Constant(pairs, [INT64(0)] * count)
        function = ir.FunctionType(pairs, [addresses.type, INT32, args[2].type, pairs])
        name = f"llvm.masked.gather.v{count}i64.v{count}p0"
        declared = cgutils.get_or_insert_function(builder.module, function, name)
        words_ = builder.bitcast(builder.call(declared, [addresses, INT32(4), args[2], zero]),
                                 ir.VectorType(INT32, 2 * count))
        halves = [builder.shuffle_vector(words_, words_, ir.Constant(ir.VectorType(INT32, count),
                                                                     list(range(half, 2 * count, 2))))
                  for half in range(2)]
        return context.make_tuple(builder, result, halves)

    return result(words, index, condition), emit


def _stack(dtype):
    @intrinsic
    def allocate(typing_context, count):
        if not isinstance(count, types.IntegerLiteral):
            raise RequireLiteralValue(count)
        words = count.literal_value

        def emit(context, builder, sig, args):
            element = context.get_data_type(dtype)
            with builder.goto_entry_block():
                block = builder.alloca(ir.ArrayType(element, words))
                block.align = 64
            return builder.bitcast(block, element.as_pointer())

        return types.CPointer(dtype)(count), emit

    return allocate


stack_floats, stack_ints, stack_longs = _stack(types.float32), _stack(types.int32), _stack(types.int64)
"""Uninitialised memory of a literal number of words that lives as long as the call."""


@intrinsic
def prefetch(typing_context, words, index):
    """Start to bring the cache line of a word nearer."""
    def emit(context, builder, sig, args):
        address = _address(context, builder, sig, args)
        function = ir.FunctionType(ir.VoidType(), [address.type, INT32, INT32, INT32])
        declared = cgutils.get_or_insert_function(builder.module, function, "llvm.prefetch.p0")
        builder.call(declared, [address, INT32(0), INT32(3), INT32(1)])  # to read, into all caches, data
        return context.get_dummy_value()

    return types.void(words, index), emit


@intrinsic
def atomic_add(typing_context, array, index, value):
    """Add to an int64 and return what was there before."""
    def emit(context, builder, sig, args):
        value = context.cast(builder, args[2], sig.args[2], types.int64)
        return builder.atomic_rmw("add", _address(context, builder, sig, args), value, "monotonic")

    return types.int64(array, index, value), emit


@intrinsic
def atomic_load(typing_context, array, index):
    """Return an int64 that another thread may be writing."""
    def emit(context, builder, sig, args):
        return builder.load_atomic(_address(context, builder, sig, args), "monotonic", 8)

    return types.int64(array, index), emit


def broadcast_word(context, builder, address, lanes):
    """Emit the float at `address` in all lanes."""
    return as_lanes(context, builder, builder.load(address, align=4), types.float32, lanes)


@intrinsic
def ticks(typing_context):
    """Return the time in ticks of a clock that runs evenly, and is read without asking the system; never 0."""
    # On Arm programs may not read the counter of cycles, but that of the system's timer.
    name = "llvm.readsteadycounter" if "neon" in host_features() else "llvm.readcyclecounter"

    def emit(context, builder, sig, args):
        function = ir.FunctionType(INT64, [])
        return builder.call(cgutils.get_or_insert_function(builder.module, function, name), [])

    return types.int64(), emit
