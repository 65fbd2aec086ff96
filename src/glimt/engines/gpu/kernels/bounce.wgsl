// Stage 4: mirror rays, side by side again in the other half of the paths.

const LEAST_RISE = 1e-3;  // the least cosine between a mirror ray and the geometric normal

// Return the direction of the mirror ray; one that a shading normal would send below the surface grazes it.
fn mirror_direction(direction: vec3<f32>, ng: vec3<f32>, ns: vec3<f32>) -> vec3<f32> {
    let mirrored = direction - ns * (2.0 * dot(direction, ns));
    let rise = dot(mirrored, ng);
    if rise >= LEAST_RISE { return mirrored; }
    return normalize(mirrored + ng * (LEAST_RISE - rise));
}

@compute @workgroup_size(GROUP_WIDTH, GROUP_HEIGHT)
fn bounce(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
          @builtin(local_invocation_index) local: u32) {
    let number = path_number(group, groups, local);
    if number >= atomicLoad(&counters[COUNTER_paths + frame_int(FRAME_depth)]) { return; }
    let half = frame_int(FRAME_half);
    let at = path_record(number, half);
    let pixel = paths[at + PATH_pixel];
    if pixel == NOBODY { return; }
    let reflectivity = path_float(at + PATH_reflectivity);
    if reflectivity <= 0.0 { return; }
    let next = path_record(atomicAdd(&counters[COUNTER_paths + frame_int(FRAME_depth) + 1u], 1u), 1u - half);
    store_path_vector(next + PATH_origin, path_vector(at + PATH_origin));
    store_path_vector(next + PATH_direction, path_vector(at + PATH_direction));
    store_path_float(next + PATH_throughput, path_float(at + PATH_throughput) * reflectivity);
    store_path_float(next + PATH_travelled, path_float(at + PATH_travelled));
    store_path_float(next + PATH_t, FAR);
    paths[next + PATH_pixel] = pixel;
}
