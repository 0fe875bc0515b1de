// The second half of a prefix sum: one workgroup sums up the blocks' totals in place, exclusively, and
// notes the sum of all.

//#include "shared/step.wgsl"
//#include "shared/scan.wgsl"

@group(0) @binding(0) var<uniform> step: Step;
@group(0) @binding(1) var<storage, read_write> totals: array<u32>;
// The sum of all goes to `counts[step.count_slot]`, if that is a slot.
@group(0) @binding(2) var<storage, read_write> counts: array<u32>;

@compute @workgroup_size(256)
fn scan_totals(@builtin(local_invocation_index) thread: u32) {
    var before_batch = 0u;
    for (var first = 0u; first < step.n_elements; first += 256u) {
        var total = 0u;
        if first + thread < step.n_elements {
            total = totals[first + thread];
        }
        let before = saturating_sum(before_batch, scan_workgroup(thread, total));
        if first + thread < step.n_elements {
            totals[first + thread] = before;
        }
        before_batch = saturating_sum(before_batch, scan_sums[255]);
    }
    if thread == 0u && step.count_slot != NO_COUNT {
        counts[step.count_slot] = before_batch;
    }
}
