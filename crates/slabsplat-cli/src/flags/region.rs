//! Flags of `[region]`.

use super::values;
use anyhow::{Result, bail};
use clap::Args;
use slabsplat::Plane;
use slabsplat::glam::DVec3;
use slabsplat::io::SceneFile;

#[derive(Args)]
#[command(next_help_heading = "Region")]
pub(super) struct RegionFlags {
    /// Show what lies in a box of the world, given by its least and its greatest corner
    #[arg(
        long, value_name = "X0,Y0,Z0,X1,Y1,Z1", value_parser = values::ends,
        allow_hyphen_values = true
    )]
    crop: Option<[DVec3; 2]>,

    /// The same with corners that count voxels; meshes have none
    #[arg(
        long, value_name = "I0,J0,K0,I1,J1,K1", value_parser = values::ends,
        allow_hyphen_values = true, conflicts_with = "crop"
    )]
    crop_index: Option<[DVec3; 2]>,

    /// Show what lies behind a plane, n*x <= d; may be given several times
    #[arg(
        long, value_name = "NX,NY,NZ,D", value_parser = values::plane, allow_hyphen_values = true
    )]
    clip: Vec<Plane>,

    /// Show all but that box and what lies behind all of these planes
    #[arg(long)]
    cut_out: bool,

    /// Light cut faces as surfaces, instead of by what is inside
    #[arg(long)]
    lit_cuts: bool,
}

impl RegionFlags {
    pub(super) fn lay_over(&self, file: &mut SceneFile) -> Result<()> {
        let mut is_cut = false;
        let SceneFile { layers, meshes, .. } = file;
        let of_layers = layers.iter_mut().map(|layer| (&mut layer.region, self.crop_index));
        let of_meshes = meshes.iter_mut().map(|mesh| (&mut mesh.region, None));
        for (region, crop_index) in of_layers.chain(of_meshes) {
            if let Some(ends) = self.crop.or(crop_index) {
                region.ends = Some(ends);
                region.is_index = self.crop_index.is_some();
            }
            if !self.clip.is_empty() {
                region.planes.clone_from(&self.clip);
            }
            // All but everywhere would be nothing.
            if region.ends.is_some() || !region.planes.is_empty() {
                region.is_inverted |= self.cut_out;
                region.is_lit |= self.lit_cuts;
                is_cut = true;
            }
        }
        for (name, is_given) in [("cut-out", self.cut_out), ("lit-cuts", self.lit_cuts)] {
            if is_given && !is_cut {
                bail!("--{name} does nothing where nothing is cut: add --crop or --clip");
            }
        }
        Ok(())
    }
}
