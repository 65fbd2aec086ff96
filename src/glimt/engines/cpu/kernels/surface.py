"""What is known about the place a ray has hit."""

from typing import NamedTuple

import numpy as np

from glimt.kernel import inline, routine
from glimt.lanes import (
    absolute,
    all_lanes,
    arccos,
    arctan2,
    bits,
    count_trailing_zeros,
    cross,
    dot,
    extract,
    f32,
    fma,
    i32,
    maximum,
    normalize,
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
from glimt.layout import INSTANCE, MATERIAL, NO_TANGENTS, OFFSET_ERROR, SPHERE_KIND, TANGENT, TRIANGLE, VERTEX

_TINY = np.float32(1e-30)
_TWO_PI, _PI = np.float32(2 * np.pi), np.float32(np.pi)


class Surface(NamedTuple):
    """A surface point for each lane, in world space.

    point, extent: the position, and the size of the instance it is on; ng, ns: unit geometric and shading normals on
    the viewer's side; texcoord_u, texcoord_v; texcoord_density: texcoord area per square metre; tangent, bitangent,
    normal: the frame of the normal map as it was modelled (normal not yet turned to the viewer); has_tangent: 1 where
    there is one; material: index.
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
def _largest(v):
    """Return the largest component by size."""
    return maximum(absolute(v.x), maximum(absolute(v.y), absolute(v.z)))


@inline
def _rescaled(v):
    """Return v with a largest component of 1, so that its square stays within float32 at any scale."""
    return v * reciprocal(maximum(_largest(v), _TINY))


@inline
def _blend(a, b, c, hit):
    """Return the interpolation of three corners' values by barycentrics."""
    return a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v


@inline
def _vertex3(scene, field, a, b, c, hit):
    return _blend(scalar3(scene.vertices, a + field), scalar3(scene.vertices, b + field),
                  scalar3(scene.vertices, c + field), hit)


@inline
def _mesh_surface(scene, record, hit, prim, direction):
    """Return the Surface of one triangle, for all lanes."""
    triangle = (np.int64(scalar_int(scene.instances, record + INSTANCE.first_triangle)) + prim) * TRIANGLE.words
    vertex_a = np.int64(scalar_int(scene.triangles, triangle + TRIANGLE.vertex))
    vertex_b = np.int64(scalar_int(scene.triangles, triangle + TRIANGLE.vertex + 1))
    vertex_c = np.int64(scalar_int(scene.triangles, triangle + TRIANGLE.vertex + 2))
    a, b, c = vertex_a * VERTEX.words, vertex_b * VERTEX.words, vertex_c * VERTEX.words

    # Corners, point and geometric normal.
    p0, p1 = scalar3(scene.vertices, a + VERTEX.position), scalar3(scene.vertices, b + VERTEX.position)
    p2 = scalar3(scene.vertices, c + VERTEX.position)
    edge1, edge2 = p1 - p0, p2 - p0
    point = p0 + edge1 * hit.u + edge2 * hit.v
    placed = scalar_int(scene.instances, record + INSTANCE.identity) == 0
    if placed:
        point = _to_world(scene, record, point, np.float32(1))
        edge1 = _to_world(scene, record, edge1, np.float32(0))
        edge2 = _to_world(scene, record, edge2, np.float32(0))
    size = maximum(_largest(edge1), _largest(edge2))
    per_size = reciprocal(maximum(size, _TINY))  # so that squares of areas stay within float32 at any scale
    facing = cross(edge1 * per_size, edge2 * per_size)
    per_area = reciprocal_sqrt(maximum(dot(facing, facing), _TINY))
    ng = facing * per_area
    ng = ng * select(dot(ng, direction) > 0.0, f32(-1.0), 1.0)

    # Shading normal, as modelled.
    normal = ng
    if scalar_int(scene.instances, record + INSTANCE.flat) == 0:
        normal = _vertex3(scene, VERTEX.normal, a, b, c, hit)
        if placed:
            normal = _rescaled(_normal_to_world(scene, record, normal))
        squared = dot(normal, normal)
        normal = select3(squared > _TINY, normal * reciprocal_sqrt(maximum(squared, _TINY)), ng)

    # Texture coordinates and how dense they are.
    at = VERTEX.texcoord
    ua, va = scalar(scene.vertices, a + at), scalar(scene.vertices, a + at + 1)
    ub, vb = scalar(scene.vertices, b + at), scalar(scene.vertices, b + at + 1)
    uc, vc = scalar(scene.vertices, c + at), scalar(scene.vertices, c + at + 1)
    texcoord_u = fma(hit.u, ub - ua, fma(hit.v, uc - ua, f32(ua)))
    texcoord_v = fma(hit.u, vb - va, fma(hit.v, vc - va, f32(va)))
    texcoord_area = absolute(f32((ub - ua) * (vc - va) - (uc - ua) * (vb - va)))
    density = texcoord_area * per_area * per_size * per_size

    # Tangent frame, built in object space so that a mirrored instance mirrors it.
    shift = scalar_int(scene.instances, record + INSTANCE.tangent_shift)
    tangent, bitangent, has_tangent = normal, normal, np.float32(0)
    if shift != NO_TANGENTS:
        a, b = (vertex_a + shift) * TANGENT.words, (vertex_b + shift) * TANGENT.words
        c = (vertex_c + shift) * TANGENT.words
        tangent = _blend(scalar3(scene.tangents, a), scalar3(scene.tangents, b), scalar3(scene.tangents, c), hit)
        a, b, c = vertex_a * VERTEX.words, vertex_b * VERTEX.words, vertex_c * VERTEX.words
        modelled = _vertex3(scene, VERTEX.normal, a, b, c, hit)
        bitangent = cross(modelled, tangent) * scalar(scene.tangents, (vertex_a + shift) * TANGENT.words + TANGENT.sign)
        if placed:
            tangent = _rescaled(_to_world(scene, record, tangent, np.float32(0)))
            bitangent = _rescaled(_to_world(scene, record, bitangent, np.float32(0)))
        tangent = tangent * reciprocal_sqrt(maximum(dot(tangent, tangent), _TINY))
        bitangent = bitangent * reciprocal_sqrt(maximum(dot(bitangent, bitangent), _TINY))
        has_tangent = np.float32(1)

    material = scalar_int(scene.instances, record + INSTANCE.material)
    if material < 0:
        material = scalar_int(scene.triangles, triangle + TRIANGLE.material)
    extent = f32(scalar(scene.instances, record + INSTANCE.extent))
    return Surface(point, extent, ng, normal, texcoord_u, texcoord_v, density, tangent, bitangent, normal,
                   f32(has_tangent), i32(material))


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
                   normal, f32(1.0), i32(material))


