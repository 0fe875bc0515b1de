//! The dependency rules themselves: who may use whom, and which crates of others stay where.
//!
//! A crate of the workspace has a row in [`LAYERS`]; most rows need no more.
//! The build script of a crate counts as a user of its own, called `crate/build.rs`, where crates of others
//! are concerned: it runs on the machine that builds, and what it uses is not in the library.

/// Where to add a row.
pub(super) const FILE: &str = file!();

/// A crate of the workspace, and the crates of the workspace that it may use.
pub(super) struct Layer {
    pub(super) name: &'static str,
    pub(super) may_use: &'static [&'static str],
    pub(super) why: &'static str,
}

/// The modules at the top of a crate, floor by floor.
pub(super) struct Floors {
    /// Where the crate's root lies.
    pub(super) folder: &'static str,
    /// Modules of one floor may use each other, but for circles, and those of all floors before.
    pub(super) from_below: &'static [&'static [&'static str]],
}

pub(super) const FLOORS: &[Floors] = &[Floors {
    folder: "crates/slabsplat-cpu/src",
    from_below: &[
        &["stopwatch", "progress"],
        &["pixels"],
        &["voxels"],
        &["footprints"],
        &["sections"],
        &["separable"],
        &["meshes", "methods"],
        &["frame"],
    ],
}];

pub(super) const LAYERS: &[Layer] = &[
    Layer { name: "slabsplat-core", may_use: &[], why: "all others stand on it" },
    Layer {
        name: "slabsplat-seeds",
        may_use: &[],
        why: "tests of every crate take their seeds from it",
    },
    Layer {
        name: "slabsplat-testbrowser",
        may_use: &[],
        why: "it runs pages of anybody's, and what they show is for tests to judge",
    },
    Layer {
        name: "slabsplat-testdata",
        may_use: &[],
        why: "tests of every crate, and what measures, ask it where volumes are",
    },
    Layer {
        name: "slabsplat-kernel",
        may_use: &["slabsplat-core"],
        why: "kernels and their tables know nothing of volumes on disk, of order, or of who draws",
    },
    Layer {
        name: "slabsplat-io",
        may_use: &["slabsplat-core"],
        why: "readers and writers make and take core's types, and never render",
    },
    Layer {
        name: "slabsplat-film",
        may_use: &["slabsplat-core"],
        why: "a film is scenes over time and frames as files; who renders one calls it",
    },
    Layer {
        name: "slabsplat-annotations",
        may_use: &["slabsplat-core"],
        why: "it draws onto a picture that is done, whoever made it of what",
    },
    Layer {
        name: "slabsplat-traverse",
        may_use: &["slabsplat-core", "slabsplat-kernel"],
        why: "the order of voxels must not depend on who draws them",
    },
    Layer {
        name: "slabsplat-backend",
        may_use: &["slabsplat-core", "slabsplat-kernel"],
        why: "the contract knows no backend, no file and no traversal",
    },
    Layer {
        name: "slabsplat-mesh",
        may_use: &["slabsplat-core", "slabsplat-traverse", "slabsplat-backend"],
        why: "where rays meet surfaces is a matter of the plan, and of no kernel and no pixel",
    },
    Layer {
        name: "slabsplat-cpu",
        may_use: &[
            "slabsplat-core",
            "slabsplat-kernel",
            "slabsplat-traverse",
            "slabsplat-backend",
            "slabsplat-mesh",
        ],
        why: "a backend executes a plan: it reads no file and sees no other backend",
    },
    Layer {
        name: "slabsplat-shaders",
        may_use: &[],
        why: "a shader gets all by its bindings, and its layouts are compared from above",
    },
    Layer {
        name: "slabsplat-gpu",
        may_use: &[
            "slabsplat-core",
            "slabsplat-kernel",
            "slabsplat-traverse",
            "slabsplat-backend",
            "slabsplat-mesh",
            "slabsplat-shaders",
        ],
        why: "a frame is data: it knows neither who executes it nor how a CPU would splat",
    },
    Layer { name: "slabsplat-wgpu", may_use: EXECUTOR, why: EXECUTES },
    Layer { name: "slabsplat-ash", may_use: EXECUTOR, why: EXECUTES },
    Layer {
        name: "slabsplat",
        may_use: &[
            "slabsplat-core",
            "slabsplat-annotations",
            "slabsplat-kernel",
            "slabsplat-io",
            "slabsplat-film",
            "slabsplat-traverse",
            "slabsplat-backend",
            "slabsplat-mesh",
            "slabsplat-cpu",
            "slabsplat-gpu",
            "slabsplat-wgpu",
            "slabsplat-ash",
        ],
        why: "the facade joins the libraries, and programs stand on top of it",
    },
    Layer {
        name: "slabsplat-mpi",
        may_use: &["slabsplat"],
        why: "ranks draw what any program draws, and share what they have drawn",
    },
    Layer {
        name: "slabsplat-viewer",
        may_use: &["slabsplat"],
        why: "a window shows what any program can have drawn, and nothing below knows of windows",
    },
    Layer {
        name: "slabsplat-serve",
        may_use: &["slabsplat"],
        why: "it hands out pictures that any program could make, and shows none",
    },
    Layer {
        name: "slabsplat-cli",
        may_use: &["slabsplat", "slabsplat-mpi", "slabsplat-serve", "slabsplat-viewer"],
        why: "what the program can do, any downstream crate must be able to do",
    },
    Layer {
        name: "slabsplat-tests",
        may_use: &[
            "slabsplat-core",
            "slabsplat-annotations",
            "slabsplat-kernel",
            "slabsplat-io",
            "slabsplat-traverse",
            "slabsplat-backend",
            "slabsplat-mesh",
            "slabsplat-cpu",
            "slabsplat-shaders",
            "slabsplat-gpu",
            "slabsplat-wgpu",
            "slabsplat-ash",
            "slabsplat",
            "slabsplat-mpi",
            "slabsplat-cli",
            "slabsplat-seeds",
            "slabsplat-testbrowser",
            "slabsplat-testdata",
        ],
        why: "tests look everywhere but into the tooling",
    },
    Layer { name: "xtask", may_use: &[], why: "lint must run while the renderer does not build" },
    Layer {
        name: "slabsplat-bench",
        may_use: &["xtask", "slabsplat-testdata", "slabsplat-testbrowser"],
        why: "it starts programs and pages and measures them from outside, as other renderers are measured",
    },
];

const EXECUTOR: &[&str] = &["slabsplat-gpu", "slabsplat-shaders"];
const EXECUTES: &str = "it executes frames that are data, and sees no plan and no other executor";

/// Crates that even a dev-dependency reaches only from above.
pub(super) const TOP: &[&str] = &["slabsplat", "slabsplat-viewer", "slabsplat-cli"];

/// The only crates of others that a crate may use.
pub(super) struct Closed {
    pub(super) name: &'static str,
    pub(super) externals: &'static [&'static str],
    /// What it may use behind a feature.
    pub(super) optional: &'static [&'static str],
    pub(super) why: &'static str,
}

