//! The scene of a file, with everything left out filled in.

use crate::automatic::{DARK, Look, lights, phong, takes_gradients};
use crate::framing::{Aim, Cells, Facing, Framing, usual_projection};
use crate::transfer::{Fitted, fitted};
use crate::volume_facts::VolumeFacts;
use slabsplat_backend::PlanError;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    Acquisition, Camera, CameraError, Fit, Grid, Layer, MeshError, MeshLayer, Orientation,
    PiecewiseLinear, Projection, RegionError, Scene, Shading, TransferFunction,
};
use slabsplat_io::{
    CameraDesc, FilmFile, FitError, IoError, LayerFile, LoadedColors, LoadedVolume, MemoryNeed,
    OpacitySource, SceneFile, TransferFit, TransferSource, VolumeChoices, check_memory,
};
use std::cell::{Cell, OnceCell};
use std::path::PathBuf;
use thiserror::Error;

/// A scene, ready to be rendered.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct OpenScene {
    /// What is seen, and how.
    pub scene: Scene,
    /// The name of the backend that the scene asks for.
    pub backend: String,
    /// What was guessed or left out when the volume was read, for people.
    pub warnings: Vec<String>,
    /// What was found from the volumes, a line for each that did not say how it looks, for people.
    pub found: Vec<String>,
    /// What the first volume's file says of it beside its values.
    pub acquisition: Acquisition,
    pub(crate) facing: Facing,
    /// The same two of every layer, of which the first one's count.
    pub(crate) origins: Vec<Origin>,
    /// What was opened, with what was chosen of files that hold several volumes.
    pub sources: SceneFile,
}

/// Where a layer of an open scene comes from.
#[derive(Clone, Debug)]
pub(crate) struct Origin {
    pub(crate) acquisition: Acquisition,
    pub(crate) facing: Facing,
    pub(crate) choices: VolumeChoices,
    /// See [`OpenScene::layer_numbers`].
    pub(crate) number: usize,
}

/// The cameras that go around with one.
type Views<'a> = &'a dyn Fn(&Camera) -> Vec<Camera>;

