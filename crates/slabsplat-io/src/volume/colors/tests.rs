//! One volume of colours in every format that has them, written here, or by what `convert` writes with; and
//! files that are spoilt.

use std::io::Cursor;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use slabsplat_seeds::for_each_seed;
use tiff::encoder::TiffEncoder;
use tiff::encoder::colortype::{ColorType, RGB8, RGB16, RGBA8};
use tiff::tags::Tag;

use super::*;
use crate::{FilesInMemory, write_colored_volume};

const DIMS: [usize; 3] = [5, 6, 2];

type Files = Vec<(&'static str, Vec<u8>)>;

/// Voxels of which no two are alike, nor any two axes.
fn color([x, y, z]: [usize; 3]) -> [u8; 3] {
    [40 * x + 7, 30 * y + z, 200 * z + 3 * y].map(|value| value as u8)
}

fn colors() -> Vec<[u8; 3]> {
    let [nx, ny, nz] = DIMS;
    let coords = (0..nx * ny * nz).map(|idx| [idx % nx, idx / nx % ny, idx / (nx * ny)]);
    coords.map(color).collect()
}

fn alpha() -> Vec<u8> {
    (0..colors().len()).map(|idx| (4 * idx + 1) as u8).collect()
}

fn rgb() -> Vec<u8> {
    colors().concat()
}

fn rgba() -> Vec<u8> {
    colors().into_iter().zip(alpha()).flat_map(|([r, g, b], a)| [r, g, b, a]).collect()
}

fn nrrd(kind: &str, n: usize, values: &[u8]) -> Vec<u8> {
    let header = format!(
        "NRRD0004\ntype: uchar\ndimension: 4\nsizes: {n} 5 6 2\nkinds: {kind} space space space\n\
         spacings: nan 1 1 1\nencoding: raw\n\n"
    );
    [header.as_bytes(), values].concat()
}

fn metaimage(values: &[u8]) -> Vec<u8> {
    let header = "ObjectType = Image\nNDims = 3\nDimSize = 5 6 2\nElementNumberOfChannels = 3\n\
                  ElementType = MET_UCHAR_ARRAY\nElementDataFile = LOCAL\n";
    [header.as_bytes(), values].concat()
}

fn nifti(datatype: i16, values: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0; 352];
    let mut put = |at: usize, field: &[u8]| bytes[at..at + field.len()].copy_from_slice(field);
    put(0, &348_i32.to_le_bytes());
    for (idx, size) in [3_i16, 5, 6, 2, 1, 1, 1, 1].into_iter().enumerate() {
        put(40 + 2 * idx, &size.to_le_bytes());
        put(76 + 4 * idx, &1.0_f32.to_le_bytes());
    }
    put(70, &datatype.to_le_bytes());
    put(108, &352.0_f32.to_le_bytes());
    // Which colours do not have.
    put(112, &3.0_f32.to_le_bytes());
    put(344, b"n+1\0");
    [bytes, values.to_vec()].concat()
}

fn npy(shape: &str, values: &[u8]) -> Vec<u8> {
    let text = format!("{{'descr': '|u1', 'fortran_order': False, 'shape': ({shape}), }}");
    let text = format!("{text:<117}\n");
    [&b"\x93NUMPY\x01\x00\x76\x00"[..], text.as_bytes(), values].concat()
}

fn vtk(kind: &str, array: &str, values: &[u8]) -> Vec<u8> {
    let header = format!(
        "# vtk DataFile Version 3.0\ncolours\n{kind}\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 6 2\n\
         ORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA 60\n{array}\n"
    );
    [header.as_bytes(), values].concat()
}

fn vti(values: &[u8]) -> Vec<u8> {
    let text = values.iter().map(u8::to_string).collect::<Vec<_>>().join(" ");
    let tags = format!(
        "<?xml version=\"1.0\"?><VTKFile type=\"ImageData\" version=\"1.0\"><ImageData WholeExtent=\"0 4 0 5 0 1\" \
         Origin=\"0 0 0\" Spacing=\"1 1 1\"><Piece Extent=\"0 4 0 5 0 1\"><PointData Scalars=\"c\">\
         <DataArray type=\"UInt8\" Name=\"c\" NumberOfComponents=\"3\" format=\"ascii\">{text}</DataArray>\
         </PointData></Piece></ImageData></VTKFile>"
    );
    tags.into_bytes()
}

