//! Whole files of VTK, written here byte by byte.

use std::io::Write;

use slabsplat_core::Samples;
use slabsplat_core::glam::DVec3;

use super::base64::encoded;
use crate::store::read_from_both as read;
use crate::{FilesInMemory, LoadedVolume, VolumeFormat, VolumeOptions};

const VALUES: [i16; 12] = [0, 1, -2, 300, 4, 5, 6, 7, 8, 9, 10, -32768];

fn bytes(is_big: bool) -> Vec<u8> {
    VALUES.iter().flat_map(|v| if is_big { v.to_be_bytes() } else { v.to_le_bytes() }).collect()
}

/// A file of 3 × 2 × 2 points with an array `a`, of which `array` says the format and what is in it.
fn vti(file: &str, image: &str, array: &str, appended: &[u8]) -> Vec<u8> {
    let text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" {file}>\n<ImageData \
         WholeExtent=\"0 2 0 1 0 1\" {image}>\n<Piece Extent=\"0 2 0 1 0 1\">\n<PointData Scalars=\"a\">\n\
         <DataArray type=\"Int16\" Name=\"a\" {array}</DataArray>\n</PointData>\n<CellData></CellData>\n\
         </Piece>\n</ImageData>\n"
    );
    [text.as_bytes(), appended, b"\n</VTKFile>\n"].concat()
}

fn appended(encoding: &str, data: &[u8]) -> Vec<u8> {
    let tag = format!("<AppendedData encoding=\"{encoding}\">\n  _");
    [tag.as_bytes(), data, b"\n</AppendedData>"].concat()
}

