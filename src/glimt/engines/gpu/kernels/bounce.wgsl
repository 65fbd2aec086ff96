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
    let path = path_at(at);
    if path.pixel == NOBODY { return; }
    let share = bitcast<vec4<f32>>(paths[at + PATH_SHARE]);
    let reflectivity = share.z;
    if reflectivity <= 0.0 { return; }
    let next = path_record(atomicAdd(&counters[COUNTER_paths + frame_int(FRAME_depth) + 1u], 1u), 1u - half);
    store_path(next, path);
    store_share(next, share.x * reflectivity, share.y, 0.0);
}
