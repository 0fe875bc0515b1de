//! How a sheet's sums become premultiplied colour, and how sheets are composited (model §3).
//! All that depends on the compositing model is here.

use slabsplat_core::{Compositing, Mode};

/// Greatest opacity of a voxel in `extinction`, which would be infinite at 1.
const MAX_OPACITY: f64 = 1.0 - 1e-6;

/// What one pixel of a sheet has summed up.
#[derive(Clone, Copy, Debug)]
pub struct SheetSums {
    compositing: Compositing,
    /// `A`, or `τ` in `extinction`.
    opacity: f64,
    /// `C`, or `E` in `extinction`.
    color: [f64; 3],
}

/// Premultiplied colour and opacity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Premultiplied {
    /// Red, green and blue times the opacity.
    pub color: [f64; 3],
    /// How much of what lies behind is occluded.
    pub opacity: f64,
}

/// What a sheet sums of an opacity: that, or its extinction.
pub(super) fn weight(compositing: Compositing, opacity: f64) -> f64 {
    match compositing {
        Compositing::Separate | Compositing::Associated => opacity,
        Compositing::Extinction => -(1.0 - opacity.min(MAX_OPACITY)).ln(),
    }
}

/// The model by which a mode splits slabs: a mean has shares of them, the largest and the least density do
/// not.
pub(super) fn splitting(mode: Mode) -> Compositing {
    match mode {
        Mode::Separate => Compositing::Separate,
        Mode::Associated | Mode::Maximum | Mode::Minimum => Compositing::Associated,
        Mode::Extinction | Mode::Average | Mode::Isosurfaces => Compositing::Extinction,
    }
}

/// The share of a slab that lies between two depths: of all of it in `extinction`, else all or nothing by its
/// middle.
pub(super) fn share_of_slab(
    compositing: Compositing,
    [front, back]: [f64; 2],
    [start, end]: [f64; 2],
) -> f64 {
    match compositing {
        Compositing::Extinction => (back.min(end) - front.max(start)).max(0.0) / (back - front),
        Compositing::Separate | Compositing::Associated => {
            let middle = 0.5 * (front + back);
            f64::from(u8::from(start <= middle && middle < end))
        }
    }
}

/// What goes through a quarter of a part between sheets (model §8), where what a sheet sums hides any of
/// itself.
pub(super) fn through_a_quarter(compositing: Compositing, length: f64, weight: f64) -> f64 {
    match compositing {
        Compositing::Extinction => (-0.25 * length * weight).exp(),
        Compositing::Separate | Compositing::Associated => 1.0,
    }
}

impl SheetSums {
    /// An empty sheet.
    pub fn new(compositing: Compositing) -> Self {
        Self { compositing, opacity: 0.0, color: [0.0; 3] }
    }

    /// An empty sum of parts of several layers of densities (model §10): in `separate`, of what each layer
    /// alone would show.
    pub fn of_parts(compositing: Compositing) -> Self {
        match compositing {
            Compositing::Separate | Compositing::Associated => Self::new(Compositing::Associated),
            Compositing::Extinction => Self::new(Compositing::Extinction),
        }
    }

    /// Adds a voxel's section weight `section`, times its opacity and its shaded colour.
    pub fn add(&mut self, section: f64, opacity: f64, color: [f64; 3]) {
        self.add_weighted(section, weight(self.compositing, opacity), color);
    }

    /// The same for what a sheet sums of an opacity.
    pub fn add_weighted(&mut self, section: f64, weight: f64, color: [f64; 3]) {
        let color_factor = match self.compositing {
            Compositing::Separate => 1.0,
            Compositing::Associated | Compositing::Extinction => weight,
        };
        self.opacity += section * weight;
        for (sum, channel) in self.color.iter_mut().zip(color) {
            *sum += section * color_factor * channel;
        }
    }

    /// Adds what a layer of densities shows, to a sum that is [`of_parts`](Self::of_parts).
    pub fn add_part(
        &mut self,
        compositing: Compositing,
        length: f64,
        weight: f64,
        color: [f64; 3],
    ) {
        let color = match compositing {
            Compositing::Separate => color.map(|channel| (length * channel).min(1.0)),
            Compositing::Associated | Compositing::Extinction => color,
        };
        self.add_weighted(length, weight, color);
    }

