//! Whole files of Zarr, written here by hand: in a folder, in memory, and in archives.

use std::fs;
use std::io::Write;
use std::path::Path;

use slabsplat_core::Samples;
use slabsplat_core::glam::DVec3;

use super::super::zip::written::zip;
use super::codecs::crc32c;
use crate::{
    FilesInMemory, LayerFile, LoadedVolume, ScratchDesc, VolumeFormat, VolumeOptions, VolumeSource,
    read_volume_with,
};

type Files = Vec<(String, Vec<u8>)>;

/// From a folder, from memory and from archives, which must come to the same.
fn read(files: &Files, options: &VolumeOptions) -> Result<LoadedVolume, String> {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("a.zarr");
    for (key, bytes) in files {
        let path = folder.join(key);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    let keys: Vec<String> = files.iter().map(|(key, _)| format!("a.zarr/{key}")).collect();
    let named = keys.iter().zip(files).map(|(key, (_, bytes))| (key.as_str(), bytes.as_slice()));
    let named: Vec<(&str, &[u8])> = named.collect();
    let of_memory = FilesInMemory::from_iter(named.iter().copied());
    let archives = [false, true].map(|packs| zip(&named, packs));
    for (at, archive) in archives.iter().enumerate() {
        fs::write(dir.path().join(format!("{at}.zip")), archive).unwrap();
    }
    let from_disk = |name: &str| read_volume_with(dir.path().join(name), options);
    let disk = from_disk("a.zarr");
    for other in
        [of_memory.read_volume_with("a.zarr", options), from_disk("0.zip"), from_disk("1.zip")]
    {
        match (&disk, &other) {
            (Ok(disk), Ok(other)) => {
                assert_eq!(disk.volume.samples(), other.volume.samples());
                assert_eq!(disk.volume.grid(), other.volume.grid());
                assert_eq!(disk.warnings, other.warnings);
            }
            (Err(_), Err(_)) => {}
            _ => panic!("{disk:?} is not {other:?}"),
        }
    }
    disk.map_err(|error| error.to_string().replace(&*dir.path().join("").to_string_lossy(), ""))
}

fn file(key: &str, text: &str) -> (String, Vec<u8>) {
    (key.to_owned(), text.as_bytes().to_vec())
}

fn value([x, y, z]: [usize; 3]) -> u16 {
    (100 * z + 10 * y + x + 1) as u16
}

/// Of 5 × 3 × 4 voxels, those of a chunk of 3 × 2 × 2; `order` is the axis of each, the slowest first.
fn chunk(index: [usize; 3], order: [usize; 3], is_big: bool) -> Vec<u8> {
    let lens = [3, 2, 2];
    let [a, b, c] = order;
    let mut bytes = Vec::new();
    for i in 0..lens[a] {
        for j in 0..lens[b] {
            for k in 0..lens[c] {
                let mut at = [0; 3];
                (at[a], at[b], at[c]) = (i, j, k);
                let at = [0, 1, 2].map(|axis| at[axis] + index[axis] * lens[axis]);
                // Beyond the border is what nobody should see.
                let is_inside = at[0] < 5 && at[1] < 3 && at[2] < 4;
                let value = if is_inside { value(at) } else { 0xeeee };
                bytes.extend(if is_big { value.to_be_bytes() } else { value.to_le_bytes() });
            }
        }
    }
    bytes
}

fn expected() -> Samples {
    let voxels = (0..60).map(|at| value([at % 5, at / 5 % 3, at / 15]));
    voxels.collect::<Vec<u16>>().into()
}

fn all_indices() -> Vec<[usize; 3]> {
    (0..8).map(|at| [at % 2, at / 2 % 2, at / 4]).collect()
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

const IMAGE: &str = r#""multiscales": [{"axes": [
    {"name": "z", "type": "space", "unit": "micrometer"}, {"name": "y", "type": "space", "unit": "micrometer"},
    {"name": "x", "type": "space", "unit": "nanometer"}],
    "datasets": [{"path": "s0", "coordinateTransformations": [{"type": "scale", "scale": [2, 3, 4000]},
        {"type": "translation", "translation": [10, 20, 30000]}]}],
    "coordinateTransformations": [{"type": "scale", "scale": [10, 1, 1]}]}]"#;