pub(super) const CLOSED: &[Closed] = &[
    Closed {
        name: "slabsplat-core",
        externals: &["bytemuck", "glam", "thiserror"],
        optional: &["image", "ndarray", "serde"],
        why: "what core uses, everybody compiles, on wasm32 too",
    },
    Closed {
        name: "slabsplat-kernel",
        externals: &["bytemuck", "glam", "libm", "thiserror"],
        optional: &[],
        why: "tables must be the same bits on every machine, so it takes its functions from libm",
    },
];

/// A crate of others, and who may use it.
pub(super) struct External {
    pub(super) name: &'static str,
    pub(super) users: Users,
    pub(super) why: &'static str,
}

pub(super) enum Users {
    Only(&'static [&'static str]),
    AllBut(&'static [&'static str]),
}

pub(super) const EXTERNALS: &[External] = &[
    External {
        name: "rayon",
        users: Users::AllBut(&[
            "slabsplat-core",
            "slabsplat-kernel",
            "slabsplat-backend",
            "slabsplat-shaders",
            "slabsplat-gpu",
            "slabsplat-wgpu",
        ]),
        why: "threads belong to those who execute on the CPU, and these must build where there are none",
    },
    External {
        name: "naga",
        users: Users::Only(&["slabsplat-shaders/build.rs"]),
        why: "shaders are compiled when slabsplat is, and no program carries a second compiler",
    },
    External {
        name: "wgpu",
        users: Users::Only(&["slabsplat-wgpu", "slabsplat-viewer"]),
        why: "whoever wants another interface must not compile this one",
    },
    External {
        name: "pollster",
        users: Users::Only(&["slabsplat-wgpu"]),
        why: "only wgpu returns futures, and they end where they come from",
    },
    External { name: "ash", users: Users::Only(&["slabsplat-ash"]), why: UNSAFE },
    External { name: "gpu-allocator", users: Users::Only(&["slabsplat-ash"]), why: UNSAFE },
    External {
        name: "robust",
        users: Users::Only(&["slabsplat-mesh"]),
        why: "exact predicates are for where edges are; volumes have none",
    },
    External {
        name: "ab_glyph",
        users: Users::Only(&["slabsplat-annotations"]),
        why: "whoever wants no text on pictures compiles no font",
    },
    External {
        name: "image",
        users: Users::Only(&["slabsplat-core", "slabsplat-io", "slabsplat-viewer"]),
        why: CODECS,
    },
    External { name: "serde", users: Users::Only(CODERS), why: CODECS },
    External { name: "toml", users: Users::Only(CODERS), why: CODECS },
    External { name: "nifti", users: Users::Only(&["slabsplat-io"]), why: CODECS },
    External { name: "flate2", users: Users::Only(&["slabsplat-io"]), why: CODECS },
    External { name: "bzip2", users: Users::Only(&["slabsplat-io"]), why: CODECS },
    External {
        name: "image-webp",
        users: Users::Only(&["slabsplat-io", "slabsplat-film"]),
        why: CODECS,
    },
    External { name: "color", users: Users::Only(&["slabsplat-io"]), why: CODECS },
    External { name: "jpeg-decoder", users: Users::Only(&["slabsplat-io"]), why: CODECS },
    External { name: "rust-j2k", users: Users::Only(&["slabsplat-io"]), why: CODECS },
    External { name: "hdf5-pure", users: Users::Only(&["slabsplat-io"]), why: CODECS },
    External { name: "gif", users: Users::Only(&["slabsplat-film"]), why: FILMS },
    External { name: "half", users: Users::Only(&["slabsplat-io"]), why: CODECS },
    External { name: "lz4_flex", users: Users::Only(&["slabsplat-io"]), why: CODECS },
    External { name: "ruzstd", users: Users::Only(&["slabsplat-io"]), why: CODECS },
    External {
        name: "plotters",
        users: Users::Only(&["slabsplat-bench"]),
        why: "plots are for the documentation, and no program carries them",
    },
    External { name: "eframe", users: Users::Only(&["slabsplat-viewer"]), why: WINDOWS },
    External { name: "rfd", users: Users::Only(&["slabsplat-viewer"]), why: WINDOWS },
    External { name: "axum", users: Users::Only(&["slabsplat-serve"]), why: SERVER },
    External { name: "tokio", users: Users::Only(&["slabsplat-serve"]), why: SERVER },
    External { name: "futures-util", users: Users::Only(&["slabsplat-serve"]), why: SERVER },
    External { name: "clap", users: Users::Only(&["slabsplat-cli"]), why: TERMINAL },
    External { name: "indicatif", users: Users::Only(&["slabsplat-cli"]), why: TERMINAL },
    External { name: "signal-hook", users: Users::Only(&["slabsplat-cli"]), why: TERMINAL },
    External {
        name: "anyhow",
        users: Users::Only(&[
            "slabsplat-cli",
            "slabsplat-shaders/build.rs",
            "slabsplat-tests",
            "xtask",
            "slabsplat-bench",
        ]),
        why: "a library's errors are an enum that the caller can act on",
    },
];

const UNSAFE: &str = "raw Vulkan is unsafe, and only one crate may contain unsafe code";
const CODECS: &str = "file formats stay in one crate";
const FILMS: &str = "who makes no films compiles no encoder of them";
const CODERS: &[&str] =
    &["slabsplat-core", "slabsplat-io", "slabsplat-viewer", "xtask", "slabsplat-bench"];
const WINDOWS: &str = "whoever draws without a display compiles no window";
const SERVER: &str = "who serves nobody compiles no server";
const TERMINAL: &str = "only the program talks to a terminal";
