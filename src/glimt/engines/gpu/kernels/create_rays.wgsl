// Stage 1: pixels to rays.

@compute @workgroup_size(GROUP_WIDTH, GROUP_HEIGHT)
fn create_rays(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
               @builtin(local_invocation_index) local: u32) {
    let number = path_number(group, groups, local);
    if number >= frame_int(FRAME_capacity) { return; }
    let columns = frame_int(FRAME_columns);
    let tiles = (columns + GROUP_WIDTH - 1u) / GROUP_WIDTH;
    let tile = number / (GROUP_WIDTH * GROUP_HEIGHT);
    let column = tile % tiles * GROUP_WIDTH + local % GROUP_WIDTH;
    let row = tile / tiles * GROUP_HEIGHT + local / GROUP_WIDTH;
    let at = path_record(number, 0u);
    if column >= columns || row >= frame_int(FRAME_rows) {
        paths[at + PATH_pixel] = NOBODY;
        return;
    }
    let pixel = row * columns + column;
    let shown = vec2(f32(column + frame_int(FRAME_first_column)), f32(row + frame_int(FRAME_first_row)));
    let x = (shown.x + frame_float(FRAME_shift_x)) * (2.0 / frame_float(FRAME_width)) - 1.0;
    let y = (shown.y + frame_float(FRAME_shift_y)) * (-2.0 / frame_float(FRAME_height)) + 1.0;
    let ray = camera_ray(x, y);
    store_path_vector(at + PATH_origin, ray.origin);
    store_path_vector(at + PATH_direction, ray.direction);
    store_path_float(at + PATH_throughput, 1.0);
    store_path_float(at + PATH_travelled, 0.0);
    store_path_float(at + PATH_t, FAR);
    paths[at + PATH_pixel] = pixel;
    let sample = sample_word(pixel);
    film[sample] = 0.0;
    film[sample + 1u] = 0.0;
    film[sample + 2u] = 0.0;
}
