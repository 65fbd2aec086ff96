"""What packets leave to single rays: when there is no room for more, and in blocks of packets of every kind."""

import numpy as np
import pytest
from test_packets import bits, different

import closed_meshes
import oracle
import strategies
import tracing
from glimt import linalg
from glimt.engines.cpu.kernels.block import PACKETS, SLOTS
from glimt.engines.cpu.kernels.single import _PENDING, _STACK, _STACK_WORDS, leave_nothing, leave_to, new_pending
from glimt.kernel import kernel
from glimt.lanes import LANES, scalar, scalar_int
from glimt.layout import MISS
from glimt.packed import pack
from glimt.scene.instance import Instance
from glimt.scene.scene import Scene
from glimt.scene.sphere import Sphere

RANDOM = np.random.default_rng(7)


# ---- room for subtrees --------------------------------------------------------------------------------------------

@kernel
def _leave(lanes, left, codes, distances, bottoms):
    """Leave subtree k at distance k / 2 to the rays of lanes[k]; return all stacks."""
    pending = new_pending()
    for slot in range(_STACK_WORDS):
        pending.stack[slot], pending.distances[slot] = -1, -1
    leave_nothing(pending)
    for k in range(len(lanes)):
        left[k] = leave_to(pending, lanes[k], np.float32(k) / np.float32(2), np.int32(k))
    for slot in range(_STACK_WORDS):
        codes[slot], distances[slot] = scalar_int(pending.stack, slot), scalar(pending.distances, slot)
    for slot in range(SLOTS):
        bottoms[slot] = scalar_int(pending.bottoms, slot)


def leave(sets):
    """Return (whether each was left, code and distance in each ray's stack, how many each ray has been left)."""
    lanes = np.array([sum(1 << slot for slot in rays) for rays in sets], np.uint64).view(np.int64)
    left, codes, distances = np.zeros(len(sets), bool), np.zeros(_STACK_WORDS, np.int32), np.zeros(_STACK_WORDS)
    bottoms = np.zeros(SLOTS, np.int64)
    _leave(lanes, left, codes, distances, bottoms)
    stacks = (SLOTS + 1, int(_STACK))
    return left, codes.reshape(stacks), distances.reshape(stacks), _PENDING + np.arange(SLOTS) * _STACK - bottoms


@pytest.mark.parametrize("seed", range(5))
def test_a_subtree_is_left_to_all_of_its_rays_or_to_none(seed):
    random = np.random.default_rng(seed)
    sets = [random.choice(SLOTS, random.integers(1, SLOTS + 1), replace=False).tolist() for _ in range(4 * _PENDING)]
    sets[:3] = [[0], [SLOTS - 1], list(range(SLOTS))]
    expected, stacks = [], [[] for _ in range(SLOTS)]
    for k, rays in enumerate(sets):
        expected.append(all(len(stacks[slot]) < _PENDING for slot in rays))
        for slot in rays if expected[-1] else ():
            stacks[slot].insert(0, k)
    left, codes, distances, counts = leave(sets)
    assert left.tolist() == expected
    assert not left.all()
    assert counts.tolist() == [len(stack) for stack in stacks]
    assert max(counts) == _PENDING
    for slot, stack in enumerate(stacks):
        top = _PENDING - len(stack)
        assert codes[slot, top:_PENDING].tolist() == stack
        np.testing.assert_array_equal(distances[slot, top:_PENDING], np.array(stack) / 2)
        assert (codes[slot, :top] == -1).all()
        assert (codes[slot, _PENDING:] == -1).all()


