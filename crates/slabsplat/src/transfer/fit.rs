//! The transfer function that a volume is shown with, of what a scene file or flags say before it is there.

use slabsplat_core::{PiecewiseLinear, TransferError, TransferFunction};
use slabsplat_io::{FitError, LayerFile, Stretch, TransferFit, ValueScale, colormap, preset};

use super::percentiles::{object_range, percentile};
use super::values::VolumeValues;

/// How a volume is shown.
#[derive(Clone, Debug)]
pub(crate) struct Fitted {
    pub(crate) transfer: TransferFunction,
    pub(crate) gradient_opacity: Option<PiecewiseLinear<1>>,
    /// What does not suit, for people.
    pub(crate) warnings: Vec<String>,
}

/// The transfer function that a layer of a file gives to a volume of such values, whose voxel step is `unit`
/// long; `automatic` finds one where none is
/// given, and `water` the value of water if values are Hounsfield units and a constant.
///
/// # Errors
/// If it cannot be stretched to the volume's values.
pub(crate) fn fitted(
    layer: &LayerFile,
    (values, unit): (&dyn VolumeValues, f64),
    automatic: impl FnOnce() -> TransferFunction,
    water: impl FnOnce() -> Option<f64>,
) -> Result<Fitted, FitError> {
    let fit = &layer.fit;
    let window = fit.stretch.map(|stretch| window_of(stretch, values)).transpose()?.flatten();
    let mut warnings = preset_warnings(fit, window, values);
    let water = match fit.scale {
        ValueScale::Hounsfield if !warnings.is_empty() => water().filter(|&water| water != 0.0),
        _ => None,
    };
    if let Some(water) = water {
        warnings = vec![format!(
            "the values look like Hounsfield units plus {water}, and are taken for that"
        )];
    }
    let placed = match &layer.transfer {
        Some(transfer) => Placed::of(transfer, fit, window.or(moved_by(water, transfer)), values)?,
        None => Placed::of_nothing(window, automatic)?,
    };
    let color = match (&fit.color, &fit.colormap) {
        (Some(color), _) => color.clone(),
        (None, Some(colors)) => {
            let range = window.or(placed.range).unwrap_or_else(|| data_range(values));
            moved(colors, "color", [0.0, 1.0], range)?
        }
        (None, None) => placed.transfer.color_points().clone(),
    };
    let opacity = fit.opacity.as_ref().unwrap_or(placed.transfer.opacity_points());
    let opacity = scaled(opacity, fit, unit);
    let gradient_opacity = match &layer.gradient_opacity {
        Some(by_gradient) => Some(by_gradient.clone()),
        None => placed.gradient_opacity,
    };
    let transfer = TransferFunction::of_curves(opacity, color);
    Ok(Fitted { transfer, gradient_opacity, warnings })
}

/// A transfer function over the values of a volume.
struct Placed {
    transfer: TransferFunction,
    gradient_opacity: Option<PiecewiseLinear<1>>,
    /// The values that a colour map goes over, if they are not all.
    range: Option<[f64; 2]>,
}

impl Placed {
    /// Of no transfer function: of a window a gray ramp over it.
    fn of_nothing(
        window: Option<[f64; 2]>,
        automatic: impl FnOnce() -> TransferFunction,
    ) -> Result<Self, FitError> {
        let transfer = match window {
            None => automatic(),
            Some(window) => {
                let opacity = PiecewiseLinear::new("opacity", [(0.0, 0.0), (1.0, 1.0)]);
                let color = colormap("gray").expect("there is a map of that name");
                let ramp = TransferFunction::of_curves(opacity.expect("a ramp is valid"), color);
                ramp.moved([0.0, 1.0], window).map_err(no_room(window))?
            }
        };
        Ok(Self { transfer, gradient_opacity: None, range: None })
    }