/// Why a scene cannot be opened.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OpenError {
    /// A volume, labels or their colours cannot be read.
    #[error(transparent)]
    Io(#[from] IoError),
    /// The camera's parts do not make a camera.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A transfer function cannot be fitted to its volume.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// A region is none.
    #[error(transparent)]
    Region(#[from] RegionError),
    /// Key frames make no film.
    #[cfg(feature = "film")]
    #[error(transparent)]
    Motion(#[from] slabsplat_film::MotionError),
    /// There is nothing to draw.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A mesh cannot be where it should.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A scene file is of another scene than the one that is to be shown as it says.
    #[error("it is of another scene: this one has {n_layers} layers and {n_meshes} meshes")]
    OtherScene {
        /// How many layers there are.
        n_layers: usize,
        /// How many meshes there are.
        n_meshes: usize,
    },
    /// A scene file that is shown over another scene has labels where that has none.
    #[error("the layer {layer_idx}, counted from 0, has no labels here")]
    NoLabels {
        /// Which layer, counted from 0.
        layer_idx: usize,
    },
    /// A scene file that is shown over another scene names a file that would have to be read.
    #[error("{} is not read for a scene that is open already", path.display())]
    NotRead {
        /// The file.
        path: PathBuf,
    },
}

impl OpenScene {
    /// Loads the volumes and meshes of `file` and fills in what the file leaves out.
    ///
    /// # Errors
    /// If a volume or a mesh cannot be read, or all volumes have no room in memory, or the camera or a region
    /// makes no sense.
    pub fn open(file: &SceneFile) -> Result<Self, OpenError> {
        check_memory(MemoryNeed::of_layers(&file.layers))?;
        let loaded = LayerFile::load_volumes(&file.layers, LayerFile::load_volume)?;
        Self::with_volumes(loaded, file)
    }

    /// The scene as it is now, as a scene file that leaves nothing open: volumes and meshes come from where
    /// they came from, all else is as `scene` has it. [`slabsplat_io::write_scene`] writes it, and
    /// [`slabsplat_io::Provenance`] puts it into a picture.
    ///
    /// # Errors
    /// If a layer has labels that are from no file.
    ///
    /// # Panics
    /// If layers or meshes were added or taken away otherwise than by
    /// [`add_layers_of`](Self::add_layers_of) and [`with_layers`](Self::with_layers).
    pub fn to_file(&self) -> Result<SceneFile, IoError> {
        let mut file = self.sources.completed(&self.scene)?;
        file.backend.clone_from(&self.backend);
        Ok(file)
    }

    /// The scene of `file` with volumes that are already there, one for each layer; labels and meshes are
    /// read.
    ///
    /// # Errors
    /// If the camera or a region makes no sense, or labels or meshes cannot be read.
    ///
    /// # Panics
    /// If there are more volumes or fewer.
    pub fn with_volumes(loaded: Vec<LoadedVolume>, file: &SceneFile) -> Result<Self, OpenError> {
        let mut opened = Self::unframed(loaded, file)?;
        opened.frame(file, &Aim::default())?;
        Ok(opened)
    }

    /// The same before the camera is looked for, for who changes layers first: [`frame`](Self::frame) does
    /// the rest.
    ///
    /// # Errors
    /// As [`with_volumes`](Self::with_volumes), but for the camera.
    ///
    /// # Panics
    /// If there are more volumes or fewer.
    pub fn unframed(loaded: Vec<LoadedVolume>, file: &SceneFile) -> Result<Self, OpenError> {
        let volumes: Vec<_> = loaded.iter().map(|loaded| loaded.volume.clone()).collect();
        let facts: Vec<_> = volumes.iter().map(|volume| VolumeFacts::from(&**volume)).collect();
        Self::unframed_by(loaded, &facts, file)
    }

    /// The same of volumes that stand for others, of which that is known.
    pub(crate) fn unframed_by(
        loaded: Vec<LoadedVolume>,
        facts: &[VolumeFacts<'_>],
        file: &SceneFile,
    ) -> Result<Self, OpenError> {
        assert_eq!(loaded.len(), file.layers.len(), "there is one volume for each layer");
        let mut sources = file.clone();
        for (source, loaded) in sources.layers.iter_mut().zip(&loaded) {
            source.options.choose(loaded);
        }
        let mut opening = Opening {
            file,
            warnings: Vec::new(),
            found: Vec::new(),
            background: None,
            facings: Vec::new(),
        };
        let acquisitions: Vec<Acquisition> = loaded.iter().map(|it| it.acquisition).collect();
        let choices: Vec<VolumeChoices> = loaded.iter().map(|it| it.choices.clone()).collect();
        let acquisition = loaded.first().map(|loaded| loaded.acquisition);
        let layers = loaded.into_iter().zip(facts).zip(&file.layers);
        let layers = layers.map(|((loaded, facts), of_file)| opening.layer(loaded, facts, of_file));
        let layers = layers.collect::<Result<Vec<_>, _>>()?;
        let meshes = opening.meshes()?;
        if layers.is_empty() && meshes.is_empty() {
            return Err(PlanError::NoLayers.into());
        }
        if let Some(film) = &mut sources.film {
            let warnings = fit_looks(film, &file.layers, (&layers, facts), &acquisitions)?;
            opening.warnings.extend(warnings);
        }
        let mut image = file.image;
        if file.unsaid.background {
            image.background = opening.background.unwrap_or(DARK);
        }
        let Opening { warnings, found, facings, .. } = opening;
        let facing = facings.first().copied().unwrap_or_default();
        let origins = acquisitions.into_iter().zip(facings).zip(choices).enumerate();
        let origin = |(number, ((acquisition, facing), choices))| Origin {
            acquisition,
            facing,
            choices,
            number,
        };
        let origins = origins.map(origin).collect();
        let scene = Scene::of_meshes(meshes, placeholder())
            .layers(layers)
            .lights(file.lights.clone())
            .image(image)
            .settings(file.settings.clone())
            .finish(file.finish.clone());
        let acquisition = acquisition.unwrap_or_default();
        Ok(Self {
            scene,
            backend: file.backend.clone(),
            warnings,
            sources,
            found,
            acquisition,
            facing,
            origins,
        })
    }

    /// Finds the camera that `file` leaves out, or the rest of it, and aims it; then the lights, if the file
    /// leaves them out.
    ///
    /// A camera that is all found stays filled by what is visible when it is aimed from elsewhere; of one
    /// that `file` gives size and position stay.
    ///
    /// # Errors
    /// If the camera makes no sense.
    pub fn frame(&mut self, file: &SceneFile, aim: &Aim) -> Result<(), OpenError> {
        self.frame_for(file, aim, None)
    }

    /// The same for a camera that goes around: where it is found, all is within the picture from each of
    /// `views`, and stands still in its middle ([`Framing::aimed_around`]). A camera that `file` gives stays.
    ///
    /// # Errors
    /// If the camera makes no sense.
    pub fn frame_around(
        &mut self,
        file: &SceneFile,
        aim: &Aim,
        views: &dyn Fn(&Camera) -> Vec<Camera>,
    ) -> Result<(), OpenError> {
        self.frame_for(file, aim, Some(views))
    }

    /// What pictures of the scene are to hold, for cameras from other sides: beside what annotations take of
    /// them. It looks at the voxels of all layers.
    pub fn framing(&self) -> Framing {
        let Scene { layers, meshes, settings, .. } = &self.scene;
        let framing = Framing::new(layers, meshes, settings.mode, self.facing);
        with_room_for_annotations(framing, &self.scene)
    }

    /// The same of layers on other grids than those of the scene's volumes, of which is known what they show.
    /// `finished` is the scene as annotations see it.
    pub(crate) fn framing_of(
        &self,
        visible: Vec<Cells>,
        grids: &[Grid],
        finished: &Scene,
    ) -> Framing {
        let framing = Framing::of_cells(visible, grids, &self.scene.meshes, self.facing);
        with_room_for_annotations(framing, finished)
    }

    /// Shows a layer by a transfer function from elsewhere, as a preset or a file has it, which is fitted to
    /// the layer's volume as scene files have theirs fitted. Warnings are returned, a line each.
    ///
    /// # Errors
    /// If it cannot be stretched to the volume's values.
    ///
    /// # Panics
    /// If there is no such layer.
    pub fn show_by(
        &mut self,
        layer_idx: usize,
        source: TransferSource,
    ) -> Result<Vec<String>, FitError> {
        let layer = &mut self.scene.layers[layer_idx];
        let mut file = self.sources.layers[layer_idx].clone();
        file.fit = TransferFit::default();
        file.gradient_opacity = None;
        let has_shading = source.shading.is_none();
        file.begin_with(source, has_shading);
        let facts = VolumeFacts::from(&*layer.volume);
        let found = || Look::of(facts.values.rows(), &facts.grid, self.acquisition);
        let Fitted { transfer, gradient_opacity, warnings } =
            fitted(&file, facts.scale(), || found().transfer, || found().kind.water())?;
        layer.transfer = transfer;
        layer.gradient_opacity = gradient_opacity.filter(|_| takes_gradients(&self.scene.settings));
        layer.transfer_2d = None;
        if !has_shading {
            layer.shading = file.shading;
        }
        Ok(warnings)
    }

    fn frame_for(
        &mut self,
        file: &SceneFile,
        aim: &Aim,
        views: Option<Views<'_>>,
    ) -> Result<(), OpenError> {
        self.frame_by(file, (aim, views), |opened| Ok(opened.framing()))
    }

    /// The same by what `framing` finds to be seen, if that has to be known.
    pub(crate) fn frame_by<E: From<OpenError>>(
        &mut self,
        file: &SceneFile,
        (aim, views): (&Aim, Option<Views<'_>>),
        framing: impl FnOnce(&Self) -> Result<Framing, E>,
    ) -> Result<(), E> {
        let is_alone = is_whole(&file.camera) && *aim == Aim::default();
        let framing = if is_alone { None } else { Some(framing(self)?) };
        Ok(self.frame_within(file, (aim, views), framing.as_ref())?)
    }

    fn frame_within(
        &mut self,
        file: &SceneFile,
        (aim, views): (&Aim, Option<Views<'_>>),
        framing: Option<&Framing>,
    ) -> Result<(), OpenError> {
        let image = &self.scene.image;
        let given = &file.camera;
        let camera = if let Some(framing) = framing {
            let mut projection = usual_projection(given.is_perspective());
            if let (Projection::Perspective { fov_y_radians }, Some(degrees)) =
                (&mut projection, given.fov_y)
            {
                *fov_y_radians = degrees.to_radians();
            }
            let found = framing.camera(None, Fit::Visible, projection, image)?;
            let is_found = given.eye.or(given.target).is_none() && given.view_height.is_none();
            let found = given.complete(&found)?;
            let has_axes = cfg!(feature = "annotations") && self.scene.finish.annotations.axes;
            // Axes are around all of the volume.
            let fit = aim.fit.or((is_found && has_axes).then_some(Fit::Volume));
            let aim = aim.fit(fit);
            match views.filter(|_| is_found || aim.fit.is_some()) {
                Some(views) => framing.aimed_around(&found, &aim, views, image)?,
                None => framing.aimed(&found, &aim, is_found, image)?,
            }
        } else {
            given.complete(&placeholder())?
        };
        self.scene.camera = camera;
        if file.unsaid.lights {
            self.scene.lights = lights(&camera);
        }
        Ok(())
    }
}

/// Gives the keys of a film the transfer functions that their volumes are shown with, and returns warnings.
fn fit_looks(
    film: &mut FilmFile,
    files: &[LayerFile],
    (layers, facts): (&[Layer], &[VolumeFacts<'_>]),
    acquisitions: &[Acquisition],
) -> Result<Vec<String>, FitError> {
    let mut all_warnings = Vec::new();
    for of_key in film.keys.iter_mut().flat_map(|key| &mut key.layers) {
        let Some(look) = &mut of_key.look else { continue };
        let layer = &layers[of_key.layer_idx];
        let mut file = files[of_key.layer_idx].clone();
        (file.transfer, file.fit) = (look.transfer.take(), look.fit.clone());
        let acquisition = acquisitions[of_key.layer_idx];
        let facts = facts[of_key.layer_idx];
        let water = || Look::of(facts.values.rows(), &facts.grid, acquisition).kind.water();
        let Fitted { transfer, warnings, .. } =
            fitted(&file, facts.scale(), || layer.transfer.clone(), water)?;
        all_warnings.extend(warnings);
        (look.transfer, look.fit) = (Some(transfer), TransferFit::default());
    }
    Ok(all_warnings)
}

/// What pictures of a scene are to hold: beside what annotations take of them, and with the box of axes if
/// that is drawn.
#[cfg(feature = "annotations")]
fn with_room_for_annotations(framing: Framing, scene: &Scene) -> Framing {
    let insets = slabsplat_annotations::insets(scene);
    let [width, height] = [scene.image.width, scene.image.height].map(f64::from);
    let beside = [insets.left, insets.right].map(|pixels| pixels / width);
    let below = [insets.bottom, insets.top].map(|pixels| pixels / height);
    let framing = framing.within(crate::framing::Window::without(beside, below));
    let ends = slabsplat_annotations::axes_box(scene).filter(|_| scene.finish.annotations.axes);
    match ends {
        Some(ends) => framing.and_box(ends),
        None => framing,
    }
}

#[cfg(not(feature = "annotations"))]
fn with_room_for_annotations(framing: Framing, _: &Scene) -> Framing {
    framing
}

/// Whether nothing of a camera is left to be found.
fn is_whole(camera: &CameraDesc) -> bool {
    let size = if camera.is_perspective() { camera.fov_y } else { camera.view_height };
    camera.eye.is_some() && camera.target.is_some() && camera.up.is_some() && size.is_some()
}

/// A camera until there is a better one.
fn placeholder() -> Camera {
    let projection = usual_projection(false);
    Camera::new(DVec3::Y, DVec3::ZERO, DVec3::Z, projection)
        .expect("its vectors are at right angles")
}

/// A scene while it is opened.
struct Opening<'a> {
    file: &'a SceneFile,
    warnings: Vec<String>,
    found: Vec<String>,
    /// That of the first layer that is found.
    background: Option<[f32; 4]>,
    /// Those of layers.
    facings: Vec<Facing>,
}

impl Opening<'_> {
    fn layer(
        &mut self,
        loaded: LoadedVolume,
        facts: &VolumeFacts<'_>,
        file: &LayerFile,
    ) -> Result<Layer, OpenError> {
        self.warnings.extend_from_slice(&loaded.warnings);
        let is_framed = self.facings.is_empty() && !is_whole(&self.file.camera);
        let Opened { mut layer, warnings, look, facing } =
            Opened::of(loaded, facts, file, is_framed)?;
        self.warnings.extend(warnings);
        self.facings.push(facing);
        if let Some(look) = look {
            self.found.push(look.description());
            self.background.get_or_insert(look.background);
            if !takes_gradients(&self.file.settings) {
                layer.gradient_opacity.clone_from(&file.gradient_opacity);
            }
        }
        Ok(layer.shading(self.shading(file.shading)))
    }

    fn meshes(&mut self) -> Result<Vec<MeshLayer>, OpenError> {
        let mut meshes = Vec::with_capacity(self.file.meshes.len());
        for mesh in &self.file.meshes {
            let (mesh, warnings) = mesh.load()?;
            self.warnings.extend(warnings);
            let shading = self.shading(mesh.shading);
            meshes.push(mesh.shading(shading));
        }
        Ok(meshes)
    }

    fn shading(&self, of_file: Shading) -> Shading {
        if self.file.unsaid.shading { Shading::Phong(phong()) } else { of_file }
    }
}

/// A layer, and what was found on the way.
struct Opened {
    layer: Layer,
    warnings: Vec<String>,
    /// What the volume looks like, if the file does not say it.
    look: Option<Look>,
    /// Which way it stands; if somebody is to look at it, and its file does not say that, as its values have
    /// it.
    facing: Facing,
}

impl Opened {
    fn of(
        loaded: LoadedVolume,
        facts: &VolumeFacts<'_>,
        file: &LayerFile,
        is_framed: bool,
    ) -> Result<Self, OpenError> {
        let found = OnceCell::new();
        let find = || found.get_or_init(|| look_of(&loaded, facts));
        let is_automatic = Cell::new(false);
        let automatic = || {
            is_automatic.set(true);
            find().transfer.clone()
        };
        let Fitted { transfer, mut gradient_opacity, mut warnings } =
            fitted(file, facts.scale(), automatic, || find().kind.water())?;
        let acquisition = loaded.acquisition;
        let facing = if is_framed && acquisition.orientation == Orientation::Unknown {
            find().facing(&facts.grid, acquisition)
        } else {
            Facing::of(acquisition.orientation, &facts.grid)
        };
        let look = found.into_inner().filter(|_| is_automatic.get());
        let LoadedVolume { volume, colors, .. } = loaded;
        // What was found by gradients goes with the opacities that were found.
        if let (Some(look), None, None) = (&look, &file.transfer_2d, &file.fit.opacity) {
            gradient_opacity = gradient_opacity.or_else(|| look.gradient_opacity.clone());
        }
        let own_colors = colors.and_then(|colors| colors.voxels);
        warnings.extend(file.warning_of(&volume, own_colors.as_ref()));
        if own_colors.is_some() && says_colors(file) {
            let what = "colours of the transfer function are not seen, as voxels have their own: colors = \
                        \"none\", or --colors none, leaves those out";
            warnings.push(what.to_owned());
        }
        let region = file.region.on(&facts.grid)?;
        let layer = Layer::new(volume, transfer)
            .transfer_2d(file.transfer_2d.clone())
            .gradient_opacity(gradient_opacity)
            .colors(own_colors)
            .isosurfaces(file.isosurfaces.clone())
            .shading(file.shading)
            .region(region);
        let Some(labels) = &file.labels else { return Ok(Self { layer, warnings, look, facing }) };
        let (labels, of_labels) = labels.load(layer.volume.grid())?;
        warnings.extend(of_labels);
        Ok(Self { layer: layer.labels(labels), warnings, look, facing })
    }
}

/// What a volume looks like to somebody who says nothing.
fn look_of(loaded: &LoadedVolume, facts: &VolumeFacts<'_>) -> Look {
    match &loaded.colors {
        Some(LoadedColors { voxels: None, opacity_from: OpacitySource::Luminance, .. }) | None => {
            Look::of(facts.values.rows(), &facts.grid, loaded.acquisition)
        }
        Some(colors) => Look::of_colors(facts.values.rows(), colors.opacity_from),
    }
}

/// Whether a layer's file says colours that are not white.
fn says_colors(file: &LayerFile) -> bool {
    let is_white =
        |colors: &PiecewiseLinear<3>| colors.points().iter().all(|(_, color)| *color == [1.0; 3]);
    let TransferFit { color, colormap, .. } = &file.fit;
    let of_transfer = file.transfer.as_ref().map(TransferFunction::color_points);
    let said = [color.as_ref(), colormap.as_ref(), of_transfer];
    said.into_iter().flatten().any(|colors| !is_white(colors))
}

/// What a layer of a file makes of a volume, with everything left out filled in, and warnings, one line each.
///
/// # Errors
/// If its transfer function or its region cannot be, or labels cannot be read.
pub fn open_layer(
    loaded: LoadedVolume,
    file: &LayerFile,
) -> Result<(Layer, Vec<String>), OpenError> {
    let volume = loaded.volume.clone();
    let facts = VolumeFacts::from(&*volume);
    let Opened { layer, warnings, .. } = Opened::of(loaded, &facts, file, false)?;
    Ok((layer, warnings))
}