fn v2(dtype: &str, order: &str, compressor: &str, separator: &str) -> String {
    format!(
        "{{\"zarr_format\": 2, \"shape\": [4, 3, 5], \"chunks\": [2, 2, 3], \"dtype\": \"{dtype}\", \"order\": \
         \"{order}\", \"compressor\": {compressor}, \"fill_value\": 9, \"filters\": null, \
         \"dimension_separator\": \"{separator}\"}}"
    )
}

fn files_v2(meta: &str, separator: &str, chunk: impl Fn([usize; 3]) -> Vec<u8>) -> Files {
    let group = file("s0/../.zgroup", "").0.replace("s0/../", "");
    let mut files = vec![
        (group, b"{\"zarr_format\": 2}".to_vec()),
        file(".zattrs", &format!("{{{IMAGE}}}")),
        file("s0/.zarray", meta),
    ];
    for index @ [x, y, z] in all_indices() {
        files.push((format!("s0/{z}{separator}{y}{separator}{x}"), chunk(index)));
    }
    files
}

#[test]
fn zarr_2_in_every_order() {
    for (dtype, order, compressor, separator) in [
        ("<u2", "C", "null", "/"),
        (">u2", "C", "{\"id\": \"zlib\"}", "."),
        ("<u2", "F", "{\"id\": \"gzip\"}", "/"),
        (">u2", "F", "null", "."),
    ] {
        let axes = if order == "C" { [2, 1, 0] } else { [0, 1, 2] };
        let pack = |bytes: Vec<u8>| match compressor {
            "null" => bytes,
            zlib_or_not if zlib_or_not.contains("zlib") => zlib(&bytes),
            _ => gzip(&bytes),
        };
        let meta = v2(dtype, order, compressor, separator);
        let files = files_v2(&meta, separator, |index| pack(chunk(index, axes, dtype == ">u2")));
        let loaded = read(&files, &VolumeOptions::default()).unwrap();
        assert_eq!(loaded.volume.samples(), &expected(), "{dtype} {order}");
        assert_eq!(loaded.format, VolumeFormat::Zarr);
        assert_eq!(loaded.warnings, [""; 0]);
        let spacing = loaded.volume.grid().spacing();
        assert!((DVec3::from_array(spacing) - DVec3::new(0.004, 0.003, 0.02)).length() < 1e-15);
        let origin = loaded.volume.grid().world_from_index().translation;
        assert!((origin - DVec3::new(0.03, 0.02, 0.1)).length() < 1e-15, "{origin}");
    }
}

fn v3(codecs: &str, chunk_shape: &str) -> String {
    format!(
        "{{\"zarr_format\": 3, \"node_type\": \"array\", \"shape\": [4, 3, 5], \"data_type\": \"uint16\", \
         \"chunk_grid\": {{\"name\": \"regular\", \"configuration\": {{\"chunk_shape\": {chunk_shape}}}}}, \
         \"chunk_key_encoding\": {{\"name\": \"default\", \"configuration\": {{\"separator\": \"/\"}}}}, \
         \"fill_value\": 9, \"codecs\": {codecs}}}"
    )
}

const BYTES: &str = r#"{"name": "bytes", "configuration": {"endian": "little"}}"#;

fn files_v3(meta: &str, chunks: impl IntoIterator<Item = (String, Vec<u8>)>) -> Files {
    let group = format!(
        "{{\"zarr_format\": 3, \"node_type\": \"group\", \"attributes\": {{\"ome\": {{\
                         \"version\": \"0.5\", {IMAGE}}}}}}}"
    );
    let mut files = vec![file("zarr.json", &group), file("s0/zarr.json", meta)];
    files.extend(chunks);
    files
}

