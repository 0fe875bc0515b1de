//! Whole NIfTI files of both versions, written here field by field.

use std::io::Write;
use std::path::Path;

use slabsplat_core::glam::{DMat3, DVec3};
use slabsplat_core::{SampleType, Samples};

use crate::store::read_from_both as read;
use crate::{Endian, LoadedVolume, VolumeFormat, VolumeOptions, read_volume};

/// A file in the making.
#[derive(Clone)]
struct Nifti {
    bytes: Vec<u8>,
    version: u8,
    endian: Endian,
}

impl Nifti {
    /// 2 × 2 × 1 voxels of 16 bits, no scaling, no orientation.
    fn new(version: u8, endian: Endian) -> Self {
        let n_header_bytes = if version == 1 { 348 } else { 540 };
        let mut nifti = Self { bytes: vec![0; n_header_bytes + 4], version, endian };
        nifti.put(0, (n_header_bytes as i32).to_le_bytes());
        let (magic_at, magic): (usize, &[u8]) =
            if version == 1 { (344, b"n+1\0") } else { (4, b"n+2\0\r\n\x1a\n") };
        nifti.bytes[magic_at..magic_at + magic.len()].copy_from_slice(magic);
        nifti.dims(&[2, 2, 1]).datatype(4).pixdim(&[1.0, 2.0, 3.0, 4.0]).offset(352.0)
    }

    fn put<const N: usize>(&mut self, offset: usize, mut bytes: [u8; N]) {
        if self.endian == Endian::Big {
            bytes.reverse();
        }
        self.bytes[offset..offset + N].copy_from_slice(&bytes);
    }

    fn put_float(&mut self, [one, two]: [usize; 2], idx: usize, value: f64) {
        if self.version == 1 {
            self.put(one + 4 * idx, (value as f32).to_le_bytes());
        } else {
            self.put(two + 8 * idx, value.to_le_bytes());
        }
    }

    fn put_floats(mut self, at: [usize; 2], values: &[f64]) -> Self {
        for (idx, &value) in values.iter().enumerate() {
            self.put_float(at, idx, value);
        }
        self
    }

    fn dims(mut self, dims: &[i64]) -> Self {
        let all = [dims.len() as i64].into_iter().chain(dims.iter().copied());
        for (idx, size) in all.enumerate() {
            if self.version == 1 {
                self.put(40 + 2 * idx, (size as i16).to_le_bytes());
            } else {
                self.put(16 + 8 * idx, size.to_le_bytes());
            }
        }
        self
    }

    fn datatype(mut self, code: i16) -> Self {
        self.put(if self.version == 1 { 70 } else { 12 }, code.to_le_bytes());
        self
    }

    fn pixdim(self, pixdim: &[f64]) -> Self {
        self.put_floats([76, 104], pixdim)
    }

    fn offset(mut self, offset: f32) -> Self {
        if self.version == 1 {
            self.put(108, offset.to_le_bytes());
        } else {
            self.put(168, (offset as i64).to_le_bytes());
        }
        self
    }

    fn scaling(self, slope: f64, intercept: f64) -> Self {
        self.put_floats([112, 176], &[slope, intercept])
    }

    fn codes(mut self, qform: i16, sform: i16) -> Self {
        for (code, at_one, at_two) in [(qform, 252, 344), (sform, 254, 348)] {
            if self.version == 1 {
                self.put(at_one, code.to_le_bytes());
            } else {
                self.put(at_two, i32::from(code).to_le_bytes());
            }
        }
        self
    }

    fn qform(self, quatern_and_offset: &[f64; 6]) -> Self {
        self.put_floats([256, 352], quatern_and_offset)
    }

    fn sform(self, rows: &[f64; 12]) -> Self {
        self.put_floats([280, 400], rows)
    }

    fn units(mut self, code: u8) -> Self {
        if self.version == 1 {
            self.bytes[123] = code;
        } else {
            self.put(500, i32::from(code).to_le_bytes());
        }
        self
    }

    /// The file with 1, 2, 3, −1 in it.
    fn with_data(&self) -> Vec<u8> {
        let mut bytes = self.bytes.clone();
        for sample in [1_i16, 2, 3, -1] {
            bytes.extend(match self.endian {
                Endian::Little => sample.to_le_bytes(),
                Endian::Big => sample.to_be_bytes(),
            });
        }
        bytes
    }

    fn read(&self) -> Result<LoadedVolume, String> {
        read(&[("a.nii", &self.with_data())])
    }
}

