// Stage 2: rays to hits.

@compute @workgroup_size(GROUP_WIDTH, GROUP_HEIGHT)
fn intersect(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
             @builtin(local_invocation_index) local: u32) {
    let number = path_number(group, groups, local);
    if number >= atomicLoad(&counters[COUNTER_paths + frame_int(FRAME_depth)]) { return; }
    let at = path_record(number, frame_int(FRAME_half));
    let path = path_at(at);
    if path.pixel == NOBODY { return; }
    var counts = Counts(0u, 0u, 0u);
    let hit = closest_hit(path.origin, path.direction, path.t, &counts);
    paths[at + PATH_t / 4u].w = bitcast<u32>(hit.t);
    paths[at + PATH_HIT] = vec4(bitcast<u32>(hit.u), bitcast<u32>(hit.v), hit.prim, hit.inst);
    count_visits(select(2u, 0u, frame_int(FRAME_depth) == 0u), counts);
}
