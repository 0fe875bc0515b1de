//! Heat that spreads and is blown along, on all ranks, and a film of it that is made while it runs.
//!
//! ```sh
//! cargo build --release -p slabsplat-mpi --features mpi --example heat
//! mpirun -n 4 target/release/examples/heat 48 heat.gif
//! ```
//!
//! It takes the voxels of a side, and the film's name: `.gif`, `.webp`, or with ffmpeg `.mp4`.

use slabsplat::film::{FilmDesc, FilmFormat, FilmWriter, FrameRate};
use slabsplat::{Grid, Image};
use slabsplat_mpi::{
    Communicator, Field, InSitu, SceneText, Tag, Values, VoxelBox, agree, receive,
};
use std::error::Error;
use std::path::Path;
use std::time::Duration;

/// What anything fails by, on whatever rank.
type AnyError = Box<dyn Error + Send + Sync>;

const N_FRAMES: u32 = 24;
const STEPS_A_FRAME: usize = 8;

fn main() -> Result<(), AnyError> {
    let args: Vec<String> = std::env::args().collect();
    let n = args.get(1).map_or(Ok(48), |n| n.parse::<usize>())?.max(8);
    run(n, Path::new(args.get(2).map_or("heat.gif", String::as_str)))
}

#[cfg(not(feature = "mpi"))]
fn run(n: usize, film: &Path) -> Result<(), AnyError> {
    let limit = Duration::from_secs(60);
    let ranks = slabsplat_mpi::ThreadRank::run(3, limit, |comm| simulate(comm, n, film));
    ranks.into_iter().collect()
}

#[cfg(feature = "mpi")]
fn run(n: usize, film: &Path) -> Result<(), AnyError> {
    let world = slabsplat_mpi::World::start(Duration::from_secs(60))?;
    simulate(&world, n, film)
}

fn simulate(comm: &dyn Communicator, n: usize, path: &Path) -> Result<(), AnyError> {
    let mut heat = Heat::new(comm, n);
    let grid = Grid::with_spacing([n; 3], [1.0; 3])?;
    let in_situ = InSitu::new(comm, grid, &heat.own)?;
    let scene = SceneText::parse(&scene_text(n))?;
    let mut frame = || -> Result<Option<Image>, AnyError> {
        for _ in 0..STEPS_A_FRAME {
            heat.step(comm, n)?;
        }
        let field = Field::packed(Values::F32(&heat.values), heat.own.clone())?;
        let picture = in_situ.picture(comm, &[field], |volumes| scene.scene(volumes))?;
        Ok(picture.map(|picture| picture.frame.image))
    };
    let film = (comm.rank() == 0).then(|| begin(path, scene.size())).transpose();
    let Some(film) = agree(comm, film)? else {
        return (0..N_FRAMES).try_for_each(|_| frame().map(|_| ()));
    };
    let first = |_| Ok::<_, AnyError>(frame()?.ok_or("rank 0 has the picture")?);
    film.make(first, |_| {})?;
    Ok(())
}

/// A film that goes on as the simulation does, and begins anew with it.
fn begin(path: &Path, [width, height]: [u32; 2]) -> Result<FilmWriter, AnyError> {
    let format = FilmFormat::of_name(path).ok_or("name the film .gif")?;
    let desc = FilmDesc::new(width, height, N_FRAMES, FrameRate::new(12.0)?)?;
    Ok(FilmWriter::begin_anew(path, format, desc, "heat that is blown along")?)
}

fn scene_text(n: usize) -> String {
    let middle = (n as f64 - 1.0) / 2.0;
    let eye = [middle + 1.6 * n as f64, middle - 2.0 * n as f64, middle + n as f64];
    format!(
        "[classify]\nopacity = [[0.02, 0.0], [0.2, 0.05], [0.8, 0.4]]\n\
         color = [[0.02, 0.1, 0.1, 0.6], [0.2, 0.9, 0.2, 0.1], [0.8, 1.0, 0.9, 0.3]]\n\
         [camera]\neye = {eye:?}\ntarget = {:?}\nup = [0.0, 0.0, 1.0]\nfov_y = 30.0\n\
         [image]\nwidth = 256\nheight = 256\nbackground = [0.02, 0.02, 0.04, 1.0]\n",
        [middle; 3]
    )
}

/// A rank's slab along z, by explicit steps.
struct Heat {
    own: VoxelBox,
    values: Vec<f32>,
}

impl Heat {
    fn new(comm: &dyn Communicator, n: usize) -> Self {
        let at = |rank: usize| rank * n / comm.n_ranks();
        let own = [0..n, 0..n, at(comm.rank())..at(comm.rank() + 1)];
        Self { values: vec![0.0; n * n * own[2].len()], own }
    }

    /// Two sources heat, all of it spreads and is blown along z.
    fn step(&mut self, comm: &dyn Communicator, n: usize) -> Result<(), AnyError> {
        for source in [[n / 3, n / 3, n / 4], [2 * n / 3, n / 2, n / 3]] {
            self.heat(source, n);
        }
        let [below, above] = self.neighbours(comm, n * n)?;
        let plane = n * n;
        let old = std::mem::take(&mut self.values);
        let layer = |k: isize| -> &[f32] {
            let last = old.len() / plane;
            match k {
                -1 => &below,
                k if k as usize == last => &above,
                k => &old[k as usize * plane..][..plane],
            }
        };
        self.values = (0..old.len())
            .map(|idx| {
                let (k, at) = ((idx / plane) as isize, idx % plane);
                let (i, j) = (at % n, at / n);
                let here = layer(k);
                let west = here[if i == 0 { at } else { at - 1 }];
                let east = here[if i + 1 == n { at } else { at + 1 }];
                let south = here[if j == 0 { at } else { at - n }];
                let north = here[if j + 1 == n { at } else { at + n }];
                let (down, up) = (layer(k - 1)[at], layer(k + 1)[at]);
                let around = west + east + south + north + down + up;
                here[at] + 0.12 * (around - 6.0 * here[at]) - 0.1 * (up - down)
            })
            .collect();
        Ok(())
    }

    /// The planes below and above; at the ends of the grid its own.
    fn neighbours(&self, comm: &dyn Communicator, plane: usize) -> Result<[Vec<f32>; 2], AnyError> {
        let ends = [&self.values[..plane], &self.values[self.values.len() - plane..]];
        let below = comm.rank().checked_sub(1);
        let above = Some(comm.rank() + 1).filter(|rank| *rank < comm.n_ranks());
        let ranks = [below, above];
        for (rank, end) in ranks.into_iter().zip(ends) {
            if let Some(rank) = rank {
                let bytes = end.iter().flat_map(|value| value.to_ne_bytes()).collect();
                comm.send(rank, Tag::Program, bytes)?;
            }
        }
        let mut planes = ends.map(<[f32]>::to_vec);
        for (rank, plane) in ranks.into_iter().zip(&mut planes) {
            if let Some(rank) = rank {
                let bytes = receive(comm, rank, Tag::Program)?;
                let values = bytes.as_chunks().0.iter().map(|value| f32::from_ne_bytes(*value));
                *plane = values.collect();
            }
        }
        Ok(planes)
    }

    fn heat(&mut self, [i, j, k]: [usize; 3], n: usize) {
        if self.own[2].contains(&k) {
            let plane = (k - self.own[2].start) * n * n;
            for (dj, di) in (0..3).flat_map(|dj| (0..3).map(move |di| (dj, di))) {
                self.values[plane + (j + dj) * n + i + di] = 1.0;
            }
        }
    }
}
