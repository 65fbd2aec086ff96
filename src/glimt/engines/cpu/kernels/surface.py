"""What is known about the place a ray has hit."""

from typing import NamedTuple

import numpy as np

from glimt.kernel import inline, routine
from glimt.lanes import (
    absolute,
    all_lanes,
    any_lane,
    arccos,
    arctan2,
    bits,
    count_trailing_zeros,
    cross,
    dot,
    extract,
    f32,
    fma,
    from_bits,
    i32,
    maximum,
    normalize,
    pick,
    pick_int,
    population_count,
    reciprocal,
    reciprocal_sqrt,
    scalar,
    scalar3,
    scalar_int,
    select,
    select3,
    splat3,
    sqrt,
    vector3,
)
from glimt.layout import FACE, INSTANCE, MATERIAL, NO_TANGENTS, OFFSET_ERROR, SPHERE_KIND, TANGENT, TRIANGLE, VERTEX

_TINY = np.float32(1e-30)
_FEW = 3
"""How many primitives of an instance a packet is peeled by, if each had as many lanes as the first."""
_CORNER, _TRIANGLE = np.int32(TRIANGLE.vertex), np.int32(TRIANGLE.words)
_VERTEX, _TANGENT, _FACE = np.int32(VERTEX.words), np.int32(TANGENT.words), np.int32(FACE.words)
_TWO_PI, _PI = np.float32(2 * np.pi), np.float32(np.pi)


class Surface(NamedTuple):
    """A surface point for each lane, in world space.

    point, extent: the position, and the size of the instance it is on; ng, ns: unit geometric and shading normals on
    the viewer's side; texcoord_u, texcoord_v; texcoord_density: texcoord area per square metre; tangent, bitangent,
    normal: the frame of the normal map as it was modelled (normal not yet turned to the viewer); has_tangent: 1 where
    there is one; material: index; clearance, clear_unit: of its triangle on this side (0: not known; see FACE), and the
    length of its unit.
    """

    point: object
    extent: object
    ng: object
    ns: object
    texcoord_u: object
    texcoord_v: object
    texcoord_density: object
    tangent: object
    bitangent: object
    normal: object
    has_tangent: object
    material: object
    clearance: object
    clear_unit: object


@inline
def _to_world(scene, record, v, w):
    """Return a point (w = 1) or vector (w = 0) of an instance's object space in world space."""
    at = record + INSTANCE.object_to_world
    x, y, z = scalar3(scene.instances, at), scalar3(scene.instances, at + 4), scalar3(scene.instances, at + 8)
    return vector3(dot(x, v) + w * scalar(scene.instances, at + 3), dot(y, v) + w * scalar(scene.instances, at + 7),
                   dot(z, v) + w * scalar(scene.instances, at + 11))


@inline
def _normal_to_world(scene, record, n):
    """Return a normal in world space: by the transposed inverse, which keeps it on its side also in a mirror."""
    at = record + INSTANCE.world_to_object
    x, y, z = scalar3(scene.instances, at), scalar3(scene.instances, at + 4), scalar3(scene.instances, at + 8)
    return x * n.x + y * n.y + z * n.z


@inline
def largest(v):
    """Return the largest component by size."""
    return maximum(absolute(v.x), maximum(absolute(v.y), absolute(v.z)))


@inline
def _rescaled(v):
    """Return v with a largest component of 1, so that its square stays within float32 at any scale."""
    return v * reciprocal(maximum(largest(v), _TINY))


@inline
def _blend(a, b, c, hit):
    """Return the interpolation of three corners' values by barycentrics."""
    return a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v


@inline
def _pick3(words, index, lanes):
    return vector3(pick(words, index, lanes), pick(words, index + 1, lanes), pick(words, index + 2, lanes))


@inline
def _blend3(words, a, b, c, hit, lanes):
    return _blend(_pick3(words, a, lanes), _pick3(words, b, lanes), _pick3(words, c, lanes), hit)


