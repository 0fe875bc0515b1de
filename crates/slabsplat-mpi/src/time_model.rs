//! How long a picture takes on how many computers, from what each rank has to do: for machines that are not
//! here. [What comes out] is in the repository.
//!
//! [What comes out]: https://github.com/slabsplat/slabsplat/blob/main/docs/scaling.md
//!
//! ```text
//! reading  = bytes of the rank that reads most / what a rank gets of the file system
//! drawing  = (voxels · a + splats · b) / threads, of the rank that draws most
//! sending  = messages · latency + bytes / bandwidth, of the rank that receives most: rank 0
//! agreeing = 2 · (n − 1) · what a message costs rank 0, five times a picture
//! ```
//!
//! Ranks do these one after the other: nothing is hidden behind anything else. What the model leaves out:
//! other programs, links that several messages share, and files that are packed.

/// A network and the computers on it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "who has other machines fills it in")]
pub struct Cluster {
    /// Seconds until the first byte of a message is there.
    pub latency_secs: f64,
    /// Seconds that each message costs who takes it in.
    pub overhead_secs: f64,
    /// Bytes a second between two computers.
    pub bytes_per_sec: f64,
    /// Bytes a second that a rank reads alone.
    pub rank_read_bytes_per_sec: f64,
    /// Bytes a second that all ranks read together, at most.
    pub all_read_bytes_per_sec: f64,
    /// Threads of a rank.
    pub n_threads: f64,
}

/// What a rank has to do, and how many there are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(
    clippy::exhaustive_structs,
    reason = "it is what reports have, or what is made up of them"
)]
pub struct RankWork {
    /// Ranks.
    pub n_ranks: f64,
    /// Bytes that the rank reads that reads most.
    pub n_bytes_read: f64,
    /// Bytes that all read.
    pub n_bytes_read_by_all: f64,
    /// Voxels that it reads and looks at.
    pub n_voxels_read: f64,
    /// Splats of the rank that draws most.
    pub n_splats: f64,
    /// Bytes that the rank sends that sends most.
    pub n_bytes_sent: f64,
    /// Bytes of the picture, which rank 0 collects.
    pub n_bytes_of_picture: f64,
}

/// Seconds that one thread takes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "they are measured by whoever has a machine")]
pub struct ThreadSpeed {
    /// To list a voxel, or find that it does not show.
    pub voxel_secs: f64,
    /// To project, shade, toss and splat a section.
    pub splat_secs: f64,
}

/// Seconds of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct PictureSecs {
    /// Of reading.
    pub reading: f64,
    /// Of drawing.
    pub drawing: f64,
    /// Of pieces of pictures that are sent.
    pub sending: f64,
    /// Of agreeing that all is well.
    pub agreeing: f64,
}

/// How often all agree for a picture: on the scene's file, on an overview of each of up to two layers, on the
/// boxes, on what was drawn, and on what was written.
const N_AGREEMENTS: f64 = 5.0;

impl PictureSecs {
    /// Of work on a cluster.
    pub fn of(work: &RankWork, speed: &ThreadSpeed, cluster: &Cluster) -> Self {
        let RankWork { n_ranks, .. } = *work;
        let drawing = work.n_voxels_read * speed.voxel_secs + work.n_splats * speed.splat_secs;
        // Each owner hears all whose pictures meet its rows, at worst all; rank 0 then hears all owners.
        let n_messages = 2.0 * (n_ranks - 1.0);
        let n_bytes = work.n_bytes_sent + work.n_bytes_of_picture;
        Self {
            reading: (work.n_bytes_read / cluster.rank_read_bytes_per_sec)
                .max(work.n_bytes_read_by_all / cluster.all_read_bytes_per_sec),
            drawing: drawing / cluster.n_threads,
            sending: 2.0 * cluster.latency_secs
                + n_messages * cluster.overhead_secs
                + n_bytes / cluster.bytes_per_sec,
            agreeing: N_AGREEMENTS
                * (2.0 * cluster.latency_secs + 2.0 * (n_ranks - 1.0) * cluster.overhead_secs),
        }
    }

