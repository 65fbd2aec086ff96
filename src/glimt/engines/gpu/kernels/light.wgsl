// Lights: what arrives at a point, before anything stands in the way.

const SHORT_OF_LIGHT = 0.9999847412109375;  // 1 - 2^-16: where a shadow ray ends on its way to a lamp
const NEARLY_NOTHING = 1e-36;

struct LightSample { wi: vec3<f32>, reach: vec3<f32>, t_max: f32, attenuation: f32 }

// Return the light of number `index` at a surface point whose shadow rays leave from `start`: the unit way to it, the
// shadow ray and its end, and what arrives. The paper's polynomial of distance / radius; glTF's cone
// (KHR_lights_punctual).
fn light_sample(index: u32, point: vec3<f32>, start: vec3<f32>) -> LightSample {
    let record = frame_int(FRAME_lights) + index * LIGHT_words;
    let kind = records[record + LIGHT_kind];
    if kind == DIRECTIONAL_LIGHT {
        let wi = -record_vector(record + LIGHT_direction);
        return LightSample(wi, wi, FAR, 1.0);
    }
    let position = record_vector(record + LIGHT_position);
    let to_light = position - point;
    let squared = max(dot(to_light, to_light), NEARLY_NOTHING);
    let inverse = inverseSqrt(squared);
    let wi = to_light * inverse;
    let x = squared * inverse * record_float(record + LIGHT_inverse_radius);
    let a = record_vector(record + LIGHT_attenuation);
    var attenuation = 1.0 / max(a.x + x * (a.y + x * a.z), NEARLY_NOTHING);
    if kind == SPOT_LIGHT {
        let cosine = -dot(wi, record_vector(record + LIGHT_direction));
        let cone = clamp(cosine * record_float(record + LIGHT_cone_scale) + record_float(record + LIGHT_cone_offset),
                         0.0, 1.0);
        attenuation = attenuation * cone * cone;
    }
    return LightSample(wi, position - start, SHORT_OF_LIGHT, attenuation);
}
