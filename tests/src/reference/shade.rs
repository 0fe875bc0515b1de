//! Blinn–Phong as model §6 has it.

use slabsplat_core::glam::{DMat3, DVec3};
use slabsplat_core::{Light, LightSource, Phong, Shading};

/// The transfer function's `color` under the light, for a surface that faces against `gradient`
/// (world space) and is seen along `forward`.
pub fn shaded_color(
    (shading, lights): (&Shading, &[Light]),
    color: [f64; 3],
    gradient: DVec3,
    forward: DVec3,
) -> [f64; 3] {
    let normal = gradient.try_normalize().map_or(DVec3::ZERO, |uphill| -uphill);
    shaded_by_normals((shading, lights), color, &[(normal, 1.0)], forward)
}

/// The same with the mean light of some normals, of length 1, or shorter where there is less of a direction,
/// by their weights.
pub fn shaded_by_normals(
    (shading, lights): (&Shading, &[Light]),
    color: [f64; 3],
    normals: &[(DVec3, f64)],
    forward: DVec3,
) -> [f64; 3] {
    let Shading::Phong(phong) = shading else {
        return color;
    };
    let weights: f64 = normals.iter().map(|(_, weight)| weight).sum();
    let (mut diffuse, mut specular) = (DVec3::ZERO, DVec3::ZERO);
    for (light, &(normal, weight)) in
        lights.iter().flat_map(|l| normals.iter().map(move |n| (l, n)))
    {
        let (of_diffuse, of_specular) = light_terms(phong, light, normal, forward);
        diffuse += weight / weights * of_diffuse * DVec3::from(light.color);
        specular += weight / weights * of_specular * DVec3::from(light.color);
    }
    let lit = DVec3::from(color) * (phong.ambient + diffuse) + specular;
    lit.to_array().map(|channel| channel.clamp(0.0, 1.0))
}

/// `k_d·(n·l + k_0·(1 − |n|))` and `k_s·(n·h)^s`.
fn light_terms(phong: &Phong, light: &Light, normal: DVec3, forward: DVec3) -> (f64, f64) {
    let to_viewer = -forward;
    let to_light = match light.source {
        LightSource::Headlight => to_viewer,
        LightSource::Direction(direction) => direction.get(),
    };
    // A light exactly behind the volume has no halfway vector, hence no highlight.
    let halfway = (to_light + to_viewer).normalize_or_zero();
    let product = |v: DVec3| {
        let product = normal.dot(v);
        if phong.two_sided { product.abs() } else { product.max(0.0) }
    };
    let n_dot_l = product(to_light);
    let diffuse =
        phong.diffuse * (n_dot_l + phong.zero_gradient * (1.0 - normal.length().min(1.0)));
    if n_dot_l <= 0.0 {
        return (diffuse, 0.0);
    }
    (diffuse, phong.specular * product(halfway).powf(phong.shininess))
}

/// Where the voxels of a cell face (model §16).
pub(super) struct Directions {
    /// The mean of their normals.
    pub(super) normal: DVec3,
    /// The share that has none.
    pub(super) undirected: f64,
    /// The mean of normal times normal, transposed, if it is known.
    pub(super) moments: Option<DMat3>,
}

