//! Table 1: two rays through the faces of a binary cube that `axis-aligned` sheets see at 45°.
//!
//! Ray 1 passes a face that is parallel to the sheets, and five footprints are added in one of them. Ray 2
//! passes the other face, and the same five are composited in five sheets. That the two do not come to the
//! same is what pops.

use slabsplat_core::Compositing;

/// What a ray has gathered after a sheet: a row of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RayRow {
    /// The number of the sheet, from the eye.
    pub sheet: u32,
    /// The footprints' weight in this sheet.
    pub weight: f64,
    /// Opacity so far.
    pub opacity: f64,
    /// Premultiplied colour so far, of white voxels.
    pub color: f64,
    /// Colour over opacity.
    pub true_color: f64,
}

/// Ray 1, as printed.
pub const PRINTED_RAY_1: RayRow = printed(1, 0.947, [0.947, 0.898, 0.948]);

/// Ray 2, as printed. It slips at sheet 5: eq. 2 gives an opacity of 0.5815.
pub const PRINTED_RAY_2: [RayRow; 5] = [
    printed(3, 0.0278, [0.0278, 0.0007, 0.0025]),
    printed(4, 0.223, [0.2446, 0.0483, 0.197]),
    printed(5, 0.446, [0.592, 0.198, 0.334]),
    printed(6, 0.223, [0.683, 0.218, 0.319]),
    printed(7, 0.0278, [0.6912, 0.218, 0.315]),
];

const fn printed(sheet: u32, weight: f64, [opacity, color, true_color]: [f64; 3]) -> RayRow {
    RayRow { sheet, weight, opacity, color, true_color }
}

/// Eq. 3 with base 2 at a squared distance in voxel steps: 0.446, 0.223 and 0.0278 at 0, ½ and 2.
pub fn footprint(r_squared: f64) -> f64 {
    0.446 * (-2.0 * r_squared).exp2()
}

/// Ray 1 by a footprint, which is given squared distances.
pub fn ray_1(footprint: impl Fn(f64) -> f64) -> RayRow {
    let weight = footprint(0.0) + 2.0 * footprint(0.5) + 2.0 * footprint(2.0);
    Ray::default().behind(1, weight)
}

/// Ray 2 by a footprint, which is given squared distances.
pub fn ray_2(footprint: impl Fn(f64) -> f64) -> [RayRow; 5] {
    let mut ray = Ray::default();
    [(3, 2.0), (4, 0.5), (5, 0.0), (6, 0.5), (7, 2.0)]
        .map(|(sheet, r_squared)| ray.behind(sheet, footprint(r_squared)))
}

/// Premultiplied colour and opacity.
#[derive(Default)]
struct Ray {
    color: f64,
    opacity: f64,
}

impl Ray {
    /// Puts a sheet behind all before it, in which white voxels of opacity 1 weigh `weight` together (eqs. 2
    /// and 4).
    fn behind(&mut self, sheet: u32, weight: f64) -> RayRow {
        let [color, .., opacity] = Compositing::Separate.resolve([weight; 4]);
        let through = 1.0 - self.opacity;
        self.color += through * color;
        self.opacity += through * opacity;
        let Self { color, opacity } = *self;
        RayRow { sheet, weight, opacity, color, true_color: color / opacity }
    }
}
