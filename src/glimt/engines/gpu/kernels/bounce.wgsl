// Stage 4: mirror rays, side by side again in the other half of the paths.

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
