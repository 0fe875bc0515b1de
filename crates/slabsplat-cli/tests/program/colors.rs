//! Volumes whose voxels are colours: told of, drawn alike from every format, and kept by `convert`.

use super::{answer, diagnostic, json, slabsplat, text};
use serde_json::json as value;
use std::path::Path;

const DIMS: [usize; 3] = [7, 6, 5];

/// A box of voxels, as light as they lie far along its axes, each axis in another colour.
fn write_nrrd(path: &Path, has_alpha: bool) {
    let [nx, ny, nz] = DIMS;
    let (kind, n) = if has_alpha { ("RGBA-color", 4) } else { ("RGB-color", 3) };
    let header = format!(
        "NRRD0004\ntype: uint8\ndimension: 4\nsizes: {n} {nx} {ny} {nz}\nspace dimension: 3\n\
         space directions: none (1,0,0) (0,1.5,0) (0,0,-2)\nspace origin: (-3,4,5)\n\
         kinds: {kind} domain domain domain\nencoding: raw\n\n"
    );
    let mut bytes = header.into_bytes();
    for voxel_idx in 0..nx * ny * nz {
        let [x, y, z] = [voxel_idx % nx, voxel_idx / nx % ny, voxel_idx / (nx * ny)];
        let rgba = [40 * x, 50 * y, 60 * z, 40 * x.min(y)].map(|sample| sample as u8);
        bytes.extend(&rgba[..n]);
    }
    std::fs::write(path, bytes).expect("the folder can be written");
}

/// From one side, in one light: what else is found differs between formats and scene files.
fn picture(directory: &Path, args: &str) -> Vec<u8> {
    const SEEN: &str = "--eye 20,-20,30 --target 0,8,1 --up 0,0,1 --view-height 14 --light 1,-2,3 --ambient 0.2 \
                        --background 0,0,0 --width 40 --height 30";
    answer(directory, &format!("render {args} {SEEN} --backend cpu --no-metadata -o a.exr"));
    std::fs::read(directory.join("a.exr")).expect("a picture was written")
}

#[test]
fn colors_are_drawn_alike_from_every_format() {
    let dir = tempfile::tempdir().expect("a folder can be made");
    let dir = dir.path();
    for has_alpha in [false, true] {
        write_nrrd(&dir.join("a.nrrd"), has_alpha);
        let expected = picture(dir, "a.nrrd");
        assert_ne!(expected, picture(dir, "a.nrrd --colors none"), "colours are seen");
        assert_eq!(expected, picture(dir, "a.nrrd --colors own"));
        let scalar = if has_alpha { "alpha" } else { "luminance" };
        assert_eq!(expected, picture(dir, &format!("a.nrrd --opacity-from {scalar}")));
        for name in ["b.nrrd", "b.nii", "b.nii.gz", "b.mha"] {
            answer(dir, &format!("convert a.nrrd {name}"));
            assert_eq!(expected, picture(dir, name), "{name}, alpha {has_alpha}");
        }
        let info = json(dir, "info a.nrrd --json");
        assert_eq!(info["colors"], value!({ "alpha": has_alpha, "opacity_from": scalar }));
        assert_eq!(info["channel"]["chosen"], value!(null));
        let kind = if has_alpha { "RGBA" } else { "RGB" };
        let text = answer(dir, "info a.nrrd");
        assert!(text.contains(&format!("colors   {kind}; values are of {scalar}\n")), "{text}");
        assert!(text.contains("channel  all of 0 to "), "{text}");
    }
    let output = slabsplat(dir, "convert a.nrrd b.zarr");
    let warnings = text(&output.stderr);
    assert!(warnings.contains("has no colours of 8 bits: alpha alone was written"), "{warnings}");
    assert_ne!(picture(dir, "a.nrrd"), picture(dir, "a.nrrd --opacity-from luminance"));
}

#[test]
fn colors_by_flags_as_by_keys() {
    let dir = tempfile::tempdir().expect("a folder can be made");
    let dir = dir.path();
    write_nrrd(&dir.join("a.nrrd"), true);
    for (flags, keys) in [
        ("--colors none", "colors = \"none\""),
        ("--opacity-from luminance", "opacity_from = \"luminance\""),
        ("--channel 2", "channel = 2"),
    ] {
        let scene = format!("[volume]\npath = \"a.nrrd\"\n{keys}\n");
        std::fs::write(dir.join("a.toml"), scene).expect("the folder can be written");
        assert_eq!(picture(dir, &format!("a.nrrd {flags}")), picture(dir, "a.toml"), "{flags}");
    }
}

#[test]
fn colors_that_cannot_be_are_refused() {
    let dir = tempfile::tempdir().expect("a folder can be made");
    let dir = dir.path();
    write_nrrd(&dir.join("a.nrrd"), false);
    let picture = "--width 9 --height 9 --backend cpu -o b.png";
    for (args, expected) in [
        ("a.nrrd --mode maximum", "no colours of voxels (colors = \"none\", or --colors none,"),
        ("a.nrrd --method post-classified", "no colours of voxels"),
        ("a.nrrd --opacity-from alpha", "a.nrrd: its colours have no alpha"),
        ("a.nrrd --channel 1 --colors own", "one channel has no colours of its own"),
        ("a.nrrd --color 0:1,0,0", "--color does nothing where voxels have colours"),
        ("a.nrrd --colormap turbo", "--colormap does nothing where voxels have colours"),
        ("builtin:cube --colors own", "its voxels have no colours"),
    ] {
        let error = diagnostic(dir, &format!("render {args} {picture}"));
        assert!(error.contains(expected), "{error} lacks {expected}");
    }
    let preset = slabsplat(dir, &format!("render a.nrrd --preset ct-bone {picture}"));
    let warnings = text(&preset.stderr);
    assert!(warnings.contains("colours of the transfer function are not seen"), "{warnings}");
    let usage = slabsplat(dir, &format!("render a.nrrd --colors pink {picture}"));
    assert!(text(&usage.stderr).contains("\"pink\" is none of: own, none"));
    std::fs::write(dir.join("a.toml"), "[volume]\npath = \"a.nrrd\"\ncolors = \"pink\"\n")
        .expect("the folder can be written");
    let error = diagnostic(dir, &format!("render a.toml {picture}"));
    assert!(error.contains("a.toml:3: ") && error.contains("none of: own, none"), "{error}");
}
