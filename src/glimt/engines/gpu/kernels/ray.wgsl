// A ray set up for boxes and triangles (Woop, Benthin, Wald, "Watertight ray/triangle intersection", 2013).

struct Ray {
    origin: vec3<f32>,
    direction: vec3<f32>,
    inverse: vec3<f32>,
    pad: vec3<f32>,
    axis: u32,
    shear: vec3<f32>,
    shear_origin: vec3<f32>,
}

const ROUNDING = 9.5367431640625e-07;  // 2^-20: bounds what a box test rounds off, as a share of the origin
const SMALLEST = 1e-12;

// Return v with its components turned so that the longest axis is z.
fn permute(axis: u32, v: vec3<f32>) -> vec3<f32> {
    if axis == 0u { return v.yzx; }
    if axis == 1u { return v.zxy; }
    return v;
}

fn set_up(origin: vec3<f32>, direction: vec3<f32>) -> Ray {
    let size = abs(direction);
    let least = max(max(size.x, max(size.y, size.z)) * SMALLEST, TINY);
    let signs = select(vec3(1.0), vec3(-1.0), direction < vec3(0.0));
    let inverse = 1.0 / select(direction, signs * least, size < vec3(least));
    let pad = abs(inverse) * (max(abs(origin.x), max(abs(origin.y), abs(origin.z))) * ROUNDING);
    var axis = 2u;
    if size.x > size.y && size.x > size.z { axis = 0u; } else if size.y >= size.x && size.y > size.z { axis = 1u; }
    let turned = permute(axis, direction);
    let depth = 1.0 / turned.z;
    return Ray(origin, direction, inverse, pad, axis,
               vec3(turned.x * depth, turned.y * depth, depth), permute(axis, origin));
}
