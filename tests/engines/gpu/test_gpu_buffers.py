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
    with pytest.raises(ValueError, match="an array of 12 bytes is more than the 8 of the buffer"):
        Download(device).want(Buffer(device, "numbers", 16), np.zeros(3, np.uint32), 8)


def test_dispatches_run_in_order_directly_and_by_numbers_on_the_gpu(device, double):
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
    commands, got, last = Commands(device, download), np.empty(count, np.uint32), np.empty((2, 5), np.float32)
    commands.clear(result)
    commands.dispatch("all", work, [group], (-(-count // 64), 1, 1))
    commands.dispatch("first 64", work, [group], groups, 12)
    download.want(result, got)
    download.want(source, last[:, 1:3], 4 * (count - 4))
    commands.submit()
    download.take()
    wanted = 2 * np.arange(count) + 5
    wanted[:64] *= 2
    np.testing.assert_array_equal(got, wanted)
    assert last[:, 1:3].view(np.uint32).tolist() == [[996, 997], [998, 999]]


@pytest.mark.parametrize("inside", [False, True], ids=["passes", "within a pass"])
def test_dispatches_are_timed_by_label(device, double, monkeypatch, inside):
    if inside and not device.has_inner_timestamps:
        pytest.skip("the adapter has no timestamps within passes")
    monkeypatch.setattr(device, "has_inner_timestamps", inside)
    bindings, work = double
    buffers = [Buffer(device, name, 4096) for name in ("shift", "source", "result")]
    buffers[0].upload(np.array([1, 1000, 0, 0], np.uint32))
    timer, download = Timer(device), Download(device)
    assert timer.seconds() == {}
    monkeypatch.setattr(gpu_commands, "MOST_TICKS", 6)
    for labels, timed in (("aba", "ab"), ("c", "c"), ("", ""), ("hhiiij", "hij"),
                          ("defghijk", "defgh" if inside else "def")):
        commands = Commands(device, download, timer)
        for label in labels:
            commands.dispatch(label, work, [bindings.group(buffers)], (2000, 1, 1))
        commands.submit()
        download.take()
        assert list(timer.seconds()) == (list(timed) if device.has_timestamps else [])
        assert timer.seconds() == timer.seconds()
        assert all(0 < seconds < 60 for seconds in timer.seconds().values())
    untimed = Commands(device, download)
    untimed.dispatch("k", work, [bindings.group(buffers)], (16, 1, 1))
    untimed.submit()
    assert "k" not in timer.seconds()


def test_results_that_nobody_waited_for_are_not_in_the_way(device, monkeypatch):
    buffer, download = Buffer(device, "array"), Download(device)
    buffer.upload(np.arange(10, dtype=np.uint32))
    wait = device.wait

    def interrupt(promise):
        raise KeyboardInterrupt

    for _ in range(2):
        monkeypatch.setattr(device, "wait", interrupt)
        with pytest.raises(KeyboardInterrupt):
            download.read(buffer, np.zeros(10, np.uint32))
        monkeypatch.setattr(device, "wait", wait)
        assert download.read(buffer, np.zeros(10, np.uint32)).tolist() == list(range(10))


def test_a_device_without_timestamps_times_nothing(device, double, monkeypatch):
    bindings, work = double
    buffers = [Buffer(device, name, 64) for name in ("shift", "source", "result")]
    monkeypatch.setattr(device, "has_timestamps", False)
    monkeypatch.setattr(device, "has_inner_timestamps", False)
    timer, download = Timer(device), Download(device)
    commands = Commands(device, download, timer)
    commands.dispatch("a", work, [bindings.group(buffers)], (1, 1, 1))
    commands.submit()
    download.take()
    assert timer.seconds() == {}
