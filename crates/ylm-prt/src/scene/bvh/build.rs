//! obvhs builds a binary hierarchy; this collapses it to nodes of eight children.

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, SortPrecision};

use super::Bvh;
use super::lanes::Isa;
use super::node::{LEAF, MAX_DEPTH, Node, TriangleBlock, WIDTH};
use super::traverse::power_of_two_below;

/// Levels of collapsed nodes before what is left is divided evenly instead; seven more then hold 2^31 triangles even
/// with blocks of one.
const MAX_COLLAPSED_DEPTH: usize = MAX_DEPTH - 12;

/// How many neighbours along the Morton curve a cluster looks at for its partner.
const SEARCH_DISTANCE: usize = 14;

/// Leaves of the binary hierarchy hold so many at most; half a block, so that leaves can share one.
const MAX_TRIANGLES_PER_LEAF: u32 = 4;

/// Builds nodes and blocks of a mesh.
pub fn build(positions: &[Vec3], triangles: &[[u32; 3]]) -> Bvh {
    let extent = positions.iter().fold(0.0f32, |extent, p| extent.max(p.abs().max_element()));
    let scale = if extent > 0.0 { power_of_two_below(1.0 / extent) } else { 1.0 };
    let corners = Corners { positions, triangles, scale };
    let binary = binary(corners);
    let mut collapse = Collapse::new(&binary, corners);
    if triangles.is_empty() {
        collapse.nodes.push(Node::EMPTY);
    } else {
        collapse.node(Subtree::Binary(0), 0);
    }
    let Collapse { nodes, blocks, .. } = collapse;
    Bvh { nodes, blocks, scale, diagonal: diagonal(positions, scale), isa: Isa::best() }
}

/// The binary hierarchy: what [`obvhs::bvh2::builder::build_bvh2`] does at `very_slow_build`, with the memory of each
/// step freed before the next, no boxes beside the leaves, and codes of 21 bits an axis to sort them by.
fn binary(corners: Corners) -> Bvh2 {
    let count = corners.triangles.len();
    let mut binary = Bvh2::zeroed(0);
    if count == 0 {
        return binary;
    }
    binary.primitive_indices = (0..count as u32).collect();
    let mut builder = PlocBuilder::new();
    let mut total = Aabb::empty();
    builder.current_nodes = (0..count)
        .map(|i| {
            let aabb = Aabb::from_points(&corners.of(i));
            total = total.union(&aabb);
            Bvh2Node::new(aabb, 1, i as u32)
        })
        .collect();
    builder.build_ploc_from_leaves::<SEARCH_DISTANCE, false>(&mut binary, total, SortPrecision::U64, 1);
    drop(builder);
    ReinsertionOptimizer::default().run(&mut binary, 1.0, None);
    collapse(&mut binary, MAX_TRIANGLES_PER_LEAF, 1.0);
    ReinsertionOptimizer::default().run(&mut binary, 1.0, None);
    binary.parents = Vec::new();
    binary
}

/// The diagonal of the positions' bounding box, times `scale`.
pub fn diagonal(positions: &[Vec3], scale: f32) -> f32 {
    let (low, high) = positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| {
        let p = p * scale;
        (low.min(p), high.max(p))
    });
    if positions.is_empty() { 0.0 } else { (high - low).length() }
}

/// The mesh in the coordinates of the nodes.
#[derive(Clone, Copy)]
struct Corners<'a> {
    positions: &'a [Vec3],
    triangles: &'a [[u32; 3]],
    scale: f32,
}

impl Corners<'_> {
    fn of(&self, triangle: usize) -> [Vec3A; 3] {
        self.triangles[triangle].map(|i| Vec3A::from(self.positions[i as usize] * self.scale))
    }
}

/// Part of the scene that becomes one child.
#[derive(Clone, Copy)]
enum Subtree<'a> {
    /// Below a node of the binary hierarchy.
    Binary(u32),
    /// A list of triangles, where the binary hierarchy was too deep.
    List(&'a [u32]),
}

struct Collapse<'a> {
    binary: &'a Bvh2,
    corners: Corners<'a>,
    /// Triangles below each binary node.
    counts: Vec<u32>,
    nodes: Vec<Node>,
    blocks: Vec<TriangleBlock>,
}

impl<'a> Collapse<'a> {
    fn new(binary: &'a Bvh2, corners: Corners<'a>) -> Self {
        let counts = triangle_counts(binary);
        // Room for all blocks, and for the nodes of most scenes: to grow, storage of this alignment is copied, which
        // would be the peak of the whole bake. What stays empty is never touched, and so takes no memory.
        let leaf_count = binary.nodes.iter().filter(|node| node.is_leaf()).count();
        let (nodes, blocks) = (Vec::with_capacity(leaf_count / 3 + 1), Vec::with_capacity(leaf_count));
        Self { binary, corners, counts, nodes, blocks }
    }

