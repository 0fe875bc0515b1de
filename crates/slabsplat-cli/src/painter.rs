//! What draws the frames of a film: a backend that has all volumes, or box by box within some memory.

use crate::advice;
use crate::ranks::Drawn;
use crate::render::nothing_visible;
use anyhow::Result;
use slabsplat::film::Film;
use slabsplat::io::SceneFile;
use slabsplat::{DividedScene, FrameHandle, OpenScene, Renderer, Scene};

pub(crate) enum Painter {
    /// All voxels are in memory.
    InCore(Box<(Renderer, OpenScene)>),
    /// Voxels come from their files, frame by frame.
    InParts(Box<DividedScene>),
}

impl Painter {
    /// What was opened.
    pub(crate) fn opened(&self) -> &OpenScene {
        match self {
            Self::InCore(core) => &core.1,
            Self::InParts(divided) => divided.opened(),
        }
    }

    pub(crate) fn opened_mut(&mut self) -> &mut OpenScene {
        match self {
            Self::InCore(core) => &mut core.1,
            Self::InParts(divided) => divided.opened_mut(),
        }
    }

    /// The backend, by name.
    pub(crate) fn backend(&self) -> &str {
        match self {
            Self::InCore(core) => core.0.caps().name,
            Self::InParts(divided) => divided.backend(),
        }
    }

    /// What makes pixels: with another one they may differ.
    pub(crate) fn device(&self) -> String {
        match self {
            Self::InCore(core) => core.0.caps().device.clone(),
            Self::InParts(divided) => format!("{}, box by box", divided.backend()),
        }
    }

    /// The scene as a scene file that leaves nothing open, not even what draws it.
    pub(crate) fn file(&mut self) -> Result<SceneFile> {
        Ok(match self {
            Self::InCore(core) => {
                let (renderer, opened) = &mut **core;
                renderer.caps().name.clone_into(&mut opened.backend);
                opened.to_file()?
            }
            Self::InParts(divided) => divided.to_file()?,
        })
    }

    /// What key frames make of it.
    pub(crate) fn film(&self) -> Result<Option<Film>> {
        Ok(match self {
            Self::InCore(core) => core.1.film()?,
            Self::InParts(divided) => divided.film()?,
        })
    }

    /// Draws a frame: the scene, as it is at that moment.
    pub(crate) fn draw(&mut self, scene: &Scene) -> Result<Drawn> {
        match self {
            Self::InCore(core) => {
                let (renderer, opened) = &mut **core;
                let frame = FrameHandle::new();
                let picture = advice::picture(renderer, scene, opened.acquisition, &frame)?;
                let why_blank = picture.is_blank.then(|| nothing_visible(scene, &picture.frame));
                Ok(Drawn { image: picture.frame.image, why_blank, notes: picture.notes })
            }
            Self::InParts(divided) => {
                let picture = divided.picture_of(scene, &FrameHandle::new())?;
                let why_blank = picture.is_blank.then(|| NOTHING_IN_PARTS.to_owned());
                Ok(Drawn { image: picture.frame.image, why_blank, notes: picture.notes })
            }
        }
    }
}

/// Why a picture in parts is empty: nobody has looked at all voxels.
pub(crate) const NOTHING_IN_PARTS: &str = "no voxel that is seen has an opacity, or all is cut off";
