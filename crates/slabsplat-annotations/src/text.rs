//! A line of text.

use ab_glyph::{
    Font, FontRef, Glyph, GlyphId, OutlinedGlyph, PxScale, PxScaleFont, ScaleFont, point,
};
use slabsplat_core::Image;

use crate::Ink;
use crate::coverage::Coverage;

/// The font, as a file of TrueType outlines, for programs that write with it elsewhere.
pub const FONT: &[u8] = include_bytes!("../fonts/DejaVuSans-subset.ttf");

/// A line of text at its place.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Label<'a> {
    /// What it says, from left to right; what ends a line, and other control characters, are spaces.
    pub text: &'a str,
    /// A point of the picture, in pixels from its upper left corner.
    pub at: [f32; 2],
    /// Which point of the text is there, in parts of its width and height: `[0.0, 0.0]` is its upper left
    /// corner, `[0.5, 1.0]` the middle of its lower edge.
    pub anchor: [f32; 2],
    /// Pixels of an em; a capital letter is 0.73 of it high. Text is drawn from above 0 to 2048.
    pub size_pixels: f32,
    /// In which colours.
    pub ink: Ink,
}

impl<'a> Label<'a> {
    /// White text with a dark halo, 16 pixels an em, whose upper left corner is there.
    pub const fn new(text: &'a str, at: [f32; 2]) -> Self {
        Self { text, at, anchor: [0.0; 2], size_pixels: 16.0, ink: Ink::LIGHT }
    }

    /// The same with another point of the text there.
    #[must_use]
    pub const fn anchor(self, anchor: [f32; 2]) -> Self {
        Self { anchor, ..self }
    }

    /// The same in another size.
    #[must_use]
    pub const fn size_pixels(self, size_pixels: f32) -> Self {
        Self { size_pixels, ..self }
    }

    /// The same in other colours.
    #[must_use]
    pub const fn ink(self, ink: Ink) -> Self {
        Self { ink, ..self }
    }
}

/// Shares of an em above and below the baseline.
const ASCENT: f32 = 0.93;
const DESCENT: f32 = 0.24;

/// The size of text that suits a picture of `width` × `height` pixels: a fortieth of its shorter side, but no
/// less than 11 pixels from 220 pixels on, and in smaller ones 9, which are just legible.
pub fn text_size(width: u32, height: u32) -> f32 {
    let side = width.min(height) as f32;
    (side / 40.0).max((side / 20.0).clamp(9.0, 11.0))
}

/// Width and height of a line of text in pixels, by the size of an em. The height is the same for all texts;
/// the halo reaches a tenth of an em further.
pub fn measure_text(text: &str, size_pixels: f32) -> [f32; 2] {
    let font = Scaled::new(size_pixels);
    [font.glyphs(text).1, (ASCENT + DESCENT) * size_pixels]
}

/// The characters of a text that the font lacks, each once: in their place is a box.
pub fn lacks(text: &str) -> Vec<char> {
    let font = Scaled::new(1.0);
    let lacks = |c: &char| !c.is_control() && font.0.glyph_id(*c) == GlyphId(0);
    let mut lacking: Vec<char> = Vec::new();
    for c in text.chars().filter(lacks) {
        if !lacking.contains(&c) {
            lacking.push(c);
        }
    }
    lacking
}

/// Twice that of the largest title of the largest picture. A letter takes memory for all of its pixels, also
/// for those outside of the picture.
const MAX_SIZE_PIXELS: f32 = 2048.0;

