//! The colours of what is drawn.

/// A colour, and that of the halo which sets it off.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "a text has these two colours")]
pub struct Ink {
    /// Red, green and blue, 0 … 1.
    pub color: [f32; 3],
    /// The same of the halo.
    pub halo: [f32; 3],
}

impl Ink {
    /// For dark pictures, and for those whose background nobody knows.
    pub const LIGHT: Self = Self { color: [1.0; 3], halo: [0.0; 3] };

    /// For light pictures.
    pub const DARK: Self = Self { color: [0.05; 3], halo: [1.0; 3] };

    /// What is legible before a premultiplied background: light before what is transparent.
    pub fn on([r, g, b, a]: [f32; 4]) -> Self {
        // Rec. 709's weights; half of it in 8-bit numbers is what people call half as light.
        let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        if 0.5 * a.max(0.5) < luminance { Self::DARK } else { Self::LIGHT }
    }

    /// Another colour with the same halo.
    #[must_use]
    pub fn colored(self, color: [f32; 3]) -> Self {
        Self { color, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ink_contrasts() {
        assert_eq!(Ink::on([0.0, 0.0, 0.0, 1.0]), Ink::LIGHT);
        assert_eq!(Ink::on([0.0; 4]), Ink::LIGHT);
        assert_eq!(Ink::on([1.0; 4]), Ink::DARK);
        assert_eq!(Ink::on([0.1, 0.1, 0.6, 1.0]), Ink::LIGHT, "navy");
        assert_eq!(Ink::on([0.9, 0.9, 0.1, 1.0]), Ink::DARK, "yellow");
    }
}
