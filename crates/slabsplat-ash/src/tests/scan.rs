//! Real shaders: a prefix sum in two passes, compared with the processor's.

use super::*;
use slabsplat_seeds::for_each_seed;
use slabsplat_shaders::{SCAN_BLOCKS, SCAN_TOTALS, STRUCTS};

const BLOCK_LEN: usize = 2048;

/// Of `shaders/shared/step.wgsl`, as naga lays it out.
fn step_bytes() -> u64 {
    let step = STRUCTS.iter().find(|layout| layout.name == "Step");
    step.expect("stages have steps").size.into()
}

/// Buffers for prefix sums of one length, and the passes.
pub(super) struct Scan {
    pub(super) elements: Slice,
    totals: Slice,
    counts: Slice,
    /// Twice: the parameters of each pass.
    steps: BufferId,
    step_words: [Vec<u32>; 2],
    step_offset: u64,
    pub(super) passes: Vec<Pass>,
}

impl Scan {
    pub(super) fn new(device: &mut AshDevice, n: usize) -> Self {
        let n_blocks = n.div_ceil(BLOCK_LEN);
        let step_offset = step_bytes().next_multiple_of(device.info().offset_alignment);
        let mut whole =
            |label, size: u64| slice(device.create_buffer(label, size).unwrap(), 0, size);
        let elements = whole("elements", n as u64 * 4);
        let totals = whole("totals", n_blocks as u64 * 4);
        let counts = whole("counts", 16);
        let steps = whole("steps", step_offset + step_bytes()).buffer;
        let pass = |shader, stage, step: u64, [one, other]: [Slice; 2], n_groups: usize| Pass {
            shader,
            stage,
            bindings: vec![slice(steps, step * step_offset, step_bytes()), one, other],
            groups: [n_groups as u32, 1, 1],
        };
        let passes = vec![
            pass(&SCAN_BLOCKS, "blocks", 0, [elements, totals], n_blocks),
            pass(&SCAN_TOTALS, "totals", 1, [totals, counts], 1),
        ];
        let step = |n: usize| {
            let mut words = vec![0; step_bytes() as usize / size_of::<u32>()];
            [words[1], words[2]] = [n as u32, 2];
            words
        };
        let step_words = [step(n), step(n_blocks)];
        Self { elements, totals, counts, steps, step_words, step_offset, passes }
    }

    /// Sums these up and reads everything.
    pub(super) fn work<'a>(&'a self, elements: &'a [u32]) -> Work<'a> {
        Work {
            writes: vec![
                write(self.steps, 0, &self.step_words[0]),
                write(self.steps, self.step_offset, &self.step_words[1]),
                write(self.elements.buffer, 0, elements),
            ],
            passes: (&self.passes[..]).into(),
            reads: vec![self.elements, self.totals, self.counts],
        }
    }

    pub(super) fn destroy(self, device: &mut AshDevice) {
        let slices = [self.elements, self.totals, self.counts];
        slices.iter().for_each(|slice| device.destroy_buffer(slice.buffer));
        device.destroy_buffer(self.steps);
    }
}

/// Compares what came back with a sum on the processor.
pub(super) fn assert_sums(done: &Done, elements: &[u32]) {
    let [sums, totals, counts] = &done.reads[..] else { panic!("three slices were read") };
    let mut sum = 0_u32;
    for (i, element) in elements.iter().enumerate() {
        let of_device = sums[i] + totals[i / BLOCK_LEN];
        assert_eq!(of_device, sum, "element {i} of {}", elements.len());
        sum += *element;
    }
    assert_eq!(counts[2], sum, "the sum of all");
}

/// So small that their sum is no overflow, for which the shaders have a rule of their own.
pub(super) fn random_elements(rng: &mut fastrand::Rng, n: usize) -> Vec<u32> {
    assert!(n <= 300_000, "{n} elements may be too many");
    std::iter::repeat_with(|| rng.u32(..10_000)).take(n).collect()
}

#[test]
fn scan_sums_any_number() {
    on_device(|device| {
        for_each_seed(1, |mut rng| {
            let random = std::iter::repeat_with(|| rng.usize(1..300_000)).take(3);
            for n in [1, 2047, 2048, 2049].into_iter().chain(random.collect::<Vec<_>>()) {
                let scan = Scan::new(device, n);
                let elements = random_elements(&mut rng, n);
                let work = device.submit(&scan.work(&elements)).unwrap();
                assert_sums(&wait(device, work), &elements);
                scan.destroy(device);
            }
        });
    });
}

#[test]
fn scan_stages_take_time() {
    on_device(|device| {
        if !device.info().has_timestamps {
            println!("skipped: the device has no timestamps");
            return;
        }
        let mut rng = fastrand::Rng::with_seed(1);
        let scan = Scan::new(device, 100_000);
        let elements = random_elements(&mut rng, 100_000);
        for _ in 0..3 {
            let work = device.submit(&scan.work(&elements)).unwrap();
            let stage_ms = wait(device, work).stage_ms;
            assert_eq!(
                stage_ms.iter().map(|(stage, _)| *stage).collect::<Vec<_>>(),
                ["blocks", "totals"]
            );
            assert!(stage_ms.iter().all(|(_, ms)| 0.0 < *ms && *ms < 10_000.0), "{stage_ms:?}");
        }
    });
}

#[test]
fn scan_stage_is_all_its_passes_in_a_row() {
    on_device(|device| {
        let mut scan = Scan::new(device, 5000);
        let [blocks, totals] = [0, 1].map(|i| scan.passes[i].clone());
        let named = |pass: &Pass, stage| Pass { stage, ..pass.clone() };
        scan.passes = vec![
            named(&blocks, "a"),
            named(&totals, "a"),
            named(&totals, "b"),
            named(&blocks, "a"),
        ];
        let work = device.submit(&scan.work(&[1; 5000])).unwrap();
        let stage_ms = wait(device, work).stage_ms;
        let stages: Vec<_> = stage_ms.iter().map(|(stage, _)| *stage).collect();
        let expected: &[_] = if device.info().has_timestamps { &["a", "b", "a"] } else { &[] };
        assert_eq!(stages, expected);
    });
}
