// Materials: parameters at a surface point, and the light they reflect.

const GRAZING = 0.02;  // the least cosine between a shading normal and the way back to the viewer

struct Material {
    ambient: vec3<f32>,
    diffuse: vec3<f32>,
    specular: vec3<f32>,
    exponent: f32,
    reflectivity: f32,
    ns: vec3<f32>,
}

// Return a shading normal, turned towards the viewer where it points away (mapped ones may, and go black).
fn bend(ns: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    let cosine = dot(ns, wo);
    if cosine >= GRAZING { return ns; }
    return normalize(ns + wo * (GRAZING - cosine));
}

fn mapped_normal(texture: u32, surface: Surface, footprint: f32, strength: f32) -> vec3<f32> {
    let n = sample_texture(texture, surface.texcoord, footprint, false) * 2.0 - 1.0;
    let mapped = surface.tangent * (n.x * strength) + surface.bitangent * (n.y * strength) + surface.normal * n.z;
    let squared = dot(mapped, mapped);
    if squared > 1e-12 { return mapped * inverseSqrt(squared); }
    return surface.normal;
}

// Return the material at a surface point. `cone_width` is the width of a pixel's cone across the ray.
fn material_at(surface: Surface, direction: vec3<f32>, cone_width: f32) -> Material {
    let record = frame_int(FRAME_materials) + u32(surface.material) * MATERIAL_words;
    let cosine = max(abs(dot(surface.ng, direction)), GRAZING);
    let footprint = cone_width * cone_width * surface.texcoord_density * (1.0 / cosine);
    var ka = record_vector(record + MATERIAL_ambient);
    var kd = record_vector(record + MATERIAL_diffuse);
    var ns = surface.ns;
    let diffuse_texture = record_int(record + MATERIAL_diffuse_texture);
    if diffuse_texture >= 0 {
        let texel = sample_texture(u32(diffuse_texture), surface.texcoord, footprint, true);
        ka *= texel;
        kd *= texel;
    }
    let normal_texture = record_int(record + MATERIAL_normal_texture);
    if normal_texture >= 0 && surface.has_tangent {
        ns = mapped_normal(u32(normal_texture), surface, footprint, record_float(record + MATERIAL_normal_scale));
    }
    // Turn to the viewer: the geometric normal decides the side, whatever the winding.
    if dot(surface.normal, surface.ng) < 0.0 { ns = -ns; }
    return Material(ka, kd, record_vector(record + MATERIAL_specular), record_float(record + MATERIAL_exponent),
                    record_float(record + MATERIAL_reflectivity), bend(ns, -direction));
}

struct Reflected { diffuse: vec3<f32>, specular: vec3<f32> }

// Return what is reflected towards wo of light from wi, the cosine of incidence included in the first.
//
// Phong's model with Blinn's halfway vector, "Models of light reflection for computer synthesized pictures" (1977).
fn material_eval(diffuse: vec3<f32>, specular: vec3<f32>, exponent: f32, ns: vec3<f32>, wo: vec3<f32>, wi: vec3<f32>,
                 cosine: f32) -> Reflected {
    let halfway = normalize(wi + wo);
    return Reflected(diffuse * cosine, specular * pow(max(dot(ns, halfway), 1e-6), exponent));
}