fn tiff<C: ColorType>(description: &str, values: &[C::Inner]) -> Vec<u8>
where
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).unwrap();
    for page in values.chunks(values.len() / DIMS[2]) {
        let mut image = encoder.new_image::<C>(5, 6).unwrap();
        image.encoder().write_tag(Tag::ImageDescription, description).unwrap();
        image.write_data(page).unwrap();
    }
    bytes.into_inner()
}

/// Each value of a page an image of its own.
fn planar_tiff(values: &[u8]) -> Vec<u8> {
    let mut bytes = b"II*\0\0\0\0\0".to_vec();
    let mut link = 4;
    for page in values.chunks(values.len() / DIMS[2]) {
        let planes = bytes.len() as u32;
        bytes.extend((0..3).flat_map(|c| page.iter().skip(c).step_by(3)));
        let arrays = bytes.len() as u32;
        bytes.extend([8_u16; 3].map(u16::to_le_bytes).concat());
        bytes.extend([0, 30, 60].map(|at| (planes + at).to_le_bytes()).concat());
        bytes.extend([30_u32; 3].map(u32::to_le_bytes).concat());
        let directory = bytes.len() as u32;
        bytes[link..link + 4].copy_from_slice(&directory.to_le_bytes());
        let entries: [(u16, u16, u32, u32); 10] = [
            (256, 3, 1, 5),
            (257, 3, 1, 6),
            (258, 3, 3, arrays),
            (259, 3, 1, 1),
            (262, 3, 1, 2),
            (273, 4, 3, arrays + 6),
            (277, 3, 1, 3),
            (278, 3, 1, 6),
            (279, 4, 3, arrays + 18),
            (284, 3, 1, 2),
        ];
        bytes.extend((entries.len() as u16).to_le_bytes());
        for (tag, kind, n, value) in entries {
            bytes.extend([tag.to_le_bytes(), kind.to_le_bytes()].concat());
            bytes.extend([n.to_le_bytes(), value.to_le_bytes()].concat());
        }
        link = bytes.len();
        bytes.extend([0; 4]);
    }
    bytes
}

fn png(samples: &[u8], color: ExtendedColorType) -> Vec<u8> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes).write_image(samples, 5, 6, color).unwrap();
    bytes
}

fn pngs(samples: &[u8], color: ExtendedColorType) -> Files {
    let slices = samples.chunks(samples.len() / DIMS[2]);
    let names = ["in/a9.png", "in/a10.png"];
    names.into_iter().zip(slices).map(|(name, slice)| (name, png(slice, color))).collect()
}

fn zarr(shape: &str, key: &'static str, values: Vec<u8>) -> Files {
    let array = format!(
        "{{\"zarr_format\": 2, \"shape\": [{shape}], \"chunks\": [{shape}], \"dtype\": \"|u1\", \
         \"compressor\": null, \"fill_value\": 0, \"order\": \"C\", \"filters\": null}}"
    );
    vec![("a.zarr/.zarray", array.into_bytes()), (key, values)]
}

/// The same colours in every format: the path to read, and what there is.
fn colored_files() -> Vec<(&'static str, Files)> {
    const OME: &str = "<OME><Image><Pixels DimensionOrder=\"XYCZT\" SizeX=\"5\" SizeY=\"6\" SizeZ=\"2\" \
                       SizeC=\"3\" SizeT=\"1\"><Channel SamplesPerPixel=\"3\"/><TiffData/></Pixels></Image></OME>";
    let one = |name: &'static str, bytes: Vec<u8>| (name, vec![(name, bytes)]);
    let shares = rgb().iter().map(|&v| format!("{} ", f64::from(v) / 255.0)).collect::<String>();
    vec![
        one("a.nrrd", nrrd("RGB-color", 3, &rgb())),
        one("a.mha", metaimage(&rgb())),
        one("a.nii", nifti(128, &rgb())),
        one("a.npy", npy("2, 6, 5, 3", &rgb())),
        one("a.vtk", vtk("BINARY", "COLOR_SCALARS c 3", &rgb())),
        one("b.vtk", vtk("ASCII", "COLOR_SCALARS c 3", shares.as_bytes())),
        one("a.vti", vti(&rgb())),
        one("a.tif", tiff::<RGB8>("", &rgb())),
        one("b.tif", tiff::<RGB8>("ImageJ=1.53t\nimages=2\nslices=2\n", &rgb())),
        one("a.ome.tif", tiff::<RGB8>(OME, &rgb())),
        one("c.tif", planar_tiff(&rgb())),
        ("in", pngs(&rgb(), ExtendedColorType::Rgb8)),
        ("a.zarr", zarr("2, 6, 5, 3", "a.zarr/0.0.0.0", rgb())),
    ]
}

