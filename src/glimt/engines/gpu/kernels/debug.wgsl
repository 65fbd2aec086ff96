// Debug views: numbers of the hits instead of radiance, and 1 where there is one.

const DEPTH = 0u;
const BARYCENTRICS = 1u;
const INSTANCES = 2u;
const NORMALS = 3u;
const SHADOWS = 4u;
const NODES = 5u;

// Return the sum of the tints of the lights that reach a surface point.
fn reaching(surface: Surface, ns: vec3<f32>) -> vec3<f32> {
    let start = above(surface);
    var tint = vec3(0.0);
    for (var index = 0u; index < frame_int(FRAME_light_count); index++) {
        let own = record_vector(frame_int(FRAME_tints) + 3u * index);
        if own.x + own.y + own.z == 0.0 { continue; }  // a light that is not asked for
        let light = light_sample(index, surface.point, start);
        if dot(ns, light.wi) <= 0.0 || light.attenuation * terminator(surface.ng, ns, light.wi) <= 0.0 { continue; }
        var counts = Counts(0u, 0u, 0u);
        if !occluded(start, light.reach, light.t_max, &counts) { tint += own; }
    }
    return tint;
}

fn numbers_of(hit: Hit, origin: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    switch frame_int(FRAME_shows) {
        case DEPTH: { return vec3(hit.t, 0.0, 0.0); }
        case BARYCENTRICS: { return vec3(1.0 - hit.u - hit.v, hit.u, hit.v); }
        case INSTANCES: { return vec3(f32(hit.inst), f32(hit.prim), 0.0); }
        case NODES: { return vec3(0.0); }  // counted on the way
        default: {
            let surface = surface_at(hit, origin, direction);
            let material = material_at(surface, direction, hit.t * frame_float(FRAME_spread));
            if frame_int(FRAME_shows) == NORMALS { return material.ns; }
            return reaching(surface, material.ns);
        }
    }
}

@compute @workgroup_size(GROUP_WIDTH, GROUP_HEIGHT)
fn debug(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
         @builtin(local_invocation_index) local: u32) {
    let number = path_number(group, groups, local);
    if number >= frame_int(FRAME_capacity) { return; }
    let at = path_record(number, 0u);
    let path = path_at(at);
    if path.pixel == NOBODY { return; }
    var counts = Counts(0u, 0u, 0u);
    let hit = closest_hit(path.origin, path.direction, FAR, &counts);
    var numbers = vec4(0.0);
    if hit.inst != MISS { numbers = vec4(numbers_of(hit, path.origin, path.direction), 1.0); }
    if frame_int(FRAME_shows) == NODES {
        numbers = vec4(f32(counts.nodes), f32(counts.blocks), f32(counts.instances), numbers.w);
    }
    film[4u * path.pixel] = numbers.x;
    film[4u * path.pixel + 1u] = numbers.y;
    film[4u * path.pixel + 2u] = numbers.z;
    film[4u * path.pixel + 3u] = numbers.w;
}
