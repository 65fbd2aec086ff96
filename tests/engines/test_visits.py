"""How many nodes and triangle blocks a ray visits: by hand, and against a walk over the packed nodes in Python."""

import numpy as np
import pytest

import glimt
import strategies
from glimt import Camera, Instance, Mesh, Sphere, linalg
from glimt.layout import INSTANCE, INSTANCE_BLOCK, LEAF_STEP, NODE, SPHERE_KIND, TRIANGLE_BLOCK, VIEW, dtype
from glimt.packed import pack_view

SIZE = 33
FACING = Camera((0, 0, 10), (0, 0, 0), fov_deg=float(np.degrees(2 * np.arctan(0.1))))  # sees 2×2 of the plane z = 0
SQUARE = Mesh([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2], [0, 2, 3]])
CENTRES = np.meshgrid(*[(2 * np.arange(SIZE) + 1) / SIZE - 1] * 2)


def visits(*things, camera=FACING):
    """Return (nodes, triangle blocks, instances) of each pixel."""
    settings = glimt.RenderSettings(SIZE, SIZE)
    values = glimt.Renderer(glimt.Scene(camera=camera, settings=settings).add(*things)).render_debug("nodes").values
    return np.moveaxis(values[..., :3], 2, 0)


# ---- by hand ------------------------------------------------------------------------------------------------------

def test_a_mesh_of_one_leaf():
    """The root of the scene; of those rays that come near the mesh also its root, its leaf and its instance."""
    nodes, blocks, instances = visits(Instance(SQUARE, linalg.scaling(0.5)))
    inside = np.maximum(*np.abs(CENTRES)) < 0.5
    np.testing.assert_array_equal(nodes, np.where(inside, 2, 1))
    np.testing.assert_array_equal(blocks, inside)
    np.testing.assert_array_equal(instances, inside)


def test_a_ball_is_an_instance_without_nodes():
    nodes, blocks, instances = visits(Sphere((0, 0, 0), 0.5))
    assert (nodes == 1).all()
    assert not blocks.any()
    inside = np.maximum(*np.abs(CENTRES)) < 0.5  # its box, of which the near side is 9.5 away
    np.testing.assert_array_equal(instances[inside], 1)
    assert not instances[np.maximum(*np.abs(CENTRES)) > 0.53].any()


@pytest.mark.parametrize("order", [1, -1])
def test_what_lies_behind_is_not_entered(order):
    """One square before another: the nearer one is walked first, whatever the order of the objects."""
    far = linalg.compose(linalg.translation((0, 0, -3)), linalg.scaling(2))
    nodes, blocks, instances = visits(*[Instance(SQUARE, linalg.scaling(0.5)), Instance(SQUARE, far)][::order])
    assert (nodes == 2).all()
    assert (blocks == 1).all()
    assert (instances == 1).all()


def test_a_mesh_of_many_leaves():
    """Squares side by side in 8 leaves of 8 triangles at most: one root whose boxes do not overlap."""
    corners = SQUARE.positions[SQUARE.triangles]
    row = strategies.mesh_of(np.concatenate([corners * (0.04, 0.04, 1) + ((k - 3.5) * 0.25, 0, 0) for k in range(8)]))
    nodes, blocks, instances = visits(row)
    assert nodes.max() == 2
    assert blocks.max() == 1
    x, y = CENTRES
    inside = (np.abs(y) < 0.04) & (np.abs((x + 1) % 0.25 - 0.125) < 0.04)
    np.testing.assert_array_equal(blocks == 1, inside)
    np.testing.assert_array_equal(nodes - 1, instances)


# ---- against a walk in Python -------------------------------------------------------------------------------------