@inline
def _merge(m, a, b):
    """Return surface a in the lanes of m, b elsewhere."""
    return Surface(select3(m, a.point, b.point), select(m, a.extent, b.extent), select3(m, a.ng, b.ng),
                   select3(m, a.ns, b.ns), select(m, a.texcoord_u, b.texcoord_u),
                   select(m, a.texcoord_v, b.texcoord_v), select(m, a.texcoord_density, b.texcoord_density),
                   select3(m, a.tangent, b.tangent), select3(m, a.bitangent, b.bitangent),
                   select3(m, a.normal, b.normal), select(m, a.has_tangent, b.has_tangent),
                   select(m, a.material, b.material))


@inline
def above(surface):
    """Return where rays may leave a surface: so far above it that rounding never puts them below."""
    return surface.point + surface.ng * ((_largest(surface.point) + surface.extent) * OFFSET_ERROR)


@routine
def surface_at(scene, hit, found, origin, direction):
    """Return the Surface of the lanes in `found`.

    The packet is peeled by distinct primitive: each costs a few broadcasts, however many lanes it has.
    """
    zero, none = f32(0.0), splat3(f32(0.0))
    result = Surface(none, zero, none, none, zero, zero, zero, none, none, none, zero, i32(0))
    todo = bits(found)
    while todo:
        lane = count_trailing_zeros(todo)
        inst, prim = extract(hit.inst, lane), extract(hit.prim, lane)
        same = found & (hit.inst == inst) & (hit.prim == prim)
        todo &= ~bits(same)
        record = np.int64(inst) * INSTANCE.words
        if scalar_int(scene.instances, record + INSTANCE.kind) == SPHERE_KIND:
            here = _sphere_surface(scene, record, origin + direction * hit.t, direction)
        else:
            here = _mesh_surface(scene, record, hit, np.int64(prim), direction)
        if all_lanes(same | ~found):  # the whole packet sees one primitive
            return here
        result = _merge(same, here, result)
    return result
