"""Structs are declared once: offsets, dtypes and sizes agree."""

import numpy as np
import pytest

from glimt import layout

STRUCTS = {name: struct for name, struct in vars(layout).items() if hasattr(struct, "words")}


def test_all_structs_are_known():
    assert set(STRUCTS) == {"NODE", "COMPRESSED_NODE", "TRIANGLE_BLOCK", "INSTANCE_BLOCK", "VERTEX", "TANGENT", "SPAN",
                            "TRIANGLE", "FACE", "INSTANCE", "PLACEMENT", "MATERIAL", "TEXTURE", "LEVEL", "LIGHT",
                            "VIEW", "FRAME", "PATH", "COUNTER"}


@pytest.mark.parametrize("name", STRUCTS)
def test_offsets_are_those_of_the_dtype_without_gaps(name):
    struct = STRUCTS[name]
    record = layout.dtype(struct)
    assert record.names == struct._fields[:-1]
    end = 0
    for field in record.names:
        kind, offset = record.fields[field][:2]
        assert offset == 4 * getattr(struct, field) == end
        assert kind.base in (np.float32, np.int32)
        end += kind.itemsize
    assert record.itemsize == 4 * struct.words == end


@pytest.mark.parametrize(("name", "words"), [
    ("NODE", 64), ("COMPRESSED_NODE", 20), ("TRIANGLE_BLOCK", 40), ("INSTANCE_BLOCK", 4), ("VERTEX", 8), ("TANGENT", 4),
    ("TRIANGLE", 4), ("FACE", 2), ("INSTANCE", 38), ("PLACEMENT", 16), ("MATERIAL", 16), ("TEXTURE", 8),
    ("LEVEL", 4), ("LIGHT", 20), ("VIEW", 21),
])
def test_words(name, words):
    """Records are read from other languages too: a change of size is no accident."""
    assert STRUCTS[name].words == words


def test_constants_are_typed_for_kernels():
    for name, kind in (("MISS", np.int32), ("NO_TANGENTS", np.int32), ("LEAF_SIZE", np.int32), ("TEXEL_MAX", np.int32),
                       ("OFFSET_ERROR", np.float32), ("COUNT_SHADOW", np.int64)):
        assert type(getattr(layout, name)) is kind
    assert layout.TEXEL_MAX == 2**layout.TEXEL_BITS - 1
