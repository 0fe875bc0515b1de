//! Prefix sums, on the device and on the CPU.

use super::{on_device, run, slice, wait};
use crate::WgpuDevice;
use slabsplat_gpu::{BufferId, Device, Done, Pass, Work, Write};
use slabsplat_seeds::for_each_seed;
use slabsplat_shaders::{SCAN_BLOCKS, SCAN_TOTALS, STRUCTS};
use std::borrow::Cow;

/// Elements that a workgroup sums up.
const BLOCK: usize = 2048;

/// Of `shaders/shared/step.wgsl`, as naga lays it out.
fn step_bytes() -> u64 {
    let step = STRUCTS.iter().find(|layout| layout.name == "Step");
    step.expect("stages have steps").size.into()
}

/// Where the second of the two steps is; a multiple of every device's alignment.
const SECOND_STEP: u64 = 256;

/// The buffers of a prefix sum, and its passes.
struct Scan {
    buffers: [BufferId; 4],
    passes: Vec<Pass>,
    n_elements: usize,
    n_blocks: usize,
}

impl Scan {
    fn new(device: &mut WgpuDevice, n_elements: usize) -> Self {
        let n_blocks = n_elements.div_ceil(BLOCK);
        let [elements_size, totals_size] = [n_elements, n_blocks].map(|n| 4 * n as u64);
        let mut make = |label, size| device.create_buffer(label, size).unwrap();
        let steps = make("steps", SECOND_STEP + step_bytes());
        let elements = make("elements", elements_size);
        let totals = make("totals", totals_size);
        let counts = make("counts", 16);
        let all_totals = slice(totals, 0, totals_size);
        let blocks = Pass {
            shader: &SCAN_BLOCKS,
            stage: "blocks",
            bindings: vec![
                slice(steps, 0, step_bytes()),
                slice(elements, 0, elements_size),
                all_totals,
            ],
            groups: [n_blocks as u32, 1, 1],
        };
        let totals_of_totals = Pass {
            shader: &SCAN_TOTALS,
            stage: "totals",
            bindings: vec![
                slice(steps, SECOND_STEP, step_bytes()),
                all_totals,
                slice(counts, 0, 16),
            ],
            groups: [1, 1, 1],
        };
        let passes = vec![blocks, totals_of_totals];
        Self { buffers: [steps, elements, totals, counts], passes, n_elements, n_blocks }
    }

    /// Sums up the values. The sum of all goes to the third slot of the counts.
    fn work<'a>(&'a self, values: &'a [u32]) -> Work<'a> {
        let [steps, elements, totals, counts] = self.buffers;
        let step = |n_elements: usize, count_slot| {
            let mut step = vec![0; step_bytes() as usize / size_of::<u32>()];
            [step[1], step[2]] = [n_elements as u32, count_slot];
            bytemuck::cast_slice::<u32, u8>(&step).to_vec()
        };
        let write = |buffer, offset, bytes| Write { buffer, offset, bytes };
        Work {
            writes: vec![
                write(steps, 0, step(self.n_elements, 0).into()),
                write(steps, SECOND_STEP, step(self.n_blocks, 2).into()),
                write(elements, 0, bytemuck::cast_slice(values).into()),
            ],
            passes: Cow::Borrowed(&self.passes),
            reads: vec![
                slice(elements, 0, 4 * self.n_elements as u64),
                slice(totals, 0, 4 * self.n_blocks as u64),
                slice(counts, 8, 4),
            ],
        }
    }
}

fn check(values: &[u32], done: &Done, has_timestamps: bool) {
    let reads = &done.reads;
    let [elements, totals, counts] = &reads[..] else { panic!("{} reads", reads.len()) };
    let mut sum = 0_u32;
    for (idx, value) in values.iter().enumerate() {
        assert_eq!(elements[idx].wrapping_add(totals[idx / BLOCK]), sum, "sum {idx}");
        sum = sum.wrapping_add(*value);
    }
    assert_eq!(counts[..], [sum], "the sum of all");
    let stages: Vec<_> = done.stage_ms.iter().map(|(stage, _)| *stage).collect();
    assert_eq!(stages, if has_timestamps { vec!["blocks", "totals"] } else { vec![] });
    for (stage, ms) in &done.stage_ms {
        assert!((0.0..60e3).contains(ms), "{stage} took {ms} ms");
    }
}

fn values(random: &mut fastrand::Rng, n: usize) -> Vec<u32> {
    // Sums stop at the largest number; these stay below it.
    (0..n).map(|_| random.u32(..1 << 10)).collect()
}

#[test]
fn scan_matches_cpu() {
    on_device(|device| {
        for_each_seed(1, |mut random| {
            let lengths = [1, BLOCK, BLOCK + 1, 256 * BLOCK + 1, random.usize(1..1_000_000)];
            for n in lengths {
                println!("{n} elements");
                let scan = Scan::new(device, n);
                let values = values(&mut random, n);
                let done = run(device, &scan.work(&values));
                check(&values, &done, device.info().has_timestamps);
            }
        });
    });
}

#[test]
fn scan_of_other_values_makes_nothing_new() {
    on_device(|device| {
        let mut random = fastrand::Rng::with_seed(1);
        let scan = Scan::new(device, 5000);
        for _ in 0..5 {
            let values = values(&mut random, 5000);
            let done = run(device, &scan.work(&values));
            check(&values, &done, device.info().has_timestamps);
        }
        assert_eq!(device.bind_groups.n_kept(), 2);
        assert_eq!(device.read_backs.n_free(), 1);
        assert_eq!(device.timers.n_free(), usize::from(device.info().has_timestamps));
    });
}

/// More than may be running at once.
#[test]
fn scan_in_flight_in_any_order() {
    on_device(|device| {
        let mut random = fastrand::Rng::with_seed(1);
        let scan = Scan::new(device, 20_000);
        let mut in_flight = Vec::new();
        for _ in 0..9 {
            let values = values(&mut random, 20_000);
            in_flight.push((device.submit(&scan.work(&values)).unwrap(), values));
        }
        random.shuffle(&mut in_flight);
        for (work, values) in in_flight {
            let done = wait(device, work);
            check(&values, &done, device.info().has_timestamps);
        }
    });
}

#[test]
fn scan_outlives_its_buffers() {
    on_device(|device| {
        let mut random = fastrand::Rng::with_seed(1);
        let scan = Scan::new(device, 300_000);
        let values = values(&mut random, 300_000);
        let work = device.submit(&scan.work(&values)).unwrap();
        for buffer in scan.buffers {
            device.destroy_buffer(buffer);
        }
        assert_eq!(device.bind_groups.n_kept(), 0);
        let done = wait(device, work);
        check(&values, &done, device.info().has_timestamps);
    });
}

/// More stages than the smallest timer has room for, and stages of several passes.
#[test]
fn scan_of_many_stages() {
    on_device(|device| {
        const STAGES: [&str; 20] = [
            "a", "b", "c", "d", "e", "f", "g", "h", "i", "j", "k", "l", "m", "n", "o", "p", "q",
            "r", "s", "t",
        ];
        let scan = Scan::new(device, 10);
        let mut passes = Vec::new();
        for stage in STAGES {
            let pass = Pass { stage, ..scan.passes[0].clone() };
            passes.extend([pass.clone(), pass]);
        }
        let values = [0; 10];
        let done = run(device, &Work { passes: passes.into(), ..scan.work(&values) });
        let stages: Vec<_> = done.stage_ms.iter().map(|(stage, _)| *stage).collect();
        assert_eq!(stages, if device.info().has_timestamps { STAGES.to_vec() } else { vec![] });
    });
}
