//! Flags that choose a volume of a file that holds several.

use clap::Args;
use slabsplat::io::{ColorUse, OpacitySource, VolumeOptions};

#[derive(Args, Default)]
#[command(next_help_heading = "Volume")]
pub(crate) struct PartFlags {
    /// Which series of a folder, or image of a file, from 0 on [default: the largest]
    #[arg(long, value_name = "N")]
    series: Option<usize>,

    /// Which value of each voxel, from 0 on [default: the first]
    #[arg(long, value_name = "N")]
    channel: Option<usize>,

    /// Which moment, from 0 on [default: the first]
    #[arg(long, value_name = "N")]
    time: Option<usize>,

    /// Which resolution: 0 is the finest [default: the finest that there is room for]
    #[arg(long, value_name = "N")]
    level: Option<usize>,

    /// In which colours voxels of three or four values are drawn: own or none [default: own, if they are
    /// meant to be colours]
    #[arg(long, value_name = "COLORS")]
    colors: Option<ColorUse>,

    /// What the opacity of voxels with colours is made of: luminance or alpha [default: alpha, if there is
    /// any]
    #[arg(long, value_name = "SOURCE")]
    opacity_from: Option<OpacitySource>,

    /// Let the volume's header name files outside of its own folder
    #[arg(long)]
    allow_external: bool,
}

impl PartFlags {
    /// Whether no flag says anything.
    pub(crate) fn are_silent(&self) -> bool {
        let Self { series, channel, time, level, colors, opacity_from, allow_external } = self;
        let is_some = [colors.is_some(), opacity_from.is_some(), *allow_external].contains(&true);
        [series, channel, time, level].iter().all(|part| part.is_none()) && !is_some
    }

    pub(crate) fn lay_over(&self, options: &mut VolumeOptions) {
        options.series = self.series.or(options.series);
        options.channel = self.channel.or(options.channel);
        options.time = self.time.or(options.time);
        options.level = self.level.or(options.level);
        options.colors = self.colors.or(options.colors);
        options.opacity_from = self.opacity_from.or(options.opacity_from);
        options.allow_external |= self.allow_external;
    }
}
