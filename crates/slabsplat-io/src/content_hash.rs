//! What tells whether a volume, a mesh or labels are those that a picture was made of.
//!
//! XXH3 of 128 bits (<https://github.com/Cyan4973/xxHash>), of what is in memory: files of two formats that
//! hold the same have the same hash. It finds accidents, a file that was replaced or read otherwise; whoever
//! wants two volumes to have one hash can make them.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use slabsplat_core::{LabelMap, Mesh, Sample, Volume, VoxelColors, with_samples};
use twox_hash::XxHash3_128;

/// The hash of a volume, of labels or of a mesh. As text `xxh3:` and 32 hexadecimal digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
#[serde(try_from = "String", into = "String")]
pub struct ContentHash(u128);

/// What a text begins with that is a hash.
const PREFIX: &str = "xxh3:";

/// Why a text is no hash.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a hash is {PREFIX} and 32 hexadecimal digits")]
#[expect(clippy::exhaustive_structs, reason = "there is nothing more to say of it")]
pub struct NotAHash;

impl ContentHash {
    /// Of a volume's grid, of what its samples mean, and of these: voxels along each axis, the affine by
    /// columns, slope and intercept, the name of the type, samples; then, if voxels are drawn in colours of
    /// their own, `colors`, and red, green and blue of each as floats of 32 bits. All numbers are
    /// little-endian, counts of 64 bits; a name follows its length, and `volume` is before all of it.
    pub fn of_volume(volume: &Volume, colors: Option<&VoxelColors>) -> Self {
        let mut hasher = Hasher::of("volume");
        let grid = volume.grid();
        hasher.counts(grid.dims());
        hasher.numbers(grid.world_from_index().to_cols_array());
        hasher.numbers([volume.scaling().slope, volume.scaling().intercept]);
        hasher.word(volume.sample_type().name());
        with_samples!(volume.samples(), |samples| hasher.samples(samples));
        if let Some(colors) = colors {
            hasher.word("colors");
            (0..colors.samples().len()).for_each(|voxel| hasher.samples(&colors.at(voxel)));
        }
        hasher.finish()
    }

    /// Of the labels that there are, and which of them each voxel has.
    pub fn of_labels(labels: &LabelMap) -> Self {
        let mut hasher = Hasher::of("labels");
        hasher.counts(labels.dims());
        hasher.counts([labels.labels().len()]);
        labels.labels().iter().for_each(|label| hasher.bytes(&label.to_le_bytes()));
        hasher.samples(labels.indices());
        hasher.finish()
    }

    /// Of a mesh's vertices, triangles, lines and points.
    pub fn of_mesh(mesh: &Mesh) -> Self {
        let mut hasher = Hasher::of("mesh");
        hasher.counts([mesh.positions().len(), mesh.triangles().len()]);
        hasher.counts([mesh.lines().len(), mesh.points().len()]);
        for (vertex, position) in mesh.positions().iter().enumerate() {
            hasher.numbers(position.to_array());
            for channels in [mesh.vertex_normal(vertex), mesh.vertex_color(vertex)] {
                // What there is none of differs from all that there may be.
                hasher.samples(&channels.unwrap_or([f32::NAN; 3]));
            }
        }
        hasher.samples(mesh.triangles().as_flattened());
        hasher.samples(mesh.lines().as_flattened());
        hasher.samples(mesh.points());
        hasher.finish()
    }
}

/// Numbers are hashed as on machines that store the least significant byte first.
struct Hasher(XxHash3_128);

impl Hasher {
    fn of(what: &str) -> Self {
        let mut hasher = Self(XxHash3_128::new());
        hasher.word(what);
        hasher
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.0.write(bytes);
    }

    fn word(&mut self, word: &str) {
        self.counts([word.len()]);
        self.bytes(word.as_bytes());
    }

    fn counts<const N: usize>(&mut self, counts: [usize; N]) {
        counts.iter().for_each(|&n| self.bytes(&(n as u64).to_le_bytes()));
    }

    fn numbers<const N: usize>(&mut self, numbers: [f64; N]) {
        numbers.iter().for_each(|number| self.bytes(&number.to_le_bytes()));
    }

    fn samples<T: Sample>(&mut self, samples: &[T]) {
        if cfg!(target_endian = "little") {
            return self.bytes(bytemuck::cast_slice(samples));
        }
        for sample in samples {
            bytemuck::bytes_of(sample).iter().rev().for_each(|byte| self.bytes(&[*byte]));
        }
    }

    fn finish(self) -> ContentHash {
        ContentHash(self.0.finish_128())
    }
}

