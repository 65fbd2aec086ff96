// Stage 2: rays to hits.

@compute @workgroup_size(GROUP_WIDTH, GROUP_HEIGHT)
fn intersect(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
             @builtin(local_invocation_index) local: u32) {
    let number = path_number(group, groups, local);
    if number >= atomicLoad(&counters[COUNTER_paths + frame_int(FRAME_depth)]) { return; }
    let at = path_record(number, frame_int(FRAME_half));
    if paths[at + PATH_pixel] == NOBODY { return; }
    var counts = Counts(0u, 0u, 0u);
    let hit = closest_hit(path_vector(at + PATH_origin), path_vector(at + PATH_direction), path_float(at + PATH_t),
                          &counts);
    store_path_float(at + PATH_t, hit.t);
    store_path_float(at + PATH_u, hit.u);
    store_path_float(at + PATH_v, hit.v);
    paths[at + PATH_prim] = hit.prim;
    paths[at + PATH_inst] = hit.inst;
    count_visits(select(2u, 0u, frame_int(FRAME_depth) == 0u), counts);
}
