// Mirror rays.

const LEAST_RISE = 1e-3;  // the least cosine between a mirror ray and the geometric normal

// Return the direction of the mirror ray; one that a shading normal would send below the surface grazes it.
fn mirror_direction(direction: vec3<f32>, ng: vec3<f32>, ns: vec3<f32>) -> vec3<f32> {
    let mirrored = direction - ns * (2.0 * dot(direction, ns));
    let rise = dot(mirrored, ng);
    if rise >= LEAST_RISE { return mirrored; }
    return normalize(mirrored + ng * (LEAST_RISE - rise));
}
