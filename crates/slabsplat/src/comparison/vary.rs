//! Settings that are varied: any row of the tables of settings, and every combination of their values.

use slabsplat_core::{
    NotAValue, OutOfRange, Phong, RenderSettings, Scene, Setting, Settings, SettingsError, Shading,
};
use thiserror::Error;

/// Most combinations that are compared: more nobody looks at.
pub const MAX_VARIANTS: usize = 64;

/// A setting, and the values that it takes in turn.
///
/// ```
/// use slabsplat::{Vary, variants};
///
/// let widths: Vary = "slab-width=1,2".parse()?;
/// let all = variants(&[widths, "method=image-aligned,axis-aligned".parse()?])?;
/// assert_eq!(all.len(), 4);
/// assert_eq!(all[1].label(), "slab_width 1, method axis-aligned");
/// # Ok::<(), slabsplat::VaryError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Vary {
    row: Row,
    values: Vec<String>,
}

/// What cannot be varied so.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum VaryError {
    /// It is not of the form `SETTING=VALUE,VALUE`.
    #[error("{0:?} should be a setting and its values: slab_width=1,2")]
    NoValues(String),
    /// There is no such setting.
    #[error("{name:?} is no setting; there are {known}")]
    UnknownSetting {
        /// What was given.
        name: String,
        /// What there is.
        known: String,
    },
    /// A setting is varied twice.
    #[error("{0} is varied twice")]
    Twice(&'static str),
    /// There are more than [`MAX_VARIANTS`].
    #[error("{0} combinations are too many to compare: at most {MAX_VARIANTS}")]
    TooMany(usize),
    /// A value is none of its setting's.
    #[error(transparent)]
    NotAValue(#[from] NotAValue),
    /// A number is outside of what its setting permits.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    /// Settings do not go together.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// No layer has the light that is varied.
    #[error("{0} does nothing: no layer is lit")]
    NotLit(&'static str),
}

/// A row of either table of settings.
#[derive(Clone, Copy, Debug)]
enum Row {
    Render(&'static Setting<RenderSettings>),
    Phong(&'static Setting<Phong>),
}

impl Row {
    fn named(name: &str) -> Result<Self, VaryError> {
        let name = name.trim().replace('-', "_");
        let render = RenderSettings::ROWS.iter().find(|row| row.name == name).map(Self::Render);
        let phong = || Phong::ROWS.iter().find(|row| row.name == name).map(Self::Phong);
        render.or_else(phong).ok_or_else(|| {
            let names = RenderSettings::ROWS.iter().map(|row| row.name);
            let names = names.chain(Phong::ROWS.iter().map(|row| row.name));
            VaryError::UnknownSetting { name, known: names.collect::<Vec<_>>().join(", ") }
        })
    }

    fn name(self) -> &'static str {
        match self {
            Self::Render(row) => row.name,
            Self::Phong(row) => row.name,
        }
    }

    /// Whether the setting alone may have that value.
    fn check(self, value: &str) -> Result<(), VaryError> {
        match self {
            Self::Render(row) => check(row, value),
            Self::Phong(row) => check(row, value),
        }
    }

    fn apply(self, value: &str, scene: &mut Scene) -> Result<(), VaryError> {
        let row = match self {
            Self::Render(row) => return Ok(row.read(&mut scene.settings, value)?),
            Self::Phong(row) => row,
        };
        let mut is_lit = false;
        for layer in &mut scene.layers {
            if let Shading::Phong(phong) = &mut layer.shading {
                row.read(phong, value)?;
                is_lit = true;
            }
        }
        if is_lit { Ok(()) } else { Err(VaryError::NotLit(row.name)) }
    }
}

fn check<S: Settings>(row: &Setting<S>, value: &str) -> Result<(), VaryError> {
    let mut settings = S::default();
    row.read(&mut settings, value)?;
    Ok(settings.check_ranges()?)
}

impl std::str::FromStr for Vary {
    type Err = VaryError;

    /// Reads `SETTING=VALUE,VALUE`; the setting may have dashes, as its flag does.
    fn from_str(text: &str) -> Result<Self, VaryError> {
        let bad = || VaryError::NoValues(text.to_owned());
        let (name, values) = text.split_once('=').ok_or_else(bad)?;
        let row = Row::named(name)?;
        let values: Vec<String> = values.split(',').map(|value| value.trim().to_owned()).collect();
        if values.iter().any(String::is_empty) {
            return Err(bad());
        }
        values.iter().try_for_each(|value| row.check(value))?;
        Ok(Self { row, values })
    }
}

impl Vary {
    /// How many values there are.
    pub fn n_values(&self) -> usize {
        self.values.len()
    }
}

/// One value for every setting that is varied.
#[derive(Clone, Debug)]
pub struct Variant {
    values: Vec<(Row, String)>,
}

impl Variant {
    /// The settings' names and values.
    pub fn values(&self) -> impl Iterator<Item = (&'static str, &str)> {
        self.values.iter().map(|(row, value)| (row.name(), value.as_str()))
    }

    /// The values in words; of a method, its name alone.
    pub fn label(&self) -> String {
        let word = |(name, value): (&str, &str)| match name {
            "method" if self.values.len() == 1 => value.to_owned(),
            _ => format!("{name} {value}"),
        };
        self.values().map(word).collect::<Vec<_>>().join(", ")
    }

    /// Whether all values that `vary` has are among these.
    pub fn has(&self, vary: &Vary) -> bool {
        self.values.iter().any(|(row, value)| {
            row.name() == vary.row.name() && vary.values.iter().all(|other| other == value)
        })
    }

    /// The scene with these values.
    ///
    /// # Errors
    /// If they do not go together, or no layer has what is varied.
    pub fn applied(&self, scene: &Scene) -> Result<Scene, VaryError> {
        let mut scene = scene.clone();
        for (row, value) in &self.values {
            row.apply(value, &mut scene)?;
        }
        scene.settings = scene.settings.checked()?;
        Ok(scene)
    }
}

/// All combinations, the last setting's values in turn first.
///
/// # Errors
/// If a setting is varied twice, or there are more than [`MAX_VARIANTS`].
pub fn variants(varied: &[Vary]) -> Result<Vec<Variant>, VaryError> {
    for (idx, vary) in varied.iter().enumerate() {
        let name = vary.row.name();
        if varied[..idx].iter().any(|other| other.row.name() == name) {
            return Err(VaryError::Twice(name));
        }
    }
    let count = varied.iter().fold(1_usize, |n, vary| n.saturating_mul(vary.values.len()));
    if MAX_VARIANTS < count {
        return Err(VaryError::TooMany(count));
    }
    let mut all = vec![Variant { values: Vec::new() }];
    for vary in varied {
        let with_values = |variant: &Variant| {
            let with = |value: &String| {
                let mut variant = variant.clone();
                variant.values.push((vary.row, value.clone()));
                variant
            };
            vary.values.iter().map(with).collect::<Vec<_>>()
        };
        all = all.iter().flat_map(with_values).collect();
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{
        Camera, Layer, Method, Projection, TransferFunction, Volume, glam::DVec3,
    };
    use slabsplat_core::{Grid, Samples, Scaling};

    fn scene() -> Scene {
        let grid = Grid::with_spacing([2; 3], [1.0; 3]).unwrap();
        let volume = Volume::new(grid, Samples::U8(vec![255; 8]), Scaling::IDENTITY).unwrap();
        let transfer = TransferFunction::new([(0.0, [0.5])], vec![(0.0, [1.0; 3])]).unwrap();
        let projection = Projection::Orthographic { view_height: 4.0 };
        let camera = Camera::new(9.0 * DVec3::Z, DVec3::ZERO, DVec3::Y, projection).unwrap();
        Scene::new(Layer::new(volume, transfer).shading(Shading::Phong(Phong::default())), camera)
    }

    /// Every row of both tables can be varied, and reaches the scene.
    #[test]
    fn vary_knows_every_setting() {
        let names =
            RenderSettings::ROWS.iter().map(|row| (row.name, row.text(&RenderSettings::default())));
        let names =
            names.chain(Phong::ROWS.iter().map(|row| (row.name, row.text(&Phong::default()))));
        for (name, default) in names {
            let vary: Vary = format!("{name}={default}").parse().unwrap();
            let [variant] = variants(&[vary]).unwrap().try_into().unwrap();
            let applied = variant.applied(&scene()).unwrap();
            assert_eq!(applied.settings, scene().settings, "{name}");
        }
        let all =
            variants(&["slab-width=2".parse().unwrap(), "ambient=0.5".parse().unwrap()]).unwrap();
        let applied = all[0].applied(&scene()).unwrap();
        assert_eq!(applied.settings.slab_width, 2.0);
        let Shading::Phong(phong) = &applied.layers[0].shading else { panic!("it was lit") };
        assert_eq!(phong.ambient, 0.5);
        let mut unlit = scene();
        unlit.layers[0].shading = Shading::None;
        assert_eq!(all[0].applied(&unlit).unwrap_err(), VaryError::NotLit("ambient"));
    }

    #[test]
    fn vary_makes_a_grid() {
        let method: Vary = "method=axis-aligned,image-aligned".parse().unwrap();
        let all = variants(&[method, "slab_width=1,2,4".parse().unwrap()]).unwrap();
        assert_eq!(all.len(), 6);
        assert_eq!(all[4].label(), "method image-aligned, slab_width 2");
        assert_eq!(all[4].applied(&scene()).unwrap().settings.method, Method::ImageAligned);
        assert!(all[4].has(&"slab_width=2".parse().unwrap()));
        assert!(!all[4].has(&"slab_width=4".parse().unwrap()));
        assert_eq!(
            variants(&["method=every-sample".parse().unwrap()]).unwrap()[0].label(),
            "every-sample"
        );
    }

    #[test]
    fn vary_rejects_what_is_no_setting() {
        let check = |text: &str, expected: &str| {
            let error = text.parse::<Vary>().unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        };
        check("width=1", "\"width\" is no setting; there are method, kernel, slab_width");
        check("slab_width", "should be a setting and its values");
        check("slab_width=1,,2", "should be a setting and its values");
        check("slab_width=thick", "slab_width is a number, not \"thick\"");
        check("slab_width=-1", "slab_width must be above 0");
        check("method=best", "\"best\" is not a choice here");
        let twice: Vary = "slab_width=1,2,3,4,5,6,7,8,9".parse().unwrap();
        let again = variants(&[twice.clone(), twice.clone()]);
        assert_eq!(again.unwrap_err(), VaryError::Twice("slab_width"));
        let many = variants(&[twice, "ambient=0,.1,.2,.3,.4,.5,.6,.7".parse().unwrap()]);
        assert_eq!(many.unwrap_err(), VaryError::TooMany(72));
    }
}
