//! The tables of `docs/scaling.md`: what the model of time says of larger volumes on more ranks.
//!
//! ```sh
//! cargo run --release -p slabsplat-mpi --example scaling
//! ```

use slabsplat_mpi::time_model::{Cluster, CubeScene, PictureSecs, RankWork, ThreadSpeed};

/// A cluster as many are: 100 Gbit/s, a parallel file system, a rank on each socket.
const CLUSTER: Cluster = Cluster {
    latency_secs: 2e-6,
    overhead_secs: 1e-6,
    bytes_per_sec: 12e9,
    rank_read_bytes_per_sec: 1e9,
    all_read_bytes_per_sec: 100e9,
    n_threads: 32.0,
};

/// The brain of 10⁹ voxels, as if nothing of it hid anything, with the imbalance of 64 ranks.
const SCENE: CubeScene = CubeScene {
    shown: 0.24,
    splats_a_voxel: 6.0,
    halo: 16.0,
    n_pixels: 1024.0 * 1024.0,
    largest: 1.4,
    largest_read: 3.9,
};

/// Of the machine that `docs/scaling.md` names: 16 s of a processor for that brain by one rank.
const SPEED: ThreadSpeed = ThreadSpeed { voxel_secs: 4e-9, splat_secs: 60e-9 };

fn main() {
    for side in [2048.0, 8192.0] {
        println!(
            "| ranks | box | reading | drawing | sending | agreeing | all | efficiency | of drawing |"
        );
        println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
        let of = |n: f64| {
            let secs = PictureSecs::of(&RankWork::of_cube(side, n, &SCENE), &SPEED, &CLUSTER);
            (secs, secs.total())
        };
        let (drawing_alone, alone) = of(1.0);
        for n in [1.0, 8.0, 64.0, 256.0, 1024.0, 4096.0] {
            let (secs, total) = of(n);
            println!(
                "| {n} | {:.0}³ | {:.2} s | {:.2} s | {:.1} ms | {:.1} ms | {total:.2} s | {:.0} % | {:.0} % |",
                side / n.cbrt(),
                secs.reading,
                secs.drawing,
                1e3 * secs.sending,
                1e3 * secs.agreeing,
                100.0 * alone / (n * total),
                100.0 * drawing_alone.drawing / (n * secs.drawing),
            );
        }
        println!();
    }
}