fn all() -> [Nifti; 4] {
    [(1, Endian::Little), (1, Endian::Big), (2, Endian::Little), (2, Endian::Big)]
        .map(|(version, endian)| Nifti::new(version, endian))
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn nifti_single_file() {
    for nifti in all() {
        let loaded = nifti.read().unwrap();
        assert_eq!(loaded.volume.samples(), &Samples::I16(vec![1, 2, 3, -1]));
        assert_eq!(loaded.warnings, [""; 0]);
        let is_one = nifti.version == 1;
        let format = if is_one { VolumeFormat::Nifti1 } else { VolumeFormat::Nifti2 };
        assert_eq!(loaded.format, format);
        let packed = read(&[("a.nii.gz", &gzip(&nifti.with_data()))]).unwrap();
        assert_eq!(packed.volume.samples(), loaded.volume.samples());
    }
}

#[test]
fn nifti_pair() {
    for nifti in all() {
        let mut header = nifti.clone().offset(0.0).bytes;
        let magic_at = if nifti.version == 1 { 345 } else { 5 };
        header[magic_at] = b'i';
        let data = &nifti.with_data()[nifti.bytes.len()..];
        for files in [
            [("a.hdr", &header[..]), ("a.img", data)],
            [("a.img", data), ("a.hdr", &header)],
            [("a.hdr.gz", &gzip(&header)), ("a.img.gz", &gzip(data))],
            [("a.img.gz", &gzip(data)), ("a.hdr", &header)],
        ] {
            let loaded = read(&files).unwrap();
            assert_eq!(loaded.volume.samples(), &Samples::I16(vec![1, 2, 3, -1]));
        }
        assert!(read(&[("a.hdr", &header)]).unwrap_err().contains(".img is missing"));
        assert!(read(&[("a.img", data)]).unwrap_err().contains(".hdr is missing"));
    }
}

#[test]
fn nifti_sample_types() {
    for (code, sample_type) in [
        (2, SampleType::U8),
        (256, SampleType::I8),
        (4, SampleType::I16),
        (512, SampleType::U16),
        (8, SampleType::I32),
        (768, SampleType::U32),
        (16, SampleType::F32),
        (64, SampleType::F64),
    ] {
        let n_voxels = 8 / sample_type.size_bytes() as i64;
        let nifti = Nifti::new(1, Endian::Big).dims(&[n_voxels, 1, 1]).datatype(code);
        let loaded = nifti.read().unwrap();
        assert_eq!(loaded.volume.sample_type(), sample_type);
        assert_eq!(loaded.warnings, [""; 0]);
    }
    for (code, expected) in
        [(1, "single bits"), (32, "complex"), (1536, "128-bit floats"), (3, "code 3")]
    {
        let err = Nifti::new(2, Endian::Little).datatype(code).read().unwrap_err();
        assert!(err.contains(expected), "{err}");
    }
}

#[test]
fn nifti_scaling() {
    for nifti in all() {
        let range = |slope, intercept| {
            nifti.clone().scaling(slope, intercept).read().unwrap().volume.summary().range.unwrap()
        };
        assert_eq!(range(2.0, 10.0), [8.0, 16.0]);
        assert_eq!(range(0.0, 10.0), [-1.0, 3.0], "a slope of 0 is no scaling");
        assert_eq!(range(f64::NAN, 10.0), [-1.0, 3.0]);
    }
}

#[test]
fn nifti_orientation_methods() {
    // A quarter turn about z, third axis mirrored.
    let half = 0.5_f64.sqrt();
    let turned = DMat3::from_cols(DVec3::Y * 2.0, DVec3::X * -3.0, DVec3::Z * -4.0);
    let rows = [9.0, 1.0, 0.0, 5.0, 0.0, 9.0, 2.0, 6.0, 0.0, 0.0, 9.0, 7.0];
    for nifti in all() {
        let nifti = nifti
            .pixdim(&[-1.0, 2.0, 3.0, 4.0])
            .qform(&[0.0, 0.0, half, -1.0, -2.0, -3.0])
            .sform(&rows);
        let place = |nifti: Nifti| nifti.read().unwrap().volume.grid().world_from_index();
        let plain = place(nifti.clone());
        assert_eq!(plain.matrix3, DMat3::from_diagonal(DVec3::new(2.0, 3.0, 4.0)));
        assert_eq!(plain.translation, DVec3::ZERO);
        let by_qform = place(nifti.clone().codes(1, 0));
        assert!(by_qform.matrix3.abs_diff_eq(turned, 1e-6), "{by_qform:?}");
        assert_eq!(by_qform.translation, DVec3::new(-1.0, -2.0, -3.0));
        let by_sform = place(nifti.clone().codes(1, 1));
        assert_eq!(by_sform.matrix3.row(0), DVec3::new(9.0, 1.0, 0.0));
        assert_eq!(by_sform.matrix3.row(1), DVec3::new(0.0, 9.0, 2.0));
        assert_eq!(by_sform.translation, DVec3::new(5.0, 6.0, 7.0));
        let singular = nifti.clone().sform(&[0.0; 12]).codes(1, 1).read().unwrap();
        assert_eq!(singular.volume.grid().world_from_index(), by_qform);
        assert_eq!(singular.warnings.len(), 1);
        let in_micrometres = place(nifti.units(3));
        assert!((in_micrometres.matrix3.y_axis.y - 0.003).abs() < 1e-12);
    }
}

#[test]
fn nifti_series_takes_the_first() {
    for nifti in all() {
        let loaded = nifti.dims(&[2, 1, 1, 2]).read().unwrap();
        assert_eq!(loaded.volume.samples(), &Samples::I16(vec![1, 2]));
        assert!(loaded.warnings[0].contains("2 times"), "{:?}", loaded.warnings);
    }
}

#[test]
fn nifti_bad_headers_are_named() {
    let check = |nifti: Nifti, expected: &str| {
        let err = nifti.read().unwrap_err();
        assert!(err.contains(expected), "{err} should contain {expected}");
        assert!(!err.contains('\n'), "{err} should be one line");
    };
    for nifti in all() {
        check(nifti.clone().dims(&[2, -2, 1]), "cannot be -2 voxels long");
        check(nifti.clone().dims(&[2, 2, 2]), "needs 16 bytes of data, has 8");
        check(nifti.clone().dims(&[]), "has 0 axes");
        check(nifti.clone().dims(&[32767, 32767, 32767]), "too many voxels");
        check(nifti.clone().dims(&[32767, 32767, 1]), "bytes of data, has 8");
        check(nifti.clone().offset(-1.0), "cannot begin at byte -1");
        check(nifti.clone().offset(1e9), "has 0");
    }
    check(Nifti::new(2, Endian::Big).dims(&[i64::MAX, 2, 2]), "too many voxels");
    check(Nifti::new(1, Endian::Big).offset(f32::NAN), "byte NaN");
    let mut analyze = Nifti::new(1, Endian::Little);
    analyze.bytes[344..348].fill(0);
    check(analyze, "not a NIfTI file");
}

#[test]
fn nifti_cut_off_anywhere() {
    for nifti in all() {
        let whole = nifti.with_data();
        for n_bytes in 0..whole.len() {
            let err = read(&[("a.nii", &whole[..n_bytes])]).unwrap_err();
            assert!(err.contains("a.nii"), "{err}");
        }
        let packed = gzip(&whole);
        for n_bytes in 0..packed.len() {
            assert!(read(&[("a.nii.gz", &packed[..n_bytes])]).is_err(), "{n_bytes} bytes");
        }
    }
}

/// The crate `nifti` is an independent reader of NIfTI-1.
#[test]
fn nifti_header_as_the_nifti_crate_reads_it() {
    for endian in [Endian::Little, Endian::Big] {
        let ours = Nifti::new(1, endian).scaling(2.0, 3.0).sform(&[1.5; 12]).codes(2, 3);
        let theirs = nifti::NiftiHeader::from_reader(&ours.bytes[..]).unwrap();
        let ours = super::Header::parse(&ours.bytes).unwrap();
        assert_eq!(ours.dim, theirs.dim.map(i64::from));
        assert_eq!(ours.datatype, i64::from(theirs.datatype));
        assert_eq!(ours.pixdim, theirs.pixdim.map(f64::from));
        assert_eq!([ours.scl_slope, ours.scl_inter], [2.0, 3.0]);
        assert_eq!(ours.vox_offset, f64::from(theirs.vox_offset));
        assert_eq!(ours.srow[2], theirs.srow_z.map(f64::from));
        let codes = [theirs.qform_code, theirs.sform_code].map(i64::from);
        assert_eq!([ours.qform_code, ours.sform_code], codes);
    }
}

#[test]
fn nifti_gone() {
    let err = read_volume(Path::new("/nonexistent/a.nii.gz")).unwrap_err().to_string();
    assert!(err.starts_with("cannot read /nonexistent/a.nii.gz: "), "{err}");
}

#[test]
fn nifti_volumes_are_chosen() {
    for nifti in all() {
        let bytes = nifti.dims(&[1, 1, 1, 2, 2]).with_data();
        let files = crate::FilesInMemory::from_iter([("a.nii", &bytes[..])]);
        let read = |options| files.read_volume_with("a.nii", &options);
        let options = VolumeOptions::default();
        for (time, channel, sample) in [(0, 0, 1), (1, 0, 2), (0, 1, 3), (1, 1, -1)] {
            let loaded = read(options.clone().time(time).channel(channel)).unwrap();
            assert_eq!(loaded.volume.samples(), &Samples::I16(vec![sample]));
            assert_eq!(loaded.warnings, [""; 0]);
            assert_eq!([loaded.choices.time.n, loaded.choices.channel.n], [2, 2]);
        }
        let error = read(options.clone().time(2)).unwrap_err().to_string();
        assert_eq!(error, "a.nii: there is no time 2: there is 0 to 1");
        let error = read(options.series(1)).unwrap_err().to_string();
        assert_eq!(error, "a.nii: there is no series 1: there is only 0");
    }
}

#[test]
fn nifti_of_wide_integers() {
    for nifti in all() {
        let nifti = nifti.dims(&[1, 1, 1]).datatype(1024);
        let loaded = nifti.read().unwrap();
        assert_eq!(
            loaded.volume.sample_type(),
            SampleType::F64,
            "four numbers of 16 bits are one of 64"
        );
        let mut bytes = nifti.bytes.clone();
        bytes.extend(match nifti.endian {
            Endian::Little => (-7_i64).to_le_bytes(),
            Endian::Big => (-7_i64).to_be_bytes(),
        });
        let narrow = read(&[("a.nii", &bytes)]).unwrap();
        assert_eq!(narrow.volume.samples(), &Samples::I32(vec![-7]));
        assert_eq!(narrow.warnings, ["samples of int64 became int32, which holds all of them"]);
        let error = nifti.dims(&[2, 1, 1]).read().unwrap_err();
        assert!(error.contains("needs 16 bytes of data, has 8"), "{error}");
    }
}

#[test]
fn nifti_colors_are_channels() {
    let nifti = Nifti::new(1, Endian::Little).dims(&[2, 1, 1]).datatype(2304);
    let mut bytes = nifti.bytes.clone();
    bytes.extend([1, 2, 3, 4, 5, 6, 7, 8]);
    let files = crate::FilesInMemory::from_iter([("a.nii", bytes.as_slice())]);
    let loaded = files.read_volume_with("a.nii", &VolumeOptions::default().channel(2)).unwrap();
    assert_eq!(loaded.volume.samples(), &Samples::U8(vec![3, 7]));
    assert_eq!(loaded.choices.channel.names, ["red", "green", "blue", "alpha"]);
    let all = files.read_volume("a.nii").unwrap();
    assert_eq!(all.volume.samples(), &Samples::U8(vec![4, 8]), "alpha");
    assert_eq!((all.choices.is_color, all.warnings.as_slice()), (true, &[][..]));
}

#[test]
fn nifti_warns_of_voxels_without_a_length() {
    for length in [0.0, f64::NAN] {
        let loaded = Nifti::new(1, Endian::Big).pixdim(&[1.0, 2.0, length, 4.0]).read().unwrap();
        assert_eq!(loaded.volume.grid().spacing(), [2.0, 1.0, 4.0]);
        let expected = format!("voxels are {length} long along axis 2: 1 was assumed");
        assert_eq!(loaded.warnings, [expected]);
    }
}

#[test]
fn nifti_of_cifti_is_refused() {
    let mut nifti = Nifti::new(2, Endian::Little);
    nifti.put(504, 3001_i32.to_le_bytes());
    assert!(nifti.read().unwrap_err().contains("CIFTI"));
}

#[test]
fn nifti_was_analyze() {
    for endian in [Endian::Little, Endian::Big] {
        let mut nifti = Nifti::new(1, endian).offset(0.0).codes(1, 1);
        nifti.bytes[344..348].fill(0);
        nifti.bytes[38] = b'r';
        nifti.put(72, 16_i16.to_le_bytes());
        let data = nifti.with_data().split_off(nifti.bytes.len());
        let loaded = read(&[("a.img", &data), ("a.hdr", &nifti.bytes)]).unwrap();
        assert_eq!(loaded.format, VolumeFormat::Analyze);
        assert_eq!(loaded.volume.samples(), &Samples::I16(vec![1, 2, 3, -1]));
        let affine = loaded.volume.grid().world_from_index();
        assert_eq!(affine.matrix3.x_axis, DVec3::new(-2.0, 0.0, 0.0));
        assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
    }
}
