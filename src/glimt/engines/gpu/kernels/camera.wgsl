// The pinhole camera.

struct CameraRay { origin: vec3<f32>, direction: vec3<f32> }

// Return (origin, unit direction) through a point of the picture plane, x and y in -1..1, y up.
fn camera_ray(x: f32, y: f32) -> CameraRay {
    let view = FRAME_view;
    let reached = frame_vector(view + VIEW_look) + frame_vector(view + VIEW_right) * x + frame_vector(view + VIEW_up) * y;
    return CameraRay(frame_vector(view + VIEW_origin), normalize(reached));
}
