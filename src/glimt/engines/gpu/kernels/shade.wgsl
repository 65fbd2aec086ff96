// Stage 3: hits to light: every light, with its shadow ray.

// Return how much of the light survives where the shading normal sees it but the surface hardly does.
//
// Chiang, Li, Burley, "Taming the shadow terminator" (2019): 1 wherever both normals agree, and a smooth way to 0 where
// the geometric one turns away, instead of a hard edge.
fn terminator(ng: vec3<f32>, ns: vec3<f32>, wi: vec3<f32>) -> f32 {
    let agreement = max(dot(ns, wi) * dot(ng, ns), 1e-6);
    let g = dot(ng, wi) / agreement;
    if g >= 1.0 { return 1.0; }
    return select(0.0, ((1.0 - g) * g + 1.0) * g, g > 0.0);
}

@compute @workgroup_size(GROUP_WIDTH, GROUP_HEIGHT)
fn shade(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
         @builtin(local_invocation_index) local: u32) {
    let number = path_number(group, groups, local);
    if number >= atomicLoad(&counters[COUNTER_paths + frame_int(FRAME_depth)]) { return; }
    let at = path_record(number, frame_int(FRAME_half));
    let path = path_at(at);
    if path.pixel == NOBODY { return; }
    let found = paths[at + PATH_HIT];
    let hit = Hit(path.t, bitcast<f32>(found.x), bitcast<f32>(found.y), found.z, found.w);
    let share = bitcast<vec4<f32>>(paths[at + PATH_SHARE]);
    let throughput = share.x;
    if hit.inst == MISS {
        add_to_pixel(path.pixel, frame_vector(FRAME_view + VIEW_background) * throughput);
        store_share(at, 0.0, 0.0, 0.0);
        return;
    }
    let direction = path.direction;
    let travelled = share.y + hit.t;
    let surface = surface_at(hit, path.origin, direction);
    let material = material_at(surface, direction, travelled * frame_float(FRAME_spread));
    let start = above(surface);
    var shadow_rays = 0u;
    var lit = material.ambient * frame_vector(FRAME_view + VIEW_ambient);
    for (var index = 0u; index < frame_int(FRAME_light_count); index++) {
        let light = light_sample(index, surface.point, start);
        let cosine = dot(material.ns, light.wi);
        let arriving = light.attenuation * terminator(surface.ng, material.ns, light.wi);
        if cosine <= 0.0 || arriving <= 0.0 { continue; }
        var counts = Counts(0u, 0u, 0u);
        let blocked = occluded(start, light.reach, light.t_max, &counts);
        count_visits(1u, counts);
        shadow_rays++;
        if blocked { continue; }
        let sent = material_eval(material.diffuse, material.specular, material.exponent, material.ns, -direction,
                                 light.wi, cosine);
        let record = frame_int(FRAME_lights) + index * LIGHT_words;
        lit += (sent.diffuse * record_vector(record + LIGHT_diffuse)
                + sent.specular * record_vector(record + LIGHT_specular)) * arriving;
    }
    if shadow_rays > 0u { atomicAdd(&counters[COUNTER_shadow], shadow_rays); }
    let is_last = frame_int(FRAME_depth) == frame_int(FRAME_max_bounces);
    let reflectivity = select(material.reflectivity, 0.0, is_last);  // the last surface shows itself only
    add_to_pixel(path.pixel, lit * (throughput * (1.0 - reflectivity)));

    // What the mirror ray needs.
    store_path(at, Path(start, FAR, mirror_direction(direction, surface.ng, material.ns), path.pixel));
    store_share(at, throughput, travelled, reflectivity);
}
