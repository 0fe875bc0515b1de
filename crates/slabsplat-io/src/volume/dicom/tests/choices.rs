//! Several series, times and channels in one folder.

use super::super::tags;
use super::written::{EXPLICIT, file, slice, text, with};
use super::{ct, read, read_with, samples};
use crate::{FilesInMemory, VolumeOptions};

#[test]
fn dicom_series_are_chosen() {
    let other = [0.0, 3.0].map(|z| {
        let changes = [(tags::SERIES_UID, text("9.9")), (tags::SERIES_NUMBER, text("2"))];
        file(EXPLICIT, &with(slice(z, [9, 9, 9, 9]), &changes))
    });
    let files = [ct(&[0.0, 1.0, 2.0]), other.to_vec(), vec![b"not an image".to_vec()]].concat();
    let loaded = read(&files).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [2, 2, 3]);
    let expected = [
        "CT 2 \"head\", 2 slices of 2 x 2".to_owned(),
        "CT 7 \"head\", 3 slices of 2 x 2".to_owned(),
    ];
    assert_eq!(loaded.choices.series.names, expected);
    assert_eq!(loaded.choices.series.chosen, 1);
    let expected =
        ["files that hold no slices were passed over: 1", "there are 2 series: series 1 was taken"];
    assert_eq!(loaded.warnings, expected);
    let first = read_with(&files, &VolumeOptions::default().series(0)).unwrap();
    assert_eq!(first.volume.grid().dims(), [2, 2, 2]);
    let error = read_with(&files, &VolumeOptions::default().series(2)).unwrap_err().to_string();
    assert!(error.starts_with("in: there is no series 2: there is 0 to 1 (0 CT 2"), "{error}");
}

/// What lists the files of a folder is named for them.
#[test]
fn dicom_folders_are_named_by_what_lists_them() {
    let slices = ct(&[0.0, 1.0]);
    let list = file(EXPLICIT, &slice(0.0, [1; 4])[..3]);
    let files = [("in/DICOMDIR", &list), ("in/a/1", &slices[0]), ("in/a/2", &slices[1])];
    let files = FilesInMemory::from_iter(files.map(|(name, bytes)| (name, bytes.as_slice())));
    for path in ["in/DICOMDIR", "in"] {
        let loaded = files.read_volume(path).unwrap();
        assert_eq!(loaded.volume.grid().dims(), [2, 2, 2], "{path}");
        assert_eq!(loaded.warnings, [""; 0], "{path}");
    }
}

#[test]
fn dicom_times_and_echoes_are_chosen() {
    let at = |z: f64, echo: &str, time: &str, value: u16| {
        let changes = [(tags::ECHO_NUMBER, text(echo)), (tags::TEMPORAL_POSITION, text(time))];
        file(EXPLICIT, &with(slice(z, [value; 4]), &changes))
    };
    let mut files = Vec::new();
    for z in [0.0, 1.0] {
        for echo in [2, 1] {
            for time in [3, 1, 2] {
                let value = 100 * z as u16 + 10 * echo + time;
                files.push(at(z, &echo.to_string(), &time.to_string(), value));
            }
        }
    }
    let names: Vec<String> = (0..files.len()).map(|idx| format!("in/{idx}")).collect();
    let files = names.iter().map(String::as_str).zip(files.iter().map(Vec::as_slice));
    let files = FilesInMemory::from_iter(files);
    let read = |channel, time| {
        let options = VolumeOptions::default().channel(channel).time(time);
        files.read_volume_with("in", &options).unwrap()
    };
    assert_eq!(samples(&read(0, 0))[..5], [11, 11, 11, 11, 111]);
    assert_eq!(samples(&read(1, 2))[..5], [23, 23, 23, 23, 123]);
    assert_eq!(read(0, 0).choices.channel.names, ["AXIAL, echo 1", "AXIAL, echo 2"]);
}
