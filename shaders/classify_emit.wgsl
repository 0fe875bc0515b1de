// Classification, second pass: writes the record of every relevant voxel, in memory order. The voxel's slot
// among the records is the number of relevant voxels before it, from the prefix sums of the first pass.

//#include "shared/step.wgsl"
//#include "shared/scan.wgsl"
//#include "shared/sample.wgsl"
//#include "shared/relevant.wgsl"
//#include "shared/transfer.wgsl"
//#include "shared/compositing.wgsl"
//#include "shared/coords.wgsl"
//#include "shared/gradient.wgsl"
//#include "shared/record.wgsl"

@group(0) @binding(0) var<uniform> volume: VolumeParams;
@group(0) @binding(1) var<uniform> step: Step;
@group(0) @binding(2) var<storage, read> samples: array<u32>;
@group(0) @binding(3) var<storage, read> transfer: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> block_sums: array<u32>;
@group(0) @binding(5) var<storage, read> totals: array<u32>;
@group(0) @binding(6) var<storage, read_write> records_0: array<Record>;
@group(0) @binding(7) var<storage, read_write> records_1: array<Record>;
@group(0) @binding(8) var<storage, read_write> records_2: array<Record>;
@group(0) @binding(9) var<storage, read_write> records_3: array<Record>;

@compute @workgroup_size(256)
fn classify_emit(
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    let block = linear_group(group, n_groups);
    let start = block * PER_BLOCK + thread * PER_THREAD;
    var found = 0u;
    for (var i = 0u; i < PER_THREAD; i++) {
        if start + i < step.n_elements && is_relevant(sample_bits(step.first + start + i)) {
            found |= 1u << i;
        }
    }
    let before = scan_workgroup(thread, countOneBits(found));
    if step.n_elements <= start {
        return;
    }
    let sum_idx = step.first_block + block;
    var slot = block_sums[sum_idx] + totals[sum_idx / PER_BLOCK] + before;
    for (var i = 0u; i < PER_THREAD; i++) {
        if (found & (1u << i)) != 0u {
            put(slot, record_of(step.first + start + i));
            slot++;
        }
    }
}

fn record_of(voxel_idx: u32) -> Record {
    let bits = sample_bits(voxel_idx);
    if volume.compositing == SUMS_DENSITIES {
        return Record(vec3(0.0), voxel_idx, vec4(density_at(bits), 0.0, 0.0, 1.0));
    }
    let weight = summed_weight(volume.compositing, opacity_at(bits));
    return Record(normal_at(voxel_idx, bits), voxel_idx, vec4(color_at(bits), weight));
}

fn put(slot: u32, record: Record) {
    let local = slot & ((1u << step.chunk_bits) - 1u);
    switch slot >> step.chunk_bits {
        case 0u: { records_0[local] = record; }
        case 1u: { records_1[local] = record; }
        case 2u: { records_2[local] = record; }
        default: { records_3[local] = record; }
    }
}
