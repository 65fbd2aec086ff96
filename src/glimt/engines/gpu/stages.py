"""The five stages as compute pipelines, and the dispatches of a frame."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from glimt.engines.gpu.buffers import Bindings, Buffer, Kind
from glimt.engines.gpu.commands import Commands
from glimt.engines.gpu.device import Device
from glimt.engines.gpu.shader import pipeline
from glimt.layout import COUNTER, FRAME, PATH, WALK_OF_MANY

STEMS = ("bindings", "count", "hit", "ray", "camera", "create_rays", "triangle", "sphere", "traverse", "intersect",
         "light", "texture", "surface", "material", "shade", "bounce", "resolve", "prepare", "debug")
"""Kernel files, in the order in which they are put together."""
STAGES = ("create_rays", "intersect", "shade", "bounce", "prepare", "resolve", "debug")
MOST_GROUPS = 65535
_STACK_STEP = 16
_BUFFERS = ("frame", "nodes", "blocks", "records", "geometry", "texels", "paths", "film", "counters", "dispatch")
_USES: dict[str, tuple[str, ...]] = {
    "create_rays": ("frame", "paths", "film"),
    "intersect": ("frame", "nodes", "blocks", "records", "paths", "counters"),
    "shade": ("frame", "nodes", "blocks", "records", "geometry", "texels", "paths", "film", "counters"),
    "bounce": ("frame", "paths", "counters"),
    "prepare": ("frame", "counters", "dispatch"),
    "resolve": ("frame", "film", "counters"),
    "debug": ("frame", "nodes", "blocks", "records", "geometry", "texels", "paths", "film"),
}
_WRITTEN = {"paths", "film", "counters", "dispatch"}


class Group(NamedTuple):
    """A workgroup's shape."""

    width: int = 8
    height: int = 8

    @property
    def size(self) -> int:
        """Invocations."""
        return self.width * self.height


class Stages:
    """Pipelines for one workgroup shape, and the bind groups for the buffers at hand."""

    def __init__(self, device: Device, group: Group, counting: bool) -> None:
        self.group = group
        self._counting = counting
        self._walk, self._stack_entries = WALK_OF_MANY, 0
        self._constants: dict[str, float] = {"GROUP_WIDTH": group.width, "GROUP_HEIGHT": group.height}
        self._bindings = {stage: Bindings(device, [(_BUFFERS.index(name), _kind(name)) for name in _USES[stage]])
                          for stage in STAGES}
        self._device = device
        self._steps: dict[str, tuple[Any, list[Any]]] = {}
        self._handles: list[Any] = []

    def suit(self, walk: np.int32, stack_entries: int) -> None:
        """Take the pipelines that walk down a scene in its way, with room for what they have to come back to."""
        if walk != self._walk or stack_entries >= self._stack_entries:
            # Never too small, and seldom another; an index one behind what is in use is read as well.
            self._walk, self._stack_entries = walk, (stack_entries // _STACK_STEP + 1) * _STACK_STEP
            self._steps.clear()

    @property
    def declarations(self) -> str:
        """What kernels are told of the scene when they are compiled."""
        return (f"const FRAME_VECTORS = {FRAME.words // 4}u;\nconst TREE_STACK = {self._stack_entries}u;\n"
                f"const WALK = {self._walk}u;\nconst COUNTING = {int(self._counting)}u;\n")

    def record(self, commands: Commands, stage: str, buffers: dict[str, Buffer], frame: int,
               invocations: int | None) -> None:
        """Record one dispatch, after `bind`: of so many invocations, or of as many as the dispatch buffer says."""
        if stage not in self._steps:
            layout = self._bindings[stage].layout
            self._steps[stage] = (pipeline(self._device, STEMS, stage, [layout], self._constants, self.declarations),
                                  [self._bindings[stage].group([buffers[name] for name in _USES[stage]])])
        found, groups = self._steps[stage]
        size: tuple[int, int, int] | Buffer = buffers["dispatch"]
        if invocations is not None:
            count = -(-invocations // self.group.size)
            size = min(count, MOST_GROUPS), -(-count // MOST_GROUPS), 1
        commands.dispatch("bounce" if stage == "prepare" else stage, found, groups, size, frame=frame)

    def bind(self, buffers: dict[str, Buffer]) -> None:
        """See which buffers are used from now on: some may have had to grow."""
        handles = [buffer.handle for buffer in buffers.values()]
        if handles != self._handles:
            self._handles = handles
            self._steps.clear()


def _kind(name: str) -> Kind:
    return "frame" if name == "frame" else "write" if name in _WRITTEN else "read"


def counter_words(max_bounces: int) -> int:
    """Return how many counters a frame of so many bounces has."""
    return int(COUNTER.words) + max_bounces + 2


def path_bytes(pixels: int) -> int:
    """Return the size of the paths of a band: two for each pixel."""
    return 8 * int(PATH.words) * pixels


def frame_records(base: NDArray[Any], samples: int, max_bounces: int, spread: float) -> NDArray[Any]:
    """Return what each dispatch of a band is told: FRAME records by sample, then by bounce."""
    records = np.repeat(base, samples * samples * (max_bounces + 1))
    index = np.arange(len(records))
    sample, depth = index // (max_bounces + 1), index % (max_bounces + 1)
    records["sample"], records["depth"], records["half"] = sample, depth, depth % 2
    records["shift_x"] = (sample % samples + np.float32(0.5)) * np.float32(1 / samples)
    records["shift_y"] = (sample // samples + np.float32(0.5)) * np.float32(1 / samples)
    records["spread"], records["max_bounces"] = spread / samples, max_bounces
    return records