fn colored_files_with_alpha() -> Vec<(&'static str, Files)> {
    let one = |name: &'static str, bytes: Vec<u8>| (name, vec![(name, bytes)]);
    vec![
        one("a.nrrd", nrrd("RGBA-color", 4, &rgba())),
        one("a.nii", nifti(2304, &rgba())),
        one("a.npy", npy("2, 6, 5, 4", &rgba())),
        one("a.vtk", vtk("BINARY", "COLOR_SCALARS c 4", &rgba())),
        one("a.tif", tiff::<RGBA8>("", &rgba())),
        ("in", pngs(&rgba(), ExtendedColorType::Rgba8)),
    ]
}

fn read(path: &str, files: &Files, options: &VolumeOptions) -> Result<LoadedVolume, String> {
    let named = files.iter().map(|(name, bytes)| (*name, bytes.as_slice()));
    let files = FilesInMemory::from_iter(named);
    let loaded = files.read_volume_with(path, options).map_err(|error| error.to_string());
    let listing = files.list_volume(path, options);
    if let (Ok(loaded), Ok(listing)) = (&loaded, &listing) {
        assert_eq!(listing.choices, loaded.choices, "{path}");
        assert_eq!(listing.dims, loaded.volume.grid().dims(), "{path}");
        let bytes = listing.sample_type.size_bytes() * loaded.volume.grid().n_voxels();
        let n_values = if listing.choices.is_color { listing.choices.channel.n + 1 } else { 1 };
        assert_eq!(listing.bytes(), (n_values * bytes) as u64, "{path}");
    }
    loaded
}

fn voxels_of(loaded: &LoadedVolume) -> &ColorSamples {
    loaded.colors.as_ref().unwrap().voxels.as_ref().unwrap().samples()
}

#[test]
fn colors_are_the_same_in_every_format() {
    let expected = ColorSamples::U8(colors());
    for (path, files) in colored_files() {
        let loaded = read(path, &files, &VolumeOptions::default()).unwrap();
        assert_eq!(voxels_of(&loaded), &expected, "{path}");
        assert_eq!(loaded.volume.samples(), &expected.luminances(), "{path}");
        assert_eq!(loaded.volume.grid().dims(), DIMS, "{path}");
        let LoadedColors { has_alpha, opacity_from, .. } = loaded.colors.clone().unwrap();
        assert_eq!((has_alpha, opacity_from), (false, OpacitySource::Luminance), "{path}");
        assert_eq!(loaded.choices.channel.names, ["red", "green", "blue"], "{path}");
        let is_guess = loaded.warnings.iter().any(|what| what.contains("taken for its colour"));
        let says_nothing = ["a.mha", "a.npy", "a.vti", "a.zarr"].contains(&path);
        assert_eq!(is_guess, says_nothing, "{path}: {:?}", loaded.warnings);

        let green = read(path, &files, &VolumeOptions::default().channel(1)).unwrap();
        let greens: Vec<u8> = colors().iter().map(|color| color[1]).collect();
        assert_eq!(green.volume.samples(), &Samples::U8(greens), "{path}");
        assert_eq!(green.colors, None, "{path}");
        let error = read(path, &files, &VolumeOptions::default().channel(3)).unwrap_err();
        assert!(error.contains("there is no channel 3"), "{error}");

        let none = read(path, &files, &VolumeOptions::default().colors(ColorUse::None)).unwrap();
        assert_eq!(none.volume.samples(), &expected.luminances(), "{path}");
        assert_eq!(none.colors.unwrap().voxels, None, "{path}");
        let options = VolumeOptions::default().opacity_from(OpacitySource::Alpha);
        let error = read(path, &files, &options).unwrap_err();
        assert!(error.contains("have no alpha"), "{path}: {error}");
    }
}

