//! Shading (model §6), once a voxel and frame.
//!
//! What comes out is what a sheet sums (model §3): the voxel's colour and opacity in the form that the
//! compositing wants, so that splatting is the same four multiply-adds for all three.
//!
//! Voxels go eight at a time through arithmetic of 32 bits. That costs some 10⁻⁶ of a colour, and less
//! than `shininess` · 2·10⁻⁷ of a highlight, which is less than the keeping of normals in 16 bits does.

use crate::blinn_phong::{BlinnPhong8, Light8};
use crate::gradient_length::GradientLengths;
use crate::order::Ordered;
use crate::{Brick, BrickGrid, Classification, RelevantList, VoxelRecord, VoxelRules};
use slabsplat_core::{Volume, VoxelColors, with_samples};

/// Everything that a voxel's colour depends on in one frame, but for the voxel.
#[derive(Clone, Copy, Debug)]
pub struct VoxelLighting<'a> {
    classification: &'a Classification,
    volume: &'a Volume,
    rules: VoxelRules<'a>,
    grid: BrickGrid,
    light: Option<&'a BlinnPhong8>,
}

impl<'a> VoxelLighting<'a> {
    /// Lights `volume` by rules, which are those classified, if there is any light.
    pub fn new(
        classification: &'a Classification,
        volume: &'a Volume,
        rules: VoxelRules<'a>,
        light: Option<&'a BlinnPhong8>,
    ) -> Self {
        Self { classification, volume, rules, grid: BrickGrid::new(volume.grid()), light }
    }

    /// The light, if there is any.
    pub fn light(&self) -> Option<&'a BlinnPhong8> {
        self.light
    }

    /// Writes red, green, blue and opacity of all voxels of `list` into `colors`, in parallel.
    pub fn shade(&self, list: &RelevantList, colors: &mut Vec<[f32; 4]>) {
        colors.resize(list.len(), [0.0; 4]);
        list.fill_by_brick(colors, |brick, records, colors| {
            self.shade_brick(brick, records, colors);
        });
    }

    /// Writes red, green, blue and opacity of voxels of one brick into `colors`, as the compositing sums
    /// them: `(c, α)` for `separate`, `(αc, α)` for `associated`, `(μc, μ)` with `μ = −ln(1 − α)`
    /// for `extinction`. There are as many `records` as `colors`.
    pub fn shade_brick(&self, brick: &Brick, records: &[VoxelRecord], colors: &mut [[f32; 4]]) {
        self.classify_brick(brick, records, colors);
        self.light_brick(records, colors);
    }

    /// What is left of [`shade_brick`](Self::shade_brick) after
    /// [`classify_brick`](Self::classify_brick). All that it does is inlined, for whatever vectors the caller
    /// is compiled for.
    #[inline(always)]
    pub fn light_brick(&self, records: &[VoxelRecord], colors: &mut [[f32; 4]]) {
        let is_weighted = self.classification.compositing().weights_colors();
        match (self.light, is_weighted) {
            (Some(light), true) if light.is_white() => {
                light_up::<1, true>(light, records, colors);
            }
            (Some(light), false) if light.is_white() => {
                light_up::<1, false>(light, records, colors);
            }
            (Some(light), true) => light_up::<3, true>(light, records, colors),
            (Some(light), false) => light_up::<3, false>(light, records, colors),
            (None, true) => {
                for [r, g, b, weight] in colors {
                    *r *= *weight;
                    *g *= *weight;
                    *b *= *weight;
                }
            }
            (None, false) => {}
        }
    }

    /// Writes red, green, blue and weight of voxels of one brick into `colors`: before light, and colours not
    /// yet times weights. There are as many `records` as `colors`.
    #[inline]
    pub fn classify_brick(&self, brick: &Brick, records: &[VoxelRecord], colors: &mut [[f32; 4]]) {
        with_samples!(self.volume.samples(), |s| self.classify(s, brick, records, colors));
        if let Some(own) = self.rules.colors {
            self.take_own_colors(own, brick, records, colors);
        }
    }

    /// Replaces the colours of transfer functions by those of voxels.
    fn take_own_colors(
        &self,
        own: &VoxelColors,
        brick: &Brick,
        records: &[VoxelRecord],
        colors: &mut [[f32; 4]],
    ) {
        let labels = self.rules.labels.map(|labels| labels.map().indices());
        for (color, idx) in colors.iter_mut().zip(self.grid.voxel_indices(brick, records)) {
            if !self.classification.has_label_color(labels.map(|labels| labels[idx])) {
                color[..3].copy_from_slice(&own.at(idx));
            }
        }
    }

    fn classify<T: Ordered>(
        &self,
        samples: &[T],
        brick: &Brick,
        records: &[VoxelRecord],
        colors: &mut [[f32; 4]],
    ) {
        let labels = self.rules.labels.map(|labels| labels.map().indices());
        if self.rules.are_by_gradient() {
            return self.classify_by_gradient((samples, labels), brick, records, colors);
        }
        let voxels = colors.iter_mut().zip(self.grid.voxel_indices(brick, records));
        let classification = self.classification;
        match labels {
            None => {
                for (color, idx) in voxels {
                    *color = classification.of(samples[idx], None);
                }
            }
            Some(labels) => {
                for (color, idx) in voxels {
                    *color = classification.of(samples[idx], Some(labels[idx]));
                }
            }
        }
    }

    fn classify_by_gradient<T: Ordered>(
        &self,
        (samples, labels): (&[T], Option<&[u16]>),
        brick: &Brick,
        records: &[VoxelRecord],
        colors: &mut [[f32; 4]],
    ) {
        let gradients = GradientLengths::new(self.volume, samples);
        for (color, record) in colors.iter_mut().zip(records) {
            let coords = self.grid.voxel_coords(brick, *record);
            let idx = self.grid.voxel_idx(coords);
            let gradient = gradients.at(coords);
            let label_idx = labels.map(|labels| labels[idx]);
            *color = self.classification.of_gradient(samples[idx], gradient, label_idx);
            if let Some(factor) = self.rules.gradient_opacity {
                *color = self.classification.thinned(*color, factor.at(gradient)[0]);
            }
        }
    }
}