@inline
def _mesh_surface(scene, record, hit, prim, lanes, direction):
    """Return the Surface of triangles of one instance: of one that all lanes share, or of one for each of `lanes`."""
    index = prim + scalar_int(scene.instances, record + INSTANCE.first_triangle)
    triangle = index * _TRIANGLE
    vertex_a = pick_int(scene.triangles, triangle + _CORNER, lanes)
    vertex_b = pick_int(scene.triangles, triangle + (_CORNER + 1), lanes)
    vertex_c = pick_int(scene.triangles, triangle + (_CORNER + 2), lanes)
    a, b, c = vertex_a * _VERTEX, vertex_b * _VERTEX, vertex_c * _VERTEX

    # Corners, point and geometric normal.
    at = np.int32(VERTEX.position)
    p0, p1 = _pick3(scene.vertices, a + at, lanes), _pick3(scene.vertices, b + at, lanes)
    p2 = _pick3(scene.vertices, c + at, lanes)
    edge1, edge2 = p1 - p0, p2 - p0
    point = p0 + edge1 * hit.u + edge2 * hit.v
    placed = scalar_int(scene.instances, record + INSTANCE.identity) == 0
    if placed:
        point = _to_world(scene, record, point, np.float32(1))
        edge1 = _to_world(scene, record, edge1, np.float32(0))
        edge2 = _to_world(scene, record, edge2, np.float32(0))
    size = maximum(largest(edge1), largest(edge2))
    per_size = reciprocal(maximum(size, _TINY))  # so that squares of areas stay within float32 at any scale
    facing = cross(edge1 * per_size, edge2 * per_size)
    per_area = reciprocal_sqrt(maximum(dot(facing, facing), _TINY))
    ng = facing * per_area
    away = dot(ng, direction) > 0.0
    ng = ng * select(away, f32(-1.0), 1.0)

    # How far there is nothing of the mesh, if that is known for this side.
    clear_unit, clearance = f32(scalar(scene.instances, record + INSTANCE.clear_unit)), i32(0)
    if any_lane(clear_unit != 0.0):
        clearance = clearance + pick_int(scene.faces, index * _FACE + np.int32(FACE.clearance), lanes)
        clearance = select(away, select(clear_unit < 0.0, clearance, 0), select(clear_unit > 0.0, clearance, 0))

    # Shading normal, as modelled.
    normal = ng
    if scalar_int(scene.instances, record + INSTANCE.flat) == 0:
        at = np.int32(VERTEX.normal)
        normal = _blend3(scene.vertices, a + at, b + at, c + at, hit, lanes)
        if placed:
            normal = _rescaled(_normal_to_world(scene, record, normal))
        squared = dot(normal, normal)
        normal = select3(squared > _TINY, normal * reciprocal_sqrt(maximum(squared, _TINY)), ng)

    # Texture coordinates and how dense they are.
    texcoord_u, texcoord_v, density = f32(0.0), f32(0.0), f32(0.0)
    if scalar_int(scene.instances, record + INSTANCE.untextured) == 0:
        at = np.int32(VERTEX.texcoord)
        ua, va = pick(scene.vertices, a + at, lanes), pick(scene.vertices, a + (at + 1), lanes)
        ub, vb = pick(scene.vertices, b + at, lanes) - ua, pick(scene.vertices, b + (at + 1), lanes) - va
        uc, vc = pick(scene.vertices, c + at, lanes) - ua, pick(scene.vertices, c + (at + 1), lanes) - va
        texcoord_u = fma(hit.u, ub, fma(hit.v, uc, ua))
        texcoord_v = fma(hit.u, vb, fma(hit.v, vc, va))
        texcoord_area = absolute(ub * vc - uc * vb)
        density = texcoord_area * per_area * per_size * per_size

    # Tangent frame, built in object space so that a mirrored instance mirrors it.
    shift = scalar_int(scene.instances, record + INSTANCE.tangent_shift)
    tangent, bitangent, has_tangent = normal, normal, np.float32(0)
    if shift != NO_TANGENTS:
        ta, tb, tc = (vertex_a + shift) * _TANGENT, (vertex_b + shift) * _TANGENT, (vertex_c + shift) * _TANGENT
        tangent = _blend3(scene.tangents, ta, tb, tc, hit, lanes)
        at = np.int32(VERTEX.normal)
        modelled = _blend3(scene.vertices, a + at, b + at, c + at, hit, lanes)
        bitangent = cross(modelled, tangent) * pick(scene.tangents, ta + np.int32(TANGENT.sign), lanes)
        if placed:
            tangent = _rescaled(_to_world(scene, record, tangent, np.float32(0)))
            bitangent = _rescaled(_to_world(scene, record, bitangent, np.float32(0)))
        tangent = tangent * reciprocal_sqrt(maximum(dot(tangent, tangent), _TINY))
        bitangent = bitangent * reciprocal_sqrt(maximum(dot(bitangent, bitangent), _TINY))
        has_tangent = np.float32(1)

    material = i32(scalar_int(scene.instances, record + INSTANCE.material))
    if any_lane(material < 0):
        material = material * 0 + pick_int(scene.triangles, triangle + np.int32(TRIANGLE.material), lanes)
    extent = f32(scalar(scene.instances, record + INSTANCE.extent))
    return Surface(point, extent, ng, normal, texcoord_u, texcoord_v, density, tangent, bitangent, normal,
                   f32(has_tangent), material, clearance, absolute(clear_unit))


