// Exclusive prefix sums over the threads of a workgroup of 256.

var<workgroup> scan_sums: array<u32, 256>;

// Sums stop at the largest number instead of starting again at 0, so that too many is never few.
fn saturating_sum(a: u32, b: u32) -> u32 {
    return a + min(b, ~a);
}

// The sum of `value` over all threads before this one. All threads must call it together. The sum over
// all threads is in `scan_sums[255]` afterwards, until the next call.
fn scan_workgroup(thread: u32, value: u32) -> u32 {
    workgroupBarrier();
    scan_sums[thread] = value;
    workgroupBarrier();
    for (var reach = 1u; reach < 256u; reach *= 2u) {
        var before = 0u;
        if reach <= thread {
            before = scan_sums[thread - reach];
        }
        workgroupBarrier();
        scan_sums[thread] = saturating_sum(scan_sums[thread], before);
        workgroupBarrier();
    }
    return scan_sums[thread] - value;
}
