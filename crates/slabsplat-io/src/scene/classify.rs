//! What `[classify]` means: which values are visible, and in which colour.

use slabsplat_core::{PiecewiseLinear, TransferFunction, TransferFunction2d, TransferImage};

use super::LayerFile;
use super::diagnostic::Diagnostic;
use super::document::{ClassifySection, TransferImageSection};
use crate::transfer::{FitError, Stretch, colormap, preset};

impl ClassifySection {
    /// Lays the section on a layer that says nothing of it yet, but for what is in files. Light of a preset
    /// is taken over unless the layer `has_shading` of its own.
    pub(super) fn lay_on(
        mut self,
        layer: &mut LayerFile,
        has_shading: bool,
    ) -> Result<(), Diagnostic> {
        self.check_ways()?;
        self.check_fit_keys()?;
        layer.isosurfaces = std::mem::take(&mut self.isosurfaces);
        layer.transfer_2d = self.to_transfer_2d()?;
        layer.gradient_opacity = self.checked_gradient_opacity()?;
        self.lay_fit_on(layer)?;
        if let Some(name) = &self.preset {
            let preset = preset(name)
                .map_err(|error| Diagnostic::at("classify", "preset", error.to_string()))?;
            layer.begin_with(preset.source, has_shading);
        }
        let is_in_file = self.file.is_some();
        if let Some(points) = self.into_points()? {
            layer.transfer = Some(points);
        }
        // Of a file more is known once it is read.
        if is_in_file {
            return Ok(());
        }
        layer
            .check_fit()
            .map_err(|error| Diagnostic::at("classify", key_of(&error), error.to_string()))
    }

    fn lay_fit_on(&self, layer: &mut LayerFile) -> Result<(), Diagnostic> {
        layer.fit.stretch =
            self.window.map(Stretch::Window).or_else(|| self.percentile.map(Stretch::Percentiles));
        if let Some(name) = &self.colormap {
            let colors = colormap(name)
                .map_err(|error| Diagnostic::at("classify", "colormap", error.to_string()))?;
            layer.fit.colormap = Some(colors);
        }
        layer.fit.opacity_scale = self.opacity_scale.unwrap_or(1.0);
        layer.fit.unit_distance = self.unit_distance;
        Ok(())
    }

    /// The transfer function that its points are.
    fn into_points(self) -> Result<Option<TransferFunction>, Diagnostic> {
        let Self { opacity, color, .. } = self;
        if opacity.is_none() && color.is_none() {
            return Ok(None);
        }
        let opacity = opacity
            .ok_or_else(|| Diagnostic::at("classify", "color", "color needs opacity beside it"))?;
        let color = color.unwrap_or_else(|| vec![[0.0, 1.0, 1.0, 1.0]]);
        transfer(&opacity, &color).map(Some)
    }

    /// What a label may have: points, or a preset for values that need no volume to be known.
    pub(super) fn into_label_transfer(self) -> Result<TransferFunction, Diagnostic> {
        let wrong = |what: &str| Diagnostic::at("labels", "styles", what);
        let is_by_gradient =
            self.gradient_opacity.is_some() || self.boxes.is_some() || self.image.is_some();
        if is_by_gradient || !self.isosurfaces.is_empty() || self.fit_key().is_some() {
            return Err(wrong(
                "of [classify] a style takes opacity, color and preset: all else is a layer's, and no label's",
            ));
        }
        self.check_ways()?;
        let Some(name) = &self.preset else {
            let needs = "classify of a style needs opacity (and color), or preset";
            return self.into_points()?.ok_or_else(|| wrong(needs));
        };
        let source = preset(name).map_err(|error| wrong(&error.to_string()))?.source;
        if source.scale.is_relative() {
            return Err(wrong(&format!(
                "the preset {name} depends on all of a volume's values, and a label has only some: take a ct-.. \
                 preset, or opacity"
            )));
        }
        Ok(source.transfer)
    }

    /// That there is no second one beside what says how values look.
    fn check_ways(&self) -> Result<(), Diagnostic> {
        let points = self.opacity.is_some() || self.color.is_some();
        let by_value = [points, self.preset.is_some(), self.file.is_some()];
        // Beside these, points are what a saved scene has retained.
        let by_both = [self.boxes.is_some(), self.image.is_some()];
        let n = |ways: &[bool]| ways.iter().filter(|&&is_there| is_there).count();
        if 1 < n(&by_value) || 1 < n(&by_both) + n(&by_value[1..]) {
            let what = "[classify] takes one of: opacity (and color), preset, file, boxes, image";
            return Err(Diagnostic::at("classify", "", what));
        }
        Ok(())
    }

