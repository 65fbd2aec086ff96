// Rays down the trees: compressed nodes of eight children, 80 bytes each (Ylitie, Karras, Laine, "Efficient incoherent
// ray traversal on GPUs through compressed wide BVHs", 2017). What differs: children go on the stack one by one, by
// distance, and are dropped when something nearer has been found by then, which saves a quarter of the bytes read.

struct Counts { nodes: u32, blocks: u32, instances: u32 }

// Of a child: a node, or a leaf by its number of blocks * LEAF_STEP + triangles; or that there is none.
const LEAF = 0x80000000u;
const NOTHING = 0xffffffffu;
const NO_KEY = -1;

var<private> stack_codes: array<u32, TREE_STACK>;
var<private> stack_distances: array<f32, TREE_STACK>;
var<private> stack_top: u32;

fn bytes_of(word: u32) -> vec4<f32> { return vec4<f32>((vec4(word) >> vec4(0u, 8u, 16u, 24u)) & vec4(255u)); }

fn exponent_scale(packed: u32, axis: u32) -> f32 {
    return bitcast<f32>(u32(extractBits(bitcast<i32>(packed), 8u * axis, 8u) + 127) << 23u);
}

// Floats as integers, which are in the same order but for two below 0. Their minimum and maximum are one instruction
// where those of floats, which have to look for NaN, are three.
fn ordered(v: vec4<f32>) -> vec4<i32> { return bitcast<vec4<i32>>(v); }

// Return the distances of four boxes as integers, a slot in the lowest bits of each; NO_KEY for those that are not met.
// Planes are bytes as the ray comes to them.
fn meet(near: vec3<u32>, far: vec3<u32>, slots: vec4<i32>, scale: vec3<f32>, near_add: vec3<f32>, far_add: vec3<f32>,
        t_max: f32) -> vec4<i32> {
    let enter = max(max(ordered(bytes_of(near.x) * scale.x + near_add.x),
                        ordered(bytes_of(near.y) * scale.y + near_add.y)),
                    max(ordered(bytes_of(near.z) * scale.z + near_add.z), vec4(0)));
    let leave = min(min(ordered(bytes_of(far.x) * scale.x + far_add.x),
                        ordered(bytes_of(far.y) * scale.y + far_add.y)),
                    min(ordered(bytes_of(far.z) * scale.z + far_add.z), vec4(bitcast<i32>(t_max))));
    let met = bitcast<vec4<f32>>(enter) <= bitcast<vec4<f32>>(leave) * BOX_SLACK;
    return select(vec4(NO_KEY), (enter & vec4(~7)) | slots, met);
}

// Return the code of the child that a key of `meet` stands for. Where there is none, that is a leaf of no triangles.
fn child(key: i32, kinds: vec2<u32>, bases: vec2<u32>) -> u32 {
    let slot = u32(key);
    let kind = (select(kinds.x, kinds.y, (slot & 4u) != 0u) >> (8u * (slot & 3u))) & 255u;
    return (kind & 63u) + select(bases.y | LEAF, bases.x, (kind & INNER_META) != 0u);
}

fn greatest(low: vec4<i32>, high: vec4<i32>) -> i32 {
    let a = max(low, high);
    return max(max(a.x, a.y), max(a.z, a.w));
}

