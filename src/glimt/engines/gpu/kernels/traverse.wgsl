// Rays down the trees: compressed nodes of eight children, 80 bytes each (Ylitie, Karras, Laine, "Efficient incoherent ray
// traversal on GPUs through compressed wide BVHs", 2017). What differs: children go on the stack one by one, sorted by
// distance, and are dropped when something nearer has been found by then, which saves a quarter of the bytes read.

struct Counts { nodes: u32, blocks: u32, instances: u32 }

// Of children on the stack: a node, or a leaf by its number of blocks * LEAF_STEP + triangles.
const LEAF = 0x80000000u;

var<private> stack_codes: array<u32, TREE_STACK>;
var<private> stack_distances: array<f32, TREE_STACK>;

fn byte_of(word: u32, slot: u32) -> f32 { return f32((word >> (8u * slot)) & 255u); }

fn exponent_scale(packed: u32, axis: u32) -> f32 {
    return bitcast<f32>(u32(extractBits(bitcast<i32>(packed), 8u * axis, 8u) + 127) << 23u);
}

// Put the children of a node that a ray meets on the stack, the nearest on top; return the new top.
fn push_children(code: u32, ray: Ray, t_max: f32, bottom: u32) -> u32 {
    let base = code * COMPRESSED_NODE_words;
    let packed = nodes[base + COMPRESSED_NODE_exponents];
    let scale = vec3(exponent_scale(packed, 0u), exponent_scale(packed, 1u), exponent_scale(packed, 2u)) * ray.inverse;
    let origin = vec3(bitcast<f32>(nodes[base]), bitcast<f32>(nodes[base + 1u]), bitcast<f32>(nodes[base + 2u]));
    let offset = (origin - ray.origin) * ray.inverse;
    // Wider by a thousandth of a cell than the box, which is more than the sums below round off.
    let pad = ray.pad + abs(scale) * 0.001;
    let near_add = offset - pad;
    let far_add = offset + pad;
    let swap = ray.inverse < vec3(0.0);
    var top = bottom;
    for (var half = 0u; half < 2u; half++) {
        let kinds = nodes[base + COMPRESSED_NODE_meta + half];
        if kinds == 0u { continue; }
        let at = base + COMPRESSED_NODE_lo_x + half;
        let lo = vec3(nodes[at], nodes[at + 2u], nodes[at + 4u]);
        let hi = vec3(nodes[at + 6u], nodes[at + 8u], nodes[at + 10u]);
        let near_planes = select(lo, hi, swap);
        let far_planes = select(hi, lo, swap);
        for (var k = 0u; k < 4u; k++) {
            let kind = (kinds >> (8u * k)) & 255u;
            if kind == 0u { continue; }
            let enter3 = vec3(byte_of(near_planes.x, k), byte_of(near_planes.y, k), byte_of(near_planes.z, k)) * scale
                + near_add;
            let leave3 = vec3(byte_of(far_planes.x, k), byte_of(far_planes.y, k), byte_of(far_planes.z, k)) * scale
                + far_add;
            let enter = max(max(enter3.x, enter3.y), max(enter3.z, 0.0));
            let leave = min(min(leave3.x, leave3.y), leave3.z);
            if enter > leave * BOX_SLACK || enter > t_max * BOX_SLACK { continue; }
            var child = nodes[base + COMPRESSED_NODE_child_base] + (kind & 63u);
            if (kind & LEAF_META) != 0u {
                child = LEAF | (nodes[base + COMPRESSED_NODE_block_base] * LEAF_STEP + (kind & 63u));
            }
            var place = top;
            while place > bottom && stack_distances[place - 1u] < enter {
                stack_distances[place] = stack_distances[place - 1u];
                stack_codes[place] = stack_codes[place - 1u];
                place--;
            }
            stack_distances[place] = enter;
            stack_codes[place] = child;
            top++;
        }
    }
    return top;
}

// Find the closest hit in one mesh, or return whether there is any. The stack above `bottom` is free.
fn walk_mesh(root: u32, inst: u32, ray: Ray, hit: ptr<function, Hit>, occlusion: bool, bottom: u32,
             counts: ptr<function, Counts>) -> bool {
    (*counts).nodes++;
    var top = push_children(root, ray, (*hit).t, bottom);
    while top > bottom {
        top--;
        let code = stack_codes[top];
        if stack_distances[top] > (*hit).t * BOX_SLACK { continue; }
        if (code & LEAF) != 0u {
            (*counts).blocks++;
            if triangle_leaf(inst, code & ~LEAF, ray, hit, occlusion) { return true; }
        } else {
            (*counts).nodes++;
            top = push_children(code, ray, (*hit).t, top);
        }
    }
    return false;
}

// Test one instance: a sphere, or a mesh in its own space. Directions keep their length there, so t stays the same.
fn enter_instance(inst: u32, ray: Ray, hit: ptr<function, Hit>, occlusion: bool, bottom: u32,
                  counts: ptr<function, Counts>) -> bool {
    (*counts).instances++;
    let record = frame_int(FRAME_instances) + inst * INSTANCE_words;
    if records[record + INSTANCE_kind] == SPHERE_KIND { return sphere_hit(inst, record, ray, hit, occlusion); }
    let root = records[record + INSTANCE_root];
    if records[record + INSTANCE_identity] != 0u { return walk_mesh(root, inst, ray, hit, occlusion, bottom, counts); }
    let at = record + INSTANCE_world_to_object;
    let x = record_vector(at);
    let y = record_vector(at + 4u);
    let z = record_vector(at + 8u);
    let shift = vec3(record_float(at + 3u), record_float(at + 7u), record_float(at + 11u));
    let origin = vec3(dot(x, ray.origin), dot(y, ray.origin), dot(z, ray.origin)) + shift;
    let direction = vec3(dot(x, ray.direction), dot(y, ray.direction), dot(z, ray.direction));
    return walk_mesh(root, inst, set_up(origin, direction), hit, occlusion, bottom, counts);
}

fn walk_scene(ray: Ray, hit: ptr<function, Hit>, occlusion: bool, counts: ptr<function, Counts>) -> bool {
    (*counts).nodes++;
    var top = push_children(frame_int(FRAME_scene_root), ray, (*hit).t, 0u);
    while top > 0u {
        top--;
        let code = stack_codes[top];
        if stack_distances[top] > (*hit).t * BOX_SLACK { continue; }
        if (code & LEAF) != 0u {
            let inst = blocks[frame_int(FRAME_scene_leaves) + (code & ~LEAF) / LEAF_STEP];
            if enter_instance(inst, ray, hit, occlusion, top, counts) { return true; }
        } else {
            (*counts).nodes++;
            top = push_children(code, ray, (*hit).t, top);
        }
    }
    return false;
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
