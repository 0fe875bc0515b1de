//! Real shaders: a sort by one digit, compared with the processor's.

use super::*;
use slabsplat_seeds::for_each_seed;
use slabsplat_shaders::{SCAN_BLOCKS, SCAN_TOTALS, SORT_COUNT, SORT_SCATTER, STRUCTS, Shader};

const BLOCK_LEN: usize = 2048;
const NO_COUNT: u32 = u32::MAX;

/// Keys, the digit by which they are sorted, and how many of them there are for the device.
struct Case {
    keys: Vec<u32>,
    shift: u32,
    digit_bits: u32,
    n_counted: usize,
}

impl Case {
    fn random(rng: &mut fastrand::Rng) -> Self {
        let most = [1, 300, 2048, 2049, 20_000][rng.usize(..5)];
        let n = rng.usize(1..=most);
        let digit_bits = rng.u32(1..=8);
        let shift = rng.u32(..=32 - digit_bits);
        // Sometimes few digits occur.
        let mask = [u32::MAX, rng.u32(..)][rng.usize(..2)];
        let keys = std::iter::repeat_with(|| rng.u32(..) & mask).take(n).collect();
        Self { keys, shift, digit_bits, n_counted: [n, rng.usize(..=n)][rng.usize(..2)] }
    }

    /// The keys that count, sorted, and the place that each had.
    fn sorted(&self) -> Vec<(u32, u32)> {
        let digit = |key: u32| (key >> self.shift) & ((1 << self.digit_bits) - 1);
        let mut all: Vec<_> = self.keys[..self.n_counted].iter().copied().zip(0..).collect();
        all.sort_by_key(|(key, _)| digit(*key));
        all
    }

    fn n_blocks(&self) -> usize {
        self.keys.len().div_ceil(BLOCK_LEN)
    }

    fn n_sums(&self) -> usize {
        self.n_blocks() << self.digit_bits
    }

    /// The members of a step that these stages read, by their names in the shaders.
    fn step(&self, n_elements: usize, count_slot: u32) -> Vec<u32> {
        let step = STRUCTS.iter().find(|layout| layout.name == "Step").expect("stages have steps");
        let value = |name: &str| match name {
            "n_elements" => n_elements as u32,
            "count_slot" => count_slot,
            "shift" => self.shift,
            "digit_bits" => self.digit_bits,
            "n_blocks" => self.n_blocks() as u32,
            _ => 0,
        };
        step.members.iter().map(|member| value(member.name)).collect()
    }
}

fn device_sorts(device: &mut AshDevice, case: &Case) {
    let n = case.keys.len();
    let values: Vec<u32> = (0..n as u32).collect();
    let steps = [
        case.step(n, 0),
        case.step(case.n_sums(), NO_COUNT),
        case.step(case.n_sums().div_ceil(BLOCK_LEN), NO_COUNT),
    ];
    let mut whole = |label, len: usize| {
        let size = 4 * len as u64;
        slice(device.create_buffer(label, size).unwrap(), 0, size)
    };
    let [keys_at, of_keys, sorted_keys, sorted_values] =
        ["keys", "values", "sorted keys", "sorted values"].map(|label| whole(label, n));
    let sums = whole("sums", case.n_sums());
    let totals = whole("totals", case.n_sums().div_ceil(BLOCK_LEN));
    let counts = whole("counts", 1);
    let step_slices = steps.each_ref().map(|step| whole("step", step.len()));
    let [sort, blocks, all] = step_slices;
    let pass = |shader: &'static Shader, bindings: &[Slice], n_groups: usize| Pass {
        shader,
        stage: "sort",
        bindings: bindings.to_vec(),
        groups: [n_groups as u32, 1, 1],
    };
    let passes = [
        pass(&SORT_COUNT, &[sort, keys_at, sums, counts], case.n_blocks()),
        pass(&SCAN_BLOCKS, &[blocks, sums, totals], case.n_sums().div_ceil(BLOCK_LEN)),
        pass(&SCAN_TOTALS, &[all, totals, counts], 1),
        pass(
            &SORT_SCATTER,
            &[sort, keys_at, of_keys, sums, totals, sorted_keys, sorted_values, counts],
            case.n_blocks(),
        ),
    ];
    let n_counted = [case.n_counted as u32];
    let mut writes: Vec<_> =
        step_slices.iter().zip(&steps).map(|(at, step)| write(at.buffer, 0, step)).collect();
    writes.push(write(keys_at.buffer, 0, &case.keys));
    writes.push(write(of_keys.buffer, 0, &values));
    writes.push(write(counts.buffer, 0, &n_counted));
    let reads = vec![sorted_keys, sorted_values];
    let work = device.submit(&Work { writes, passes: passes[..].into(), reads }).unwrap();
    let done = wait(device, work);
    let [keys, values] = [0, 1].map(|i| done.reads[i][..case.n_counted].to_vec());
    let sorted: Vec<(u32, u32)> = keys.into_iter().zip(values).collect();
    let what = format!("{n} keys, {} bits from {}", case.digit_bits, case.shift);
    assert!(sorted == case.sorted(), "{what}, of which {} count", case.n_counted);
    let buffers = [keys_at, of_keys, sorted_keys, sorted_values, sums, totals, counts];
    buffers.iter().chain(&step_slices).for_each(|at| device.destroy_buffer(at.buffer));
}

#[test]
fn sort_by_any_digit() {
    on_device(|device| {
        for_each_seed(2, |mut rng| {
            for _ in 0..20 {
                device_sorts(device, &Case::random(&mut rng));
            }
        });
    });
}
