//! Which colours a picture's values have, and how that is told: by a bar, or by a legend where values are
//! labels.

use slabsplat_core::{Layer, Mode, Scene, TransferFunction};

use crate::sheet::written;

/// What tells colours.
#[derive(Clone, Debug)]
pub(crate) enum ColorKey<'a> {
    /// The colours of a layer's values, from the least that is visible to the greatest.
    Bar(&'a Layer, [f64; 2]),
    /// What is called what, and has which colour.
    Legend(Legend),
}

/// Names, each with its colour.
type Legend = Vec<(String, [f64; 3])>;

impl<'a> ColorKey<'a> {
    /// That of the first layer; or why there is none.
    pub(crate) fn of(scene: &'a Scene) -> Result<Self, &'static str> {
        let layer = scene.layers.first().ok_or("meshes have no values")?;
        if scene.settings.mode == Mode::Isosurfaces {
            return Err("isosurfaces have a colour each");
        }
        if let Some(legend) = legend_of_labels(layer)? {
            return Ok(Self::Legend(legend));
        }
        if layer.colors.is_some() {
            return Err("voxels have colours of their own");
        }
        if layer.transfer_2d.is_some() {
            return Err("colours depend on gradients, too");
        }
        if let Some(steps) = steps_of(&layer.transfer) {
            return Ok(Self::Legend(steps));
        }
        visible_range(layer).map(|range| Self::Bar(layer, range)).ok_or("no value is visible")
    }
}

/// The colours of a layer's labels; `None` if it has none, or they only hide some of its voxels.
fn legend_of_labels(layer: &Layer) -> Result<Option<Legend>, &'static str> {
    let Some(labels) = &layer.labels else { return Ok(None) };
    let all = labels.map().labels().iter().map(|label| (*label, labels.style(*label)));
    let visible: Vec<_> = all.filter(|(_, style)| 0.0 < style.opacity).collect();
    if visible.iter().any(|(_, style)| style.color.is_none() && style.transfer.is_some()) {
        return Err("labels have transfer functions of their own");
    }
    let legend: Vec<_> = visible
        .into_iter()
        .filter_map(|(label, style)| Some((written(label as f64), style.color?)))
        .collect();
    Ok((!legend.is_empty()).then_some(legend))
}

/// The visible values of a transfer function that gives each of some values a colour of its own, all the way
/// to half way between them, as label maps are shown; `None` of others.
///
/// Each value has two points, where its colour begins and where it ends: the first value is where its own
/// begins, and each further one as far beyond the border as the one before lies before it.
fn steps_of(transfer: &TransferFunction) -> Option<Legend> {
    let (pairs, []) = transfer.color_points().points().as_chunks::<2>() else { return None };
    let opacities = transfer.opacity_points().points();
    if pairs.len() < 2 || opacities.len() != 2 * pairs.len() {
        return None;
    }
    let (mut value, mut legend) = (pairs[0][0].0, Vec::new());
    for (idx, [(start, color), (end, same)]) in pairs.iter().enumerate() {
        if 0 < idx {
            value = 2.0 * start - value;
        }
        let last = if idx + 1 < pairs.len() { pairs[idx + 1][0].0 } else { value };
        let is_step = color == same && (end - last).abs() <= 1e-9 * end.abs().max(1.0);
        let [(from, [opacity]), (to, [as_opaque])] = [opacities[2 * idx], opacities[2 * idx + 1]];
        if !is_step || [from, to] != [*start, *end] || opacity != as_opaque {
            return None;
        }
        if 0.0 < opacity {
            legend.push((written(value), *color));
        }
    }
    (!legend.is_empty()).then_some(legend)
}

