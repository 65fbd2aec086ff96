// Rays down the trees: compressed nodes of eight children, 80 bytes each (Ylitie, Karras, Laine, "Efficient incoherent ray
// traversal on GPUs through compressed wide BVHs", 2017). What differs: children go on the stack one by one, sorted by
// distance, and are dropped when something nearer has been found by then, which saves a quarter of the bytes read.

struct Counts { nodes: u32, blocks: u32, instances: u32 }

// Of a child: a node, or a leaf by its number of blocks * LEAF_STEP + triangles; or that there is none.
const LEAF = 0x80000000u;
const NOTHING = 0xffffffffu;

var<private> stack_codes: array<u32, TREE_STACK>;
var<private> stack_distances: array<f32, TREE_STACK>;
var<private> stack_top: u32;

fn bytes_of(word: u32) -> vec4<f32> { return vec4<f32>((vec4(word) >> vec4(0u, 8u, 16u, 24u)) & vec4(255u)); }

fn exponent_scale(packed: u32, axis: u32) -> f32 {
    return bitcast<f32>(u32(extractBits(bitcast<i32>(packed), 8u * axis, 8u) + 127) << 23u);
}

// Return the distances of four boxes as integers, a slot in the lowest bits of each; NOTHING for those that are not met.
// Planes are bytes as the ray comes to them.
fn meet(near: vec3<u32>, far: vec3<u32>, kinds: u32, slots: vec4<u32>, scale: vec3<f32>, near_add: vec3<f32>,
        far_add: vec3<f32>, t_max: f32) -> vec4<u32> {
    let enter = max(max(bytes_of(near.x) * scale.x + near_add.x, bytes_of(near.y) * scale.y + near_add.y),
                    max(bytes_of(near.z) * scale.z + near_add.z, vec4(0.0)));
    let leave = min(min(bytes_of(far.x) * scale.x + far_add.x, bytes_of(far.y) * scale.y + far_add.y),
                    bytes_of(far.z) * scale.z + far_add.z);
    let is_there = (vec4(kinds) & (vec4(255u) << vec4(0u, 8u, 16u, 24u))) != vec4(0u);
    let met = is_there & (enter <= min(leave, vec4(t_max)) * BOX_SLACK);
    return select(vec4(NOTHING), (bitcast<vec4<u32>>(enter) & vec4(~7u)) | slots, met);
}

fn least(a: vec4<u32>, b: vec4<u32>) -> u32 {
    let c = min(a, b);
    return min(min(c.x, c.y), min(c.z, c.w));
}

// Return the code of the child that a key of `meet` stands for.
fn child(key: u32, kinds: vec2<u32>, bases: vec2<u32>) -> u32 {
    let kind = (select(kinds.x, kinds.y, (key & 4u) != 0u) >> (8u * (key & 3u))) & 255u;
    return (kind & 63u) + select(bases.x, bases.y | LEAF, (kind & LEAF_META) != 0u);
}

// Put the children of a node that a ray meets on the stack, the nearest on top but for the very nearest, which is
// returned.
fn push_children(code: u32, ray: Ray, t_max: f32) -> u32 {
    let base = code * COMPRESSED_NODE_words;
    let packed = nodes[base + COMPRESSED_NODE_exponents];
    let scale = vec3(exponent_scale(packed, 0u), exponent_scale(packed, 1u), exponent_scale(packed, 2u)) * ray.inverse;
    let origin = vec3(bitcast<f32>(nodes[base]), bitcast<f32>(nodes[base + 1u]), bitcast<f32>(nodes[base + 2u]));
    let offset = (origin - ray.origin) * ray.inverse;
    // Wider by a thousandth of a cell than the box, which is more than the sums above round off.
    let pad = ray.pad + abs(scale) * 0.001;
    let kinds = vec2(nodes[base + COMPRESSED_NODE_meta], nodes[base + COMPRESSED_NODE_meta + 1u]);
    let bases = vec2(nodes[base + COMPRESSED_NODE_child_base], nodes[base + COMPRESSED_NODE_block_base] * LEAF_STEP);
    let down = ray.inverse < vec3(0.0);
    let lo = base + vec3(COMPRESSED_NODE_lo_x, COMPRESSED_NODE_lo_y, COMPRESSED_NODE_lo_z);
    let hi = base + vec3(COMPRESSED_NODE_hi_x, COMPRESSED_NODE_hi_y, COMPRESSED_NODE_hi_z);
    let n = select(lo, hi, down);
    let f = select(hi, lo, down);
    var low = meet(vec3(nodes[n.x], nodes[n.y], nodes[n.z]), vec3(nodes[f.x], nodes[f.y], nodes[f.z]), kinds.x,
                   vec4(0u, 1u, 2u, 3u), scale, offset - pad, offset + pad, t_max);
    var high = meet(vec3(nodes[n.x + 1u], nodes[n.y + 1u], nodes[n.z + 1u]),
                    vec3(nodes[f.x + 1u], nodes[f.y + 1u], nodes[f.z + 1u]), kinds.y,
                    vec4(4u, 5u, 6u, 7u), scale, offset - pad, offset + pad, t_max);
    let nearest = least(low, high);
    if nearest == NOTHING { return NOTHING; }
    let missed = select(vec4(0u), vec4(1u), low == vec4(NOTHING)) + select(vec4(0u), vec4(1u), high == vec4(NOTHING));
    stack_top += 7u - (missed.x + missed.y + missed.z + missed.w);
    var place = stack_top;
    var key = nearest;
    loop {
        low = select(low, vec4(NOTHING), low == vec4(key));
        high = select(high, vec4(NOTHING), high == vec4(key));
        key = least(low, high);
        if key != NOTHING {
            place--;
            stack_distances[place] = bitcast<f32>(key & ~7u);
            stack_codes[place] = child(key, kinds, bases);
        }
        continuing { break if key == NOTHING; }
    }
    return child(nearest, kinds, bases);
}