@inline
def _sphere_surface(scene, record, point, direction):
    """Return the Surface of one sphere, for all lanes; `point` is near it."""
    center = scalar3(scene.instances, record + INSTANCE.center)
    radius = scalar(scene.instances, record + INSTANCE.radius)
    normal = normalize(point - center)
    ng = normal * select(dot(normal, direction) > 0.0, f32(-1.0), 1.0)
    material = scalar_int(scene.instances, record + INSTANCE.material)
    texcoord_u, texcoord_v, density = f32(0.0), f32(0.0), f32(0.0)
    tangent, bitangent = normal, normal
    textured = np.int64(material) * MATERIAL.words
    if (scalar_int(scene.materials, textured + MATERIAL.diffuse_texture) >= 0
            or scalar_int(scene.materials, textured + MATERIAL.normal_texture) >= 0):
        texcoord_u = arctan2(-normal.z, normal.x) * (np.float32(1) / _TWO_PI) + 0.5
        texcoord_v = arccos(normal.y) * (np.float32(1) / _PI)
        around = sqrt(maximum(1.0 - normal.y * normal.y, np.float32(1e-6)))
        density = reciprocal(around * (_TWO_PI * _PI * radius * radius))
        tangent = vector3(normal.z, 0.0, -normal.x) * (1.0 / around)
        bitangent = cross(normal, tangent)
    extent = f32(scalar(scene.instances, record + INSTANCE.extent))
    return Surface(center + normal * radius, extent, ng, normal, texcoord_u, texcoord_v, density, tangent, bitangent,
                   normal, f32(1.0), i32(material), i32(0), f32(0.0))


@inline
def _merge(m, a, b):
    """Return surface a in the lanes of m, b elsewhere."""
    return Surface(select3(m, a.point, b.point), select(m, a.extent, b.extent), select3(m, a.ng, b.ng),
                   select3(m, a.ns, b.ns), select(m, a.texcoord_u, b.texcoord_u),
                   select(m, a.texcoord_v, b.texcoord_v), select(m, a.texcoord_density, b.texcoord_density),
                   select3(m, a.tangent, b.tangent), select3(m, a.bitangent, b.bitangent),
                   select3(m, a.normal, b.normal), select(m, a.has_tangent, b.has_tangent),
                   select(m, a.material, b.material), select(m, a.clearance, b.clearance),
                   select(m, a.clear_unit, b.clear_unit))


@inline
def above(surface):
    """Return where rays may leave a surface: so far above it that rounding never puts them below."""
    return surface.point + surface.ng * ((largest(surface.point) + surface.extent) * OFFSET_ERROR)


@routine
def surface_at(scene, hit, found, origin, direction):
    """Return the Surface of the lanes in `found`.

    The packet is peeled by distinct primitive: each costs a few broadcasts, however many lanes it has. Where an
    instance shows too many of them, each lane gathers its own.
    """
    zero, none = f32(0.0), splat3(f32(0.0))
    result = Surface(none, zero, none, none, zero, zero, zero, none, none, none, zero, i32(0), i32(0), zero)
    todo = bits(found)
    while todo:
        lane = count_trailing_zeros(todo)
        inst, prim = extract(hit.inst, lane), extract(hit.prim, lane)
        together = from_bits(todo) & (hit.inst == inst)
        same = together & (hit.prim == prim)
        record = np.int64(inst) * INSTANCE.words
        if scalar_int(scene.instances, record + INSTANCE.kind) == SPHERE_KIND:
            here = _sphere_surface(scene, record, origin + direction * hit.t, direction)
        elif population_count(bits(together)) > _FEW * population_count(bits(same)):
            same = together
            here = _mesh_surface(scene, record, hit, hit.prim, together, direction)
        else:
            here = _mesh_surface(scene, record, hit, prim, same, direction)
        todo &= ~bits(same)
        if all_lanes(same | ~found):  # the whole packet sees one primitive
            return here
        result = _merge(same, here, result)
    return result
