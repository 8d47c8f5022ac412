//! What a bake is asked to do.

use ylm::Bands;

/// What may stand between a point and the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TransferKind {
    /// Nothing: the clamped cosine in closed form.
    Unshadowed,
    /// The scene itself, found by rays.
    Shadowed,
}

impl TransferKind {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Unshadowed, Self::Shadowed];

    /// The name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unshadowed => "unshadowed",
            Self::Shadowed => "shadowed",
        }
    }

    /// The inverse of [`TransferKind::name`].
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

/// What a bake is asked to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeSettings {
    /// Bands of the transfer.
    pub bands: Bands,
    /// What may block light.
    pub kind: TransferKind,
    /// Rays a lighting point, any number but 0. Not used without shadows.
    pub rays: u32,
    /// Draws the sample sets and who gets which.
    pub seed: u64,
    /// How far along the normal rays start, in diagonals of the lit surface's bounding box.
    ///
    /// [`BakeSettings::BIAS`] is a hundred roundings of the coordinates of a scene around the origin, and less than a
    /// tenth of an edge of meshes of up to ten million triangles. More is needed where surfaces lie on one another.
    pub bias: f32,
    /// How far from their start rays end, in the world's units: what is farther does not block. Infinity for no end.
    pub t_max: f32,
}

impl BakeSettings {
    /// Default of [`BakeSettings::bias`].
    pub const BIAS: f32 = 1e-5;
}