#[test]
fn zarr_3_with_transposed_axes_and_sums() {
    let codecs = format!(
        "[{{\"name\": \"transpose\", \"configuration\": {{\"order\": [1, 2, 0]}}}}, {BYTES}, \
                          {{\"name\": \"crc32c\"}}]"
    );
    let chunks = all_indices().into_iter().map(|index @ [x, y, z]| {
        let mut bytes = chunk(index, [1, 0, 2], false);
        bytes.extend(crc32c(&bytes).to_le_bytes());
        (format!("s0/c/{z}/{y}/{x}"), bytes)
    });
    let mut files = files_v3(&v3(&codecs, "[2, 2, 3]"), chunks);
    assert_eq!(read(&files, &VolumeOptions::default()).unwrap().volume.samples(), &expected());
    files[2].1[0] ^= 1;
    let error = read(&files, &VolumeOptions::default()).unwrap_err();
    assert!(error.contains("checksum"), "{error}");
}

/// A shard of all chunks, of which one is not there.
#[test]
fn zarr_3_in_shards() {
    for location in ["start", "end"] {
        let codecs = format!(
            "[{{\"name\": \"sharding_indexed\", \"configuration\": {{\"chunk_shape\": [2, 2, 3], \"codecs\": \
             [{BYTES}, {{\"name\": \"gzip\"}}], \"index_codecs\": [{BYTES}, {{\"name\": \"crc32c\"}}], \
             \"index_location\": \"{location}\"}}}}]"
        );
        let n_index = 8 * 16 + 4;
        let (mut index, mut data) = (Vec::new(), Vec::new());
        let mut at = if location == "start" { n_index } else { 0 };
        for chunk_idx in all_indices() {
            let packed = gzip(&chunk(chunk_idx, [2, 1, 0], false));
            let is_there = chunk_idx != [1, 0, 0];
            let words = if is_there { [at as u64, packed.len() as u64] } else { [u64::MAX; 2] };
            index.extend(words.iter().flat_map(|word| word.to_le_bytes()));
            if is_there {
                at += packed.len();
                data.extend(packed);
            }
        }
        index.extend(crc32c(&index).to_le_bytes());
        let shard =
            if location == "start" { [index, data].concat() } else { [data, index].concat() };
        let files = files_v3(&v3(&codecs, "[4, 4, 6]"), [("s0/c/0/0/0".to_owned(), shard)]);
        let loaded = read(&files, &VolumeOptions::default()).unwrap();
        let Samples::U16(samples) = loaded.volume.samples() else { panic!("not uint16") };
        for (at, &sample) in samples.iter().enumerate() {
            let [x, y, z] = [at % 5, at / 5 % 3, at / 15];
            let is_lacking = 3 <= x && y < 2 && z < 2;
            assert_eq!(sample, if is_lacking { 9 } else { value([x, y, z]) }, "{at}");
        }
    }
}

/// A shard of so many chunks that they are unpacked on all threads, each of one voxel. At most one is broken.
fn shard_of_voxels(broken: Option<[usize; 3]>) -> Files {
    let codecs = format!(
        "[{{\"name\": \"sharding_indexed\", \"configuration\": {{\"chunk_shape\": [1, 1, 1], \"codecs\": \
         [{BYTES}, {{\"name\": \"gzip\"}}], \"index_codecs\": [{BYTES}]}}}}]"
    );
    let (mut index, mut data) = (Vec::new(), Vec::new());
    for at in 0..96 {
        let voxel = [at % 6, at / 6 % 4, at / 24];
        let mut packed = gzip(&value(voxel).to_le_bytes());
        if broken == Some(voxel) {
            packed[0] = 0;
        }
        let words = [data.len() as u64, packed.len() as u64];
        index.extend(words.iter().flat_map(|word| word.to_le_bytes()));
        data.extend(packed);
    }
    data.extend(index);
    files_v3(&v3(&codecs, "[4, 4, 6]"), [("s0/c/0/0/0".to_owned(), data)])
}