    /// Adds a share of what another layer has summed up in the same sheet.
    pub fn add_share(&mut self, share: f64, layer: Self) {
        self.opacity += share * layer.opacity;
        for (sum, channel) in self.color.iter_mut().zip(layer.color) {
            *sum += share * channel;
        }
    }

    /// The finished sheet.
    pub fn finish(self) -> Premultiplied {
        // Sections of the `paper` normalisation may be negative; a sheet cannot be.
        let a = self.opacity;
        if a <= 0.0 {
            return Premultiplied::default();
        }
        match self.compositing {
            Compositing::Separate => {
                let opacity = a.clamp(0.0, 1.0);
                Premultiplied { color: self.color.map(|c| opacity * c.clamp(0.0, 1.0)), opacity }
            }
            Compositing::Associated => {
                let factor = if 1.0 < a { 1.0 / a } else { 1.0 };
                Premultiplied { color: self.color.map(|c| c * factor), opacity: a.min(1.0) }
            }
            Compositing::Extinction => {
                let opacity = -(-a).exp_m1();
                Premultiplied { color: self.color.map(|c| c * opacity / a), opacity }
            }
        }
    }
}

impl Premultiplied {
    /// Lays `behind` under what is there.
    pub fn lay_over(&mut self, behind: Self) {
        let through = 1.0 - self.opacity;
        for (front, back) in self.color.iter_mut().zip(behind.color) {
            *front += through * back;
        }
        self.opacity += through * behind.opacity;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(compositing: Compositing, splats: &[(f64, f64, f64)]) -> Premultiplied {
        let mut sums = SheetSums::new(compositing);
        for &(weight, opacity, gray) in splats {
            sums.add(weight, opacity, [gray; 3]);
        }
        sums.finish()
    }

    fn check(compositing: Compositing, splats: &[(f64, f64, f64)], color: f64, opacity: f64) {
        let sheet = sheet(compositing, splats);
        assert!((sheet.color[1] - color).abs() < 1e-12, "{compositing}: {sheet:?}");
        assert!((sheet.opacity - opacity).abs() < 1e-12, "{compositing}: {sheet:?}");
    }

    #[test]
    fn sheet_colors_by_hand() {
        let two = [(0.5, 0.4, 1.0), (0.25, 0.8, 0.5)];
        check(Compositing::Separate, &two, 0.4 * 0.625, 0.4);
        check(Compositing::Associated, &two, 0.3, 0.4);
        let (mu, nu) = (-0.5 * 0.6_f64.ln(), -0.25 * 0.2_f64.ln());
        let opacity = 1.0 - (-mu - nu).exp();
        check(Compositing::Extinction, &two, (mu + 0.5 * nu) * opacity / (mu + nu), opacity);
    }

    #[test]
    fn sheet_is_clamped() {
        let much = [(3.0, 1.0, 0.8)];
        check(Compositing::Separate, &much, 1.0, 1.0);
        check(Compositing::Associated, &much, 0.8, 1.0);
        let opacity = 1.0 - 1e-18;
        check(Compositing::Extinction, &much, 0.8 * opacity, opacity);
        for &compositing in Compositing::ALL {
            assert_eq!(sheet(compositing, &[]), Premultiplied::default());
        }
    }

    /// model §3: in `extinction`, two slabs composited have the opacity of the one that holds both.
    #[test]
    fn sheet_extinction_is_additive() {
        let (front, back) = ((0.3, 0.7, 0.9), (0.6, 0.5, 0.1));
        let mut composited = sheet(Compositing::Extinction, &[front]);
        composited.lay_over(sheet(Compositing::Extinction, &[back]));
        let together = sheet(Compositing::Extinction, &[front, back]);
        assert!((composited.opacity - together.opacity).abs() < 1e-15);
        // Of one colour, the colour is additive too.
        let gray = |(weight, opacity, _): (f64, f64, f64)| (weight, opacity, 0.4);
        let mut composited = sheet(Compositing::Extinction, &[gray(front)]);
        composited.lay_over(sheet(Compositing::Extinction, &[gray(back)]));
        let together = sheet(Compositing::Extinction, &[gray(front), gray(back)]);
        assert!((composited.color[0] - together.color[0]).abs() < 1e-15);
    }
}
