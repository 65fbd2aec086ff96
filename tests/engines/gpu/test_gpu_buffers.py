"""Arrays go to the GPU and come back, passes run in order and are timed."""

import numpy as np
import pytest
from gpu_device import software_device

from glimt.engines.gpu import commands as gpu_commands
from glimt.engines.gpu.adapters import import_wgpu
from glimt.engines.gpu.buffers import Bindings, Buffer, Download
from glimt.engines.gpu.commands import Commands, Timer
from glimt.engines.gpu.shader import Part, compile_parts, pipeline
from glimt.errors import GlimtError

DOUBLE = """
@group(0) @binding(3) var<uniform> shift: vec4u;
@group(0) @binding(5) var<storage, read> source: array<u32>;
@group(0) @binding(6) var<storage, read_write> result: array<u32>;
@compute @workgroup_size(64) fn double(@builtin(global_invocation_id) id: vec3u) {
    if (id.x < shift.y) {
        result[id.x] += 2u * source[id.x] + shift.x;
    }
}
"""


@pytest.fixture
def device():
    """Return a device."""
    return software_device()


@pytest.fixture
def double(device):
    """Return bindings, and a pipeline that adds 2 source + shift.x to the first shift.y words of the result."""
    device.kept[("module", "", "double")] = compile_parts(device, [Part("double.wgsl", DOUBLE)])
    bindings = Bindings(device, [(3, "uniform"), (5, "read"), (6, "write")])
    return bindings, pipeline(device, ["double"], "double", [bindings.layout])


@pytest.mark.parametrize("array", [
    np.arange(1000, dtype=np.float32), np.arange(24, dtype=np.int32).reshape(2, 3, 4)[:, ::-1],
    np.array([(1, 2.5)], [("a", "i4"), ("b", "f4")]), np.zeros(0, np.float32), np.array([2**63], np.uint64),
], ids=["floats", "strided", "records", "empty", "words-of-8"])
def test_round_trip(device, array):
    buffer = Buffer(device, "array")
    buffer.upload(array)
    assert buffer.nbytes == array.nbytes
    if array.nbytes:
        back = Download(device).read(buffer, np.empty(array.shape, array.dtype))
        assert back.tobytes() == np.ascontiguousarray(array).tobytes()


def test_memory_is_kept_while_it_suffices_and_grows_by_half(device):
    buffer, download = Buffer(device, "array"), Download(device)
    buffer.upload(np.zeros(1000, np.float32))
    first = buffer.handle
    buffer.upload(np.ones(900, np.float32))
    assert buffer.handle is first
    buffer.upload(np.arange(1010, dtype=np.float32))
    assert buffer.handle is not first
    assert 6000 <= buffer.handle.size < 6100
    assert download.read(buffer, np.empty(1010, np.float32))[-1] == 1009
    assert download.read(buffer, np.empty(2, np.float32)).tolist() == [0, 1]


def test_what_does_not_fit(device):
    most = device.limits["max-storage-buffer-binding-size"]
    with pytest.raises(GlimtError, match=rf"the statues' trees takes [\d,]+ MiB, more than the {most >> 20:,} MiB of"):
        Buffer(device, "the statues' trees", most + 2**20)
    with pytest.raises(TypeError, match="4-byte"):
        Buffer(device, "bytes").upload(np.zeros(8, np.uint8))
    buffer = Buffer(device, "numbers", 16)
    download = Download(device)
    download.record(device.gpu.create_command_encoder(), buffer)
    with pytest.raises(ValueError, match="12 bytes"):
        download.take(np.zeros(3, np.uint32))


def test_passes_run_in_order_directly_and_by_numbers_on_the_gpu(device, double):
    bindings, work = double
    count = 1000
    shift, source, result, groups = (Buffer(device, name, extra_usage=import_wgpu().BufferUsage.INDIRECT)
                                     for name in ("shift", "source", "result", "groups"))
    shift.upload(np.array([5, count, 0, 0], np.uint32))
    source.upload(np.arange(count, dtype=np.uint32))
    result.upload(np.full(count, 77, np.uint32))
    groups.upload(np.array([9, 9, 9, 1, 1, 1], np.uint32))
    group = bindings.group([shift, source, result])
    assert bindings.group([shift, source, result]) is group
    assert bindings.group([shift, result, source]) is not group
    group, download = bindings.group([shift, source, result]), Download(device)
    commands = Commands(device)
    commands.clear(result)
    commands.dispatch("all", work, [group], (-(-count // 64), 1, 1))
    commands.dispatch("first 64", work, [group], groups, 12)
    commands.download(download, result)
    commands.submit()
    wanted = 2 * np.arange(count) + 5
    wanted[:64] *= 2
    np.testing.assert_array_equal(download.take(np.empty(count, np.uint32)), wanted)


def test_passes_are_timed_by_label(device, double, monkeypatch):
    bindings, work = double
    buffers = [Buffer(device, name, 4096) for name in ("shift", "source", "result")]
    buffers[0].upload(np.array([1, 1000, 0, 0], np.uint32))
    timer = Timer(device, depth=2)
    assert timer.seconds() == {}
    monkeypatch.setattr(gpu_commands, "MOST_TIMED", 3)
    for labels in (["a", "b", "a"], ["c"], ["d", "e", "f", "g"]):
        commands = Commands(device, timer)
        for label in labels:
            commands.dispatch(label, work, [bindings.group(buffers)], (16, 1, 1))
        commands.submit()
        if labels[0] == "a":
            both = timer.seconds()
            assert list(both) == (["a", "b"] if device.has_timestamps else [])
            assert both == timer.seconds()
    wanted = [["d", "e", "f"], ["c"], []] if device.has_timestamps else [[], [], []]
    assert [list(timer.seconds(back)) for back in range(3)] == wanted
    assert all(0 <= seconds < 60 for seconds in timer.seconds().values())
    untimed = Commands(device)
    untimed.dispatch("h", work, [bindings.group(buffers)], (16, 1, 1))
    untimed.submit()
    assert list(timer.seconds()) == wanted[0]


def test_a_device_without_timestamps_times_nothing(device, double, monkeypatch):
    bindings, work = double
    buffers = [Buffer(device, name, 64) for name in ("shift", "source", "result")]
    monkeypatch.setattr(device, "has_timestamps", False)
    timer = Timer(device)
    commands = Commands(device, timer)
    commands.dispatch("a", work, [bindings.group(buffers)], (1, 1, 1))
    commands.submit()
    assert timer.seconds() == {}
