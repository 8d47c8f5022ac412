//! Which lighting points are joined by an edge.

/// The neighbours of each point over the triangles' edges.
///
/// Points at one position with different normals have no edge between them: a crease is a border.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Neighbours {
    /// Where the list of each point starts in `list`, and where the last one ends.
    starts: Vec<u32>,
    list: Vec<u32>,
}

impl Neighbours {
    /// Of `point_count` points; each list rises, and names a point once.
    ///
    /// Cost: O(t log t) for t triangles.
    pub fn of(point_count: usize, triangles: &[[u32; 3]]) -> Self {
        let mut edges: Vec<[u32; 2]> = Vec::with_capacity(6 * triangles.len());
        for &[a, b, c] in triangles {
            edges.extend([[a, b], [b, a], [b, c], [c, b], [c, a], [a, c]].iter().filter(|[a, b]| a != b));
        }
        edges.sort_unstable();
        edges.dedup();
        let mut starts = vec![0; point_count + 1];
        for [from, _] in &edges {
            starts[*from as usize + 1] += 1;
        }
        for i in 0..point_count {
            starts[i + 1] += starts[i];
        }
        Self { starts, list: edges.into_iter().map(|[_, to]| to).collect() }
    }

    /// The neighbours of a point.
    pub fn around(&self, point: u32) -> &[u32] {
        let [start, end] = [point, point + 1].map(|i| self.starts[i as usize] as usize);
        &self.list[start..end]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_neighbours_of_those_that_they_share_an_edge_with() {
        // Two triangles with a common edge, one with a corner twice, and a point without a triangle.
        let neighbours = Neighbours::of(6, &[[0, 1, 2], [2, 1, 3], [4, 4, 0]]);
        let expected: [&[u32]; 6] = [&[1, 2, 4], &[0, 2, 3], &[0, 1, 3], &[1, 2], &[0], &[]];
        for (point, expected) in expected.iter().enumerate() {
            assert_eq!(neighbours.around(point as u32), *expected);
        }
        assert_eq!(Neighbours::of(0, &[]), Neighbours { starts: vec![0], list: Vec::new() });
    }
}
