//! What is known of a volume beside its values: which machine made it, and how it stands in the world.

/// What whoever made a volume says of it. Nothing of it changes a pixel; what is found for a volume that
/// nobody has described ([`Viewpoint`](crate::Viewpoint), colours) depends on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Acquisition {
    /// What measured it, if that is known.
    pub modality: Option<Modality>,
    /// What the axes of the world are.
    pub orientation: Orientation,
    /// Whether lengths in the world are millimetres. Otherwise nobody says what they are.
    pub is_metric: bool,
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
pub enum Orientation {
    /// Nobody says: x goes to the right and y to the back of what stands on an end of z.
    #[default]
    Unknown,
    /// Those of a body, RAS+: x to its right, y to its front, z to its head.
    Anatomical,
    /// Those of pictures, one behind the other: x to the right, y *down* the rows, z to the next picture.
    Pictures,
}
