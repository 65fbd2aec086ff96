// Triangles against a ray, watertight.

// Return a corner relative to the origin, turned and sheared so that the ray is the z axis; z not yet scaled.
fn corner(at: u32, ray: Ray) -> vec3<f32> {
    let p = permute(ray.axis, vec3(bitcast<f32>(blocks[at]), bitcast<f32>(blocks[at + LEAF_SIZE]),
                                   bitcast<f32>(blocks[at + 2u * LEAF_SIZE]))) - ray.shear_origin;
    return vec3(fma(-ray.shear.x, p.z, p.x), fma(-ray.shear.y, p.z, p.y), p.z);
}

fn edge(p: vec3<f32>, q: vec3<f32>) -> f32 {
    let above = p.x * q.y;
    let below = p.y * q.x;
    return above - below;
}

// Return whether a ray, which is at 0, passes between the least and the greatest of three coordinates.
fn within(a: f32, b: f32, c: f32) -> bool { return min(a, min(b, c)) <= 0.0 && max(a, max(b, c)) >= 0.0; }

// Test the triangles of a leaf block; return whether one blocks the ray, if that is all that is asked.
fn triangle_leaf(block: u32, count: u32, inst: u32, ray: Ray, hit: ptr<function, Hit>, occlusion: bool) -> bool {
    let base = block * TRIANGLE_BLOCK_words;
    for (var j = 0u; j < count; j++) {
        let a = corner(base + TRIANGLE_BLOCK_x0 + j, ray);
        let b = corner(base + TRIANGLE_BLOCK_x1 + j, ray);
        let c = corner(base + TRIANGLE_BLOCK_x2 + j, ray);
        let wa = edge(c, b);
        let wb = edge(a, c);
        let wc = edge(b, a);
        let sum = wa + wb + wc;
        if (min(wa, min(wb, wc)) < 0.0 && max(wa, max(wb, wc)) > 0.0) || sum == 0.0
            || !within(a.x, b.x, c.x) || !within(a.y, b.y, c.y) {
            continue;
        }
        let scale = 1.0 / sum;
        let u = wb * scale;
        let v = wc * scale;
        let t = fma(wa * scale, a.z, fma(u, b.z, v * c.z)) * ray.shear.z;
        let prim = blocks[base + TRIANGLE_BLOCK_prim + j];
        if occlusion {
            if t > 0.0 && t < (*hit).t { return true; }
        } else if closer(*hit, t, inst, prim) {
            *hit = Hit(t, u, v, prim, inst);
        }
    }
    return false;
}
