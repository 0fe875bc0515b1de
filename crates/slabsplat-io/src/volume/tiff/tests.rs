//! Whole TIFFs, written here page by page.

use std::fs::File;
use std::path::Path;

use slabsplat_core::Samples;
use tiff::encoder::colortype::{
    CMYK8, ColorType, Gray8, Gray16, Gray32Float, Gray64, GrayI16, GrayI64,
};
use tiff::encoder::{Compression, Rational, TiffEncoder, TiffValue};
use tiff::tags::Tag;

use crate::store::read_from_both;
use crate::{LoadedVolume, VolumeFormat, VolumeOptions, list_volume, read_volume};

/// Pages of 3 × 2 pixels, with a description of the first, and its resolution.
struct Written<'a> {
    description: &'a str,
    resolution: Option<[u32; 2]>,
    compression: Compression,
    is_big: bool,
}

const PLAIN: Written<'static> = Written {
    description: "",
    resolution: None,
    compression: Compression::Uncompressed,
    is_big: false,
};

impl Written<'_> {
    /// Page `n` has the samples `first + 6n …`.
    fn write<C: ColorType>(&self, path: &Path, pages: &[Vec<C::Inner>])
    where
        [C::Inner]: TiffValue,
    {
        let file = File::create(path).unwrap();
        if self.is_big {
            let encoder = TiffEncoder::new_big(file).unwrap();
            return self.write_pages::<C, _>(encoder, pages);
        }
        self.write_pages::<C, _>(TiffEncoder::new(file).unwrap(), pages);
    }

    fn write_pages<C: ColorType, K: tiff::encoder::TiffKind>(
        &self,
        encoder: TiffEncoder<File, K>,
        pages: &[Vec<C::Inner>],
    ) where
        [C::Inner]: TiffValue,
    {
        let mut encoder = encoder.with_compression(self.compression);
        for (idx, page) in pages.iter().enumerate() {
            let mut image = encoder.new_image::<C>(3, 2).unwrap();
            if idx == 0 {
                let tags = image.encoder();
                tags.write_tag(Tag::ImageDescription, self.description).unwrap();
                if let Some([n, d]) = self.resolution {
                    tags.write_tag(Tag::XResolution, Rational { n, d }).unwrap();
                    tags.write_tag(Tag::YResolution, Rational { n, d: 2 * d }).unwrap();
                }
            }
            image.write_data(page).unwrap();
        }
    }

    fn read8(&self, n_pages: u8) -> Result<LoadedVolume, String> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.tif");
        let pages: Vec<Vec<u8>> = (0..n_pages).map(|z| (6 * z..6 * z + 6).collect()).collect();
        self.write::<Gray8>(&path, &pages);
        read_from_both(&[("a.tif", &std::fs::read(&path).unwrap())])
    }
}

fn bytes_of(loaded: &LoadedVolume) -> &[u8] {
    let Samples::U8(samples) = loaded.volume.samples() else { panic!("not of 8 bits") };
    samples
}

#[test]
fn tiff_pages_are_slices() {
    for compression in [
        Compression::Uncompressed,
        Compression::Lzw,
        Compression::Deflate(Default::default()),
        Compression::Packbits,
    ] {
        for is_big in [false, true] {
            let loaded = Written { compression, is_big, ..PLAIN }.read8(4).unwrap();
            assert_eq!(bytes_of(&loaded), (0..24).collect::<Vec<u8>>());
            assert_eq!(loaded.volume.grid().dims(), [3, 2, 4]);
            assert_eq!(loaded.format, VolumeFormat::Tiff);
            assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
        }
    }
}

#[test]
fn tiff_samples_have_their_own_type() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("misnamed.raw");
    let read = || read_volume(&path).unwrap().volume.samples().clone();
    PLAIN.write::<Gray16>(&path, &[vec![0, 1, 2, 3, 4, 65535]]);
    assert_eq!(read(), Samples::U16(vec![0, 1, 2, 3, 4, 65535]));
    PLAIN.write::<GrayI16>(&path, &[vec![-1000, 1, 2, 3, 4, 5]]);
    assert_eq!(read(), Samples::I16(vec![-1000, 1, 2, 3, 4, 5]));
    let packed = Written { compression: Compression::Lzw, ..PLAIN };
    packed.write::<Gray32Float>(&path, &[vec![0.5, -1.0, 2.0, 3.0, 4.0, f32::INFINITY]]);
    assert_eq!(read(), Samples::F32(vec![0.5, -1.0, 2.0, 3.0, 4.0, f32::INFINITY]));
    assert_eq!(list_volume(&path, &VolumeOptions::default()).unwrap().bytes(), 24);
    PLAIN.write::<Gray64>(&path, &[vec![0, 1, 2, 3, 4, 1 << 31]]);
    assert_eq!(read(), Samples::U32(vec![0, 1, 2, 3, 4, 1 << 31]));
    packed.write::<GrayI64>(&path, &[vec![0, -1, 2, 3, 4, 5], vec![0, 1, 2, 3, 4, i64::MIN]]);
    let wide = [0.0, -1.0, 2.0, 3.0, 4.0, 5.0, 0.0, 1.0, 2.0, 3.0, 4.0, i64::MIN as f64];
    assert_eq!(read(), Samples::F64(wide.to_vec()));
}