/// Draws a line of text; what is outside of the picture is cut off.
pub fn draw_text(image: &mut Image, label: &Label<'_>) {
    let Label { text, at, anchor, size_pixels, ink } = *label;
    if !(0.0 < size_pixels && size_pixels <= MAX_SIZE_PIXELS) {
        return;
    }
    let font = Scaled::new(size_pixels);
    let (glyphs, width) = font.glyphs(text);
    let size = [width, (ASCENT + DESCENT) * size_pixels];
    let corner = [0, 1].map(|axis| at[axis] - anchor[axis] * size[axis]);
    // A baseline between two rows of pixels is a blurred one.
    let baseline = [corner[0], (corner[1] + ASCENT * size_pixels).round()];
    let radius = halo_radius(size_pixels);
    // Accents and overhangs reach out of the box.
    let margin = radius + 0.3 * size_pixels;
    let ends = [corner.map(|c| c - margin), [0, 1].map(|axis| corner[axis] + size[axis] + margin)];
    let Some(mut coverage) = Coverage::between(image, ends) else { return };
    for mut glyph in glyphs {
        glyph.position = point(baseline[0] + glyph.position.x, baseline[1]);
        if let Some(outlined) = font.0.outline_glyph(glyph) {
            rasterize(&outlined, &mut coverage);
        }
    }
    coverage.grown(radius).paint(image, ink.halo);
    coverage.paint(image, ink.color);
}

/// How far the halo of what is drawn at a size of text reaches, in pixels.
pub(crate) fn halo_radius(size_pixels: f32) -> f32 {
    (0.09 * size_pixels).max(1.2)
}

/// Glyphs that are not in the picture are not rasterised: a text may be longer than any picture.
fn rasterize(outlined: &OutlinedGlyph, coverage: &mut Coverage) {
    let bounds = outlined.px_bounds();
    if coverage.reaches([bounds.min.x, bounds.max.x]) {
        let [left, top] = [bounds.min.x as i64, bounds.min.y as i64];
        outlined.draw(|x, y, part| coverage.add([left + i64::from(x), top + i64::from(y)], part));
    }
}

