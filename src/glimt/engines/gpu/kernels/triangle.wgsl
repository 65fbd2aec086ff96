// Triangles against a ray, watertight: the four of a leaf block at once.

struct Corners { x: vec4<f32>, y: vec4<f32>, z: vec4<f32> }

fn least(a: vec4<u32>) -> u32 { return min(min(a.x, a.y), min(a.z, a.w)); }

// Return a corner of each, relative to the origin, turned and sheared so that the ray is the z axis; z not yet scaled.
fn corner(at: u32, ray: Ray) -> Corners {
    let x = select(ray.axis + 1u, 0u, ray.axis == 2u);
    let y = 3u - ray.axis - x;
    let p = Corners(bitcast<vec4<f32>>(blocks[at + x]) - ray.shear_origin.x,
                    bitcast<vec4<f32>>(blocks[at + y]) - ray.shear_origin.y,
                    bitcast<vec4<f32>>(blocks[at + ray.axis]) - ray.shear_origin.z);
    return Corners(fma(vec4(-ray.shear.x), p.z, p.x), fma(vec4(-ray.shear.y), p.z, p.y), p.z);
}

// Return twice p.x q.y - p.y q.x; for q and p the very opposite, so that no ray passes between triangles.
//
// WGSL lets drivers fuse one product into the difference: then neither order of p and q need be positive. Here both
// orders are taken, and what is fused already cannot be fused otherwise.
fn edge(p: Corners, q: Corners) -> vec4<f32> {
    return fma(p.x, q.y, -(p.y * q.x)) - fma(p.y, q.x, -(p.x * q.y));
}

struct Edges { wa: vec4<f32>, wb: vec4<f32>, wc: vec4<f32>, inside: vec4<bool> }

// Return the edge functions of corners seen along a ray, and where none is on another side than the rest.
fn edges(a: Corners, b: Corners, c: Corners) -> Edges {
    let wa = edge(c, b);
    let wb = edge(a, c);
    let wc = edge(b, a);
    let zero = vec4(0.0);  // comparing them all is less than taking their minimum and maximum
    return Edges(wa, wb, wc,
                 ((wa >= zero) & (wb >= zero) & (wc >= zero)) | ((wa <= zero) & (wb <= zero) & (wc <= zero)));
}

// Return where a ray, which is at 0, passes between the least and the greatest coordinates of corners.
fn within(a: Corners, b: Corners, c: Corners) -> vec4<bool> {
    let zero = vec4(0.0);
    return ((a.x <= zero) | (b.x <= zero) | (c.x <= zero)) & ((a.x >= zero) | (b.x >= zero) | (c.x >= zero))
         & ((a.y <= zero) | (b.y <= zero) | (c.y <= zero)) & ((a.y >= zero) | (b.y >= zero) | (c.y >= zero));
}

struct Meeting { t: vec4<f32>, u: vec4<f32>, v: vec4<f32>, anywhere: vec4<bool> }

// Return where a ray meets the planes of triangles, by edge functions and the z of their corners; nowhere if edge-on.
fn meeting(wa: vec4<f32>, wb: vec4<f32>, wc: vec4<f32>, za: vec4<f32>, zb: vec4<f32>, zc: vec4<f32>,
           shear_z: f32) -> Meeting {
    let sum = wa + wb + wc;
    let scale = 1.0 / sum;
    let u = wb * scale;
    let v = wc * scale;
    return Meeting(fma(wa * scale, za, fma(u, zb, v * zc)) * shear_z, u, v, sum != vec4(0.0));
}

// Test the triangles of a leaf block; return whether one blocks the ray, if that is all that is asked.
fn triangle_leaf(inst: u32, code: u32, ray: Ray, hit: ptr<function, Hit>, occlusion: bool) -> bool {
    let base = code / LEAF_STEP * (TRIANGLE_BLOCK_words / 4u);
    let a = corner(base + TRIANGLE_BLOCK_x0 / 4u, ray);
    let b = corner(base + TRIANGLE_BLOCK_x1 / 4u, ray);
    let c = corner(base + TRIANGLE_BLOCK_x2 / 4u, ray);
    let w = edges(a, b, c);
    let met = meeting(w.wa, w.wb, w.wc, a.z, b.z, c.z, ray.shear.z);
    let found = w.inside & within(a, b, c) & met.anywhere & (met.t > vec4(0.0))
        & (vec4(0u, 1u, 2u, 3u) < vec4(code % LEAF_STEP));
    let t = select(vec4(FAR), met.t, found);
    let nearest = min(min(t.x, t.y), min(t.z, t.w));
    if occlusion { return nearest < (*hit).t; }
    let prims = select(vec4(MISS), blocks[base + TRIANGLE_BLOCK_prim / 4u], found & (t == vec4(nearest)));
    let prim = least(prims);
    if prim != MISS && closer(*hit, nearest, inst, prim) {
        let others = prims != vec4(prim);  // whose u and v may be anything
        let one = vec4(1.0);
        *hit = Hit(nearest, dot(select(met.u, vec4(0.0), others), one), dot(select(met.v, vec4(0.0), others), one),
                   prim, inst);
    }
    return false;
}