#[test]
fn colors_with_alpha_are_as_opaque() {
    let expected = ColorSamples::U8(colors());
    for (path, files) in colored_files_with_alpha() {
        let loaded = read(path, &files, &VolumeOptions::default()).unwrap();
        assert_eq!(voxels_of(&loaded), &expected, "{path}");
        assert_eq!(loaded.volume.samples(), &Samples::U8(alpha()), "{path}");
        assert_eq!(loaded.colors.unwrap().opacity_from, OpacitySource::Alpha, "{path}");
        let options = VolumeOptions::default().opacity_from(OpacitySource::Luminance);
        let loaded = read(path, &files, &options).unwrap();
        assert_eq!(loaded.volume.samples(), &expected.luminances(), "{path}");
        assert_eq!(voxels_of(&loaded), &expected, "{path}");
        let last = read(path, &files, &VolumeOptions::default().channel(3)).unwrap();
        assert_eq!(last.volume.samples(), &Samples::U8(alpha()), "{path}");
    }
}

#[test]
fn colors_of_one_alpha_are_as_opaque_as_they_are_light() {
    let opaque: Vec<u8> = colors().into_iter().flat_map(|[r, g, b]| [r, g, b, 255]).collect();
    let files = vec![("a.nrrd", nrrd("RGBA-color", 4, &opaque))];
    let loaded = read("a.nrrd", &files, &VolumeOptions::default()).unwrap();
    assert_eq!(loaded.volume.samples(), &ColorSamples::U8(colors()).luminances());
    assert!(loaded.warnings.concat().contains("alpha is the same everywhere"));
    let options = VolumeOptions::default().opacity_from(OpacitySource::Alpha);
    let loaded = read("a.nrrd", &files, &options).unwrap();
    assert_eq!(loaded.volume.summary().range, Some([255.0; 2]));
}

#[test]
fn colors_of_16_bits() {
    let wide: Vec<u16> = rgb().into_iter().map(|value| 256 * u16::from(value) + 9).collect();
    let expected = wide.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2]]).collect();
    let expected = ColorSamples::U16(expected);
    let bytes: Vec<u8> = wide.iter().flat_map(|value| value.to_ne_bytes()).collect();
    for (path, files) in [
        ("a.tif", vec![("a.tif", tiff::<RGB16>("", &wide))]),
        ("in", pngs(&bytes, ExtendedColorType::Rgb16)),
    ] {
        let loaded = read(path, &files, &VolumeOptions::default()).unwrap();
        assert_eq!(voxels_of(&loaded), &expected, "{path}");
        assert_eq!(loaded.volume.samples(), &expected.luminances(), "{path}");
    }
}

#[test]
fn colors_that_nothing_says_are_asked_for() {
    let own = VolumeOptions::default().colors(ColorUse::Own);
    let vector = vec![("a.nrrd", nrrd("vector", 3, &rgb()))];
    assert_eq!(read("a.nrrd", &vector, &VolumeOptions::default()).unwrap().colors, None);
    let asked = read("a.nrrd", &vector, &own).unwrap();
    assert_eq!(voxels_of(&asked), &ColorSamples::U8(colors()));
    let slice = vec![("a.npy", npy("6, 5, 3", &rgb()[..90]))];
    let asked = read("a.npy", &slice, &own).unwrap();
    assert_eq!(voxels_of(&asked), &ColorSamples::U8(colors()[..30].to_vec()));
    // Channels in front, as microscopes have them.
    let planes: Vec<u8> = (0..3).flat_map(|c| rgb().into_iter().skip(c).step_by(3)).collect();
    let channels = zarr("3, 2, 6, 5", "a.zarr/0.0.0.0", planes);
    let named = "{\"multiscales\": [{\"version\": \"0.4\", \"axes\": [{\"name\": \"c\", \"type\": \"channel\"}, \
                 {\"name\": \"z\", \"type\": \"space\"}, {\"name\": \"y\", \"type\": \"space\"}, \
                 {\"name\": \"x\", \"type\": \"space\"}], \"datasets\": [{\"path\": \"0\"}]}]}";
    let mut image: Files = vec![("a.zarr/.zattrs", named.into())];
    image.extend(channels.into_iter().map(|(name, bytes)| match name {
        "a.zarr/.zarray" => ("a.zarr/0/.zarray", bytes),
        _ => ("a.zarr/0/0.0.0.0", bytes),
    }));
    assert_eq!(read("a.zarr", &image, &VolumeOptions::default()).unwrap().colors, None);
    let asked = read("a.zarr", &image, &own).unwrap();
    assert_eq!(voxels_of(&asked), &ColorSamples::U8(colors()));
}

