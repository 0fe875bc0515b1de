//! What is seen by what: submissions after submissions, passes after writes, reads after all.

use super::scan::{Scan, assert_sums, random_elements};
use super::*;
use crate::submit::{MAX_IN_FLIGHT, PIECE_BYTES};

#[test]
fn work_is_polled_in_any_order() {
    on_device(|device| {
        let mut rng = fastrand::Rng::with_seed(1);
        // More than may be in flight, on shared buffers.
        let scan = Scan::new(device, 30_000);
        let inputs: Vec<_> =
            (0..MAX_IN_FLIGHT + 5).map(|_| random_elements(&mut rng, 30_000)).collect();
        let submitted = inputs.iter().map(|input| device.submit(&scan.work(input)).unwrap());
        let mut works: Vec<_> = submitted.zip(&inputs).collect();
        rng.shuffle(&mut works);
        for (work, input) in works {
            assert_sums(&wait(device, work), input);
        }
    });
}

#[test]
fn passes_are_submitted_again_with_other_bytes() {
    on_device(|device| {
        let mut rng = fastrand::Rng::with_seed(1);
        let scan = Scan::new(device, 10_000);
        for _ in 0..10 {
            let input = random_elements(&mut rng, 10_000);
            let work = device.submit(&scan.work(&input)).unwrap();
            assert_sums(&wait(device, work), &input);
        }
        assert_eq!(device.recordings.n_recorded(), 1, "one after the other, one is enough");
    });
}

#[test]
fn passes_of_many_lists_take_turns() {
    on_device(|device| {
        let mut rng = fastrand::Rng::with_seed(1);
        let scans: Vec<_> = (0..30).map(|i| Scan::new(device, 1000 + 700 * i)).collect();
        for _ in 0..100 {
            let i = rng.usize(..scans.len());
            let input = random_elements(&mut rng, 1000 + 700 * i);
            let work = device.submit(&scans[i].work(&input)).unwrap();
            if rng.bool() {
                assert_sums(&wait(device, work), &input);
            }
        }
    });
}

/// Sums of sums: each submission continues with what the last one left.
#[test]
fn passes_see_what_earlier_submissions_wrote() {
    on_device(|device| {
        let scan = Scan::new(device, 2000);
        let first = vec![1; 2000];
        device.submit(&scan.work(&first)).unwrap();
        let again = Work { writes: Vec::new(), ..scan.work(&first) };
        device.submit(&again).unwrap();
        let last = device.submit(&again).unwrap();
        let mut expected = first;
        for _ in 0..3 {
            let mut sum = 0_u32;
            for element in &mut expected {
                sum += std::mem::replace(element, sum);
            }
        }
        assert_eq!(wait(device, last).reads[0], expected);
    });
}

#[test]
fn writes_in_one_place_keep_their_order() {
    on_device(|device| {
        let buffer = device.create_buffer("written", 64).unwrap();
        let writes = vec![
            write(buffer, 0, &[1, 2, 3, 4]),
            write(buffer, 8, &[5, 6]),
            write(buffer, 4, &[7]),
        ];
        device.submit(&Work { writes, ..Work::default() }).unwrap();
        let read = read_now(device, &[slice(buffer, 0, 20), slice(buffer, 4, 8)]);
        assert_eq!(read, [vec![1, 7, 5, 6, 0], vec![7, 5]]);
    });
}

#[test]
fn writes_may_be_longer_than_staging_memory() {
    on_device(|device| {
        let n_words = (PIECE_BYTES as usize * 5 / 2) / 4 + 3;
        let input: Vec<u32> = (0..n_words as u32).map(|i| i.wrapping_mul(0x9e37_79b9)).collect();
        let buffer = device.create_buffer("long", n_words as u64 * 4 + 8).unwrap();
        let scan = Scan::new(device, 1000);
        let mut work = scan.work(&[3; 1000]);
        // On the way already when the long write comes.
        device.submit(&work).unwrap();
        work.writes.insert(1, write(buffer, 4, &input));
        work.reads.push(slice(buffer, 0, n_words as u64 * 4 + 8));
        let submitted = device.submit(&work).unwrap();
        let mut done = wait(device, submitted);
        let long = done.reads.pop().unwrap();
        assert!(long[0] == 0 && long[1..=n_words] == input && long[n_words + 1] == 0);
        assert_sums(&done, &[3; 1000]);
    });
}

#[test]
fn writes_of_many_submissions_share_staging_memory() {
    on_device(|device| {
        let n_words = PIECE_BYTES as usize / 8;
        let buffer = device.create_buffer("long", n_words as u64 * 4).unwrap();
        for i in 0..6 {
            let input = vec![i; n_words];
            device
                .submit(&Work { writes: vec![write(buffer, 0, &input)], ..Work::default() })
                .unwrap();
        }
        assert_eq!(read_now(device, &[slice(buffer, 0, n_words as u64 * 4)]), [vec![5; n_words]]);
    });
}