#[test]
fn zarr_3_in_shards_of_many_chunks() {
    let loaded = read(&shard_of_voxels(None), &VolumeOptions::default()).unwrap();
    let Samples::U16(samples) = loaded.volume.samples() else { panic!("not uint16") };
    for (at, &sample) in samples.iter().enumerate() {
        assert_eq!(sample, value([at % 5, at / 5 % 3, at / 15]), "{at}");
    }
    let error = read(&shard_of_voxels(Some([1, 2, 3])), &VolumeOptions::default()).unwrap_err();
    assert!(error.contains("s0/c/0/0/0") && error.contains("cannot be unpacked"), "{error}");
    // What the volume has no part in is not looked at.
    assert!(read(&shard_of_voxels(Some([5, 3, 3])), &VolumeOptions::default()).is_ok());
}

/// Boxes of chunks that are retained are those of the whole, in shards and alone, and no chunk is unpacked
/// twice while there is room.
#[test]
fn zarr_chunks_are_retained_for_other_boxes() {
    let alone = files_v2(&v2("<u2", "C", "null", "/"), "/", |idx| chunk(idx, [2, 1, 0], false));
    for (files, n_chunks) in [(alone, 8), (shard_of_voxels(None), 60)] {
        let dir = tempfile::tempdir().unwrap();
        for (key, bytes) in &files {
            let path = dir.path().join("a.zarr").join(key);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, bytes).unwrap();
        }
        let path = dir.path().join("a.zarr");
        let layer = LayerFile::of_volume(VolumeSource::File(path));
        for room in [0, 50, 1 << 20] {
            let boxes = layer.open_boxes(&ScratchDesc::default()).unwrap();
            boxes.retain_chunks(room);
            let before = boxes.chunk_counts()[0];
            for (first, last) in (0..4).flat_map(|first| (first + 1..=4).map(move |n| (first, n))) {
                let of = boxes.read([0..5, 0..3, first..last]).unwrap().volume;
                let Samples::U16(samples) = of.samples() else { panic!("not uint16") };
                for (at, &sample) in samples.iter().enumerate() {
                    assert_eq!(sample, value([at % 5, at / 5 % 3, first + at / 15]), "{at}");
                }
            }
            if 1 << 10 < room {
                assert_eq!(boxes.chunk_counts()[0] - before, n_chunks);
            }
        }
    }
}

#[test]
fn zarr_fills_what_is_not_there() {
    let meta = v2("<u2", "C", "null", "/");
    let mut files = files_v2(&meta, "/", |index| chunk(index, [2, 1, 0], false));
    files.retain(|(key, _)| !key.starts_with("s0/1") && key != "s0/0/0/1");
    let loaded = read(&files, &VolumeOptions::default()).unwrap();
    let Samples::U16(samples) = loaded.volume.samples() else { panic!("not uint16") };
    assert_eq!(samples[..5], [1, 2, 3, 9, 9]);
    assert_eq!(samples[30..], [9; 30]);
    files.truncate(3);
    assert!(read(&files, &VolumeOptions::default()).unwrap_err().contains("no chunk of the array"));
    files[2].1 = meta.replace("\"fill_value\": 9", "\"fill_value\": 0").into_bytes();
    let loaded = read(&files, &VolumeOptions::default()).unwrap();
    assert!(loaded.warnings[0].contains("all voxels have its fill value"), "{:?}", loaded.warnings);
}