#[test]
fn colors_that_there_are_not() {
    let gray = vec![("a.npy", npy("2, 6, 5", &alpha()))];
    let rgb = vec![("a.nrrd", nrrd("RGB-color", 3, &rgb()))];
    let check = |files: &Files, options: &VolumeOptions, expected: &str| {
        let error = read(files[0].0, files, options).unwrap_err();
        assert!(error.contains(expected) && !error.contains('\n'), "{error} lacks {expected}");
    };
    let own = VolumeOptions::default().colors(ColorUse::Own);
    check(&gray, &own, "its voxels have no colours, which are three or four integers");
    let lightness = VolumeOptions::default().opacity_from(OpacitySource::Luminance);
    check(&gray, &lightness, "leave out opacity_from");
    check(&rgb, &own.channel(1), "leave out channel, or colors");
    assert!(read("a.npy", &gray, &VolumeOptions::default().colors(ColorUse::None)).is_ok());
}

/// A gray image with alpha is one of two channels.
#[test]
fn gray_with_alpha_is_two_channels() {
    let pixels: Vec<u8> = alpha().into_iter().flat_map(|value| [value, 255 - value]).collect();
    let files = pngs(&pixels, ExtendedColorType::La8);
    let loaded = read("in", &files, &VolumeOptions::default()).unwrap();
    assert_eq!(loaded.volume.samples(), &Samples::U8(alpha()));
    assert_eq!(loaded.choices.channel.names, ["gray", "alpha"]);
    assert!(loaded.warnings.concat().contains("there are 2 channels"));
}

#[test]
fn colors_that_break_off_are_refused() {
    for (path, files) in colored_files().into_iter().chain(colored_files_with_alpha()) {
        let (name, whole) = files.last().unwrap();
        // All tags at the end, or all digits of the last number.
        let n_less = match path {
            "a.vti" => 60,
            "b.vtk" => 25,
            _ => 1,
        };
        let n_needed = whole.len() - n_less;
        for n_bytes in (0..n_needed).step_by(23).chain([n_needed]) {
            let mut files = files.clone();
            files.retain(|(other, _)| other != name);
            files.push((name, whole[..n_bytes].to_vec()));
            match read(path, &files, &VolumeOptions::default()) {
                Err(error) => assert!(!error.contains('\n'), "{error}"),
                // A page that lacks whole, or an image's last bytes, which say only that it ends.
                Ok(_) => assert!(path.ends_with("tif") || path == "in", "{path}: {n_bytes} bytes"),
            }
        }
    }
}

#[test]
fn colors_are_written_and_read_again() {
    for_each_seed(3, |mut rng| {
        let dir = tempfile::tempdir().unwrap();
        let grid = Grid::with_spacing([7, 5, 5], [0.5, 1.0, 2.0]).unwrap();
        let n_voxels = grid.n_voxels();
        let is_wide = rng.bool();
        let samples = if is_wide {
            ColorSamples::U16((0..n_voxels).map(|_| [0; 3].map(|_| rng.u16(..))).collect())
        } else {
            ColorSamples::U8((0..n_voxels).map(|_| [0; 3].map(|_| rng.u8(..))).collect())
        };
        let is_alpha = rng.bool();
        let scalar: Samples = match (is_alpha, is_wide) {
            (false, _) => samples.luminances(),
            (true, false) => (0..n_voxels).map(|_| rng.u8(..)).collect::<Vec<_>>().into(),
            (true, true) => (0..n_voxels).map(|_| rng.u16(..)).collect::<Vec<_>>().into(),
        };
        let volume = slabsplat_core::Volume::new(grid, scalar, Scaling::IDENTITY).unwrap();
        let colors = LoadedColors {
            voxels: VoxelColors::new(grid.dims(), samples.clone()).ok(),
            has_alpha: is_alpha,
            opacity_from: OpacitySource::ALL[usize::from(is_alpha)],
        };
        for name in ["a.nrrd", "a.nii", "a.nii.gz", "a.mha", "a.npy", "a.raw", "a.zarr"] {
            let path = dir.path().join(name);
            let what = format!("{name}, alpha {is_alpha}, wide {is_wide}");
            let warnings = write_colored_volume(&path, &volume, &colors).unwrap().concat();
            let options = VolumeOptions::default();
            let is_lost = matches!(name, "a.raw" | "a.zarr") || is_wide && name.contains(".nii");
            assert_eq!(warnings.contains("has no colours"), is_lost, "{what}: {warnings}");
            // Three numbers of 16 bits are a colour only if somebody says so.
            let is_unsaid = is_wide && matches!(name, "a.mha" | "a.npy") && !is_lost;
            let options = if is_unsaid { options.colors(ColorUse::Own) } else { options };
            let loaded = crate::read_volume_with(&path, &options).unwrap();
            assert_eq!(loaded.volume.samples(), volume.samples(), "{what}");
            assert_eq!(loaded.colors.is_none(), is_lost, "{what}");
            if !is_lost {
                assert_eq!(voxels_of(&loaded), &samples, "{what}");
            }
            if name != "a.npy" {
                assert_eq!(loaded.volume.grid(), &grid, "{what}");
            }
        }
    });
}

