//! Buffers that come and go, and objects that are used again.

use super::scan::{Scan, assert_sums, random_elements};
use super::*;

#[test]
fn buffers_begin_as_zeros() {
    on_device(|device| {
        // Memory that was used before.
        for _ in 0..5 {
            let buffer = device.create_buffer("used", 100_000).unwrap();
            assert_eq!(read_now(device, &[slice(buffer, 0, 100_000)]), [vec![0; 25_000]]);
            let ones = vec![u32::MAX; 25_000];
            device
                .submit(&Work { writes: vec![write(buffer, 0, &ones)], ..Work::default() })
                .unwrap();
            device.destroy_buffer(buffer);
        }
        let buffer = device.create_buffer("partly written", 16).unwrap();
        let work = Work { writes: vec![write(buffer, 8, &[9])], ..Work::default() };
        device.submit(&work).unwrap();
        assert_eq!(read_now(device, &[slice(buffer, 0, 16)]), [[0, 0, 9, 0]]);
    });
}

#[test]
fn buffers_outlive_the_work_in_flight() {
    on_device(|device| {
        let mut rng = fastrand::Rng::with_seed(1);
        let mut works = Vec::new();
        for _ in 0..12 {
            let n = rng.usize(1..100_000);
            let scan = Scan::new(device, n);
            let input = random_elements(&mut rng, n);
            works.push((device.submit(&scan.work(&input)).unwrap(), input));
            scan.destroy(device);
        }
        for (work, input) in works.iter().rev() {
            assert_sums(&wait(device, *work), input);
        }
        assert_eq!(device.recordings.n_recorded(), 0, "recordings go with their buffers");
        assert_eq!(device.sets.n_filled(), 0, "sets go with their buffers");
        assert_eq!(device.buffers.last_leaves_after(), None, "all buffers have gone");
    });
}

#[test]
fn buffers_that_no_work_used_go() {
    on_device(|device| {
        let buffer = device.create_buffer("unused", 4).unwrap();
        device.destroy_buffer(buffer);
        device.submit(&Work::default()).unwrap();
        let buffer = device.create_buffer("left over", 4).unwrap();
        assert_eq!(read_now(device, &[slice(buffer, 0, 4)]), [[0]]);
    });
}

/// Once warm, a frame makes nothing new.
#[test]
fn objects_are_used_again() {
    on_device(|device| {
        let mut rng = fastrand::Rng::with_seed(1);
        let scan = Scan::new(device, 20_000);
        let mut n_objects = Vec::new();
        for _ in 0..20 {
            let input = random_elements(&mut rng, 20_000);
            let works = [0; 3].map(|_| device.submit(&scan.work(&input)).unwrap());
            for work in works {
                assert_sums(&wait(device, work), &input);
            }
            let n_idle = device.staging.n_idle() + device.readback.n_idle();
            n_objects.push([device.recordings.n_recorded(), device.spare_lists.len(), n_idle]);
        }
        let [recorded, lists, buffers] = n_objects[19];
        assert!(recorded <= 3 && lists <= 6 && buffers <= 6, "{n_objects:?}");
        assert_eq!(device.sets.n_filled(), 2);
    });
}

#[test]
fn work_is_taken_once() {
    on_device(|device| {
        let buffer = device.create_buffer("read", 4).unwrap();
        let work = Work { reads: vec![slice(buffer, 0, 4)], ..Work::default() };
        let work = device.submit(&work).unwrap();
        assert_eq!(wait(device, work).reads, [[0]]);
        assert_eq!(wait(device, work), Done::default());
    });
}

#[test]
fn device_goes_with_work_in_flight() {
    on_device(|device| {
        let scan = Scan::new(device, 250_000);
        let input = vec![1; 250_000];
        for _ in 0..4 {
            device.submit(&scan.work(&input)).unwrap();
        }
        device.create_buffer("never cleared", 4).unwrap();
    });
}

#[test]
fn pipelines_are_made_of_all_shaders() {
    on_device(|device| {
        for shader in slabsplat_shaders::ALL {
            if let Err(fault) = device.pipelines.get(shader) {
                panic!("{}: {fault:?}", shader.name);
            }
        }
    });
}
