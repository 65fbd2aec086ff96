// A picture over a window, stretched, and what lies over it, whose colours are multiplied by its opacity already.

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var overlay: texture_2d<f32>;
@group(0) @binding(2) var between: sampler;

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) at: vec2<f32>,  // 0 to 1, row 0 on top
}

@vertex
fn corner(@builtin(vertex_index) index: u32) -> Corner {
    // A triangle that is twice as large as the window either way.
    let at = vec2(f32((index << 1u) & 2u), f32(index & 2u));
    return Corner(vec4(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y, 0.0, 1.0), at);
}

@fragment
fn show(from_: Corner) -> @location(0) vec4<f32> {
    let below = textureSampleLevel(picture, between, from_.at, 0.0).rgb;
    let above = textureSampleLevel(overlay, between, from_.at, 0.0);
    return vec4(above.rgb + (1.0 - above.a) * below, 1.0);
}
