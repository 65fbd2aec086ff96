// Texture look-ups: bilinear within a level, linear between levels, from the same texels as the CPU's.

const FAR_TEXCOORD = 1e6;

fn texel(word: u32) -> vec3<f32> {
    return vec3(f32(word & TEXEL_MAX), f32((word >> TEXEL_BITS) & TEXEL_MAX),
                f32((word >> (2u * TEXEL_BITS)) & TEXEL_MAX));
}

// Return (first texel, weight of the one after it) along one axis; repeated texels go from -1 to size - 1.
fn position(coordinate: f32, size: f32, clamp_: bool) -> vec2<f32> {
    var at = coordinate * size - 0.5;
    if clamp_ { at = clamp(at, 0.0, size - 1.0); }
    let first = floor(at);
    return vec2(first, at - first);
}

// Return the texture at (u, v) in 0..1 of the level whose record index is `level`.
fn bilinear(level: u32, u: f32, v: f32, clamp_: bool, squared: bool) -> vec3<f32> {
    let record = frame_int(FRAME_levels) + level * LEVEL_words;
    let columns = f32(record_int(record + LEVEL_width));
    let rows = f32(record_int(record + LEVEL_height));
    let px = position(u, columns, clamp_);
    let py = position(v, rows, clamp_);
    var x0 = px.x;
    var y0 = py.x;
    var y1 = y0 + 1.0;
    if clamp_ {
        y1 = min(y1, rows - 1.0);
    } else {
        if x0 < 0.0 { x0 = columns - 1.0; }
        if y0 < 0.0 { y0 = rows - 1.0; }
        if y1 > rows - 1.0 { y1 = 0.0; }
    }
    let first = u32(record_int(record + LEVEL_first_texel)) + u32(x0);
    let stride = u32(columns) + 1u;
    let row0 = first + u32(y0) * stride;
    let row1 = first + u32(y1) * stride;
    var a = texel(texels[row0]);
    var b = texel(texels[row0 + 1u]);
    var c = texel(texels[row1]);
    var d = texel(texels[row1 + 1u]);
    if squared { a *= a; b *= b; c *= c; d *= d; }
    let above = a + (b - a) * px.y;
    let below = c + (d - c) * px.y;
    return above + (below - above) * py.y;
}

// Return the texture with record index `texture` as values 0..1.
//
// `footprint` is the area of a pixel on the surface in texcoord units. The level is the one where that is a texel's,
// after Akenine-Möller et al., "Improved shader and texture level of detail using ray cones" (2021).
fn sample_texture(texture: u32, texcoord: vec2<f32>, footprint: f32, is_color: bool) -> vec3<f32> {
    let record = frame_int(FRAME_textures) + texture * TEXTURE_words;
    let clamp_ = record_int(record + TEXTURE_clamp) != 0;
    let scale = vec2(record_float(record + TEXTURE_scale), record_float(record + TEXTURE_scale + 1u));
    let offset = vec2(record_float(record + TEXTURE_offset), record_float(record + TEXTURE_offset + 1u));
    var at = clamp(texcoord * scale + offset, vec2(-FAR_TEXCOORD), vec2(FAR_TEXCOORD));
    if clamp_ { at = clamp(at, vec2(0.0), vec2(1.0)); } else { at = at - floor(at); }

    // Level of detail; squares keep the geometric mean of both directions without a root.
    let first = u32(record_int(record + TEXTURE_first_level));
    let last = f32(record_int(record + TEXTURE_levels) - 1);
    let level0 = frame_int(FRAME_levels) + first * LEVEL_words;
    let count = f32(record_int(level0 + LEVEL_width)) * abs(scale.x) * f32(record_int(level0 + LEVEL_height))
        * abs(scale.y);
    let detail = clamp(log2(max(footprint * count, 1.0)) * 0.5, 0.0, last);
    let lower = floor(detail);
    let weight = detail - lower;
    var value = bilinear(first + u32(lower), at.x, at.y, clamp_, is_color);
    if weight > 0.0 {
        value += (bilinear(first + u32(lower) + 1u, at.x, at.y, clamp_, is_color) - value) * weight;
    }
    let one = 1.0 / f32(TEXEL_MAX);
    return value * select(one, one * one, is_color);
}
