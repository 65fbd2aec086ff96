// Stage 5: a pixel's sample to its sum; one that is not finite, or would not add up, is counted and black.

const LARGEST = 1e34;

@compute @workgroup_size(GROUP_WIDTH, GROUP_HEIGHT)
fn resolve(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
           @builtin(local_invocation_index) local: u32) {
    let pixel = path_number(group, groups, local);
    if pixel >= frame_int(FRAME_columns) * frame_int(FRAME_rows) { return; }
    let from_ = sample_word(pixel);
    let to = 4u * pixel;
    let light = vec3(film[from_], film[from_ + 1u], film[from_ + 2u]);
    let first = frame_int(FRAME_sample) == 0u;
    let before = select(vec3(film[to], film[to + 1u], film[to + 2u]), vec3(0.0), first);
    let finite = abs(light.x) < LARGEST && abs(light.y) < LARGEST && abs(light.z) < LARGEST;
    if !finite { atomicAdd(&counters[COUNTER_non_finite], 1u); }
    let sum = before + select(vec3(0.0), light, finite);
    film[to] = sum.x;
    film[to + 1u] = sum.y;
    film[to + 2u] = sum.z;
    film[to + 3u] = f32(frame_int(FRAME_sample) + 1u);
}
