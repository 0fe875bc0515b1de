//! A picture of every volume in a folder, as somebody gets it who says nothing:
//! `cargo run --release -p slabsplat --example contact_sheet -- FOLDER sheet.png [SIDE]`.
//!
//! `cargo xtask sheet` makes that of the volumes that tests have. What is in which tile is printed.

use slabsplat::{Image, OpenScene, Renderer, io};
use std::error::Error;
use std::path::{Path, PathBuf};

/// Tiles in a row.
const COLUMNS: usize = 5;

/// Between two tiles, in pixels.
const GAP: u32 = 4;

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let folder = args.next().ok_or("name a folder of volumes, and a picture")?;
    let output = args.next().unwrap_or_else(|| "sheet.png".to_owned());
    let side = args.next().map_or(Ok(320), |side| side.parse())?;
    let mut volumes = Vec::new();
    find(Path::new(&folder), &mut volumes);
    let mut renderer = Renderer::open("auto", |note| eprintln!("{note}"))?;
    let mut tiles = Vec::new();
    for path in &volumes {
        let mut file = io::SceneFile::of_volume(io::VolumeSource::File(path.clone()));
        (file.image.width, file.image.height) = (side, side);
        let opened = OpenScene::open(&file)?;
        let frame = renderer.render(&opened.scene)?;
        println!("{:>2}  {}\n    {}", tiles.len() + 1, path.display(), opened.found.join("; "));
        tiles.push(frame.image);
    }
    io::write_picture(&output, &sheet(&tiles, side))?;
    println!("{output}: {} volumes, {COLUMNS} in a row", tiles.len());
    Ok(())
}

/// All that can be read in a folder, by name.
fn find(path: &Path, volumes: &mut Vec<PathBuf>) {
    let is_text_or_samples = |path: &Path| {
        path.extension()
            .is_some_and(|extension| ["md", "tsv", "raw"].iter().any(|e| extension == *e))
    };
    // A folder of folders is a collection, though a reader of DICOM would look into them.
    let has_folders = std::fs::read_dir(path)
        .is_ok_and(|entries| entries.flatten().any(|entry| entry.path().is_dir()))
        && path.extension().is_none_or(|extension| extension != "zarr");
    if !has_folders
        && !is_text_or_samples(path)
        && io::list_volume(path, &io::VolumeOptions::default()).is_ok()
    {
        volumes.push(path.to_owned());
    } else if let Ok(entries) = std::fs::read_dir(path) {
        let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        paths.sort();
        paths.iter().for_each(|path| find(path, volumes));
    }
}

fn sheet(tiles: &[Image], side: u32) -> Image {
    let step = side + GAP;
    let n_rows = tiles.len().div_ceil(COLUMNS) as u32;
    let width = COLUMNS as u32 * step - GAP;
    let mut sheet = Image::filled(width, (n_rows * step).max(step) - GAP, [0.3, 0.3, 0.3, 1.0]);
    for (idx, tile) in tiles.iter().enumerate() {
        let (left, top) = (idx % COLUMNS * step as usize, idx / COLUMNS * step as usize);
        for (y, pixels) in tile.pixels().chunks_exact(side as usize).enumerate() {
            let start = (top + y) * width as usize + left;
            sheet.pixels_mut()[start..start + pixels.len()].copy_from_slice(pixels);
        }
    }
    sheet
}