class Walk:
    """One ray in float64 down both trees of a packed scene, and what it has visited."""

    def __init__(self, packed, origin, direction):
        self.packed, self.t = packed, np.inf
        self.nodes = self.blocks = self.instances = 0
        self._descend(packed.tlas_nodes, 0, origin, direction, self._instance, by_octant=False)

    def _descend(self, words, root, origin, direction, leaf, by_octant=True):
        records, stack, inverse = words.view(dtype(NODE)), [(0.0, root)], 1 / direction
        while stack:
            entry, code = stack.pop()
            if entry > self.t:
                continue
            if code < 0:
                leaf(~code, origin, direction)
                continue
            self.nodes += 1
            node = records[code]
            lo, hi = (np.stack([node[f"{side}_{axis}"] for axis in "xyz"]).astype(np.float64) for side in ("lo", "hi"))
            forward = direction[:, None] >= 0  # an unused child has a box from inf to -inf
            enter = np.maximum(((np.where(forward, lo, hi) - origin[:, None]) * inverse[:, None]).max(0), 0)
            leave = np.minimum(((np.where(forward, hi, lo) - origin[:, None]) * inverse[:, None]).min(0), self.t)
            octant = (direction < 0) @ (1, 2, 4)
            order = [int(node["order"][octant]) >> 4 * place & 7 for place in range(8)]
            if not by_octant:
                order = sorted(range(8), key=lambda k: (-enter[k], -k))
            stack += [(float(enter[k]), int(node["child"][k])) for k in order if enter[k] <= leave[k]]

    def _instance(self, code, origin, direction):
        block = self.packed.tlas_blocks.view(dtype(INSTANCE_BLOCK))[code // LEAF_STEP]
        for inst in block["instance"][:code % LEAF_STEP]:
            self.instances += 1
            record = self.packed.instances.view(dtype(INSTANCE))[inst]
            if record["kind"] == SPHERE_KIND:
                self._sphere(record, origin, direction)
            else:
                matrix = record["world_to_object"].reshape(3, 4).astype(np.float64)
                self._descend(self.packed.blas_nodes, int(record["root"]), linalg.transform_points(matrix, origin),
                              linalg.transform_vectors(matrix, direction), self._triangles)

    def _sphere(self, record, origin, direction):
        to_center = record["center"].astype(np.float64) - origin
        nearest = to_center @ direction
        squared = float(record["radius"])**2 - (to_center @ to_center - nearest**2)
        if squared >= 0 and nearest > squared**0.5:
            self.t = min(self.t, nearest - squared**0.5)

    def _triangles(self, code, origin, direction):
        """Möller and Trumbore's test."""
        self.blocks += 1
        block = self.packed.blas_blocks.view(dtype(TRIANGLE_BLOCK))[code // LEAF_STEP]
        for k in range(code % LEAF_STEP):
            a, b, c = (np.array([block[f"{axis}{corner}"][k] for axis in "xyz"], np.float64) for corner in range(3))
            across = np.cross(direction, c - a)
            area = across @ (b - a)
            if area == 0:
                continue
            u = across @ (origin - a) / area
            back = np.cross(origin - a, b - a)
            v, t = back @ direction / area, back @ (c - a) / area
            if u >= 0 and v >= 0 and u + v <= 1 and t > 0:
                self.t = min(self.t, t)


def ball(triangles):
    """Return a bumpy ball of about so many triangles around (0, 0, 0)."""
    rows = int((triangles / 4)**0.5)
    theta, phi = np.meshgrid(np.linspace(0.01, np.pi - 0.01, rows + 1), np.linspace(0, 2 * np.pi, 2 * rows + 1))
    radius = 1 + 0.1 * np.sin(5 * theta) * np.sin(7 * phi)
    grid = radius[..., None] * np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], 2)
    corners = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    return strategies.mesh_of(np.concatenate([np.stack([corners[k] for k in which], 2).reshape(-1, 3, 3)
                                              for which in ((0, 1, 2), (0, 2, 3))]))


@pytest.mark.parametrize("seed", range(3))
def test_the_same_walk_in_python(seed):
    random = np.random.default_rng(seed)
    scene = glimt.Scene(settings=glimt.RenderSettings(96, 64)).add(Sphere((1.5, 0, 0.5), 0.75))
    mesh = ball(2000)
    for name in ("identity", "turned", "mirrored", "stretched", "moved"):
        scene.add(Instance(mesh, strategies.MATRICES[name](random)))
    scene.camera = Camera(tuple(random.uniform(2, 4, 3)), (0, 0, 0), fov_deg=40)
    renderer = glimt.Renderer(scene)
    values = renderer.render_debug("nodes").values
    view = pack_view(scene.camera, scene.settings, []).astype(np.float64)
    origin, right, up, look = (view[at:at + 3] for at in (VIEW.origin, VIEW.right, VIEW.up, VIEW.look))
    ours, theirs = [], []
    for column, row in random.integers(0, (96, 64), (300, 2)):
        direction = look + (2 * column + 1 - 96) / 96 * right + (64 - 2 * row - 1) / 64 * up
        walk = Walk(renderer._packed, origin, linalg.normalize(direction))
        ours.append(values[row, column])
        theirs.append((walk.nodes, walk.blocks, walk.instances, walk.t < np.inf))
    ours, theirs = np.array(ours), np.array(theirs)
    assert theirs[:, 1].max() > 5
    assert 0.2 < theirs[:, 3].mean() < 0.9
    same = (ours == theirs).all(1)
    assert same.mean() > 0.99, np.stack([ours, theirs], 1)[~same]  # a ray may graze a box
    assert np.abs(ours - theirs).max() <= 3