impl fmt::Display for ContentHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{PREFIX}{:032x}", self.0)
    }
}

impl FromStr for ContentHash {
    type Err = NotAHash;

    fn from_str(text: &str) -> Result<Self, NotAHash> {
        let digits = text.strip_prefix(PREFIX).ok_or(NotAHash)?;
        let are_digits = digits.len() == 32 && digits.bytes().all(|c| c.is_ascii_hexdigit());
        let number = are_digits.then(|| u128::from_str_radix(digits, 16).ok()).flatten();
        number.map(Self).ok_or(NotAHash)
    }
}

impl TryFrom<String> for ContentHash {
    type Error = NotAHash;

    fn try_from(text: String) -> Result<Self, NotAHash> {
        text.parse()
    }
}

impl From<ContentHash> for String {
    fn from(hash: ContentHash) -> Self {
        hash.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::glam::DVec3;
    use slabsplat_core::{ColorSamples, Grid, MeshParts, Samples, Scaling};

    fn volume(spacing: f64, samples: Samples, slope: f64) -> Volume {
        let grid = Grid::with_spacing([3, 1, 1], [spacing, 1.0, 1.0]).unwrap();
        Volume::new(grid, samples, Scaling { slope, intercept: 0.0 }).unwrap()
    }

    #[test]
    fn hash_of_a_volume_is_of_all_that_it_is() {
        let hash = |spacing, samples: Samples, slope| {
            ContentHash::of_volume(&volume(spacing, samples, slope), None)
        };
        let bytes = || Samples::U8(vec![1, 2, 3]);
        let first = hash(1.0, bytes(), 1.0);
        assert_eq!(first, hash(1.0, bytes(), 1.0));
        assert_ne!(first, hash(1.5, bytes(), 1.0), "another grid");
        assert_ne!(first, hash(1.0, bytes(), 2.0), "other values");
        assert_ne!(first, hash(1.0, Samples::U8(vec![1, 3, 2]), 1.0), "other samples");
        assert_ne!(first, hash(1.0, Samples::I8(vec![1, 2, 3]), 1.0), "another type");
        let colored = |colors| {
            let colors = VoxelColors::new([3, 1, 1], ColorSamples::U8(colors)).unwrap();
            ContentHash::of_volume(&volume(1.0, bytes(), 1.0), Some(&colors))
        };
        assert_ne!(first, colored(vec![[0; 3]; 3]), "colours");
        assert_ne!(colored(vec![[0; 3]; 3]), colored(vec![[1; 3]; 3]), "other colours");
        // It stands in pictures, so that it must never change.
        assert_eq!(first.to_string(), EXPECTED);
    }

    const EXPECTED: &str = "xxh3:3b1d423e2ec6f61b8a1140323321f9cd";

    #[test]
    fn hash_of_a_mesh_and_of_labels() {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let parts = MeshParts::new(positions).triangles(vec![[0, 1, 2]]);
        let colors = vec![[0.5; 3]; 3];
        let hash = |parts: MeshParts| ContentHash::of_mesh(&Mesh::new(parts).unwrap());
        let plain = hash(parts.clone());
        assert_eq!(plain, hash(parts.clone()));
        assert_ne!(plain, hash(parts.clone().colors(colors)));
        assert_ne!(plain, hash(parts.clone().lines(vec![[0, 1]])));
        assert_ne!(plain, hash(parts.points(vec![2])));
        let labels = |samples: Vec<u8>| {
            let labels = volume(1.0, samples.into(), 1.0);
            ContentHash::of_labels(&LabelMap::new(&labels, labels.grid()).unwrap())
        };
        assert_eq!(labels(vec![0, 1, 7]), labels(vec![0, 1, 7]));
        assert_ne!(labels(vec![0, 1, 7]), labels(vec![0, 1, 8]));
        assert_ne!(labels(vec![0, 1, 7]), labels(vec![1, 0, 7]));
    }

    #[test]
    fn hash_as_text_comes_back() {
        let hash = ContentHash(0x00ab_0000_0000_0000_0000_0000_0000_0001);
        assert_eq!(hash.to_string(), "xxh3:00ab0000000000000000000000000001");
        assert_eq!(hash.to_string().parse(), Ok(hash));
        let long = format!("xxh3:{}", "0".repeat(33));
        let signed = format!("xxh3:+{}", "0".repeat(31));
        for text in ["", "xxh3:", "00ab0000000000000000000000000001", &long, &signed, "xxh3:é"] {
            assert_eq!(text.parse::<ContentHash>(), Err(NotAHash), "{text}");
        }
    }
}