/// Lights classified `colors` with one or three channels of light, and multiplies them with their weights, if
/// they are weighted.
#[inline(always)]
fn light_up<const N: usize, const IS_WEIGHTED: bool>(
    blinn_phong: &BlinnPhong8,
    records: &[VoxelRecord],
    colors: &mut [[f32; 4]],
) {
    let (eights, rest) = records.as_chunks();
    let (color_eights, color_rest) = colors.as_chunks_mut::<8>();
    for (records, colors) in eights.iter().zip(color_eights) {
        lay_on::<N, IS_WEIGHTED>(&blinn_phong.on(records), colors);
    }
    let mut last = [VoxelRecord::default(); 8];
    last[..rest.len()].copy_from_slice(rest);
    lay_on::<N, IS_WEIGHTED>(&blinn_phong.on(&last), color_rest);
}

/// Lays light on up to eight colours.
#[inline(always)]
fn lay_on<const N: usize, const IS_WEIGHTED: bool>(lights: &[Light8; N], colors: &mut [[f32; 4]]) {
    for (x, color) in colors.iter_mut().enumerate() {
        let weight = color[3];
        let factor = if IS_WEIGHTED { weight } else { 1.0 };
        // The weight goes along, so that the four are one vector, and is put back.
        for (idx, channel) in color.iter_mut().enumerate() {
            let light = &lights[idx.min(N - 1)];
            let lit = *channel * light.diffuse[x] + light.specular[x];
            *channel = if lit < 1.0 { lit } else { 1.0 } * factor;
        }
        color[3] = weight;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{random_ranges, random_volume};
    use crate::{BrickRanges, RelevantList};
    use slabsplat_core::glam::DVec3;
    use slabsplat_core::{
        BlinnPhong, Compositing, Grid, Light, LightInView, Phong, Scaling, TransferFunction,
    };
    use slabsplat_seeds::for_each_seed;

    #[test]
    fn shade_sums_what_the_compositing_wants() {
        let grid = Grid::with_spacing([1, 1, 1], [1.0; 3]).unwrap();
        let volume = Volume::new(grid, vec![7_u8].into(), Scaling::IDENTITY).unwrap();
        let color = [0.2, 0.4, 0.8];
        let check = |opacity: f64, compositing, expected: [f64; 4]| {
            let transfer =
                TransferFunction::new(vec![(0.0, [opacity])], vec![(0.0, color)]).unwrap();
            let rules = VoxelRules::by_value(&transfer);
            let classification = Classification::new(&rules, compositing, &volume);
            let lighting = VoxelLighting::new(&classification, &volume, rules, None);
            let mut colors = [[0.0; 4]];
            let brick = Brick { brick_idx: 0, first: 0, n_voxels: 1 };
            lighting.shade_brick(&brick, &[VoxelRecord::default()], &mut colors);
            for (actual, expected) in colors[0].iter().zip(expected) {
                assert!((f64::from(*actual) - expected).abs() < 1e-6, "{colors:?}");
            }
        };
        check(0.5, Compositing::Separate, [0.2, 0.4, 0.8, 0.5]);
        check(0.5, Compositing::Associated, [0.1, 0.2, 0.4, 0.5]);
        let mu = std::f64::consts::LN_2;
        check(0.5, Compositing::Extinction, [0.2 * mu, 0.4 * mu, 0.8 * mu, mu]);
        let most = -(1e-6_f64).ln();
        check(1.0, Compositing::Extinction, [0.2 * most, 0.4 * most, 0.8 * most, most]);
    }

    /// model §6 word by word, in 64 bits, for a normal of length 1 or 0.
    fn naive_phong(phong: &Phong, lights: &[LightInView], color: DVec3, normal: DVec3) -> DVec3 {
        let product = |direction: DVec3| {
            let product = normal.dot(direction);
            if phong.two_sided { product.abs() } else { product.max(0.0) }
        };
        let mut lit = color * phong.ambient;
        if normal == DVec3::ZERO {
            let facing_all =
                lights.iter().map(|light| color * phong.diffuse * light.color).sum::<DVec3>();
            lit += phong.zero_gradient * facing_all;
        }
        for light in lights.iter().filter(|light| 0.0 < product(light.to_light)) {
            lit += color * phong.diffuse * light.color * product(light.to_light);
            lit += phong.specular * light.color * product(light.halfway).powf(phong.shininess);
        }
        lit.clamp(DVec3::ZERO, DVec3::ONE)
    }

    /// One white light or none, or some coloured ones.
    fn random_lights(rng: &mut fastrand::Rng) -> Vec<Light> {
        let mut light = || {
            let direction = DVec3::new(rng.f64() - 0.5, rng.f64() - 0.5, rng.f64() - 0.5);
            let color = [rng.f64(), rng.f64(), rng.f64()];
            let light =
                if rng.bool() { Light::default() } else { Light::towards(direction).unwrap() };
            (light, light.color(color), rng.usize(0..6))
        };
        match light() {
            (_, _, 0) => vec![],
            (white, _, 1..=3) => vec![white],
            (_, colored, 4) => vec![colored],
            (white, colored, _) => vec![white, colored, light().1],
        }
    }

    fn random_phong(rng: &mut fastrand::Rng) -> Phong {
        Phong::default()
            .ambient(rng.f64())
            .diffuse(rng.f64())
            .zero_gradient(rng.f64())
            .specular(rng.f64())
            .shininess([0.0, 1.0, 20.0, 7.5, 100.0][rng.usize(0..5)])
            .two_sided(rng.bool())
    }

    /// Of a weighted colour; opacities stay far from 1, so that weights stay below 2. A highlight of
    /// shininess 100 has an error of 2·10⁻⁵, all others far less.
    const MAX_ERROR: f64 = 3e-5;

    #[test]
    fn shade_is_the_definition() {
        for_each_seed(1, |mut rng| {
            for _ in 0..200 {
                let volume = random_volume(&mut rng);
                let mut point = |_| std::array::from_fn(|_| 0.8 * rng.f64());
                let [a, b] = [0, 1].map(&mut point);
                let opacity = vec![(-20.0, [0.1]), (200.0, [0.8])];
                let transfer = TransferFunction::new(opacity, vec![(0.0, a), (90.0, b)]).unwrap();
                let compositing = Compositing::ALL[rng.usize(0..Compositing::ALL.len())];
                let phong = random_phong(&mut rng);
                let forward = DVec3::new(rng.f64() - 0.5, rng.f64(), 0.3).normalize();
                let mut list = RelevantList::default();
                let ranges = random_ranges(&mut rng, &volume);
                list.update(&volume, &BrickRanges::new(&volume), &ranges, None);

                let rules = VoxelRules::by_value(&transfer);
                let classification = Classification::new(&rules, compositing, &volume);
                let light = BlinnPhong::new(phong, &random_lights(&mut rng), forward);
                let light8 = BlinnPhong8::new(&light);
                let mut colors = Vec::new();
                VoxelLighting::new(&classification, &volume, rules, Some(&light8))
                    .shade(&list, &mut colors);

                for brick in list.bricks() {
                    for (&record, &actual) in
                        list.voxels_of(brick).iter().zip(&colors[brick.voxels()])
                    {
                        let value = volume.value(list.voxel_idx(brick, record));
                        let color = DVec3::from(transfer.color(value));
                        let normal = DVec3::from(record.normal.map(f64::from)).normalize_or_zero();
                        let lit = naive_phong(&phong, &light.lights, color, normal);
                        let opacity = transfer.opacity(value);
                        let expected = match compositing {
                            Compositing::Separate => lit.extend(opacity),
                            Compositing::Associated => (lit * opacity).extend(opacity),
                            Compositing::Extinction => {
                                let mu = -(-opacity).ln_1p();
                                (lit * mu).extend(mu)
                            }
                        };
                        let difference = expected - DVec4::from(actual.map(f64::from));
                        assert!(
                            difference.abs().max_element() < MAX_ERROR,
                            "{difference} {phong:?}"
                        );
                    }
                }
            }
        });
    }
    use slabsplat_core::glam::DVec4;
}