// Put the children of a node that a ray meets on the stack, the nearest on top but for the very nearest, which is
// returned.
fn push_children(code: u32, ray: Ray, t_max: f32, occlusion: bool) -> u32 {
    let base = code * (COMPRESSED_NODE_words / 4u);
    let head = nodes[base];
    let links = nodes[base + COMPRESSED_NODE_child_base / 4u];
    let planes = array(nodes[base + COMPRESSED_NODE_lo_x / 4u], nodes[base + COMPRESSED_NODE_lo_z / 4u],
                       nodes[base + COMPRESSED_NODE_hi_y / 4u]);
    let packed = head.w;
    let scale = vec3(exponent_scale(packed, 0u), exponent_scale(packed, 1u), exponent_scale(packed, 2u)) * ray.inverse;
    let offset = (bitcast<vec3<f32>>(head.xyz) - ray.origin) * ray.inverse;
    // Wider by a thousandth of a cell than the box, which is more than the sums above round off.
    let pad = ray.pad + abs(scale) * 0.001;
    let kinds = links.zw;
    let bases = vec2(links.x, links.y * LEAF_STEP);
    let down = ray.inverse < vec3(0.0);
    var lo = vec3(planes[0].x, planes[0].z, planes[1].x);
    var hi = vec3(planes[1].z, planes[2].x, planes[2].z);
    var low = meet(select(lo, hi, down), select(hi, lo, down), vec4(0, 1, 2, 3), scale, offset - pad,
                   offset + pad, t_max);
    lo = vec3(planes[0].y, planes[0].w, planes[1].y);
    hi = vec3(planes[1].w, planes[2].y, planes[2].w);
    var high = meet(select(lo, hi, down), select(hi, lo, down), vec4(4, 5, 6, 7), scale, offset - pad,
                    offset + pad, t_max);
    let nearest = bitcast<i32>(least(min(bitcast<vec4<u32>>(low), bitcast<vec4<u32>>(high))));
    if nearest == NO_KEY { return NOTHING; }
    var key = greatest(low, high);
    loop {
        if key != nearest {
            if !occlusion { stack_distances[stack_top] = bitcast<f32>(key & ~7); }
            stack_codes[stack_top] = child(key, kinds, bases);
            stack_top++;
        }
        low = select(low, vec4(NO_KEY), low == vec4(key));
        high = select(high, vec4(NO_KEY), high == vec4(key));
        key = greatest(low, high);
        continuing { break if key <= nearest; }
    }
    return child(nearest, kinds, bases);
}

// Take a child from the stack; return NOTHING where there is none above `bottom`, or if it is too far. What only has to
// be hit is looked for up to the same distance all the way: nothing on the stack is ever too far.
fn pop(bottom: u32, t_max: f32, occlusion: bool) -> u32 {
    if stack_top <= bottom { return NOTHING; }
    stack_top--;
    let is_near = occlusion || stack_distances[stack_top] <= t_max * BOX_SLACK;
    return select(NOTHING, stack_codes[stack_top], is_near);
}

fn is_done(next: u32, bottom: u32) -> bool { return next == NOTHING && stack_top <= bottom; }

// Go down from a child to the nearest leaf, over those on the stack where there is none; NOTHING when all are done.
//
// Rays that have found theirs wait here for their neighbours: leaves are then tested together. Those that have to take
// from the stack more than once do so while others go down.
fn descend(start: u32, bottom: u32, ray: Ray, t_max: f32, occlusion: bool, counts: ptr<function, Counts>) -> u32 {
    var next = start;
    loop {
        if (next & LEAF) == 0u {
            (*counts).nodes++;
            next = push_children(next, ray, t_max, occlusion);
        }
        if next == NOTHING { next = pop(bottom, t_max, occlusion); }
        continuing { break if (next != NOTHING && (next & LEAF) != 0u) || is_done(next, bottom); }
    }
    return next;
}

// Find the closest hit in one mesh, or return whether there is any.
fn walk_mesh(root: u32, inst: u32, ray: Ray, hit: ptr<function, Hit>, occlusion: bool,
             counts: ptr<function, Counts>) -> bool {
    let bottom = stack_top;
    var next = root;
    var blocked = false;
    loop {
        next = descend(next, bottom, ray, (*hit).t, occlusion, counts);
        if next != NOTHING {
            (*counts).blocks++;
            blocked = triangle_leaf(inst, next & ~LEAF, ray, hit, occlusion);
            next = pop(bottom, (*hit).t, occlusion);
        }
        continuing { break if blocked || is_done(next, bottom); }
    }
    return blocked;
}