// Return the next child from the stack that is near enough, NOTHING when there is none above `bottom`.
fn pop(bottom: u32, t_max: f32) -> u32 {
    while stack_top > bottom {
        stack_top--;
        if stack_distances[stack_top] <= t_max * BOX_SLACK { return stack_codes[stack_top]; }
    }
    return NOTHING;
}

// Go down from a child to the nearest leaf, over those on the stack where there is none; NOTHING when all are done.
//
// Rays that have found theirs wait here for their neighbours: leaves are then tested together.
fn descend(start: u32, bottom: u32, ray: Ray, t_max: f32, counts: ptr<function, Counts>) -> u32 {
    var next = start;
    loop {
        if (next & LEAF) == 0u {
            (*counts).nodes++;
            next = push_children(next, ray, t_max);
            if next == NOTHING { next = pop(bottom, t_max); }
        }
        continuing { break if (next & LEAF) != 0u; }
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
        next = descend(next, bottom, ray, (*hit).t, counts);
        if next != NOTHING {
            (*counts).blocks++;
            blocked = triangle_leaf(inst, next & ~LEAF, ray, hit, occlusion);
            next = pop(bottom, (*hit).t);
        }
        continuing { break if blocked || next == NOTHING; }
    }
    return blocked;
}

// Return a ray in the space of an instance's mesh. Directions keep their length there, so t stays the same.
fn in_space_of(record: u32, ray: Ray) -> Ray {
    if records[record + INSTANCE_identity] != 0u { return ray; }
    let at = record + INSTANCE_world_to_object;
    let x = record_vector(at);
    let y = record_vector(at + 4u);
    let z = record_vector(at + 8u);
    let shift = vec3(record_float(at + 3u), record_float(at + 7u), record_float(at + 11u));
    let origin = vec3(dot(x, ray.origin), dot(y, ray.origin), dot(z, ray.origin)) + shift;
    return set_up(origin, vec3(dot(x, ray.direction), dot(y, ray.direction), dot(z, ray.direction)));
}

// Test one instance: a sphere, or a mesh in its own space.
fn enter_instance(inst: u32, ray: Ray, hit: ptr<function, Hit>, occlusion: bool,
                  counts: ptr<function, Counts>) -> bool {
    (*counts).instances++;
    let record = frame_int(FRAME_instances) + inst * INSTANCE_words;
    if records[record + INSTANCE_kind] == SPHERE_KIND { return sphere_hit(inst, record, ray, hit, occlusion); }
    return walk_mesh(records[record + INSTANCE_root], inst, in_space_of(record, ray), hit, occlusion, counts);
}

// Return how many triangles a leaf block holds: unused places, the last ones, have no primitive.
fn triangles_in(block: u32) -> u32 {
    let prims = block * TRIANGLE_BLOCK_words + TRIANGLE_BLOCK_prim;
    var count = 0u;
    for (var j = 0u; j < 4u; j++) { count += select(0u, 1u, bitcast<i32>(blocks[prims + j]) >= 0); }
    return count;
}

// Test every sphere and every triangle, one after the other, as if there were no trees.
fn test_everything(ray: Ray, hit: ptr<function, Hit>, occlusion: bool, counts: ptr<function, Counts>) -> bool {
    var blocked = false;
    for (var inst = 0u; inst < frame_int(FRAME_span_count) && !blocked; inst++) {
        (*counts).instances++;
        let record = frame_int(FRAME_instances) + inst * INSTANCE_words;
        if records[record + INSTANCE_kind] == SPHERE_KIND {
            blocked = sphere_hit(inst, record, ray, hit, occlusion);
            continue;
        }
        let own = in_space_of(record, ray);
        let span = frame_int(FRAME_spans) + inst * SPAN_words;
        let first = records[span + SPAN_first_block];
        let end = first + records[span + SPAN_blocks];
        for (var block = first; block < end && !blocked; block++) {
            (*counts).blocks++;
            blocked = triangle_leaf(inst, block * LEAF_STEP + triangles_in(block), own, hit, occlusion);
        }
    }
    return blocked;
}

fn walk_scene(ray: Ray, hit: ptr<function, Hit>, occlusion: bool, counts: ptr<function, Counts>) -> bool {
    if frame_int(FRAME_span_count) > 0u { return test_everything(ray, hit, occlusion, counts); }
    stack_top = 0u;
    var next = frame_int(FRAME_scene_root);
    var blocked = false;
    loop {
        next = descend(next, 0u, ray, (*hit).t, counts);
        if next != NOTHING {
            let inst = blocks[frame_int(FRAME_scene_leaves) + (next & ~LEAF) / LEAF_STEP];
            blocked = enter_instance(inst, ray, hit, occlusion, counts);
            next = pop(0u, (*hit).t);
        }
        continuing { break if blocked || next == NOTHING; }
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
