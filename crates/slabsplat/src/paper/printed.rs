//! The times of the paper's §5, on an SGI Onyx with InfiniteReality, whose graphics hardware drew the splats.

/// What §5 prints of a volume.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PrintedTimes {
    /// What it is called there.
    pub volume: &'static str,
    /// Relevant voxels.
    pub n_voxels: f64,
    /// Their share of all voxels, as printed.
    pub share: f64,
    /// Sorting the relevant voxels for the new method, in seconds; it is printed of one volume.
    pub sort_secs: Option<f64>,
    /// Shading them.
    pub shade_secs: f64,
    /// Rendering the splats by `axis-aligned`.
    pub axis_aligned_secs: f64,
    /// Rendering the splats by `image-aligned`.
    pub image_aligned_secs: f64,
}

/// Both volumes of §5.
pub const PRINTED_TIMES: [PrintedTimes; 2] = [
    PrintedTimes {
        volume: "UNC MRI brain",
        n_voxels: 1.2e6,
        share: 0.16,
        sort_secs: Some(7.0),
        shade_secs: 3.8,
        axis_aligned_secs: 4.2,
        image_aligned_secs: 16.6,
    },
    PrintedTimes {
        volume: "nerve cell",
        n_voxels: 0.9e6,
        share: 0.05,
        sort_secs: None,
        shade_secs: 2.9,
        axis_aligned_secs: 2.8,
        image_aligned_secs: 9.0,
    },
];
