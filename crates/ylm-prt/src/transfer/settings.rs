//! What a bake is asked to do.

use ylm::Bands;

/// What may stand between a point and the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TransferKind {
    /// Nothing: the clamped cosine in closed form.
    Unshadowed,
    /// The scene itself, found by rays.
    Shadowed,
    /// The scene itself, which also reflects light and sends out its own.
    Interreflected,
}

impl TransferKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Unshadowed, Self::Shadowed, Self::Interreflected];

    /// The name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unshadowed => "unshadowed",
            Self::Shadowed => "shadowed",
            Self::Interreflected => "interreflected",
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
    /// How often light bounces. Not used but for interreflected transfer.
    pub bounces: Bounces,
    /// Whether plain visibility is baked beside the transfer.
    pub visibility: bool,
}

/// How often light bounces, and what is kept of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounces {
    /// When it ends.
    pub end: BounceEnd,
    /// What is stored.
    pub kept: KeptBounces,
    /// Memory for the hits that are remembered from the direct pass, in bytes; where it does not suffice, rays are
    /// traced again for each bounce, to the same result.
    pub memory_bytes: usize,
}

/// When light has bounced often enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BounceEnd {
    /// After so many bounces.
    Count(u32),
    /// After the first bounce whose energy is below this share of that of the direct light, but after
    /// [`Bounces::MAX_COUNT`] at the latest.
    Energy(f32),
}

/// What is stored of bounced light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KeptBounces {
    /// The sum over all bounces.
    #[default]
    Sum,
    /// Each bounce by itself, to look at: as many times the memory.
    Each,
}

impl Bounces {
    /// Most bounces.
    pub const MAX_COUNT: u32 = 256;
    /// Default of [`BounceEnd::Energy`].
    pub const ENERGY: f32 = 1e-3;
    /// Default of [`Bounces::memory_bytes`]: 4 GB.
    pub const MEMORY_BYTES: usize = 4_000_000_000;
}

impl Default for Bounces {
    fn default() -> Self {
        Self {
            end: BounceEnd::Energy(Self::ENERGY),
            kept: KeptBounces::default(),
            memory_bytes: Self::MEMORY_BYTES,
        }
    }
}

/// Shadowed transfer of 5 bands with 1024 rays a point.
impl Default for BakeSettings {
    fn default() -> Self {
        Self {
            bands: Bands::new(5).expect("in range"),
            kind: TransferKind::Shadowed,
            rays: 1024,
            seed: 0,
            bias: Self::BIAS,
            t_max: f32::INFINITY,
            bounces: Bounces::default(),
            visibility: false,
        }
    }
}

impl BakeSettings {
    /// Default of [`BakeSettings::bias`].
    pub const BIAS: f32 = 1e-5;
}
