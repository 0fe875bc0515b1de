//! One pyramid's face and a broken one in every format, and what is wrong with files.

use super::*;
use slabsplat_core::glam::DVec3;
use std::path::PathBuf;

/// Reads a file of those bytes.
fn read(name: &str, bytes: &[u8]) -> Result<LoadedMesh, IoError> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read_mesh(&path)
}

fn mesh(name: &str, bytes: &[u8]) -> Mesh {
    read(name, bytes).unwrap_or_else(|error| panic!("{name}: {error}")).mesh
}

/// What is wrong with a file, without its path.
fn fault(name: &str, bytes: &[u8]) -> String {
    match read(name, bytes) {
        Err(IoError::Malformed { what, .. }) => what,
        other => panic!("{name}: {other:?}"),
    }
}

fn corners(mesh: &Mesh, triangle: usize) -> [[f64; 3]; 3] {
    mesh.corners(triangle).map(|corner| corner.to_array())
}

const CORNERS: [[f64; 3]; 3] = [[0.0, 0.0, 0.5], [1.0, 0.0, 0.0], [0.0, 2.0, -3.0]];

const PLY: &str = "ply\r\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty float x\n\
    property float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
    property float nx\nproperty float ny\nproperty float nz\nelement face 2\n\
    property list uchar int vertex_indices\nproperty float quality\nelement edge 2\nproperty int vertex1\nproperty int vertex2\nend_header\n\
    0 0 0.5 255 0 51 0 0 1\n1 0 0 0 255 0 0 2 0\n0 2 -3 0 0 255 1 0 0\n-1 2 0 0 0 0 0 0 1\n\
    4 0 1 2 3 0.5\n3 0 1 7 1\n2 0\n1 -1\n";

/// The same in binary.
fn binary_ply(is_big_endian: bool) -> Vec<u8> {
    let (header, data) = PLY.split_once("end_header\n").unwrap();
    let order = if is_big_endian { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = header.replace("ascii", order).into_bytes();
    bytes.extend(b"end_header\n");
    let mut push = |mut number: Vec<u8>| {
        if is_big_endian {
            number.reverse();
        }
        bytes.extend(number);
    };
    let float = |word: &str| word.parse::<f32>().unwrap().to_le_bytes().to_vec();
    let byte = |word: &str| vec![word.parse::<u8>().unwrap()];
    let int = |word: &str| word.parse::<i32>().unwrap().to_le_bytes().to_vec();
    for line in data.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        for (idx, word) in words.iter().enumerate() {
            push(match words.len() {
                9 if (3..6).contains(&idx) => byte(word),
                9 => float(word),
                2 => int(word),
                _ if idx == 0 => byte(word),
                _ if idx + 1 == words.len() => float(word),
                _ => int(word),
            });
        }
    }
    bytes
}

#[test]
fn ply_of_every_encoding() {
    for bytes in [PLY.as_bytes().to_vec(), binary_ply(false), binary_ply(true)] {
        let loaded = read("a.ply", &bytes).unwrap();
        let mesh = loaded.mesh;
        assert_eq!(loaded.format.name(), "PLY");
        assert_eq!(corners(&mesh, 0), CORNERS);
        assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh.colors(0), Some([[1.0, 0.0, 0.2], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]));
        assert_eq!(mesh.normals(0), Some([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]));
        let [warning] = &loaded.warnings[..] else { panic!("{:?}", loaded.warnings) };
        assert_eq!((mesh.lines(), mesh.points()), (&[[2, 0]][..], &[][..]));
        let expected =
            "2 of 3 triangles and 2 lines are left out: 2 refer to vertices that are not there";
        assert!(warning.ends_with(expected), "{warning}");
    }
}

#[test]
fn ply_faults() {
    let check = |from: &str, to: &str, expected: &str| {
        let bytes = PLY.replacen(from, to, 1).into_bytes();
        let what = fault("a.ply", &bytes);
        assert!(what.contains(expected), "{what}");
    };
    check("\n1 -1\n", "", "edge 1 of 2: the file ends before it");
    check("vertex 4", "vertex 400000000000", "vertex 5 of 400000000000: the file ends before it");
    check("vertex 4", "vertex -4", "\"-4\" is not a number of elements");
    check("4 0 1 2 3", "-4 0 1 2 3", "face 0 of 2: a list cannot have -4 numbers");
    check("4 0 1 2 3", "4e9 0 1 2 3", "face 0 of 2");
    check("-1 2 0", "-1 two 0", "vertex 3 of 4: \"two\" is not a number");
    check("format ascii 1.0\n", "", "no format");
    check("ascii", "utf-8", "\"utf-8\" is no format");
    check("float x", "real x", "\"real\" is no type");
    check("element vertex 4\n", "", "a property before any element");
    check("end_header", "end", "no line of a PLY header");
    check("element face", "element tristrips", "strips");
    // Of which one may have colours, and the other none.
    check("element face", "element vertex", "there are two elements \"vertex\"");
    assert!(fault("a.ply", b"ply\nformat ascii 1.0\n").contains("end_header"));
    assert!(fault("a.ply", b"plyers").contains("does not begin with ply"));
    let endless = b"ply\nformat ascii 1.0\nelement face 18446744073709551615\nend_header\n";
    assert_eq!(mesh("a.ply", endless).triangles().len(), 0);
}