/// The colour of a cell (model §16).
pub(super) fn shaded_cell_color(
    (shading, lights): (&Shading, &[Light]),
    color: [f64; 3],
    &Directions { normal, undirected, moments }: &Directions,
    forward: DVec3,
) -> [f64; 3] {
    let Shading::Phong(phong) = shading else {
        return color;
    };
    let length = normal.length();
    let directed = (1.0 - undirected).max(length);
    let r = if 0.0 < directed { length / directed } else { 0.0 };
    let along =
        |v: DVec3| if 0.0 < directed { (normal.dot(v) / directed).clamp(-1.0, 1.0) } else { 0.0 };
    let s = phong.shininess;
    let f = if 0.0 < r { r / (r + s * (1.0 - r)) } else { 0.0 };
    std::array::from_fn(|channel| {
        let (mut diffuse, mut specular) = (0.0, 0.0);
        for light in lights {
            let to_light = match light.source {
                LightSource::Headlight => -forward,
                LightSource::Direction(direction) => direction.get(),
            };
            let m = along(to_light);
            let v = match moments {
                Some(moments) if 0.0 < directed => {
                    (to_light.dot(moments * to_light) / directed - m * m).max(0.0)
                }
                Some(_) => 0.0,
                None => (1.0 - r * r) / (3.0 - r * r) * (1.0 - m * m),
            };
            let beyond = if 0.0 < v { 0.75 * v * v / (v + 0.5 * m * m) } else { 0.0 };
            let both_sides = (m * m + beyond).sqrt();
            let one_side = 0.5 * (both_sides + m);
            let (facing, share) = match phong.two_sided {
                true => (both_sides, 1.0),
                false => (one_side, if 0.0 < both_sides { one_side / both_sides } else { 0.0 }),
            };
            let of_undirected = phong.zero_gradient * undirected;
            diffuse += light.color[channel] * phong.diffuse * (directed * facing + of_undirected);
            let halfway = (to_light - forward).normalize_or_zero();
            let n_h = if 0.0 < r { along(halfway) / r } else { 0.0 };
            let n_h = if phong.two_sided { n_h.abs() } else { n_h }.clamp(-1.0, 1.0);
            // 0 to the power of nearly 0 would change from 1 to 0 at once.
            let of_one = n_h.clamp(2_f64.powi(-127), 1.0).powf(f * s);
            let highlight = r * r * of_one + (1.0 - r * r) * (f * s * (n_h - 1.0)).exp();
            let factor = (1.0 + f * s) / (1.0 + s);
            specular +=
                light.color[channel] * phong.specular * directed * share * factor * highlight;
        }
        (color[channel] * (phong.ambient + diffuse) + specular).clamp(0.0, 1.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: [f64; 3] = [0.5, 0.0, 0.0];

    fn phong() -> Phong {
        Phong::default().ambient(0.1).diffuse(0.6).specular(0.2).shininess(3.0).two_sided(false)
    }

    fn towards(direction: DVec3) -> Light {
        Light::towards(direction).expect("the direction is not zero")
    }

    fn check(phong: Phong, gradient: DVec3, expected: [f64; 3]) {
        check_lit(phong, &[Light::default()], gradient, expected);
    }

    fn check_lit(phong: Phong, lights: &[Light], gradient: DVec3, expected: [f64; 3]) {
        let shading = Shading::Phong(phong);
        let actual = shaded_color((&shading, lights), RED, gradient, DVec3::NEG_Z);
        let error = (DVec3::from_array(actual) - DVec3::from_array(expected)).length();
        assert!(error < 1e-12, "{phong:?} {gradient}: {actual:?}");
    }

    #[test]
    fn shade_facing_oblique_and_averted() {
        check(phong(), DVec3::Z * -5.0, [0.5 * 0.7 + 0.2, 0.2, 0.2]);
        let oblique = DVec3::new(0.6, 0.0, -0.8);
        check(phong(), oblique, [0.5 * (0.1 + 0.48) + 0.2 * 0.512, 0.2 * 0.512, 0.2 * 0.512]);
        check(phong(), -oblique, [0.05, 0.0, 0.0]);
        let two_sided = phong().two_sided(true);
        check(two_sided, -oblique, [0.5 * (0.1 + 0.48) + 0.2 * 0.512, 0.2 * 0.512, 0.2 * 0.512]);
    }

    #[test]
    fn shade_zero_gradient_faces_every_light() {
        check(phong(), DVec3::ZERO, [0.5 * 0.7, 0.0, 0.0]);
        check(phong().shininess(0.0), DVec3::ZERO, [0.5 * 0.7, 0.0, 0.0]);
        let lights = [towards(DVec3::X), towards(DVec3::NEG_Z)];
        check_lit(phong(), &lights, DVec3::ZERO, [0.5 * 1.3, 0.0, 0.0]);
        check_lit(phong(), &[], DVec3::ZERO, [0.05, 0.0, 0.0]);
        check(phong().zero_gradient(0.25), DVec3::ZERO, [0.5 * 0.25, 0.0, 0.0]);
    }

    #[test]
    fn shade_light_from_the_side_and_behind() {
        let side = [towards(DVec3::X)];
        let half = 0.5_f64.sqrt().powi(3) * 0.2;
        check_lit(phong(), &side, DVec3::NEG_X, [0.5 * 0.7 + half, half, half]);
        check_lit(phong(), &side, DVec3::NEG_Z, [0.05, 0.0, 0.0]);
        let two_sided = phong().two_sided(true);
        let behind = [towards(DVec3::NEG_Z)];
        check_lit(two_sided, &behind, DVec3::NEG_Z, [0.5 * 0.7, 0.0, 0.0]);
    }

    #[test]
    fn shade_sums_lights_by_color() {
        let (dim, blue) =
            (Light::default().color([0.5; 3]), Light::default().color([0.0, 0.0, 0.5]));
        let both = [dim, blue];
        check_lit(phong(), &both, DVec3::NEG_Z, [0.5 * (0.1 + 0.3) + 0.1, 0.1, 0.2]);
        check_lit(phong(), &[], DVec3::NEG_Z, [0.05, 0.0, 0.0]);
    }

    #[test]
    fn shade_is_clamped_and_optional() {
        let bright = phong().specular(9.0);
        check(bright, DVec3::NEG_Z, [1.0; 3]);
        assert_eq!(
            shaded_color((&Shading::None, &[Light::default()]), RED, DVec3::X, DVec3::X),
            RED
        );
    }
}
