//! The same volumes seen otherwise, from frame to frame: what a film is made of.

use super::{Budget, DividedError, DividedScene, Shares, Surveyed};
use crate::{Picture, RenderError, frame_scene};
use slabsplat_backend::check_parts;
use slabsplat_core::{FrameHandle, Scene};

impl DividedScene {
    /// Draws another scene of the same volumes and finishes it: [the opened one](Self::opened) with another
    /// camera, other lights, settings or looks of layers, as films have it. Boxes that were read for the
    /// frame before are not read again, as far as there is room for them.
    ///
    /// # Errors
    /// As [`open`](Self::open) and [`picture`](Self::picture), for the other scene.
    ///
    /// # Panics
    /// If it has more layers or fewer.
    pub fn picture_of(&self, scene: &Scene, frame: &FrameHandle) -> Result<Picture, DividedError> {
        self.at(scene)?.picture(frame)
    }

    /// How many boxes were read for all pictures, and how many were there from one before.
    pub fn box_counts(&self) -> [u64; 2] {
        self.retained.counts()
    }

    /// The other scene, cut into boxes for it.
    fn at(&self, scene: &Scene) -> Result<Self, DividedError> {
        let n_layers = self.sources.len();
        assert_eq!(scene.layers.len(), n_layers, "usage: it is of the same volumes");
        check_parts(scene)?;
        let mut opened = self.opened.clone();
        opened.scene = scene.clone();
        let drawn = frame_scene(scene).map_err(RenderError::from)?;
        let budget = Budget::new(scene, &drawn.image, (&self.desc, &self.backend))?;
        drop(drawn);
        let surveyed = Surveyed {
            opened,
            sources: self.sources.clone(),
            labels: self.labels.clone(),
            grids: self.grids.clone(),
            outlines: self.outlines.clone(),
            backend: self.backend.clone(),
        };
        let (divided, _) = Self::divided(surveyed, &self.desc, (budget, Shares::whole()))?;
        Ok(Self { retained: self.retained.clone(), ..divided })
    }

    /// The film of the scene's file, as [`OpenScene::film`](crate::OpenScene::film).
    ///
    /// # Errors
    /// As there.
    #[cfg(feature = "film")]
    pub fn film(&self) -> Result<Option<slabsplat_film::Film>, crate::OpenError> {
        self.opened.film_on(&self.grids)
    }
}