/// Two levels of an image of two channels and three times.
#[test]
fn zarr_parts_are_chosen() {
    let attributes = r#"{"multiscales": [{"axes": [{"name": "t", "type": "time"},
        {"name": "c", "type": "channel"}, {"name": "y", "type": "space"}, {"name": "x", "type": "space"}],
        "datasets": [{"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [1, 1, 1, 1]}]},
        {"path": "1", "coordinateTransformations": [{"type": "scale", "scale": [1, 1, 2, 2]}]}]}]}"#;
    let array = |len: usize| {
        format!(
            "{{\"zarr_format\": 2, \"shape\": [3, 2, {len}, {len}], \"chunks\": [1, 2, {len}, {len}], \"dtype\": \
             \"|u1\", \"order\": \"C\", \"compressor\": null, \"fill_value\": 0}}"
        )
    };
    let mut files = vec![file(".zattrs", attributes)];
    for (level, len) in [(0_u8, 2), (1, 1)] {
        files.push(file(&format!("{level}/.zarray"), &array(len)));
        for time in 0..3_u8 {
            let of_channel = |channel: u8| vec![100 * level + 10 * time + channel; len * len];
            let bytes = [of_channel(0), of_channel(1)].concat();
            files.push((format!("{level}/{time}.0.0.0"), bytes));
        }
    }
    let first = read(&files, &VolumeOptions::default()).unwrap();
    assert_eq!(first.volume.samples(), &Samples::U8(vec![0; 4]));
    let choices = &first.choices;
    assert_eq!((choices.level.n, choices.channel.n, choices.time.n), (2, 2, 3));
    let options = VolumeOptions::default().level(1).channel(1).time(2);
    let other = read(&files, &options).unwrap();
    assert_eq!(other.volume.samples(), &Samples::U8(vec![121]));
    assert_eq!(other.volume.grid().spacing(), [2.0, 2.0, 1.0]);
    assert!(read(&files, &VolumeOptions::default().level(2)).unwrap_err().contains("no level 2"));
}

#[test]
fn zarr_errors_are_plain() {
    let meta = v2("<u2", "C", "null", "/");
    let whole = |index| chunk(index, [2, 1, 0], false);
    let check = |meta: &str, expected: &str| {
        let error = read(&files_v2(meta, "/", whole), &VolumeOptions::default()).unwrap_err();
        assert!(error.contains(expected) && !error.contains('\n'), "{error} lacks {expected}");
    };
    check(&meta.replace("<u2", "<c8"), "\"<c8\" cannot be samples");
    check(&meta.replace("null, \"fill", "{\"id\": \"lzma\"}, \"fill"), "packed by \"lzma\"");
    check(
        &meta.replace("\"filters\": null", "\"filters\": [{\"id\": \"delta\"}]"),
        "filter \"delta\"",
    );
    check(&meta.replace("[2, 2, 3]", "[2, 0, 3]"), "chunks cannot have the shape");
    check(&meta.replace("[2, 2, 3]", "[2, 3]"), "chunks cannot have the shape");
    check(&meta.replace("[4, 3, 5]", "[4, 3, -5]"), "not a list of sizes");
    check(&meta.replace("[4, 3, 5]", "[4, 4000000000, 5]"), "too many voxels");
    check(&meta.replace("[4, 3, 5]", "[2000, 20000, 50]"), "a million chunks");
    let large =
        meta.replace("[4, 3, 5]", "[2000, 20000, 50]").replace("[2, 2, 3]", "[200, 200, 50]");
    check(&large, "cannot be in the few chunks");
    check(&meta.replace("[2, 2, 3]", "[2, 2, 4]"), "less than it should");
    check("{", "no JSON");
    check("{}", "no samples");
    check("-8", "no JSON object");
    let files = vec![file("zarr.json", "[1]")];
    assert!(read(&files, &VolumeOptions::default()).unwrap_err().contains("no JSON object"));
    let files = vec![file(".zattrs", &format!("{{{}}}", IMAGE.replace("s0", "../s0")))];
    assert!(read(&files, &VolumeOptions::default()).unwrap_err().contains("path that cannot be"));
    let files = vec![file(".zattrs", &format!("{{{IMAGE}}}"))];
    assert!(read(&files, &VolumeOptions::default()).unwrap_err().contains("no array or image"));
    let files = vec![file(".zgroup", "{\"zarr_format\": 2}")];
    assert!(
        read(&files, &VolumeOptions::default()).unwrap_err().contains("no image of several levels")
    );
    let loaded = crate::read_volume(Path::new("/nonexistent.zarr"));
    assert!(loaded.is_err());
}