    /// Whether it says how values look, or would.
    pub(super) fn says_values(&self) -> bool {
        let ways = [
            self.opacity.is_some(),
            self.color.is_some(),
            self.preset.is_some(),
            self.file.is_some(),
            self.boxes.is_some(),
            self.image.is_some(),
            self.gradient_opacity.is_some(),
        ];
        ways.contains(&true) || self.fit_key().is_some()
    }

    /// The first key that fits a function of the value to a volume.
    fn fit_key(&self) -> Option<&'static str> {
        let keys = [
            ("colormap", self.colormap.is_some()),
            ("window", self.window.is_some()),
            ("percentile", self.percentile.is_some()),
            ("opacity_scale", self.opacity_scale.is_some()),
            ("unit_distance", self.unit_distance.is_some()),
        ];
        keys.into_iter().find_map(|(key, is_there)| is_there.then_some(key))
    }

    fn check_fit_keys(&self) -> Result<(), Diagnostic> {
        let wrong = |key: &'static str, what: &str| Err(Diagnostic::at("classify", key, what));
        if self.color.is_some() && self.colormap.is_some() {
            return wrong("colormap", "color and colormap both say the colours: leave one out");
        }
        if self.window.is_some() && self.percentile.is_some() {
            return wrong("percentile", "window and percentile both say the values: leave one out");
        }
        match self.fit_key() {
            Some(key) if self.boxes.is_some() || self.image.is_some() => wrong(
                key,
                &format!("{key} is for functions of the value alone, not for boxes or image"),
            ),
            _ => Ok(()),
        }
    }

    /// `None` if the section has none, or it is in a file.
    fn to_transfer_2d(&self) -> Result<Option<TransferFunction2d>, Diagnostic> {
        if let Some(boxes) = &self.boxes {
            return Ok(Some(TransferFunction2d::Boxes(boxes.clone())));
        }
        let image = self.image.as_ref().map(TransferImageSection::to_image).transpose()?;
        Ok(image.flatten().map(TransferFunction2d::Image))
    }

    fn checked_gradient_opacity(&self) -> Result<Option<PiecewiseLinear<1>>, Diagnostic> {
        let Some(points) = &self.gradient_opacity else { return Ok(None) };
        let points = points.iter().map(|&[gradient, factor]| (gradient, factor));
        PiecewiseLinear::new("gradient_opacity", points)
            .map(Some)
            .map_err(|error| Diagnostic::at("classify", "gradient_opacity", error.to_string()))
    }
}

/// The key that an error is about.
fn key_of(error: &FitError) -> &'static str {
    match error {
        FitError::Window(_) | FitError::PointsDoNotMove => "window",
        FitError::Percentiles(_) | FitError::NothingBetween { .. } => "percentile",
        FitError::OpacityScale(_) => "opacity_scale",
        FitError::UnitDistance(_) => "unit_distance",
        FitError::NoRoom(_) => "",
    }
}

impl TransferImageSection {
    /// `None` if it is in a file.
    fn to_image(&self) -> Result<Option<TransferImage>, Diagnostic> {
        let at_image = |what: String| Diagnostic::at("classify", "image", what);
        let (width, pixels) = match (&self.file, self.width, &self.pixels) {
            (Some(_), None, None) => return Ok(None),
            (None, Some(width), Some(pixels)) => (width, pixels.clone()),
            _ => {
                let what = "a picture has a file, or width and pixels";
                return Err(at_image(what.to_owned()));
            }
        };
        TransferImage::new(width, pixels, self.values, self.gradients)
            .map(Some)
            .map_err(|error| at_image(error.to_string()))
    }
}

fn transfer(opacity: &[[f64; 2]], color: &[[f64; 4]]) -> Result<TransferFunction, Diagnostic> {
    let opacity = opacity.iter().map(|&[value, alpha]| (value, alpha));
    let color = color.iter().map(|&[value, r, g, b]| (value, [r, g, b]));
    TransferFunction::new(opacity, color)
        .map_err(|error| Diagnostic::at("classify", error.what(), error.to_string()))
}