fn word(n: usize, is_wide: bool, is_big: bool) -> Vec<u8> {
    let mut bytes = (n as u64).to_le_bytes()[..if is_wide { 8 } else { 4 }].to_vec();
    if is_big {
        bytes.reverse();
    }
    bytes
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// Words in front, and blocks of 16 bytes.
fn blocks(bytes: &[u8], is_big: bool, pack: fn(&[u8]) -> Vec<u8>) -> [Vec<u8>; 2] {
    let packed: Vec<Vec<u8>> = bytes.chunks(16).map(pack).collect();
    let words = [packed.len(), 16, bytes.len() % 16];
    let words = words.into_iter().chain(packed.iter().map(Vec::len));
    [words.flat_map(|n| word(n, false, is_big)).collect(), packed.concat()]
}

fn check(name: &str, file: &[u8]) -> LoadedVolume {
    let loaded = read(&[(name, file)]).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(loaded.volume.samples(), &Samples::I16(VALUES.to_vec()), "{name}");
    assert_eq!(loaded.volume.grid().dims(), [3, 2, 2]);
    assert_eq!(loaded.format, VolumeFormat::Vtk);
    assert_eq!(loaded.warnings, [""; 0]);
    loaded
}

#[test]
fn vti_in_every_encoding() {
    let text = VALUES.map(|v| v.to_string()).join(" ");
    check("text.vti", &vti("", "", &format!("format=\"ascii\">\n{text}\n"), b""));
    for is_big in [false, true] {
        for is_wide in [false, true] {
            let order = if is_big { "BigEndian" } else { "LittleEndian" };
            let width = if is_wide { "UInt64" } else { "UInt32" };
            let file = format!("byte_order=\"{order}\" header_type=\"{width}\"");
            let plain = [word(24, is_wide, is_big), bytes(is_big)].concat();
            let inline = format!("format=\"binary\">\n  {}\n", encoded(&plain));
            check("inline.vti", &vti(&file, "", &inline, b""));
            // As some writers have it: the length by itself.
            let apart = encoded(&word(24, is_wide, is_big)) + &encoded(&bytes(is_big));
            check("apart.vti", &vti(&file, "", &format!("format=\"binary\">{apart}"), b""));
            let in_file = [b"12345".to_vec(), plain.clone()].concat();
            let array = "format=\"appended\" offset=\"5\">";
            check("raw.vti", &vti(&file, "", array, &appended("raw", &in_file)));
            let text = encoded(&plain);
            let array = "format=\"appended\" offset=\"0\"/>";
            check("base64.vti", &vti(&file, "", array, &appended("base64", text.as_bytes())));
        }
    }
}

#[test]
fn vti_in_packed_blocks() {
    for (name, pack) in [
        ("vtkZLibDataCompressor", zlib as fn(&[u8]) -> Vec<u8>),
        ("vtkLZ4DataCompressor", lz4_flex::block::compress),
    ] {
        for is_big in [false, true] {
            let order = if is_big { "BigEndian" } else { "LittleEndian" };
            let file = format!("byte_order=\"{order}\" compressor=\"{name}\"");
            let [words, data] = blocks(&bytes(is_big), is_big, pack);
            let text = encoded(&words) + &encoded(&data);
            check("inline.vti", &vti(&file, "", &format!("format=\"binary\">{text}"), b""));
            let in_file = [words, data].concat();
            let array = "format=\"appended\" offset=\"0\"><InformationKey name=\"x\"/>";
            check("raw.vti", &vti(&file, "", array, &appended("raw", &in_file)));
        }
    }
    let file = vti("compressor=\"vtkLZMADataCompressor\"", "", "format=\"binary\">AAAA", b"");
    assert!(read(&[("a.vti", &file)]).unwrap_err().contains("save them with ZLib or LZ4"));
}

#[test]
fn vti_keys_come_before_numbers() {
    let text = VALUES.map(|v| v.to_string()).join(" ");
    let keys = "<InformationKey name=\"N\" location=\"L\" length=\"1\"><Value index=\"0\"> 7 </Value>\n\
                </InformationKey>";
    for array in
        [format!("format=\"ascii\">\n{text}\n{keys}"), format!("format=\"ascii\">\n{text}\n")]
    {
        check("a.vti", &vti("", "", &array, b""));
    }
    check("b.vti", &vti("", "", &format!("format=\"ascii\"><InformationKey/>\n{text}\n"), b""));
}

#[test]
fn vti_places_by_extent_spacing_and_direction() {
    let text = VALUES.map(|v| v.to_string()).join(" ");
    let array = format!("format=\"ascii\">{text}");
    // Rows of the matrix: x goes along y, y against x.
    let image = "Origin=\"10 20 30\" Spacing=\"1 2 3\" Direction=\"0 -1 0 1 0 0 0 0 1\"";
    let file = String::from_utf8(vti("", image, &array, b"")).unwrap();
    let file = file.replace("0 2 0 1 0 1", "-1 1 5 6 2 3");
    let grid = *check("a.vti", file.as_bytes()).volume.grid();
    let place =
        |i: f64, j: f64, k: f64| grid.world_from_index().transform_point3(DVec3::new(i, j, k));
    assert_eq!(place(0.0, 0.0, 0.0), DVec3::new(0.0, 19.0, 36.0));
    assert_eq!(place(1.0, 1.0, 1.0), DVec3::new(-2.0, 20.0, 39.0));
}

/// Pieces in any order, and a value for each cell.
#[test]
fn vti_of_pieces_and_cells() {
    let piece = |extent: &str, points: &str, cells: &str| {
        format!(
            "<Piece Extent=\"{extent}\"><PointData><DataArray type=\"UInt8\" Name=\"p\" format=\"ascii\">\
             {points}</DataArray></PointData><CellData><DataArray type=\"UInt8\" Name=\"c\" \
             format=\"ascii\">{cells}</DataArray></CellData></Piece>"
        )
    };
    let file = format!(
        "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 3 0 1 0 0\">{}{}</ImageData></VTKFile>",
        piece("1 3 0 1 0 0", "1 2 3 11 12 13", "1 2"),
        piece("0 1 0 1 0 0", "0 1 10 11", "0"),
    );
    let points = read(&[("a.vti", file.as_bytes())]).unwrap();
    assert_eq!(points.volume.samples(), &Samples::U8(vec![0, 1, 2, 3, 10, 11, 12, 13]));
    let files = FilesInMemory::from_iter([("a.vti", file.as_bytes())]);
    let cells = files.read_volume("a.vti:c").unwrap();
    assert_eq!(cells.volume.samples(), &Samples::U8(vec![0, 1, 2]));
    assert_eq!(cells.volume.grid().world_from_index().translation, DVec3::new(0.5, 0.5, 0.0));
    assert_eq!(cells.choices.series.names, ["p", "c"]);
    let lacking = file.replacen("<Piece Extent=\"0 1", "<Other Extent=\"0 1", 1);
    let lacking = lacking.replace("</Piece></ImageData>", "</Other></ImageData>");
    let error_or_not = read(&[("a.vti", lacking.as_bytes())]);
    assert!(error_or_not.unwrap().warnings.iter().any(|w| w.contains("not all of the image")));
}

fn legacy(kind: &str, attributes: &str, data: &[u8]) -> Vec<u8> {
    let text = format!(
        "# vtk DataFile Version 3.0\na title\n{kind}\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 2\n\
         ASPECT_RATIO 1 1.5 2\nORIGIN 1 2 3\nPOINT_DATA 12\n{attributes}"
    );
    [text.as_bytes(), data].concat()
}

#[test]
fn vtk_in_text_and_binary() {
    let text = VALUES.map(|v| v.to_string()).join("\n");
    let scalars = "SCALARS a short\nLOOKUP_TABLE default\n";
    for file in [
        legacy("ASCII", scalars, text.as_bytes()),
        legacy("BINARY", scalars, &bytes(true)),
        legacy("BINARY", "SCALARS a short 1\n", &bytes(true)),
        legacy("BINARY", "FIELD FieldData 1\na 1 12 short\n", &bytes(true)),
    ] {
        let loaded = check("a.vtk", &file);
        assert_eq!(loaded.volume.grid().spacing(), [1.0, 1.5, 2.0]);
        let origin = loaded.volume.grid().world_from_index().translation;
        assert_eq!(origin, DVec3::new(1.0, 2.0, 3.0));
    }
}

/// What comes after the numbers in text is no number.
#[test]
fn vtk_arrays_in_text() {
    let text = VALUES.map(|v| v.to_string()).join(" ");
    let data =
        format!("{text}\nFIELD FieldData 1\nb 1 12 short\n{text}\nMETADATA\nINFORMATION 0\n\n");
    let file = legacy("ASCII", "SCALARS a short\nLOOKUP_TABLE default\n", data.as_bytes());
    let files = FilesInMemory::from_iter([("a.vtk", file.as_slice())]);
    for name in ["a.vtk", "a.vtk:b"] {
        let loaded = files.read_volume(name).unwrap();
        assert_eq!(loaded.volume.samples(), &Samples::I16(VALUES.to_vec()), "{name}");
    }
}

#[test]
fn vtk_arrays_and_components() {
    let table = [&b"\nLOOKUP_TABLE t 2\n"[..], &[9; 8]].concat();
    let metadata = b"\nMETADATA\nINFORMATION 0\n\nVECTORS v%20w short\n";
    let vectors: Vec<u8> =
        VALUES.iter().flat_map(|v| [[0, 1], v.to_be_bytes(), [0, 2]].concat()).collect();
    let data = [&bytes(true)[..], &table, metadata, &vectors].concat();
    let file = legacy("BINARY", "SCALARS a short\nLOOKUP_TABLE t\n", &data);
    let files = FilesInMemory::from_iter([("a.vtk", file.as_slice())]);
    let options = VolumeOptions::default().channel(1);
    let middle = files.read_volume_with("a.vtk:v w", &options).unwrap();
    assert_eq!(middle.volume.samples(), &Samples::I16(VALUES.to_vec()));
    let first = files.read_volume("a.vtk:v w").unwrap();
    assert_eq!(first.volume.samples(), &Samples::I16(vec![1; 12]));
    assert_eq!(first.choices.channel.n, 3);
    let scalars = files.read_volume("a.vtk").unwrap();
    assert_eq!(scalars.choices.series.names, ["a", "v w"]);
}

#[test]
fn vtk_errors_are_plain() {
    let check = |name: &str, file: &[u8], expected: &str| {
        let error = read(&[(name, file)]).unwrap_err();
        assert!(error.contains(expected) && !error.contains('\n'), "{error} lacks {expected}");
    };
    let array = "format=\"appended\" offset=\"0\">";
    let lies = [word(24, false, false), bytes(false)[..20].to_vec()].concat();
    let huge = |file: Vec<u8>| {
        String::from_utf8(file).unwrap().replace("0 2 0 1 0 1", "0 9999 0 999 0 99")
    };
    check("a.vti", &vti("", "", array, b""), "no appended data");
    check(
        "a.vti",
        &vti("", "", array, &appended("raw", &word(20, false, false))),
        "needs 24 bytes of data",
    );
    check(
        "a.vti",
        huge(vti("", "", array, &appended("raw", b"1234"))).as_bytes(),
        "needs 2000000000 bytes",
    );
    let packed = "compressor=\"vtkZLibDataCompressor\"";
    check("a.vti", &vti(packed, "", array, &appended("raw", &[0xff; 40])), "cannot be that many");
    let one = [word(1, false, false), word(24, false, false), word(0, false, false)].concat();
    let one = [one, word(9, false, false), b"notzlib!!".to_vec()].concat();
    check("a.vti", &vti(packed, "", array, &appended("raw", &one)), "cannot be unpacked by zlib");
    check("a.vti", &vti("", "Direction=\"1 0\"", array, b""), "should be 9 numbers");
    check("a.vti", &vti("", "Spacing=\"0 1 1\"", "format=\"ascii\">", &[b' '; 90]), "matrix");
    check("a.vti", &vti("", "", "format=\"ascii\">1 2 x", b""), "\"x\" is not a number of int16");
    let text = vti("", "", "format=\"ascii\">1 2 3", b"");
    check("a.vti", &text, "needs 24 bytes of data, has 6");
    let other = String::from_utf8(text).unwrap().replace("Int16", "String");
    check("a.vti", other.as_bytes(), "cannot be samples");
    let grid = b"<VTKFile type=\"UnstructuredGrid\">";
    check("a.vti", grid, "UnstructuredGrid is no image");
    let surface = b"<VTKFile type=\"PolyData\">";
    check("a.vtp", surface, "PolyData is no image: ParaView saves it as a mesh");
    check("a.vti", b"<VTKFile type=\"Un\nGrid\">", "is no image");
    check("a.vti", b"<?xml version=\"1.0\"?><!DOCTYPE VTKFile []><VTKFile>", "document type");
    check("a.vti", b"garbage", "not a VTK images file");
    check("a.vtk", &legacy("BINARY", "SCALARS a short\n", &lies[..20]), "needs 24 bytes");
    check("a.vtk", &legacy("HEX", "", b""), "ASCII or BINARY");
    check(
        "a.vtk",
        &legacy("ASCII", "SCALARS a bit\n", b"1 0 1 0 1 0 1 0 1 0 1 0"),
        "cannot be samples",
    );
    check("a.vtk", &legacy("ASCII", "NONSENSE\n", b""), "\"NONSENSE\" is no keyword");
    let text = String::from_utf8(legacy("ASCII", "", b"")).unwrap();
    check(
        "a.vtk",
        text.replace("STRUCTURED_POINTS", "POLYDATA").as_bytes(),
        "POLYDATA is no image: ParaView saves it as a mesh",
    );
    check("a.vtk", text.replace("POINT_DATA 12", "POINT_DATA 13").as_bytes(), "data of 13 points");
    check("a.vtk", text.as_bytes(), "no arrays");
}