fn ome(pixels: &str, blocks: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?><OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\"><Image \
         ID=\"Image:0\"><Pixels {pixels}>{blocks}</Pixels></Image></OME>"
    )
}

#[test]
fn tiff_of_ome_says_which_pages_are_slices() {
    let slices = |pixels: &str, blocks: &str| {
        let description = ome(pixels, blocks);
        let loaded = Written { description: &description, ..PLAIN }.read8(4);
        loaded.map(|loaded| bytes_of(&loaded).iter().step_by(6).map(|v| v / 6).collect::<Vec<_>>())
    };
    let all = "<TiffData IFD=\"0\" PlaneCount=\"4\"/>";
    let of = |order: &str, z: u32, c: u32, t: u32| {
        format!("DimensionOrder=\"{order}\" SizeZ=\"{z}\" SizeC=\"{c}\" SizeT=\"{t}\"")
    };
    assert_eq!(slices(&of("XYZCT", 4, 1, 1), all).unwrap(), [0, 1, 2, 3]);
    assert_eq!(slices(&of("XYCZT", 4, 1, 1), "").unwrap(), [0, 1, 2, 3]);
    assert_eq!(slices(&of("XYZCT", 2, 2, 1), all).unwrap(), [0, 1]);
    assert_eq!(slices(&of("XYCZT", 2, 2, 1), all).unwrap(), [0, 2]);
    assert_eq!(slices(&of("XYTZC", 2, 1, 2), all).unwrap(), [0, 2]);
    let places: String = [(3, 0), (1, 1)]
        .map(|(ifd, z)| format!("<TiffData IFD=\"{ifd}\" FirstZ=\"{z}\" PlaneCount=\"1\"/>"))
        .concat();
    assert_eq!(slices(&of("XYZCT", 2, 1, 1), &places).unwrap(), [3, 1]);
    let error = slices(&of("XYZCT", 5, 1, 1), all).unwrap_err();
    assert!(error.contains("tells of 5 slices"), "{error}");
    let error = slices(&of("XYZCT", 3, 1, 1), &places).unwrap_err();
    assert!(error.contains("not all in this file"), "{error}");
    let error = slices("SizeZ=\"4\"", "<TiffData\n").unwrap_err();
    assert!(error.contains("broken in line 2") && !error.contains('\n'), "{error}");
    assert!(slices("SizeZ=\"-1\"", "").unwrap_err().contains("\"-1\" for SizeZ"));
}

#[test]
fn tiff_channels_and_times_are_chosen() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.tif");
    let pages: Vec<Vec<u8>> = (0..8).map(|page| vec![page; 6]).collect();
    let first_pages = |description: &str, options: VolumeOptions| {
        Written { description, ..PLAIN }.write::<Gray8>(&path, &pages);
        let loaded = crate::read_volume_with(&path, &options).map_err(|e| e.to_string())?;
        let choices = [&loaded.choices.channel, &loaded.choices.time];
        assert_eq!(choices.map(|choice| choice.n), [2, 2]);
        Ok::<_, String>(bytes_of(&loaded).iter().step_by(6).copied().collect::<Vec<_>>())
    };
    let channels = "<Channel Name=\"DAPI\"/><Channel Name=\"GFP\"/>";
    let ome = ome("DimensionOrder=\"XYCZT\" SizeZ=\"2\" SizeC=\"2\" SizeT=\"2\"", channels);
    let imagej = "ImageJ=1.53t\nimages=8\nchannels=2\nslices=2\nframes=2\n";
    let options = VolumeOptions::default();
    for description in [ome.as_str(), imagej] {
        let read =
            |channel, time| first_pages(description, options.clone().channel(channel).time(time));
        assert_eq!(read(0, 0).unwrap(), [0, 2]);
        assert_eq!(read(1, 0).unwrap(), [1, 3]);
        assert_eq!(read(0, 1).unwrap(), [4, 6]);
        assert_eq!(read(1, 1).unwrap(), [5, 7]);
        assert!(read(1, 2).unwrap_err().contains("there is no time 2: there is 0 to 1"));
    }
    let error = first_pages(&ome, options.channel(7)).unwrap_err();
    assert!(error.ends_with("there is no channel 7: there is 0 to 1 (0 DAPI, 1 GFP)"), "{error}");
}

