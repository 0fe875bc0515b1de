// Classification, first pass: how many voxels of each block of 2048 are relevant (model §6; the list L_r
// of the paper's §4, made by prefix sums instead of by sorting).

//#include "shared/step.wgsl"
//#include "shared/sample.wgsl"
//#include "shared/relevant.wgsl"

@group(0) @binding(0) var<uniform> volume: VolumeParams;
@group(0) @binding(1) var<uniform> step: Step;
@group(0) @binding(2) var<storage, read> samples: array<u32>;
@group(0) @binding(3) var<storage, read> transfer: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> block_counts: array<u32>;

var<workgroup> n_relevant: atomic<u32>;

@compute @workgroup_size(256)
fn classify_count(
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    if thread == 0u {
        atomicStore(&n_relevant, 0u);
    }
    workgroupBarrier();
    let block = linear_group(group, n_groups);
    let start = block * PER_BLOCK + thread * PER_THREAD;
    var n = 0u;
    for (var i = 0u; i < PER_THREAD; i++) {
        if start + i < step.n_elements && is_relevant(sample_bits(step.first + start + i)) {
            n++;
        }
    }
    atomicAdd(&n_relevant, n);
    workgroupBarrier();
    if thread == 0u && block * PER_BLOCK < step.n_elements {
        block_counts[step.first_block + block] = atomicLoad(&n_relevant);
    }
}