    /// Makes a node of `subtree` and everything below it; returns its index.
    fn node(&mut self, subtree: Subtree, depth: usize) -> u32 {
        let index = self.nodes.len();
        self.nodes.push(Node::EMPTY);
        let mut list = Vec::new();
        let subtree = match subtree {
            Subtree::Binary(root) if depth >= MAX_COLLAPSED_DEPTH => {
                self.gather(root, &mut list);
                Subtree::List(&list)
            }
            other => other,
        };
        let children = match subtree {
            Subtree::Binary(root) => self.open(root).into_iter().map(Subtree::Binary).collect(),
            Subtree::List(list) => {
                list.chunks(list.len().div_ceil(WIDTH)).map(Subtree::List).collect::<Vec<_>>()
            }
        };
        for (lane, child) in children.into_iter().enumerate() {
            let (low, high) = self.bounds(child);
            let child =
                if self.count(child) <= WIDTH { self.block(child) } else { self.node(child, depth + 1) };
            let node = &mut self.nodes[index];
            for axis in 0..3 {
                node.bounds[axis][lane] = low[axis];
                node.bounds[axis + 3][lane] = high[axis];
            }
            node.children[lane] = child;
            node.child_count += 1;
        }
        index as u32
    }

    /// Up to eight binary nodes that together hold what `root` holds: the largest is opened as long as there is room,
    /// those that fill more than one block first.
    fn open(&self, root: u32) -> Vec<u32> {
        let nodes = &self.binary.nodes;
        let mut open = vec![root];
        while open.len() < WIDTH {
            let largest = (0..open.len()).filter(|&i| !nodes[open[i] as usize].is_leaf()).max_by(|&i, &j| {
                let key = |i: usize| {
                    let node = open[i] as usize;
                    (self.counts[node] as usize > WIDTH, nodes[node].aabb().half_area())
                };
                let ((large_i, area_i), (large_j, area_j)) = (key(i), key(j));
                large_i.cmp(&large_j).then(area_i.total_cmp(&area_j))
            });
            let Some(largest) = largest else { break };
            let first = nodes[open[largest] as usize].first_index;
            open[largest] = first;
            open.push(first + 1);
        }
        open
    }

    /// Makes a block of a subtree of at most eight triangles.
    fn block(&mut self, subtree: Subtree) -> u32 {
        let mut gathered = Vec::new();
        let list = match subtree {
            Subtree::Binary(root) => {
                self.gather(root, &mut gathered);
                &gathered
            }
            Subtree::List(list) => list,
        };
        let mut block = TriangleBlock::EMPTY;
        for (lane, &triangle) in list.iter().enumerate() {
            for (corner, position) in self.corners.of(triangle as usize).into_iter().enumerate() {
                for axis in 0..3 {
                    block.corners[3 * corner + axis][lane] = position[axis];
                }
            }
            block.triangles[lane] = triangle;
        }
        self.blocks.push(block);
        LEAF | (self.blocks.len() - 1) as u32
    }

    fn count(&self, subtree: Subtree) -> usize {
        match subtree {
            Subtree::Binary(root) => self.counts[root as usize] as usize,
            Subtree::List(list) => list.len(),
        }
    }

    fn bounds(&self, subtree: Subtree) -> (Vec3A, Vec3A) {
        match subtree {
            Subtree::Binary(root) => {
                let aabb = self.binary.nodes[root as usize].aabb();
                (aabb.min, aabb.max)
            }
            Subtree::List(list) => {
                list.iter().fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(low, high), &i| {
                    let aabb = Aabb::from_points(&self.corners.of(i as usize));
                    (low.min(aabb.min), high.max(aabb.max))
                })
            }
        }
    }

    /// Appends the triangles below a binary node.
    fn gather(&self, root: u32, list: &mut Vec<u32>) {
        let mut stack = vec![root];
        while let Some(index) = stack.pop() {
            let node = &self.binary.nodes[index as usize];
            let first = node.first_index;
            if node.is_leaf() {
                let range = first as usize..(first + node.prim_count) as usize;
                list.extend_from_slice(&self.binary.primitive_indices[range]);
            } else {
                stack.extend([first + 1, first]);
            }
        }
    }
}

/// Triangles below each node of a binary hierarchy, however deep it is.
fn triangle_counts(binary: &Bvh2) -> Vec<u32> {
    let mut counts = vec![0; binary.nodes.len()];
    let mut stack = if binary.nodes.is_empty() { vec![] } else { vec![0u32] };
    while let Some(&index) = stack.last() {
        let node = &binary.nodes[index as usize];
        let first = node.first_index as usize;
        if node.is_leaf() {
            counts[index as usize] = node.prim_count;
        } else if counts[first] == 0 {
            stack.extend([first as u32, first as u32 + 1]);
            continue;
        } else {
            counts[index as usize] = counts[first] + counts[first + 1];
        }
        stack.pop();
    }
    counts
}