#[test]
fn colors_are_taken_apart() {
    let of = |samples: Samples, n| {
        let ColorParts { colors, alpha } = ColorParts::of(samples, n).unwrap();
        (colors, alpha)
    };
    let rgb = ColorSamples::U8(vec![[1, 2, 3], [4, 5, 6]]);
    assert_eq!(of(vec![1_u8, 2, 3, 4, 5, 6].into(), 3), (rgb.clone(), None));
    let mut roomy = Vec::with_capacity(100);
    roomy.extend([1_u8, 2, 3, 4, 5, 6]);
    assert_eq!(of(roomy.into(), 3), (rgb.clone(), None));
    let alpha = Some(Samples::U8(vec![10, 20]));
    assert_eq!(of(vec![1_u8, 2, 3, 10, 4, 5, 6, 20].into(), 4), (rgb, alpha));
    let wide = of(vec![1_u16, 2, 3, 65535].into(), 4);
    assert_eq!(wide.0, ColorSamples::U16(vec![[1, 2, 3]]));
    assert_eq!(wide.1, Some(Samples::U16(vec![65535])));
    assert!(ColorParts::of(vec![1.0_f32; 3].into(), 3).is_none());
}

#[test]
fn one_value_of_each_is_picked() {
    let check = |sample_bytes, chosen, expected: &[u8]| {
        let mut pixels: Vec<u8> = (0..12).collect();
        pick(&mut pixels, sample_bytes, [12 / sample_bytes / 2, chosen]);
        assert_eq!(pixels, expected);
    };
    check(1, 0, &[0, 6]);
    check(2, 2, &[4, 5, 10, 11]);
    check(3, 1, &[3, 4, 5, 9, 10, 11]);
}

#[test]
fn unmultiplied_colors_are_whole_again() {
    let mut pixels = vec![0, 50, 100, 100, 255, 7, 0, 255, 9, 0, 0, 0];
    unmultiply(&mut pixels, SampleType::U8);
    assert_eq!(pixels, [0, 128, 255, 100, 255, 7, 0, 255, 0, 0, 0, 0]);
    let mut wide: Vec<u8> = bytemuck::cast_slice(&[1000_u16, 0, 60000, 30000]).to_vec();
    unmultiply(&mut wide, SampleType::U16);
    assert_eq!(bytemuck::pod_collect_to_vec::<u8, u16>(&wide), [2185, 0, 65535, 30000]);
}

#[test]
fn colors_are_those_that_are_meant_or_asked_for() {
    use Meaning::{Color, Other, Unsaid};
    let [u8_type, u16_type, f32_type] =
        [SampleType::U8, SampleType::U16, SampleType::F32].map(StoredType::Sample);
    let check = |n, stored, meaning, options: &VolumeOptions, expected: bool| {
        let values = Values { n, stored, meaning };
        assert_eq!(options.take_colors(&values), expected, "{values:?} {options:?}");
    };
    let silent = VolumeOptions::default();
    let own = VolumeOptions::default().colors(ColorUse::Own);
    let none = VolumeOptions::default().colors(ColorUse::None);
    for (n, stored, meaning, of_itself, if_asked) in [
        (3, u8_type, Color, true, true),
        (4, u16_type, Color, true, true),
        (3, u8_type, Unsaid, true, true),
        (3, u16_type, Unsaid, false, true),
        (4, u8_type, Other, false, true),
        (2, u8_type, Color, false, false),
        (5, u8_type, Color, false, false),
        (3, f32_type, Color, false, false),
    ] {
        check(n, stored, meaning, &silent, of_itself);
        check(n, stored, meaning, &none, of_itself);
        check(n, stored, meaning, &own, if_asked);
        check(n, stored, meaning, &own.clone().channel(0), false);
    }
}
