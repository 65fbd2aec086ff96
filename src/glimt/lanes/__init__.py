"""SIMD lanes as ordinary Numba values.

A value of type `f32` holds one float for each of `LANES` pixels in one register; `i32` and `mask` likewise. Kernels
read like shaders::

    a = load(numbers, i)
    b = f32(2.0)
    c = select(a < b, a * b, minimum(a, b))
    if any_lane(c > 1.0): ...

Additions and multiplications may be contracted to fused multiply-adds, nothing else is reordered, so the same lane
gives the same bits whatever its neighbours hold. `product` and `difference` are never contracted.
"""

from glimt.lanes.math import arccos, arctan2, exp2, log2, power
from glimt.lanes.memory import (
    atomic_add,
    atomic_load,
    compress_store,
    gather,
    gather_int,
    gather_pairs,
    load,
    load4,
    load4_repeated,
    load8,
    load8_int,
    load_int,
    pick,
    pick_int,
    pointer,
    prefetch,
    scalar,
    scalar_int,
    stack_floats,
    stack_ints,
    stack_longs,
    store,
    store8,
    store_scalar,
    store_scalar_int,
    ticks,
)
from glimt.lanes.ops import (
    absolute,
    all_lanes,
    any_lane,
    as_float,
    as_int,
    bits,
    count_trailing_zeros,
    difference,
    extract,
    first_bit,
    floor,
    fma,
    from_bits,
    highest,
    interleave4,
    join,
    lane_numbers,
    least_number,
    lower_half,
    lowest,
    maximum,
    minimum,
    population_count,
    product,
    reciprocal,
    reciprocal_sqrt,
    select,
    sqrt,
    to_float,
    to_int,
    upper_half,
)
from glimt.lanes.sort import compress8, numbers8, numbers_in_fours, pack8, shuffle, sort8, unpack8
from glimt.lanes.types import LANES, f32, f32x8, i32, mask
from glimt.lanes.vector import (
    Vector3,
    compress_store3,
    cross,
    dot,
    load3,
    normalize,
    scalar3,
    select3,
    splat3,
    store3,
    vector3,
)

__all__ = [
    "LANES", "Vector3", "absolute", "all_lanes", "any_lane", "arccos", "arctan2", "as_float", "as_int",
    "atomic_add", "atomic_load", "bits", "compress8", "compress_store", "compress_store3", "count_trailing_zeros",
    "cross", "difference", "dot", "exp2", "extract", "f32", "f32x8", "first_bit", "floor", "fma", "from_bits",
    "gather", "gather_int", "gather_pairs", "highest", "i32", "interleave4", "join", "lane_numbers", "least_number",
    "load", "load3", "load4", "load4_repeated", "load8", "load8_int", "load_int", "log2", "lower_half", "lowest",
    "mask", "maximum", "minimum", "normalize", "numbers8", "numbers_in_fours", "pack8", "pick", "pick_int", "pointer",
    "population_count", "power", "prefetch", "product", "reciprocal", "reciprocal_sqrt", "scalar", "scalar3",
    "scalar_int", "select", "select3", "shuffle", "sort8", "splat3", "sqrt", "stack_floats", "stack_ints",
    "stack_longs", "store", "store3", "store8", "store_scalar", "store_scalar_int", "ticks", "to_float", "to_int",
    "unpack8", "upper_half", "vector3",
]
