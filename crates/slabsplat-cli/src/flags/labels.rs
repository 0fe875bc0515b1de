//! Flags of `[labels]`.

use anyhow::{Result, bail};
use clap::Args;
use slabsplat::io::{LabelColors, LabelsFile, SceneFile};
use std::path::{Path, PathBuf};

#[derive(Args)]
#[command(next_help_heading = "Labels")]
pub(super) struct LabelFlags {
    /// What voxels belong to: a volume of whole numbers, on the same grid or another
    #[arg(long, value_name = "FILE")]
    labels: Option<PathBuf>,

    /// Colours of labels: a table of FreeSurfer, 3D Slicer, ITK-SNAP or BIDS, or auto
    #[arg(long, value_name = "FILE")]
    label_colors: Option<PathBuf>,

    /// Show no other labels
    #[arg(long, value_name = "N,..", value_delimiter = ',', allow_hyphen_values = true)]
    only_labels: Option<Vec<i64>>,
}

impl LabelFlags {
    pub(super) fn lay_over(&self, file: &mut SceneFile) -> Result<()> {
        for layer in &mut file.layers {
            if let Some(path) = &self.labels {
                layer.labels = Some(LabelsFile::new(path.clone()));
            }
        }
        let has_labels = file.layers.iter().any(|layer| layer.labels.is_some());
        let wishes = [
            ("label-colors", self.label_colors.is_some()),
            ("only-labels", self.only_labels.is_some()),
        ];
        if let Some((name, _)) = wishes.iter().find(|(_, is_given)| *is_given && !has_labels) {
            bail!("--{name} does nothing without labels: add --labels");
        }
        for labels in file.layers.iter_mut().filter_map(|layer| layer.labels.as_mut()) {
            if let Some(colors) = &self.label_colors {
                labels.colors = Some(LabelColors::named(colors, Path::new("")));
            }
            if let Some(only) = &self.only_labels {
                labels.only = Some(only.clone());
            }
        }
        Ok(())
    }
}
