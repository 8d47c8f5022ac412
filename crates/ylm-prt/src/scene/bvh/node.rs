//! What the hierarchy is made of: inner nodes of eight boxes, leaf blocks of eight triangles.

/// Children of an inner node, and triangles of a leaf block.
pub const WIDTH: usize = 8;

/// Flag of a child that is a leaf block.
pub const LEAF: u32 = 1 << 31;

/// Most levels of inner nodes; bounds the traversal's stack.
pub const MAX_DEPTH: usize = 56;

/// Entries that the traversal's stack needs at most: every node leaves all children but one behind.
pub const STACK: usize = MAX_DEPTH * (WIDTH - 1) + WIDTH;

/// Eight boxes and what is in them.
///
/// A missing child has the empty box (+∞, −∞), which no ray meets.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
pub struct Node {
    /// Low x, y, z, then high x, y, z of the children.
    pub bounds: [[f32; WIDTH]; 6],
    /// Index of a node, or [`LEAF`] and index of a block.
    pub children: [u32; WIDTH],
    /// How many children there are; they stand first.
    pub child_count: u32,
}

impl Node {
    /// No child.
    pub const EMPTY: Self = {
        let (low, high) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
        Self { bounds: [low, low, low, high, high, high], children: [0; WIDTH], child_count: 0 }
    };
}

/// Eight triangles, corner by corner. A missing one has all corners at 0 and so no area.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
pub struct TriangleBlock {
    /// x, y, z of the first corner, of the second, of the third.
    pub corners: [[f32; WIDTH]; 9],
    /// Index of each triangle.
    pub triangles: [u32; WIDTH],
}

impl TriangleBlock {
    /// No triangle.
    pub const EMPTY: Self = Self { corners: [[0.0; WIDTH]; 9], triangles: [u32::MAX; WIDTH] };

    /// Whether triangle `lane` has a corner exactly at `corner`.
    pub fn touches(&self, lane: usize, corner: [f32; 3]) -> bool {
        self.corners.chunks_exact(3).any(|xyz| (0..3).all(|axis| xyz[axis][lane] == corner[axis]))
    }
}