/// From the least visible value to the greatest, of those that the volume has and the transfer function
/// speaks of.
fn visible_range(layer: &Layer) -> Option<[f64; 2]> {
    let transfer = &layer.transfer;
    let visible = transfer.iso_ranges();
    let (first, last) = (visible.first()?, visible.last()?);
    let positions = || transfer.positions();
    let ends =
        [positions().fold(f64::INFINITY, f64::min), positions().fold(f64::NEG_INFINITY, f64::max)];
    let [least, greatest] = layer.volume.summary().range?;
    let lo = first.lo.max(ends[0]).max(least);
    let hi = last.hi.min(ends[1]).min(greatest);
    // One value, or a function of one point, has a colour as well.
    Some(if lo < hi {
        [lo, hi]
    } else {
        [least, if least < greatest { greatest } else { least + 1.0 }]
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use slabsplat_core::glam::DVec3;
    use slabsplat_core::{
        Camera, ColorSamples, Grid, LabelMap, LabelStyle, Labels, Projection, Scaling, TransferBox,
        TransferFunction2d, Volume, VoxelColors,
    };

    pub(crate) fn layer() -> Layer {
        let grid = Grid::centered([2, 2, 2], [1.0; 3]).unwrap();
        let volume =
            Volume::new(grid, vec![0_u8, 50, 100, 150, 200, 250, 3, 4].into(), Scaling::IDENTITY);
        let colors = [(0.0, [1.0, 0.0, 0.0]), (200.0, [0.0, 0.0, 1.0])];
        let transfer = TransferFunction::new([(40.0, 0.0), (60.0, 0.5), (300.0, 0.5)], colors);
        Layer::new(volume.unwrap(), transfer.unwrap())
    }

    pub(crate) fn scene(layer: Layer) -> Scene {
        let projection = Projection::Orthographic { view_height: 3.0 };
        let camera = Camera::new(DVec3::X * 9.0, DVec3::ZERO, DVec3::Z, projection).unwrap();
        Scene::new(layer, camera)
    }

    pub(crate) const RED: [f64; 3] = [1.0, 0.0, 0.0];
    pub(crate) const BLUE: [f64; 3] = [0.0, 0.0, 1.0];

    /// As automatic scenes show the labels 0, 3 and 10.
    pub(crate) fn steps() -> TransferFunction {
        let at = [0.0, 1.5, 1.5, 6.5, 6.5, 10.0];
        let (opacities, colors) = ([0.0, 0.9, 0.9], [BLUE, RED, BLUE]);
        let opacity = (0..6).map(|idx| (at[idx], opacities[idx / 2]));
        let color = (0..6).map(|idx| (at[idx], colors[idx / 2]));
        TransferFunction::new(opacity, color).unwrap()
    }

    fn legend(layer: Layer) -> Vec<(String, [f64; 3])> {
        match ColorKey::of(&scene(layer)) {
            Ok(ColorKey::Legend(legend)) => legend,
            other => panic!("{other:?} is no legend"),
        }
    }

    fn labels(layer: &Layer, styles: impl IntoIterator<Item = (i64, LabelStyle)>) -> Labels {
        Labels::new(LabelMap::new(&layer.volume, layer.volume.grid()).unwrap(), styles).unwrap()
    }

    fn colored(color: [f64; 3]) -> LabelStyle {
        LabelStyle::default().color(color)
    }

    #[test]
    fn color_key_is_a_bar_of_visible_values() {
        let scene = scene(layer());
        let Ok(ColorKey::Bar(_, [lo, hi])) = ColorKey::of(&scene) else { panic!("no bar") };
        assert!((39.99..40.01).contains(&lo) && hi == 250.0, "{lo} {hi}");
    }

    #[test]
    fn color_key_of_labels_is_a_legend() {
        let expected = [("3".to_owned(), RED), ("10".to_owned(), BLUE)];
        assert_eq!(legend(layer().transfer(steps())), expected);
        let with_labels = |styles: Vec<(i64, LabelStyle)>| {
            let layer = layer();
            let labels = labels(&layer, styles);
            layer.labels(labels)
        };
        let unseen = colored(RED).opacity(0.0);
        let styles = vec![(3, colored(RED)), (4, unseen.clone()), (150, colored(BLUE))];
        let expected = [("3".to_owned(), RED), ("150".to_owned(), BLUE)];
        assert_eq!(legend(with_labels(styles)), expected);
        // Labels that only hide some voxels leave colours to values.
        let hidden = scene(with_labels(vec![(4, unseen)]));
        assert!(matches!(ColorKey::of(&hidden), Ok(ColorKey::Bar(..))));
    }

    #[test]
    fn color_key_of_other_steps_is_a_bar() {
        let check = |opacity: Vec<(f64, f64)>, color: Vec<(f64, [f64; 3])>| {
            let transfer = TransferFunction::new(opacity, color).unwrap();
            let scene = scene(layer().transfer(transfer));
            assert!(matches!(ColorKey::of(&scene), Ok(ColorKey::Bar(..))));
        };
        let colors = vec![(0.0, BLUE), (9.0, BLUE), (9.0, RED), (200.0, RED)];
        let opacity = vec![(0.0, 0.1), (9.0, 0.1), (9.0, 0.9), (200.0, 0.9)];
        check(opacity.clone(), colors.clone());
        let opacity_alone = vec![(0.0, 0.1), (9.0, 0.2), (9.0, 0.9), (18.0, 0.9)];
        let colors = vec![(0.0, BLUE), (9.0, BLUE), (9.0, RED), (18.0, RED)];
        check(opacity_alone, colors.clone());
        check(vec![(0.0, 0.1), (18.0, 0.9)], colors);
    }

    #[test]
    fn color_key_says_why_there_is_none() {
        let check = |layer: Layer, expected: &str| {
            assert_eq!(ColorKey::of(&scene(layer)).map(|_| ()), Err(expected));
        };
        let layer = layer();
        let own = LabelStyle::default().transfer(steps());
        let with_transfers = labels(&layer, [(3, own)]);
        check(layer.clone().labels(with_transfers), "labels have transfer functions of their own");
        let colors = VoxelColors::new([2; 3], ColorSamples::U8(vec![[0; 3]; 8])).unwrap();
        check(layer.clone().colors(colors), "voxels have colours of their own");
        let boxes = vec![TransferBox::new([0.0, 9.0], [0.0, 1.0]).unwrap()];
        let by_both = TransferFunction2d::Boxes(boxes);
        check(layer.clone().transfer_2d(by_both), "colours depend on gradients, too");
        let clear = TransferFunction::new([(0.0, 0.0)], [(0.0, [1.0; 3])]).unwrap();
        check(layer.clone().transfer(clear), "no value is visible");
        let mut isosurfaces = scene(layer.clone());
        isosurfaces.settings.mode = Mode::Isosurfaces;
        assert!(ColorKey::of(&isosurfaces).is_err());
        isosurfaces.layers.clear();
        assert!(ColorKey::of(&isosurfaces).is_err());
    }
}
