// Stage 1: pixels to rays.

const PIXEL_BLOCK = vec2(4u, 2u);

// Return an invocation's place in its tile: eight in a row are a block of pixels, whose rays stay together longer than
// those of a row, also where a processor takes more or fewer at a time.
fn place_in_tile(local: u32) -> vec2<u32> {
    if GROUP_WIDTH % PIXEL_BLOCK.x != 0u || GROUP_HEIGHT % PIXEL_BLOCK.y != 0u {
        return vec2(local % GROUP_WIDTH, local / GROUP_WIDTH);
    }
    let block = local / (PIXEL_BLOCK.x * PIXEL_BLOCK.y);
    let blocks_across = GROUP_WIDTH / PIXEL_BLOCK.x;
    return (vec2(block % blocks_across, block / blocks_across) * PIXEL_BLOCK
            + vec2(local % PIXEL_BLOCK.x, local / PIXEL_BLOCK.x % PIXEL_BLOCK.y));
}

@compute @workgroup_size(GROUP_WIDTH, GROUP_HEIGHT)
fn create_rays(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
               @builtin(local_invocation_index) local: u32) {
    let number = path_number(group, groups, local);
    if number >= frame_int(FRAME_capacity) { return; }
    let columns = frame_int(FRAME_columns);
    let tiles = (columns + GROUP_WIDTH - 1u) / GROUP_WIDTH;
    let tile = number / (GROUP_WIDTH * GROUP_HEIGHT);
    let place = place_in_tile(local);
    let column = tile % tiles * GROUP_WIDTH + place.x;
    let row = tile / tiles * GROUP_HEIGHT + place.y;
    let at = path_record(number, 0u);
    if column >= columns || row >= frame_int(FRAME_rows) {
        paths[at + PATH_direction / 4u].w = NOBODY;
        return;
    }
    let pixel = row * columns + column;
    let shown = vec2(f32(column + frame_int(FRAME_first_column)), f32(row + frame_int(FRAME_first_row)));
    let x = (shown.x + frame_float(FRAME_shift_x)) * (2.0 / frame_float(FRAME_width)) - 1.0;
    let y = (shown.y + frame_float(FRAME_shift_y)) * (-2.0 / frame_float(FRAME_height)) + 1.0;
    let ray = camera_ray(x, y);
    store_path(at, Path(ray.origin, FAR, ray.direction, pixel));
    store_share(at, 1.0, 0.0, 0.0);
    let sample = sample_word(pixel);
    film[sample] = 0.0;
    film[sample + 1u] = 0.0;
    film[sample + 2u] = 0.0;
}
