// Triangles against a ray, watertight.

// Return a corner relative to the origin, turned and sheared so that the ray is the z axis; z not yet scaled.
fn corner(at: u32, ray: Ray) -> vec3<f32> {
    let p = permute(ray.axis, vec3(bitcast<f32>(blocks[at]), bitcast<f32>(blocks[at + LEAF_SIZE]),
                                   bitcast<f32>(blocks[at + 2u * LEAF_SIZE]))) - ray.shear_origin;
    return vec3(fma(-ray.shear.x, p.z, p.x), fma(-ray.shear.y, p.z, p.y), p.z);
}

// Return twice p.x q.y - p.y q.x; for q and p the very opposite, so that no ray passes between triangles.
//
// WGSL lets drivers fuse one product into the difference: then neither order of p and q need be positive. Here both
// orders are taken, and what is fused already cannot be fused otherwise.
fn edge(p: vec3<f32>, q: vec3<f32>) -> f32 {
    return fma(p.x, q.y, -(p.y * q.x)) - fma(p.y, q.x, -(p.x * q.y));
}

struct Edges { wa: f32, wb: f32, wc: f32, inside: bool }

// Return the edge functions of corners seen along a ray, and whether none is on another side than the rest.
fn edges(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> Edges {
    let wa = edge(c, b);
    let wb = edge(a, c);
    let wc = edge(b, a);
    return Edges(wa, wb, wc, min(wa, min(wb, wc)) >= 0.0 || max(wa, max(wb, wc)) <= 0.0);
}

// Return whether a ray, which is at 0, passes between the least and the greatest of three coordinates.
fn within(a: f32, b: f32, c: f32) -> bool { return min(a, min(b, c)) <= 0.0 && max(a, max(b, c)) >= 0.0; }

struct Meeting { t: f32, u: f32, v: f32, inside: bool }

// Return where a ray meets the plane of a triangle, and whether that can be inside: never for an edge-on one.
fn meeting(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, wa: f32, wb: f32, wc: f32, shear_z: f32) -> Meeting {
    let sum = wa + wb + wc;
    let scale = 1.0 / sum;
    let u = wb * scale;
    let v = wc * scale;
    let t = fma(wa * scale, a.z, fma(u, b.z, v * c.z)) * shear_z;
    return Meeting(t, u, v, sum != 0.0 && within(a.x, b.x, c.x) && within(a.y, b.y, c.y));
}

// Test the triangles of a leaf block; return whether one blocks the ray, if that is all that is asked.
fn triangle_leaf(inst: u32, code: u32, ray: Ray, hit: ptr<function, Hit>, occlusion: bool) -> bool {
    let base = code / LEAF_STEP * TRIANGLE_BLOCK_words;
    var j = 0u;
    var blocked = false;
    loop {
        let a = corner(base + TRIANGLE_BLOCK_x0 + j, ray);
        let b = corner(base + TRIANGLE_BLOCK_x1 + j, ray);
        let c = corner(base + TRIANGLE_BLOCK_x2 + j, ray);
        let w = edges(a, b, c);
        if w.inside {
            let met = meeting(a, b, c, w.wa, w.wb, w.wc, ray.shear.z);
            let prim = blocks[base + TRIANGLE_BLOCK_prim + j];
            if occlusion {
                blocked = met.inside && met.t > 0.0 && met.t < (*hit).t;
            } else if met.inside && closer(*hit, met.t, inst, prim) {
                *hit = Hit(met.t, met.u, met.v, prim, inst);
            }
        }
        j++;
        continuing { break if blocked || j == code % LEAF_STEP; }
    }
    return blocked;
}
