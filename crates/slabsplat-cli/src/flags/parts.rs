//! Flags that choose a volume of a file that holds several.

use clap::Args;
use slabsplat::io::VolumeOptions;

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

    /// Let the volume's header name files outside of its own folder
    #[arg(long)]
    allow_external: bool,
}

impl PartFlags {
    /// Whether no flag says anything.
    pub(crate) fn are_silent(&self) -> bool {
        let Self { series, channel, time, level, allow_external } = self;
        [series, channel, time, level].iter().all(|part| part.is_none()) && !allow_external
    }

    pub(crate) fn lay_over(&self, options: &mut VolumeOptions) {
        options.series = self.series.or(options.series);
        options.channel = self.channel.or(options.channel);
        options.time = self.time.or(options.time);
        options.level = self.level.or(options.level);
        options.allow_external |= self.allow_external;
    }
}
