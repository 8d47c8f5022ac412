//! How the triangles of a mesh hang together.

use glam::Vec3;

use crate::scene::mesh::Mesh;
use crate::scene::normals::triangle_normal;

/// Counts that tell whether a mesh is sound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Topology {
    /// Positions.
    pub vertex_count: usize,
    /// Triangles.
    pub triangle_count: usize,
    /// Positions that no triangle uses.
    pub unused_vertex_count: usize,
    /// Positions that are equal to one before them.
    pub duplicate_position_count: usize,
    /// Triangles without area.
    pub degenerate_triangle_count: usize,
    /// Triangles with the same three corners, in any order, as one before them.
    pub duplicate_triangle_count: usize,
    /// Edges of one triangle.
    pub boundary_edge_count: usize,
    /// Edges of more than two triangles.
    pub non_manifold_edge_count: usize,
    /// Parts without a common vertex.
    pub component_count: usize,
}

impl Topology {
    /// Counts over a mesh's triangles; vertices are the same if their indices are.
    ///
    /// Where a file has a vertex for each normal, as glTF files do, count over [`Mesh::welded`] to learn whether the
    /// surface is closed.
    ///
    /// Cost: O(t log t) for t triangles.
    pub fn of(mesh: &Mesh) -> Self {
        let vertex_count = mesh.positions.len();
        let mut is_used = vec![false; vertex_count];
        for &i in mesh.triangles.as_flattened() {
            is_used[i as usize] = true;
        }
        let has_area = |corners: &&[u32; 3]| triangle_normal(&mesh.positions, **corners).is_some();
        let mut faces: Vec<[u32; 3]> = mesh.triangles.clone();
        faces.iter_mut().for_each(|corners| corners.sort_unstable());
        let (boundary_edge_count, non_manifold_edge_count) = count_edges(&mesh.triangles);
        Self {
            vertex_count,
            triangle_count: mesh.triangles.len(),
            unused_vertex_count: is_used.iter().filter(|&&used| !used).count(),
            duplicate_position_count: duplicates(mesh.positions.iter().map(|&p| position_key(p)).collect()),
            degenerate_triangle_count: mesh.triangles.len() - mesh.triangles.iter().filter(has_area).count(),
            duplicate_triangle_count: duplicates(faces),
            boundary_edge_count,
            non_manifold_edge_count,
            component_count: count_components(mesh, &is_used),
        }
    }

    /// Whether the triangles have no border.
    pub fn is_closed(&self) -> bool {
        self.triangle_count > 0 && self.boundary_edge_count == 0
    }
}

impl Mesh {
    /// The mesh with one vertex for all that have equal positions; without normals and materials.
    pub fn welded(&self) -> Mesh {
        let mut order: Vec<u32> = (0..self.positions.len() as u32).collect();
        let key = |i: u32| position_key(self.positions[i as usize]);
        order.sort_by_key(|&i| (key(i), i));
        let mut first_of = vec![0; order.len()];
        for same in order.chunk_by(|&a, &b| key(a) == key(b)) {
            for &i in same {
                first_of[i as usize] = same[0];
            }
        }
        let mut positions = Vec::new();
        let mut new_index = vec![0; order.len()];
        for (i, &position) in self.positions.iter().enumerate() {
            if first_of[i] as usize == i {
                new_index[i] = positions.len() as u32;
                positions.push(position);
            }
        }
        let triangles = self.triangles.iter();
        let triangles =
            triangles.map(|corners| corners.map(|i| new_index[first_of[i as usize] as usize])).collect();
        Mesh { positions, triangles, ..Mesh::default() }
    }
}

/// Bits that equal positions share.
fn position_key(position: Vec3) -> [u32; 3] {
    // 0 + −0 = 0.
    (position + Vec3::ZERO).to_array().map(f32::to_bits)
}

/// How many items are equal to one before them.
fn duplicates<T: Ord>(mut items: Vec<T>) -> usize {
    items.sort_unstable();
    items.windows(2).filter(|pair| pair[0] == pair[1]).count()
}

/// The edges of one triangle, and those of more than two. A triangle with a repeated index has fewer than three edges.
fn count_edges(triangles: &[[u32; 3]]) -> (usize, usize) {
    let mut edges: Vec<[u32; 2]> = Vec::with_capacity(3 * triangles.len());
    for &[a, b, c] in triangles {
        edges.extend(
            [[a, b], [b, c], [c, a]].iter().filter(|[a, b]| a != b).map(|&[a, b]| [a.min(b), a.max(b)]),
        );
    }
    edges.sort_unstable();
    let runs = edges.chunk_by(|a, b| a == b).map(<[_]>::len);
    runs.fold((0, 0), |(one, many), run| (one + usize::from(run == 1), many + usize::from(run > 2)))
}

/// The parts that the triangles fall into, by union and find with halved paths.
fn count_components(mesh: &Mesh, is_used: &[bool]) -> usize {
    fn find(parents: &mut [u32], mut i: u32) -> u32 {
        while parents[i as usize] != i {
            parents[i as usize] = parents[parents[i as usize] as usize];
            i = parents[i as usize];
        }
        i
    }
    let mut parents: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    for &[a, b, c] in &mesh.triangles {
        for (a, b) in [(a, b), (b, c)] {
            let (a, b) = (find(&mut parents, a), find(&mut parents, b));
            // The smaller index becomes the root, so that the answer does not depend on the order of triangles.
            parents[a.max(b) as usize] = a.min(b);
        }
    }
    (0..parents.len()).filter(|&i| is_used[i] && parents[i] as usize == i).count()
}