/// The font at a size.
struct Scaled(PxScaleFont<FontRef<'static>>);

impl Scaled {
    fn new(size_pixels: f32) -> Self {
        let font = FontRef::try_from_slice(FONT).expect("the bundled font can be read");
        // The crate's scale is the height of a line.
        let em = font.units_per_em().expect("the bundled font has an em");
        let scale = PxScale::from(size_pixels * font.height_unscaled() / em);
        Self(font.into_scaled(scale))
    }

    /// Glyphs with their places on a baseline that begins at 0, and where it ends.
    fn glyphs(&self, text: &str) -> (Vec<Glyph>, f32) {
        let font = &self.0;
        let (mut x, mut before) = (0.0, None);
        let mut glyphs = Vec::new();
        for c in text.chars() {
            let id = font.glyph_id(if c.is_control() { ' ' } else { c });
            x += before.map_or(0.0, |before| font.kern(before, id));
            glyphs.push(id.with_scale_and_position(font.scale(), point(x, 0.0)));
            x += font.h_advance(id);
            before = Some(id);
        }
        (glyphs, x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRAY: [f32; 4] = [0.5, 0.5, 0.5, 1.0];

    fn drawn(label: Label<'_>) -> Image {
        let mut image = Image::filled(120, 60, GRAY);
        draw_text(&mut image, &label);
        image
    }

    fn label(text: &str) -> Label<'_> {
        Label { text, at: [60.0, 30.0], anchor: [0.5, 0.5], size_pixels: 20.0, ink: Ink::LIGHT }
    }

    /// Least and largest column and row of what is lighter than `least`.
    fn extent(image: &Image, least: f32) -> Option<[[u32; 2]; 2]> {
        let width = image.width() as usize;
        let lit = image.pixels().iter().enumerate().filter(|(_, pixel)| least < pixel[0]);
        lit.map(|(idx, _)| [(idx % width) as u32, (idx / width) as u32]).fold(None, |ends, at| {
            let [min, max] = ends.unwrap_or([at, at]);
            Some([[0, 1].map(|i| min[i].min(at[i])), [0, 1].map(|i| max[i].max(at[i]))])
        })
    }

    #[test]
    fn text_is_where_its_anchor_is() {
        let [width, height] = measure_text("HHH", 20.0);
        assert!(
            (40.0..50.0).contains(&width) && (20.0..26.0).contains(&height),
            "{width} {height}"
        );
        let [min, max] = extent(&drawn(label("HHH")), 0.8).unwrap();
        assert!((min[0] as f32 - (60.0 - width / 2.0)).abs() < 4.0, "{min:?}");
        assert!((max[0] as f32 - (60.0 + width / 2.0)).abs() < 4.0, "{max:?}");
        // Of 20 pixels an em, a capital letter takes 14 or 15 rows.
        assert!((14..=16).contains(&(max[1] - min[1] + 1)), "{min:?} {max:?}");
        let [upper, _] = extent(&drawn(Label { anchor: [0.0, 1.0], ..label("HHH") }), 0.8).unwrap();
        assert!(60 <= upper[0] && upper[1] + 12 < min[1] + 1, "{upper:?}");
    }

    #[test]
    fn text_has_a_halo_and_is_whole_at_its_middle() {
        let image = drawn(label("H"));
        assert!(image.pixels().contains(&[1.0; 4]), "ink");
        assert!(image.pixels().iter().any(|pixel| pixel[0] < 0.05), "halo");
        let mut clear = Image::filled(120, 60, [0.0; 4]);
        draw_text(&mut clear, &label("H"));
        for [r, g, b, a] in clear.pixels() {
            assert!(0.0 <= *r && r == g && g == b && *r <= *a && *a <= 1.0, "premultiplied");
        }
        assert_eq!(clear.pixel(0, 0), [0.0; 4]);
    }

    #[test]
    fn text_is_cut_off_at_the_edges() {
        let long = "x".repeat(3000);
        for (text, at) in [(&*long, [60.0, 30.0]), ("abc", [-5.0, -3.0]), ("abc", [121.0, 66.0])] {
            assert!(
                drawn(Label { at, ..label(text) }) != Image::filled(120, 60, GRAY),
                "{text} {at:?}"
            );
        }
        for at in [[-500.0, 30.0], [60.0, 1e30], [f32::NAN; 2], [f32::INFINITY; 2]] {
            assert!(drawn(Label { at, ..label("abc") }) == Image::filled(120, 60, GRAY), "{at:?}");
        }
        // A letter of 10¹⁰ pixels a side has more than can be counted.
        for size_pixels in [0.0, -4.0, 1e5, 1e10, f32::MAX, f32::NAN, f32::INFINITY] {
            let image = drawn(Label { size_pixels, ..label("abc") });
            assert!(image == Image::filled(120, 60, GRAY), "{size_pixels}");
        }
        let mut dot = Image::filled(1, 1, GRAY);
        draw_text(&mut dot, &Label { at: [0.5, 0.5], size_pixels: 400.0, ..label("I") });
        assert_eq!(dot.pixel(0, 0), [1.0; 4], "a pixel within the letter");
    }

    #[test]
    fn text_of_science_is_in_the_font() {
        assert_eq!(lacks("µm Å 10⁻³ ×±° αβγ Ж é ñ ü ß Ł – — … ’ ≤ → −\n"), [] as [char; 0]);
        assert_eq!(lacks("a漢b字漢"), ['漢', '字']);
        assert!(drawn(label("漢")) != Image::filled(120, 60, GRAY), "a box is drawn");
    }

    #[test]
    fn text_kerns_and_adds_up() {
        let width = |text: &str| measure_text(text, 20.0)[0];
        assert!(width("AV") < width("A") + width("V"));
        assert_eq!(width(""), 0.0);
        assert!((measure_text("mm", 40.0)[0] - 2.0 * width("mm")).abs() < 1e-3);
        assert_eq!(width("a\nb"), width("a b"));
    }

    #[test]
    fn text_size_suits_the_picture() {
        assert_eq!(text_size(240, 240), 11.0);
        assert_eq!(text_size(4000, 4000), 100.0);
        assert_eq!(text_size(3000, 200), 10.0);
        assert_eq!(text_size(60, 60), 9.0);
    }
}
