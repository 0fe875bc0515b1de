//! What is known of a volume beside its values: which machine made it, and how it stands in the world.

use crate::choices::named;

/// What whoever made a volume says of it. Nothing of it changes a pixel; what is found for a volume that
/// nobody has described ([`Viewpoint`](crate::Viewpoint), colours) depends on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Acquisition {
    /// What measured it, if that is known.
    pub modality: Option<Modality>,
    /// What the axes of the world are.
    pub orientation: Orientation,
    /// Whether lengths in the world are millimetres. Otherwise nobody says what they are.
    pub is_metric: bool,
}

impl Acquisition {
    /// Nobody says anything, as by default.
    pub const UNKNOWN: Self =
        Self { modality: None, orientation: Orientation::Unknown, is_metric: false };

    /// The same, measured by that.
    #[must_use]
    pub const fn modality(self, modality: Modality) -> Self {
        Self { modality: Some(modality), ..self }
    }

    /// The same with axes of that meaning.
    #[must_use]
    pub const fn orientation(self, orientation: Orientation) -> Self {
        Self { orientation, ..self }
    }

    /// The same with lengths in millimetres.
    #[must_use]
    pub const fn metric(self) -> Self {
        Self { is_metric: true, ..self }
    }
}

/// What measured a volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Modality {
    /// Computed tomography.
    Ct,
    /// Magnetic resonance.
    Mr,
    /// A light microscope or an electron microscope.
    Microscopy,
}

/// What the axes of the world are to what is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[expect(clippy::exhaustive_enums, reason = "who draws or frames a volume has to know each")]
pub enum Orientation {
    /// Nobody says: x goes to the right and y to the back of what stands on an end of z.
    #[default]
    Unknown,
    /// Those of a body, RAS+: x to its right, y to its front, z to its head.
    Anatomical,
    /// Those of pictures, one behind the other: x to the right, y *down* the rows, z to the next picture.
    Pictures,
}

named!(Modality { Ct = "ct", Mr = "mr", Microscopy = "microscopy" });
named!(Orientation { Unknown = "unknown", Anatomical = "anatomical", Pictures = "pictures" });