@pytest.mark.parametrize("count", [300, 4000, 40_000])
def test_packets_leave_more_to_single_rays_than_these_can_keep(count):
    """Needles whose boxes all overlap: every ray wants almost every subtree, and few end before the last."""
    corners = RANDOM.uniform(-1, 1, (count, 3, 3))
    corners[:, 2] = corners[:, 0] + RANDOM.uniform(-1, 1, (count, 3)) * 0.001
    scene = Scene().add(strategies.mesh_of(corners))
    packed = pack(scene)
    directions = np.abs(RANDOM.normal(size=(2000, 3))).astype(np.float32)
    origins = (RANDOM.uniform(-1, 1, directions.shape) - 2 * directions).astype(np.float32)
    assert not different(packed, origins, directions).any()
    if count == 300:
        found = oracle.meetings(scene, origins, directions)
        assert not oracle.wrong_hits(found, tracing.closest(packed, origins, directions)).any()


# ---- blocks of packets of every kind ------------------------------------------------------------------------------

def packet(kind):
    """Return (origins, directions) of LANES rays around the origin."""
    origins = RANDOM.uniform(-2, 2, (LANES, 3))
    if kind == "anywhere":
        return origins, RANDOM.normal(size=(LANES, 3))
    if kind == "one octant":
        signs = RANDOM.choice([-1, 1], 3)
        return origins, signs * np.abs(RANDOM.normal(size=(LANES, 3)))
    if kind == "two octants":
        return origins, [-1, 1, 0] * np.abs(RANDOM.normal(size=(LANES, 3))) + RANDOM.normal(size=(LANES, 3)) * [0, 0, 1]
    if kind == "along an axis":
        return origins, np.eye(3)[RANDOM.integers(3)] * RANDOM.choice([-1, 1], (LANES, 1))
    start = RANDOM.normal(size=3) * 3  # a narrow beam
    return np.tile(start, (LANES, 1)), RANDOM.normal(size=(LANES, 3)) * 0.1 - start


KINDS = ["anywhere", "one octant", "two octants", "along an axis", "a narrow beam", "idle"]


@pytest.fixture(scope="module")
def packed():
    """A mesh where it was modelled, one in a space of its own, another across both, and a sphere."""
    matrix = linalg.compose(linalg.translation((0.3, 0.2, -0.4)), linalg.rotation((1, 1, 0), 50),
                            linalg.scaling((1, 0.6, 1.3)))
    rough = closed_meshes.icosphere(4, roughness=0.2)
    return pack(Scene().add(rough, Instance(rough, matrix), Sphere((1, 1, 0), 0.7),
                            Instance(closed_meshes.icosphere(2), linalg.scaling(1.05))))


def test_a_block_of_packets_of_every_kind(packed):
    kinds = [KINDS[k] for k in RANDOM.integers(len(KINDS), size=500 * PACKETS)]
    origins, directions = np.concatenate([packet(kind) for kind in kinds], 1).astype(np.float32)
    active = np.repeat([kind != "idle" for kind in kinds], LANES)
    hits = tracing.closest(packed, origins, directions, active)
    assert (hits.inst[~active] == MISS).all()
    assert 0.3 < (hits.inst[active] != MISS).mean() < 1
    assert len(np.unique(hits.inst[active])) == 5
    spread = np.random.default_rng(0).permutation(len(origins))  # each ray in another packet, of no kind
    elsewhere = tracing.closest(packed, origins[spread], directions[spread], active[spread])
    assert (bits(hits[spread]) == bits(elsewhere)).all()
    blocked = tracing.blocked(packed, origins, directions, 0.5, active)
    np.testing.assert_array_equal(blocked, active & (hits.t < 0.5))


def test_any_packets_of_a_block_may_be_idle(packed):
    kinds = ["a narrow beam", "anywhere", "one octant", "two octants"] * (PACKETS // 4)
    origins, directions = np.concatenate([packet(kind) for kind in kinds], 1).astype(np.float32)
    every = tracing.closest(packed, origins, directions)
    for chosen in range(2**PACKETS) if PACKETS == 4 else RANDOM.integers(2**PACKETS, size=256):
        active = np.repeat((chosen >> np.arange(PACKETS)) & 1 == 1, LANES)
        hits = tracing.closest(packed, origins, directions, active)
        assert (bits(hits[active]) == bits(every[active])).all()
        assert (hits.inst[~active] == MISS).all()
