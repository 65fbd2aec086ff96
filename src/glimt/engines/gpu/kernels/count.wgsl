// What rays visit: counted where that is asked for, by pipelines of their own.

fn count_visits(kind: u32, counts: Counts) {
    if COUNTING == 0u { return; }
    atomicAdd(&counters[COUNTER_nodes + kind], counts.nodes);
    atomicAdd(&counters[COUNTER_blocks + kind], counts.blocks);
}