#[test]
fn tiff_of_ome_has_millimetres() {
    let spacing = |sizes: &str| {
        let description = ome(&format!("SizeZ=\"4\" {sizes}"), "");
        let loaded = Written { description: &description, ..PLAIN }.read8(4).unwrap();
        (loaded.volume.grid().spacing(), loaded.warnings.len())
    };
    let micrometres = "PhysicalSizeX=\"500\" PhysicalSizeY=\"250\" PhysicalSizeZ=\"2000\"";
    assert_eq!(spacing(micrometres), ([0.5, 0.25, 2.0], 0));
    let mixed = format!("{micrometres} PhysicalSizeXUnit=\"nm\" PhysicalSizeYUnit=\"mm\"");
    assert_eq!(spacing(&mixed).0[1], 250.0);
    assert!((spacing(&mixed).0[0] - 5e-4).abs() < 1e-15);
    assert_eq!(spacing(""), ([1.0; 3], 1));
    assert_eq!(spacing(&format!("{micrometres} PhysicalSizeXUnit=\"pixel\"")), ([1.0; 3], 1));
}

#[test]
fn tiff_of_imagej() {
    let read = |lines: &str, resolution| {
        let description = format!("ImageJ=1.53t\n{lines}");
        Written { description: &description, resolution, ..PLAIN }.read8(4)
    };
    let loaded = read("images=4\nslices=4\nunit=\\u00B5m\nspacing=3.0\n", Some([2, 1])).unwrap();
    let spacing = loaded.volume.grid().spacing();
    for (size, expected) in spacing.into_iter().zip([5e-4, 1e-3, 3e-3]) {
        assert!((size - expected).abs() < 1e-15, "{spacing:?}");
    }
    assert_eq!(loaded.warnings, [""; 0]);
    let channels = read("images=4\nchannels=2\nslices=2\n", None).unwrap();
    assert_eq!(bytes_of(&channels)[6], 12, "the second slice is the third page");
    assert_eq!(channels.warnings.len(), 2, "{:?}", channels.warnings);
    let times = read("images=4\nframes=2\nunit=mm\n", Some([1, 1])).unwrap();
    assert_eq!(times.volume.grid().dims(), [3, 2, 2]);
    let error = read("images=900\nslices=900\n", None).unwrap_err();
    assert!(error.contains("tells of 900 pages, and the file has 4"), "{error}");
}

#[test]
fn tiff_that_is_no_volume() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.tif");
    let error = || read_volume(&path).unwrap_err().to_string();
    PLAIN.write::<CMYK8>(&path, &[vec![0; 24]]);
    assert!(error().contains("save them in gray or RGB (CMYK(8))"), "{}", error());
    std::fs::write(&path, b"II*\0").unwrap();
    assert!(error().contains("a.tif"), "{}", error());
    std::fs::write(&path, b"not one").unwrap();
    assert!(error().contains("not a TIFF file"), "{}", error());
    // A directory of no entries that is its own successor.
    std::fs::write(&path, b"II*\0\x08\0\0\0\0\0\x08\0\0\0").unwrap();
    assert!(!error().contains('\n'), "{}", error());
}

/// A page of 3 × 2 pixels that says to be of 60,000 × 60,000.
#[test]
fn tiff_that_lies_costs_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.tif");
    PLAIN.write::<Gray8>(&path, &[vec![7; 6]]);
    let mut bytes = std::fs::read(&path).unwrap();
    for tag in [0x100_u16, 0x101] {
        let entry = [&tag.to_le_bytes()[..], &4_u16.to_le_bytes(), &1_u32.to_le_bytes()].concat();
        let at = bytes.windows(8).position(|window| window == entry).expect("the tag is there");
        bytes[at + 8..at + 12].copy_from_slice(&60_000_u32.to_le_bytes());
    }
    std::fs::write(&path, bytes).unwrap();
    let error = read_volume(&path).unwrap_err().to_string();
    assert!(error.contains("a.tif") && !error.contains('\n'), "{error}");
}

/// Two files of two pages each, which say so, and one of them alone.
struct Parted {
    dir: tempfile::TempDir,
}

impl Parted {
    fn new(blocks: &str, second: &[Vec<u8>]) -> Self {
        let dir = tempfile::tempdir().unwrap();
        let description = ome("SizeZ=\"4\" DimensionOrder=\"XYZCT\"", blocks);
        let first: Vec<Vec<u8>> = vec![(0..6).collect(), (6..12).collect()];
        Written { description: &description, ..PLAIN }
            .write::<Gray8>(&dir.path().join("a.tif"), &first);
        Written { description: &description, ..PLAIN }
            .write::<Gray8>(&dir.path().join("b.tif"), second);
        Self { dir }
    }