    fn of(
        transfer: &TransferFunction,
        fit: &TransferFit,
        window: Option<[f64; 2]>,
        values: &dyn VolumeValues,
    ) -> Result<Self, FitError> {
        let is_as_it_is = |range| Self {
            transfer: transfer.clone(),
            gradient_opacity: fit.gradient_opacity.clone(),
            range,
        };
        let (from, to) = match (fit.scale, window) {
            (ValueScale::Points, _) => return Ok(is_as_it_is(None)),
            (ValueScale::Values | ValueScale::Hounsfield, None) => {
                return Ok(is_as_it_is(Some(transfer.color_points().span())));
            }
            (ValueScale::Values | ValueScale::Hounsfield, Some(window)) => {
                (transfer.span(), window)
            }
            (ValueScale::Data | ValueScale::Object { .. }, Some(window)) => ([0.0, 1.0], window),
            (ValueScale::Data, None) => ([0.0, 1.0], data_range(values)),
            (ValueScale::Object { percentile }, None) => {
                let range = object_range(values, percentile);
                ([0.0, 1.0], range.unwrap_or_else(|| data_range(values)))
            }
        };
        let by_gradient = fit.gradient_opacity.as_ref().map(|curve| {
            // Gradients have no beginning to be moved, only a scale.
            let factor = (to[1] - to[0]) / (from[1] - from[0]);
            if factor.is_finite() {
                moved(curve, "opacity", [0.0, 1.0], [0.0, factor])
            } else {
                Ok(curve.clone())
            }
        });
        Ok(Self {
            transfer: transfer.moved(from, to).map_err(no_room(to))?,
            gradient_opacity: by_gradient.transpose()?,
            range: Some(to),
        })
    }
}

/// The window of a transfer function over Hounsfield units where water has another value than 0.
fn moved_by(water: Option<f64>, transfer: &TransferFunction) -> Option<[f64; 2]> {
    water.map(|water| transfer.span().map(|end| end + water))
}

/// The ends of a window; `None` of a volume without finite values.
fn window_of(stretch: Stretch, values: &dyn VolumeValues) -> Result<Option<[f64; 2]>, FitError> {
    match stretch {
        Stretch::Window(window) => Ok(Some(window)),
        Stretch::Percentiles(percentiles) => {
            let [lo, hi] = percentiles.map(|percent| percentile(values, percent));
            match (lo, hi) {
                (Some(lo), Some(hi)) if lo < hi => Ok(Some([lo, hi])),
                (Some(value), Some(_)) => Err(FitError::NothingBetween { percentiles, value }),
                _ => Ok(None),
            }
        }
    }
}

/// The least and the largest value. A volume of one value has that at its top, so that it is seen.
fn data_range(values: &dyn VolumeValues) -> [f64; 2] {
    match values.range() {
        Some([lo, hi]) if lo < hi => [lo, hi],
        Some([value, _]) => [value - value.abs().max(1.0), value],
        None => [0.0, 1.0],
    }
}

fn scaled(opacity: &PiecewiseLinear<1>, fit: &TransferFit, unit: f64) -> PiecewiseLinear<1> {
    let opacity = if fit.opacity_scale == 1.0 {
        opacity.clone()
    } else {
        opacity.multiplied(fit.opacity_scale)
    };
    match fit.unit_distance.map(|distance| unit / distance) {
        // A voxel step is what opacities are per.
        None | Some(1.0) => opacity,
        Some(ratio) if ratio.is_finite() => opacity.over_distance(ratio),
        Some(_) => opacity.multiplied(f64::MAX),
    }
}

fn moved<const N: usize>(
    curve: &PiecewiseLinear<N>,
    what: &'static str,
    from: [f64; 2],
    to: [f64; 2],
) -> Result<PiecewiseLinear<N>, FitError> {
    curve.moved(what, from, to).map_err(no_room(to))
}

fn no_room(to: [f64; 2]) -> impl Fn(TransferError) -> FitError {
    move |_| FitError::NoRoom(to)
}

