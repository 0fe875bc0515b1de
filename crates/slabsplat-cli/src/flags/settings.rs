//! Flags of `[render]`.

use super::values;
use anyhow::Result;
use clap::Args;
use slabsplat::io::SceneFile;
use slabsplat::{
    BACKEND_NAMES, Compositing, KERNEL_NAMES, KernelName, Lookup, Method, Normalization,
};

#[derive(Args)]
#[command(next_help_heading = "Rendering")]
pub(super) struct SettingsFlags {
    /// image-aligned (the paper's), axis-aligned or every-sample
    #[arg(long, value_parser = values::method)]
    pub(super) method: Option<Method>,

    /// Reconstruction kernel
    #[arg(long, value_name = "NAME", value_parser = KERNEL_NAMES.to_vec())]
    kernel: Option<String>,

    /// Thickness of a slab, in voxel steps
    #[arg(long, value_name = "STEPS", allow_hyphen_values = true)]
    slab_width: Option<f64>,

    /// separate, associated or extinction
    #[arg(long, value_parser = values::compositing)]
    compositing: Option<Compositing>,

    /// How thick sections are darkened: none, paper or product
    #[arg(long, value_parser = values::normalization)]
    normalization: Option<Normalization>,

    /// Thinnest width of the slab hierarchy, in voxel steps
    #[arg(long, value_name = "STEPS", allow_hyphen_values = true)]
    base_slab_width: Option<f64>,

    /// Sections in a table
    #[arg(long, value_name = "N")]
    sections: Option<u32>,

    /// Samples along the radius of a table
    #[arg(long, value_name = "N")]
    radial_samples: Option<u32>,

    /// How a section is looked up: nearest or linear
    #[arg(long, value_parser = values::lookup)]
    lookup: Option<Lookup>,

    /// Opacity from which a pixel counts as full; 1 draws everything
    #[arg(long, value_name = "OPACITY", allow_hyphen_values = true)]
    opacity_cutoff: Option<f64>,

    /// How far a pixel may be from what all sections would give; 0 draws them all
    #[arg(long, value_name = "DIFFERENCE", allow_hyphen_values = true)]
    tolerance: Option<f64>,

    // Not clap's to check: a scene may name a backend, too, and is told the same.
    #[arg(long, value_name = "NAME", help = backend_help())]
    backend: Option<String>,
}

fn backend_help() -> String {
    let names = BACKEND_NAMES.join(", ");
    format!("What executes the frame: {names}; auto is the fastest that there is")
}

impl SettingsFlags {
    pub(super) fn lay_over(&self, file: &mut SceneFile) -> Result<()> {
        let was = file.settings.clone();
        let kernel = self.kernel.clone().map(|name| KernelName(name.into()));
        file.settings = slabsplat::RenderSettings {
            method: self.method.unwrap_or(was.method),
            kernel: kernel.unwrap_or(was.kernel),
            slab_width: self.slab_width.unwrap_or(was.slab_width),
            compositing: self.compositing.unwrap_or(was.compositing),
            normalization: self.normalization.unwrap_or(was.normalization),
            base_slab_width: self.base_slab_width.unwrap_or(was.base_slab_width),
            sections: self.sections.unwrap_or(was.sections),
            radial_samples: self.radial_samples.unwrap_or(was.radial_samples),
            lookup: self.lookup.unwrap_or(was.lookup),
            opacity_cutoff: self.opacity_cutoff.unwrap_or(was.opacity_cutoff),
            tolerance: self.tolerance.unwrap_or(was.tolerance),
        }
        .checked()?;
        if let Some(backend) = &self.backend {
            file.backend.clone_from(backend);
        }
        Ok(())
    }
}
