// The small answer of traversal: what surface is built from later.

struct Hit { t: f32, u: f32, v: f32, prim: u32, inst: u32 }

fn no_hit(t_max: f32) -> Hit { return Hit(t_max, 0.0, 0.0, MISS, MISS); }

// Return whether a hit at t replaces `hit`. Ties go to the lower instance and primitive: the answer does not depend on
// the order in which a tree is walked.
fn closer(hit: Hit, t: f32, inst: u32, prim: u32) -> bool {
    let before = hit.inst > inst || (hit.inst == inst && hit.prim > prim);
    return t > 0.0 && (t < hit.t || (t == hit.t && before));
}
