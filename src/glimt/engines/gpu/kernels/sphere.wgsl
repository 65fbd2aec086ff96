// Spheres against a ray, in world space.

// Haines et al., "Precision improvements for ray/sphere intersection" (Ray Tracing Gems, 2019): the discriminant comes
// from the distance between the centre and the line. Directions need not be of unit length.
fn sphere_hit(inst: u32, record: u32, ray: Ray, hit: ptr<function, Hit>, occlusion: bool) -> bool {
    let sphere = bitcast<vec4<f32>>(blocks[record]);
    let radius = sphere.w;
    let to_center = sphere.xyz - ray.origin;
    let inverse = 1.0 / dot(ray.direction, ray.direction);
    let nearest = dot(to_center, ray.direction) * inverse;
    let beside = to_center - ray.direction * nearest;
    let discriminant = radius * radius - dot(beside, beside);
    if discriminant < 0.0 { return false; }
    let half_chord = sqrt(discriminant * inverse);
    let enter = nearest - half_chord;
    let t = select(nearest + half_chord, enter, enter > 0.0);
    if occlusion { return t > 0.0 && t < (*hit).t; }
    if closer(*hit, t, inst, 0u) { *hit = Hit(t, 0.0, 0.0, 0u, inst); }
    return false;
}
