// A film to colours, as `glimt.color.develop` makes them.

struct Development {
    width: u32,
    height: u32,
    scale: f32,
    is_filmic: u32,
}

@group(0) @binding(0) var<uniform> development: Development;
@group(0) @binding(1) var<storage, read> sums: array<vec4<f32>>;
@group(0) @binding(2) var developed: texture_storage_2d<rgba8unorm, write>;

fn filmic(x: vec3<f32>) -> vec3<f32> {
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

fn linear_to_srgb(values: vec3<f32>) -> vec3<f32> {
    let high = 1.055 * pow(values, vec3(1.0 / 2.4)) - 0.055;
    return select(high, values * 12.92, values <= vec3(0.0031308));
}

@compute @workgroup_size(8, 8)
fn develop(@builtin(global_invocation_id) pixel: vec3<u32>) {
    if pixel.x >= development.width || pixel.y >= development.height { return; }
    let sum = sums[pixel.y * development.width + pixel.x];
    let factor = select(0.0, development.scale / sum.w, sum.w > 0.0);
    var value = clamp(sum.xyz * factor, vec3(0.0), vec3(1e4));
    if development.is_filmic != 0u { value = filmic(value); }
    textureStore(developed, pixel.xy, vec4(linear_to_srgb(min(value, vec3(1.0))), 1.0));
}
