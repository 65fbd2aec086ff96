// What is known about the place a ray has hit.

struct Surface {
    point: vec3<f32>,
    extent: f32,
    ng: vec3<f32>,
    ns: vec3<f32>,
    texcoord: vec2<f32>,
    texcoord_density: f32,
    tangent: vec3<f32>,
    bitangent: vec3<f32>,
    normal: vec3<f32>,
    has_tangent: bool,
    material: i32,
}

const PI = 3.14159265358979;

fn largest(v: vec3<f32>) -> f32 { return max(abs(v.x), max(abs(v.y), abs(v.z))); }

// Return v with a largest component of 1, so that its square stays within float32 at any scale.
fn rescaled(v: vec3<f32>) -> vec3<f32> { return v * (1.0 / max(largest(v), TINY)); }

// Return a point (w = 1) or vector (w = 0) of an instance's object space in world space.
fn to_world(record: u32, v: vec3<f32>, w: f32) -> vec3<f32> {
    let at = record + INSTANCE_object_to_world;
    return vec3(dot(record_vector(at), v) + w * record_float(at + 3u),
                dot(record_vector(at + 4u), v) + w * record_float(at + 7u),
                dot(record_vector(at + 8u), v) + w * record_float(at + 11u));
}

// Return a normal in world space: by the transposed inverse, which keeps it on its side also in a mirror.
fn normal_to_world(record: u32, n: vec3<f32>) -> vec3<f32> {
    let at = record + INSTANCE_world_to_object;
    return record_vector(at) * n.x + record_vector(at + 4u) * n.y + record_vector(at + 8u) * n.z;
}

fn blend(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, hit: Hit) -> vec3<f32> {
    return a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v;
}

fn mesh_surface(record: u32, hit: Hit, direction: vec3<f32>) -> Surface {
    let triangle = triangle_at(hit.prim + records[record + INSTANCE_first_triangle]);
    let a = vertex_at(triangle.x);
    let b = vertex_at(triangle.y);
    let c = vertex_at(triangle.z);

    // Corners, point and geometric normal.
    var edge1 = b.position - a.position;
    var edge2 = c.position - a.position;
    var point = a.position + edge1 * hit.u + edge2 * hit.v;
    let placed = records[record + INSTANCE_identity] == 0u;
    if placed {
        point = to_world(record, point, 1.0);
        edge1 = to_world(record, edge1, 0.0);
        edge2 = to_world(record, edge2, 0.0);
    }
    let per_size = 1.0 / max(max(largest(edge1), largest(edge2)), TINY);
    let facing = cross(edge1 * per_size, edge2 * per_size);
    let per_area = inverseSqrt(max(dot(facing, facing), TINY));
    var ng = facing * per_area;
    if dot(ng, direction) > 0.0 { ng = -ng; }

    // Shading normal, as modelled.
    var normal = ng;
    let modelled = blend(a.normal, b.normal, c.normal, hit);
    if record_int(record + INSTANCE_flat) == 0 {
        normal = modelled;
        if placed { normal = rescaled(normal_to_world(record, normal)); }
        let squared = dot(normal, normal);
        if squared > TINY { normal = normal * inverseSqrt(squared); } else { normal = ng; }
    }

    // Texture coordinates and how dense they are.
    let tb = b.texcoord - a.texcoord;
    let tc = c.texcoord - a.texcoord;
    let texcoord = a.texcoord + tc * hit.v + tb * hit.u;
    let density = abs(tb.x * tc.y - tc.x * tb.y) * per_area * per_size * per_size;

    // Tangent frame, built in object space so that a mirrored instance mirrors it.
    let shift = record_int(record + INSTANCE_tangent_shift);
    var tangent = normal;
    var bitangent = normal;
    let has_tangent = bitcast<u32>(shift) != NO_TANGENTS;
    if has_tangent {
        let tangent_a = tangent_at(u32(i32(triangle.x) + shift));
        let tangent_b = tangent_at(u32(i32(triangle.y) + shift));
        let tangent_c = tangent_at(u32(i32(triangle.z) + shift));
        tangent = blend(tangent_a.xyz, tangent_b.xyz, tangent_c.xyz, hit);
        bitangent = cross(modelled, tangent) * tangent_a.w;
        if placed {
            tangent = rescaled(to_world(record, tangent, 0.0));
            bitangent = rescaled(to_world(record, bitangent, 0.0));
        }
        tangent = tangent * inverseSqrt(max(dot(tangent, tangent), TINY));
        bitangent = bitangent * inverseSqrt(max(dot(bitangent, bitangent), TINY));
    }
    var material = record_int(record + INSTANCE_material);
    if material < 0 { material = bitcast<i32>(triangle.w); }
    return Surface(point, record_float(record + INSTANCE_extent), ng, normal, texcoord, density, tangent, bitangent,
                   normal, has_tangent, material);
}

// Return the surface of a sphere; `point` is near it.
fn sphere_surface(record: u32, point: vec3<f32>, direction: vec3<f32>) -> Surface {
    let center = record_vector(record + INSTANCE_center);
    let radius = record_float(record + INSTANCE_radius);
    let normal = normalize(point - center);
    let ng = select(normal, -normal, dot(normal, direction) > 0.0);
    let texcoord = vec2(atan2(-normal.z, normal.x) * (0.5 / PI) + 0.5, acos(clamp(normal.y, -1.0, 1.0)) * (1.0 / PI));
    let around = sqrt(max(1.0 - normal.y * normal.y, 1e-6));
    let density = 1.0 / (around * (2.0 * PI * PI * radius * radius));
    let tangent = vec3(normal.z, 0.0, -normal.x) * (1.0 / around);
    return Surface(center + normal * radius, record_float(record + INSTANCE_extent), ng, normal, texcoord, density,
                   tangent, cross(normal, tangent), normal, true, record_int(record + INSTANCE_material));
}

fn surface_at(hit: Hit, origin: vec3<f32>, direction: vec3<f32>) -> Surface {
    let record = frame_int(FRAME_instances) + hit.inst * INSTANCE_words;
    if records[record + INSTANCE_kind] == SPHERE_KIND {
        return sphere_surface(record, origin + direction * hit.t, direction);
    }
    return mesh_surface(record, hit, direction);
}

// Return where rays may leave a surface: so far above it that rounding never puts them below.
fn above(surface: Surface) -> vec3<f32> {
    return surface.point + surface.ng * ((largest(surface.point) + surface.extent) * OFFSET_ERROR);
}