    fn read(&self, name: &str) -> Result<LoadedVolume, String> {
        read_volume(self.dir.path().join(name)).map_err(|error| error.to_string())
    }
}

fn second_half() -> Vec<Vec<u8>> {
    vec![(12..18).collect(), (18..24).collect()]
}

#[test]
fn tiff_of_ome_in_several_files() {
    let single = |z: usize, ifd: usize, file: &str| {
        format!(
            "<TiffData FirstZ=\"{z}\" IFD=\"{ifd}\"><UUID FileName=\"{file}\">x</UUID></TiffData>"
        )
    };
    let of_each = [
        single(0, 0, "a.tif"),
        single(1, 1, "a.tif"),
        single(2, 0, "b.tif"),
        single(3, 1, "b.tif"),
    ];
    let runs = "<TiffData FirstZ=\"0\" IFD=\"0\" PlaneCount=\"2\"><UUID FileName=\"a.tif\">x</UUID></TiffData>\
                <TiffData FirstZ=\"2\"><UUID FileName=\"b.tif\">y</UUID></TiffData>";
    for blocks in [of_each.concat(), runs.to_owned()] {
        let parted = Parted::new(&blocks, &second_half());
        for name in ["a.tif", "b.tif"] {
            let loaded = parted.read(name).unwrap();
            assert_eq!(bytes_of(&loaded), (0..24).collect::<Vec<u8>>(), "{name} {blocks}");
        }
        // A folder of such files is one of them, not slices by their names.
        let error = parted.read("").unwrap_err();
        assert!(error.contains("name it, not its folder"), "{error}");
        let alone = parted.dir.path().join("b.tif");
        std::fs::remove_file(alone).unwrap();
        assert!(parted.read("a.tif").unwrap_err().contains("b.tif"));
    }
    let outside = runs.replace("b.tif", "../b.tif");
    let error = Parted::new(&outside, &second_half()).read("a.tif").unwrap_err();
    assert!(error.contains("outside of its folder"), "{error}");
    let error = Parted::new(runs, &second_half()[..1]).read("a.tif").unwrap_err();
    assert!(error.contains("b.tif: the file has no page 1"), "{error}");
    let parted = Parted::new(runs, &[]);
    PLAIN.write::<Gray16>(&parted.dir.path().join("b.tif"), &[vec![0; 6], vec![0; 6]]);
    assert!(
        parted.read("a.tif").unwrap_err().contains("b.tif: its pages are of another size or type")
    );
}

/// The metadata of all files in one that has nothing else.
#[test]
fn tiff_of_ome_with_a_companion() {
    let blocks = "<TiffData FirstZ=\"0\" IFD=\"0\" PlaneCount=\"2\"><UUID FileName=\"a.tif\">x</UUID></TiffData>\
                  <TiffData FirstZ=\"2\" IFD=\"0\" PlaneCount=\"2\"><UUID FileName=\"b.tif\">y</UUID></TiffData>";
    let parted = Parted::new(blocks, &second_half());
    let path = |name: &str| parted.dir.path().join(name);
    let companion = ome("SizeZ=\"4\" DimensionOrder=\"XYZCT\"", blocks);
    std::fs::write(path("c.companion.ome"), companion).unwrap();
    let description = "<OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\">\
                       <BinaryOnly MetadataFile=\"c.companion.ome\" UUID=\"urn:uuid:z\"/></OME>";
    let refers = Written { description, ..PLAIN };
    refers.write::<Gray8>(&path("b.tif"), &second_half());
    assert_eq!(bytes_of(&parted.read("b.tif").unwrap()), (0..24).collect::<Vec<u8>>());
    std::fs::copy(path("a.tif"), path("c.companion.ome")).unwrap();
    assert_eq!(bytes_of(&parted.read("b.tif").unwrap()), (0..24).collect::<Vec<u8>>());
    std::fs::remove_file(path("c.companion.ome")).unwrap();
    assert!(parted.read("b.tif").unwrap_err().contains("c.companion.ome"));
}

/// The photometric interpretation of gray pixels, made that of a palette.
#[test]
fn tiff_of_a_palette_names_what_converts_it() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.tif");
    PLAIN.write::<Gray8>(&path, &[vec![0; 6]]);
    let mut bytes = std::fs::read(&path).unwrap();
    let gray = [6, 1, 3, 0, 1, 0, 0, 0, 1, 0];
    let at = bytes.windows(gray.len()).position(|tag| tag == gray).expect("the page has the tag");
    bytes[at + 8] = 3;
    let error = read_from_both(&[("a.tif", &bytes)]).unwrap_err();
    assert!(error.contains("a palette's colours") && error.contains("ImageJ"), "{error}");
}