    /// All of them.
    pub fn total(&self) -> f64 {
        self.reading + self.drawing + self.sending + self.agreeing
    }
}

impl RankWork {
    /// Of a volume of `side`³ voxels of a byte of which `shown` are relevant, each with so many splats, on a
    /// picture of `n_pixels`, of which a part is not empty in each rank's; boxes are read with `halo` voxels
    /// on each side, and of several ranks the one with most work has `largest` times the mean.
    pub fn of_cube(side: f64, n_ranks: f64, scene: &CubeScene) -> Self {
        let of_box = side / n_ranks.cbrt();
        let near = ((of_box + 2.0 * scene.halo) / of_box).powi(3).min(n_ranks);
        let n_voxels = side.powi(3) / n_ranks;
        let is_alone = n_ranks <= 1.0;
        let [largest, largest_read] =
            if is_alone { [1.0; 2] } else { [scene.largest, scene.largest_read] };
        // A box is seen as large as its face, n^(2/3) of them beside each other.
        let n_pixels_of_box = (1.5 * scene.n_pixels / n_ranks.powf(2.0 / 3.0)).min(scene.n_pixels);
        // Voxels around a box are drawn where it shows them: a step on each side.
        let drawn = ((of_box + 2.0) / of_box).powi(3);
        Self {
            n_ranks,
            n_bytes_read: n_voxels * near * largest_read,
            n_bytes_read_by_all: n_voxels * near * n_ranks,
            n_voxels_read: n_voxels * near * largest_read,
            n_splats: n_voxels * scene.shown * scene.splats_a_voxel * drawn * largest,
            n_bytes_sent: 16.0 * n_pixels_of_box * largest,
            n_bytes_of_picture: 16.0 * scene.n_pixels,
        }
    }
}

/// A scene of a cube, by what was measured of another one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "it is made up by whoever asks")]
pub struct CubeScene {
    /// The part of the voxels that are relevant.
    pub shown: f64,
    /// Splats of each.
    pub splats_a_voxel: f64,
    /// Voxels that are read around a box, on each side.
    pub halo: f64,
    /// Pixels of the picture.
    pub n_pixels: f64,
    /// The most splats of a rank over the mean.
    pub largest: f64,
    /// The most voxels that a rank reads over the mean; boxes of much that is empty are large.
    pub largest_read: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLUSTER: Cluster = Cluster {
        latency_secs: 2e-6,
        overhead_secs: 1e-6,
        bytes_per_sec: 12e9,
        rank_read_bytes_per_sec: 1e9,
        all_read_bytes_per_sec: 100e9,
        n_threads: 32.0,
    };
    const SCENE: CubeScene = CubeScene {
        shown: 0.2,
        splats_a_voxel: 5.0,
        halo: 8.0,
        n_pixels: 1e6,
        largest: 1.1,
        largest_read: 2.0,
    };
    const SPEED: ThreadSpeed = ThreadSpeed { voxel_secs: 2e-9, splat_secs: 30e-9 };

    #[test]
    fn time_falls_with_ranks_until_messages_cost_more() {
        let secs = |side: f64, n: f64| {
            PictureSecs::of(&RankWork::of_cube(side, n, &SCENE), &SPEED, &CLUSTER)
        };
        for n in [2.0, 8.0, 64.0, 512.0] {
            assert!(secs(2048.0, n).total() < secs(2048.0, n / 2.0).total(), "{n}");
            assert!(secs(2048.0, n).agreeing > secs(2048.0, n / 2.0).agreeing, "{n}");
        }
        assert!(secs(64.0, 1e6).total() > secs(64.0, 8.0).total());
        let one = RankWork::of_cube(100.0, 1.0, &SCENE);
        assert_eq!((one.n_ranks, one.n_bytes_read_by_all, one.n_voxels_read), (1.0, 1e6, 1e6));
    }
}
