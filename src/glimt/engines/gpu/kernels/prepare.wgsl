// Between bounces: how many workgroups the mirror rays that go on take.

@group(0) @binding(9) var<storage, read_write> dispatch: array<u32>;

const MOST_GROUPS = 65535u;  // along one side of a dispatch

@compute @workgroup_size(1)
fn prepare() {
    let count = atomicLoad(&counters[COUNTER_paths + frame_int(FRAME_depth)]);
    let size = GROUP_WIDTH * GROUP_HEIGHT;
    let groups = (count + size - 1u) / size;
    dispatch[0] = min(groups, MOST_GROUPS);
    dispatch[1] = (groups + MOST_GROUPS - 1u) / MOST_GROUPS;
    dispatch[2] = 1u;
}