/// What does not suit. Who gives a window knows the values.
fn preset_warnings(
    fit: &TransferFit,
    window: Option<[f64; 2]>,
    values: &dyn VolumeValues,
) -> Vec<String> {
    // All values are looked at, if that has to be.
    let (Some(name), None) = (&fit.preset, window) else { return Vec::new() };
    let Some(range) = values.range() else { return Vec::new() };
    let preset = preset(name).ok();
    preset.and_then(|preset| preset.suited.warning(name, range)).into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Grid, Samples, Scaling, Volume};
    use slabsplat_io::parse_scene;

    /// 101 values from −100 to 900, in voxels of 2.
    fn volume() -> Volume {
        let grid = Grid::with_spacing([101, 1, 1], [2.0, 3.0, 4.0]).unwrap();
        let samples = (0..101).map(|idx| 10 * idx - 100).collect();
        Volume::new(grid, Samples::I16(samples), Scaling::IDENTITY).unwrap()
    }

    fn layer(keys: &str) -> LayerFile {
        let scene = format!("volume = {{ generate = \"cube\" }}\n[classify]\n{keys}");
        parse_scene(&scene, "a.toml").unwrap().layers.remove(0)
    }

    fn of_volume(
        layer: &LayerFile,
        volume: &Volume,
        automatic: impl FnOnce() -> TransferFunction,
        water: impl FnOnce() -> Option<f64>,
    ) -> Result<Fitted, FitError> {
        fitted(layer, (volume, volume.grid().unit()), automatic, water)
    }

    fn fit(keys: &str) -> Fitted {
        let automatic = || TransferFunction::new([(7.0, 0.5)], [(7.0, [1.0, 0.0, 0.0])]).unwrap();
        of_volume(&layer(keys), &volume(), automatic, || None).unwrap()
    }

    #[test]
    fn fit_stretches_what_has_no_values() {
        // All values, a window, percentiles.
        for (keys, [lo, hi]) in [
            ("preset = \"gray\"", [-100.0, 900.0]),
            ("preset = \"gray\"\nwindow = [0, 50]", [0.0, 50.0]),
            ("preset = \"gray\"\npercentile = [10, 90]", [0.0, 800.0]),
            ("window = [100, 300]", [100.0, 300.0]),
            ("preset = \"ct-bone\"\nwindow = [10, 20]", [10.0, 20.0]),
        ] {
            let transfer = fit(keys).transfer;
            let of = |value: f64| transfer.opacity(value);
            assert_eq!(transfer.span(), [lo, hi], "{keys}");
            assert!(
                of(lo) == 0.0 && 0.0 < of(0.5 * (lo + hi)) && of(0.5 * (lo + hi)) < of(hi),
                "{keys}"
            );
        }
        let relative = fit("preset = \"mr-t1\"").transfer;
        assert!(relative.opacity(0.0) == 0.0 && 0.8 < relative.opacity(900.0), "{relative:?}");
    }

    #[test]
    fn fit_keeps_what_has_values() {
        let bone = preset("ct-bone").unwrap().source.transfer;
        assert_eq!(fit("preset = \"ct-bone\"").transfer, bone);
        assert_eq!(fit("").transfer.opacity(3.0), 0.5, "automatic");
        let points = "opacity = [[80, 0.0], [255, 0.9]]\ncolormap = \"gray\"\nwindow = [0, 100]";
        let transfer = fit(points).transfer;
        assert_eq!(transfer.opacity_points().span(), [80.0, 255.0], "points do not move");
        assert_eq!(transfer.color(50.0), [0.5; 3], "colours do");
    }

    #[test]
    fn fit_lays_colors_over_values() {
        let color = |keys: &str, value| fit(keys).transfer.color(value)[0];
        assert_eq!(color("colormap = \"gray\"", 400.0), 0.5, "all values");
        assert_eq!(color("colormap = \"gray_r\"", 900.0), 0.0, "backwards");
        assert_eq!(fit("colormap = \"gray\"").transfer.opacity(3.0), 0.5, "automatic opacities");
        assert_eq!(color("colormap = \"gray\"\npreset = \"ct-bone\"", 425.0), 0.5, "150 to 700");
    }

    #[test]
    fn fit_scales_opacity() {
        let opacity = |keys: &str| {
            fit(&format!("opacity = [[0, 0.0], [100, 0.5]]\n{keys}")).transfer.opacity(100.0)
        };
        assert_eq!(opacity("opacity_scale = 0.5"), 0.25);
        assert_eq!(opacity("opacity_scale = 9"), 1.0);
        // A voxel step is 2: twice 1, half 4.
        assert!((opacity("unit_distance = 1") - 0.75).abs() < 1e-12);
        assert!((opacity("unit_distance = 4") - (1.0 - 0.5_f64.sqrt())).abs() < 1e-12);
        assert_eq!(opacity("unit_distance = 2"), 0.5);
    }

    #[test]
    fn fit_warns_of_values_that_do_not_suit() {
        assert!(fit("preset = \"ct-bone\"").warnings.is_empty());
        let grid = Grid::with_spacing([2, 1, 1], [1.0; 3]).unwrap();
        let gray = Volume::new(grid, Samples::U8(vec![0, 255]), Scaling::IDENTITY).unwrap();
        let warnings = |keys: &str| {
            of_volume(&layer(keys), &gray, || unreachable!("there is a preset"), || None)
                .unwrap()
                .warnings
        };
        let [warning] = &warnings("preset = \"ct-bone\"")[..] else {
            panic!("there is one warning")
        };
        assert!(
            warning.contains("ct-bone is for Hounsfield units") && warning.contains("0 to 255")
        );
        assert!(warnings("preset = \"ct-bone\"\nwindow = [90, 255]").is_empty());
        assert!(warnings("preset = \"mr-t1\"").is_empty());
    }

    /// CT that was stored without a sign: −1000 to 2000 and 1024.
    #[test]
    fn fit_of_hounsfield_units_and_a_constant() {
        let grid = Grid::with_spacing([3, 1, 1], [1.0; 3]).unwrap();
        let volume =
            Volume::new(grid, Samples::U16(vec![24, 1524, 3024]), Scaling::IDENTITY).unwrap();
        let fit = |keys: &str, water| {
            let automatic = || unreachable!("there is a preset");
            of_volume(&layer(keys), &volume, automatic, || water).unwrap()
        };
        let plain = preset("ct-bone").unwrap().source.transfer;
        let found = fit("preset = \"ct-bone\"", Some(1024.0));
        for units in [0.0, 149.0, 300.0, 700.0, 1500.0] {
            assert_eq!(found.transfer.opacity(units + 1024.0), plain.opacity(units), "{units}");
        }
        assert_eq!(
            found.warnings,
            ["the values look like Hounsfield units plus 1024, and are taken for that"]
        );
        let not_found = fit("preset = \"ct-bone\"", None);
        assert_eq!(not_found.transfer, plain);
        assert!(not_found.warnings[0].contains("ct-bone is for Hounsfield units"));
        let window = fit("preset = \"ct-bone\"\nwindow = [1000, 3000]", Some(1024.0));
        assert_eq!(window.transfer.span(), [1000.0, 3000.0], "who gives a window knows the values");
    }

    #[test]
    fn fit_of_odd_volumes() {
        let of = |samples: Vec<f32>, keys: &str| {
            let grid = Grid::with_spacing([samples.len(), 1, 1], [1.0; 3]).unwrap();
            let volume = Volume::new(grid, Samples::F32(samples), Scaling::IDENTITY).unwrap();
            let automatic = || TransferFunction::new([(0.0, 0.5)], [(0.0, [1.0; 3])]).unwrap();
            of_volume(&layer(keys), &volume, automatic, || None)
        };
        for keys in [
            "preset = \"gray\"",
            "preset = \"mr-t1\"",
            "colormap = \"turbo\"",
            "percentile = [0, 100]",
        ] {
            for samples in [vec![f32::NAN], vec![f32::NAN, f32::INFINITY], vec![f32::MIN, f32::MAX]]
            {
                assert!(of(samples.clone(), keys).is_ok(), "{keys} of {samples:?}");
            }
        }
        let one = of(vec![5.0; 3], "preset = \"gray\"").unwrap().transfer;
        assert!(0.0 < one.opacity(5.0), "a single value is seen");
        let error = of(vec![0.0, 0.0, 9.0], "percentile = [1, 50]").unwrap_err().to_string();
        assert!(error.contains("1 and 50 of the volume are the same value, 0"), "{error}");
        let narrow = of(
            vec![1.0, 1.0_f32.next_up()],
            "colormap = \"turbo\"\nwindow = [1, 1.0000000000000002]",
        );
        assert!(narrow.unwrap_err().to_string().contains("no room"), "49 colours in one step");
    }
}
