// What kernels read and write. Records are words, whatever a field's type: see layout.py. Most come in vectors of four,
// at a quarter of the price.

@group(0) @binding(0) var<uniform> frame_words: array<vec4<u32>, FRAME_VECTORS>;
@group(0) @binding(1) var<storage, read> nodes: array<vec4<u32>>;   // COMPRESSED_NODE: all meshes', then the scene's
@group(0) @binding(2) var<storage, read> blocks: array<vec4<u32>>;  // TRIANGLE_BLOCK, then PLACEMENT
@group(0) @binding(3) var<storage, read> records: array<u32>;    // INSTANCE, MATERIAL, TEXTURE, LEVEL, LIGHT
@group(0) @binding(4) var<storage, read> geometry: array<vec4<u32>>;  // TRIANGLE, VERTEX, TANGENT
@group(0) @binding(5) var<storage, read> texels: array<u32>;
@group(0) @binding(6) var<storage, read_write> paths: array<vec4<u32>>;  // PATH, twice as many as there are pixels
@group(0) @binding(7) var<storage, read_write> film: array<f32>;     // of a band: sums, then the sample at work
@group(0) @binding(8) var<storage, read_write> counters: array<atomic<u32>>;

override GROUP_WIDTH: u32 = 8;
override GROUP_HEIGHT: u32 = 8;

const FAR = 3.0e38;
const TINY = 1e-30;
const NOBODY = 0xffffffffu;  // the pixel of a path that has none

fn frame_int(at: u32) -> u32 { return frame_words[at >> 2u][at & 3u]; }
fn frame_float(at: u32) -> f32 { return bitcast<f32>(frame_int(at)); }
fn frame_vector(at: u32) -> vec3<f32> { return vec3(frame_float(at), frame_float(at + 1u), frame_float(at + 2u)); }

fn record_int(at: u32) -> i32 { return bitcast<i32>(records[at]); }
fn record_float(at: u32) -> f32 { return bitcast<f32>(records[at]); }
fn record_vector(at: u32) -> vec3<f32> {
    return vec3(record_float(at), record_float(at + 1u), record_float(at + 2u));
}

// Vertices and material of a triangle.
fn triangle_at(index: u32) -> vec4<u32> { return geometry[frame_int(FRAME_triangles) / 4u + index]; }

struct Vertex { position: vec3<f32>, normal: vec3<f32>, texcoord: vec2<f32> }

fn vertex_at(index: u32) -> Vertex {
    let at = frame_int(FRAME_vertices) / 4u + index * (VERTEX_words / 4u);
    let first = bitcast<vec4<f32>>(geometry[at]);
    let second = bitcast<vec4<f32>>(geometry[at + 1u]);
    return Vertex(first.xyz, vec3(first.w, second.xy), second.zw);
}

// A tangent, and the sign of its bitangent.
fn tangent_at(index: u32) -> vec4<f32> { return bitcast<vec4<f32>>(geometry[frame_int(FRAME_tangents) / 4u + index]); }

// The first half of a PATH record. The other two vectors are its hit and its share.
struct Path { origin: vec3<f32>, t: f32, direction: vec3<f32>, pixel: u32 }

const PATH_HIT = PATH_u / 4u;
const PATH_SHARE = PATH_throughput / 4u;

fn path_at(at: u32) -> Path {
    let start = paths[at + PATH_origin / 4u];
    let way = paths[at + PATH_direction / 4u];
    return Path(bitcast<vec3<f32>>(start.xyz), bitcast<f32>(start.w), bitcast<vec3<f32>>(way.xyz), way.w);
}

fn store_path(at: u32, path: Path) {
    paths[at + PATH_origin / 4u] = vec4(bitcast<vec3<u32>>(path.origin), bitcast<u32>(path.t));
    paths[at + PATH_direction / 4u] = vec4(bitcast<vec3<u32>>(path.direction), path.pixel);
}

fn store_share(at: u32, throughput: f32, travelled: f32, reflectivity: f32) {
    paths[at + PATH_SHARE] = bitcast<vec4<u32>>(vec4(throughput, travelled, reflectivity, 0.0));
}

// The number of this invocation's path, side by side in the half of `paths` that this depth reads.
fn path_number(group: vec3<u32>, groups: vec3<u32>, local: u32) -> u32 {
    return (group.y * groups.x + group.x) * (GROUP_WIDTH * GROUP_HEIGHT) + local;
}

fn path_record(number: u32, half: u32) -> u32 {
    return (half * frame_int(FRAME_capacity) + number) * (PATH_words / 4u);
}

fn sample_word(pixel: u32) -> u32 { return 4u * (frame_int(FRAME_capacity) + pixel); }

fn add_to_pixel(pixel: u32, light: vec3<f32>) {
    let at = sample_word(pixel);
    film[at] += light.x;
    film[at + 1u] += light.y;
    film[at + 2u] += light.z;
}
