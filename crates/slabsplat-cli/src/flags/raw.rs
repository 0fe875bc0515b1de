//! Flags that describe a raw file, which has no header to say it.

use super::parts::PartFlags;
use super::values::{self, Dims};
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use slabsplat::SampleType;
use slabsplat::glam::DVec3;
use slabsplat::io::{Endian, RawDesc};

#[derive(Args, Default)]
#[command(next_help_heading = "Volume")]
pub(crate) struct RawFlags {
    /// Size of a voxel, instead of what the file says
    #[arg(long, value_name = "X,Y,Z", value_parser = values::spacing, allow_hyphen_values = true)]
    pub(crate) spacing: Option<DVec3>,

    #[command(flatten)]
    pub(crate) parts: PartFlags,

    /// Raw file: voxels along each axis, the fastest first
    #[arg(long, value_name = "X,Y,Z", value_parser = values::dims, allow_hyphen_values = true)]
    dims: Option<Dims>,

    /// Raw file: type of a sample, as uint8, int16, float32
    #[arg(long = "type", value_name = "TYPE", value_parser = values::sample_type)]
    sample_type: Option<SampleType>,

    /// Raw file: order of a sample's bytes [default: little]
    #[arg(long, value_name = "ORDER")]
    endian: Option<ByteOrder>,

    /// Raw file: bytes before the first sample [default: 0]
    #[arg(long, value_name = "N")]
    header_bytes: Option<u64>,
}

#[derive(Clone, Copy, ValueEnum)]
enum ByteOrder {
    Little,
    Big,
}

impl RawFlags {
    /// Whether no flag says anything.
    pub(crate) fn are_silent(&self) -> bool {
        self.spacing.is_none() && self.parts.are_silent() && matches!(self.desc(), Ok(None))
    }

    /// What the flags say of a raw file; `None` if they say nothing of one.
    pub(crate) fn desc(&self) -> Result<Option<RawDesc>> {
        let is_silent = self.dims.is_none()
            && self.sample_type.is_none()
            && self.endian.is_none()
            && self.header_bytes.is_none();
        if is_silent {
            return Ok(None);
        }
        let (Some(Dims(dims)), Some(sample_type)) = (self.dims, self.sample_type) else {
            bail!("a raw file needs both --dims and --type");
        };
        let endian = match self.endian {
            Some(ByteOrder::Big) => Endian::Big,
            Some(ByteOrder::Little) | None => Endian::Little,
        };
        // Its spacing is 1 unless the scene or a flag says another.
        let desc = RawDesc::new(dims, sample_type).endian(endian);
        Ok(Some(desc.header_bytes(self.header_bytes.unwrap_or(0))))
    }
}