// Return a ray in the space of a placement's mesh. Directions keep their length there, so t stays the same.
fn in_space_of(record: u32, ray: Ray) -> Ray {
    let x = bitcast<vec4<f32>>(blocks[record]);
    let y = bitcast<vec4<f32>>(blocks[record + 1u]);
    let z = bitcast<vec4<f32>>(blocks[record + 2u]);
    let origin = vec3(dot(x.xyz, ray.origin), dot(y.xyz, ray.origin), dot(z.xyz, ray.origin)) + vec3(x.w, y.w, z.w);
    return set_up(origin, vec3(dot(x.xyz, ray.direction), dot(y.xyz, ray.direction), dot(z.xyz, ray.direction)));
}

// Test one instance by its placement: a sphere, or a mesh in its own space.
fn enter_instance(record: u32, ray: Ray, hit: ptr<function, Hit>, occlusion: bool,
                  counts: ptr<function, Counts>) -> bool {
    (*counts).instances++;
    let what = blocks[record + PLACEMENT_inst / 4u];
    if what.z == SPHERE_KIND { return sphere_hit(what.x, record, ray, hit, occlusion); }
    return walk_mesh(what.y, what.x, in_space_of(record, ray), hit, occlusion, counts);
}

fn placement(number: u32) -> u32 { return frame_int(FRAME_placements) / 4u + number * (PLACEMENT_words / 4u); }

// Return how many triangles a leaf block holds: unused places, the last ones, have no primitive.
fn triangles_in(block: u32) -> u32 {
    let prims = bitcast<vec4<i32>>(blocks[(block * TRIANGLE_BLOCK_words + TRIANGLE_BLOCK_prim) / 4u]);
    return dot(select(vec4(0u), vec4(1u), prims >= vec4(0)), vec4(1u));
}

// Test every sphere and every triangle, one after the other, as if there were no trees.
fn test_everything(ray: Ray, hit: ptr<function, Hit>, occlusion: bool, counts: ptr<function, Counts>) -> bool {
    var blocked = false;
    for (var number = 0u; number < frame_int(FRAME_placement_count) && !blocked; number++) {
        (*counts).instances++;
        let record = placement(number);
        let what = blocks[record + PLACEMENT_inst / 4u];
        if what.z == SPHERE_KIND {
            blocked = sphere_hit(what.x, record, ray, hit, occlusion);
            continue;
        }
        let own = in_space_of(record, ray);
        let span = frame_int(FRAME_spans) + what.x * SPAN_words;
        let first = records[span + SPAN_first_block];
        let end = first + records[span + SPAN_blocks];
        for (var block = first; block < end && !blocked; block++) {
            (*counts).blocks++;
            blocked = triangle_leaf(what.x, block * LEAF_STEP + triangles_in(block), own, hit, occlusion);
        }
    }
    return blocked;
}

fn walk_scene(ray: Ray, hit: ptr<function, Hit>, occlusion: bool, counts: ptr<function, Counts>) -> bool {
    if WALK == WALK_WITHOUT_TREES { return test_everything(ray, hit, occlusion, counts); }
    stack_top = 0u;
    if WALK == WALK_OF_ONE { return enter_instance(placement(0u), ray, hit, occlusion, counts); }
    var next = frame_int(FRAME_scene_root);
    var blocked = false;
    loop {
        next = descend(next, 0u, ray, (*hit).t, occlusion, counts);
        if next != NOTHING {
            if next % LEAF_STEP != 0u {
                blocked = enter_instance(placement((next & ~LEAF) / LEAF_STEP), ray, hit, occlusion, counts);
            }
            next = pop(0u, (*hit).t, occlusion);
        }
        continuing { break if blocked || is_done(next, 0u); }
    }
    return blocked;
}

fn closest_hit(origin: vec3<f32>, direction: vec3<f32>, t_max: f32, counts: ptr<function, Counts>) -> Hit {
    var hit = no_hit(t_max);
    _ = walk_scene(set_up(origin, direction), &hit, false, counts);
    return hit;
}

fn occluded(origin: vec3<f32>, direction: vec3<f32>, t_max: f32, counts: ptr<function, Counts>) -> bool {
    var hit = no_hit(t_max);
    return walk_scene(set_up(origin, direction), &hit, true, counts);
}