fn text_stl() -> String {
    let facet = |corners: [[f64; 3]; 3]| {
        let vertices = corners.map(|[x, y, z]| format!("vertex {x} {y} {z}\n")).concat();
        format!("facet normal 0 0 0\n outer loop\n{vertices} endloop\nendfacet\n")
    };
    let broken = [[f64::NAN, 0.0, 0.0], [1.0; 3], [2.0, 1.0, 1.0]];
    let flat = [[0.0; 3], [1.0; 3], [2.0; 3]];
    format!("solid by hand\n{}{}{}endsolid by hand\n", facet(CORNERS), facet(broken), facet(flat))
}

/// The same in binary, with a header that looks like text.
fn binary_stl() -> Vec<u8> {
    let mut bytes = [b"solid ".as_slice(), &[b' '; 74], &3_u32.to_le_bytes()].concat();
    let text = text_stl();
    let numbers: Vec<f32> = text
        .lines()
        .filter_map(|line| line.strip_prefix("vertex "))
        .flat_map(|line| line.split(' ').map(|word| word.parse().unwrap()))
        .collect();
    for corners in numbers.chunks(9) {
        bytes.extend([0; 12]);
        bytes.extend(corners.iter().flat_map(|it| it.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

#[test]
fn stl_as_text_and_in_binary() {
    let upper = text_stl().to_uppercase();
    for (name, bytes) in
        [("a.stl", text_stl().into_bytes()), ("A.STL", upper.into_bytes()), ("a", binary_stl())]
    {
        let loaded = read(name, &bytes).unwrap();
        assert_eq!((loaded.format.name(), loaded.mesh.triangles().len()), ("STL", 1));
        assert_eq!(corners(&loaded.mesh, 0), CORNERS);
        assert_eq!(loaded.mesh.normals(0), None);
        let [warning] = &loaded.warnings[..] else { panic!("{:?}", loaded.warnings) };
        let expected =
            "2 of 3 triangles are left out: 1 have a corner that is not finite, 1 have no area";
        assert!(warning.ends_with(expected), "{warning}");
    }
}

#[test]
fn stl_faults() {
    let text = text_stl();
    let check = |bytes: &[u8], expected: &str| {
        let what = fault("a.stl", bytes);
        assert!(what.contains(expected), "{what}");
    };
    check(b"", "shorter than a header");
    let mut binary = binary_stl();
    binary[0] = b'x';
    check(&binary[..200], "cut off: it has 2 of 3 triangles");
    check(
        &[&[0; 80], u32::MAX.to_le_bytes().as_slice(), &[0; 99]].concat(),
        "cut off: it has 1 of 4294967295 triangles",
    );
    check(
        text.replacen("vertex 0 2 -3\n", "", 1).as_bytes(),
        "line 7: a facet has 3 vertices, not 2",
    );
    check(text.replacen("0 2 -3", "0 2", 1).as_bytes(), "line 6: 3 numbers are needed, not 2");
    check(text.replacen("0 2 -3", "0 2 x", 1).as_bytes(), "line 6: \"x\" is not a number");
    check(text.replacen("facet", "face", 1).as_bytes(), "line 2: \"face\" is no word");
    check(&text.as_bytes()[..73], "cut off within a facet");
}

const OBJ: &str = "# by hand\nmtllib no.mtl\no thing\nv 0 0 0.5\nv 1 0 0 1.0\nv 0 2 -3 0.25 1 0\nv -1 2 0\n\
    vt 0 0\nvn 0 0 2\nusemtl none\ns off\nf 1//1 2/1/1 -2//-1 4//1\nf 1 2 3\nf 1 2 9\nf 1 2\nl 1 2/1 -1\nl 3 8\nl 4\np 2 4 -9\n";

#[test]
fn obj_of_polygons() {
    let loaded = read("a.obj", OBJ.as_bytes()).unwrap();
    let mesh = loaded.mesh;
    assert_eq!((loaded.format.name(), mesh.triangles().len()), ("OBJ", 3));
    assert_eq!(corners(&mesh, 0), CORNERS);
    assert_eq!(corners(&mesh, 1), [CORNERS[0], CORNERS[2], [-1.0, 2.0, 0.0]]);
    assert_eq!(mesh.normals(1), Some([[0.0, 0.0, 1.0]; 3]));
    let flat = mesh.face_normal(2).as_vec3();
    for normal in mesh.normals(2).unwrap() {
        assert!((DVec3::from_array(normal.map(f64::from)) - flat.as_dvec3()).length() < 1e-6);
    }
    assert_eq!(mesh.colors(0), Some([[0.8; 3], [0.8; 3], [0.25, 1.0, 0.0]]));
    let [warning] = &loaded.warnings[..] else { panic!("{:?}", loaded.warnings) };
    let expected = "5 of 5 triangles, 4 lines and 3 points are left out: 4 refer";
    assert!(warning.contains(expected), "{warning}");
    let at = |vertex: u32| mesh.positions()[vertex as usize].to_array();
    let ends: Vec<[[f64; 3]; 2]> = mesh.lines().iter().map(|line| line.map(at)).collect();
    let [a, b, d] = [CORNERS[0], CORNERS[1], [-1.0, 2.0, 0.0]];
    assert_eq!(ends, [[a, b], [b, d]]);
    assert_eq!(mesh.points().iter().map(|point| at(*point)).collect::<Vec<_>>(), [b, d]);
    let plain = mesh_of_lines("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/2 3/3\nf 3 2 1\n");
    assert_eq!(plain.triangles(), [[0, 1, 2], [2, 1, 0]]);
    assert_eq!((plain.normals(0), plain.colors(0)), (None, None));
}

fn mesh_of_lines(text: &str) -> Mesh {
    mesh("a.obj", text.as_bytes())
}

#[test]
fn obj_faults() {
    let check = |from: &str, to: &str, expected: &str| {
        let what = fault("a.obj", OBJ.replacen(from, to, 1).as_bytes());
        assert!(what.contains(expected), "{what}");
    };
    check("v 1 0 0 1.0", "v 1 0", "line 5: 3 numbers are needed, not 2");
    check("v 1 0 0 1.0", "v 1 0 0 w", "line 5: \"w\" is not a number");
    check("vn 0 0 2", "vn 0 0 z", "line 9: \"z\" is not a number");
    check("f 1 2 3", "f 1 2 c", "line 13: \"c\" is not the number of a vertex");
    let far = "f 1 2 9223372036854775807\nf -9223372036854775808 1 2\n";
    let loaded = read("a.obj", OBJ.replacen("f 1 2 9\n", far, 1).as_bytes()).unwrap();
    assert_eq!(loaded.mesh.dropped().n_without_vertices, 5, "with those of OBJ");
}

#[test]
fn mesh_of_nothing_is_told() {
    for (name, bytes) in [
        ("a.obj", &b"# nothing\n"[..]),
        ("a.ply", b"ply\nformat ascii 1.0\nend_header\n"),
        ("a.stl", b"solid\nendsolid\n"),
    ] {
        let loaded = read(name, bytes).unwrap();
        let expected = "there are no triangles, no lines and no points";
        assert!(loaded.warnings[0].ends_with(expected), "{:?}", loaded.warnings);
    }
}

/// Of files that have nothing but vertices every vertex is a point, but for those that are nowhere.
#[test]
fn vertices_alone_are_a_point_cloud() {
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n";
    let data = "1 2 3 255 0 0\nnan 0 0 0 0 0\n4 5 6 0 0 255\n";
    let faces = "element face 0\nproperty list uchar int vertex_indices\n";
    let plain = format!("{header}end_header\n{data}");
    let with_faces = format!("{header}{faces}end_header\n{data}");
    let obj = "v 1 2 3 1 0 0\nvn 0 0 1\nv nan 0 0\nv 4 5 6 0 0 1\n".to_owned();
    for (name, text) in [("a.ply", plain), ("a.ply", with_faces), ("a.obj", obj)] {
        let loaded = read(name, text.as_bytes()).unwrap();
        let mesh = loaded.mesh;
        assert_eq!((mesh.points(), mesh.lines().len()), (&[0, 2][..], 0), "{text}");
        assert_eq!(mesh.positions()[2], DVec3::new(4.0, 5.0, 6.0));
        assert_eq!(mesh.vertex_color(2), Some([0.0, 0.0, 1.0]));
        let [warning] = &loaded.warnings[..] else { panic!("{:?}", loaded.warnings) };
        let expected = "1 of 3 points are left out: 1 have a corner that is not finite";
        assert!(warning.ends_with(expected), "{warning}");
    }
}

#[test]
fn mesh_formats_by_name() {
    for (name, expected) in
        [("a.ply", true), ("a.STL", true), ("b.obj", true), ("b.nii", false), ("ply", false)]
    {
        assert_eq!(is_mesh_name(PathBuf::from(name)), expected, "{name}");
    }
    let unknown = read("a.gltf", b"{}").unwrap_err();
    assert!(unknown.to_string().contains("PLY (.ply), STL (.stl) or OBJ (.obj)"), "{unknown}");
    assert!(matches!(read_mesh(PathBuf::from("/nowhere.ply")), Err(IoError::Read { .. })));
}
