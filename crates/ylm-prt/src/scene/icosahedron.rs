//! The regular solid that spheres are cut from.

use glam::Vec3;

/// The twelve corners of an icosahedron, of unit length, and its twenty faces, wound outwards.
pub fn icosahedron() -> ([Vec3; 12], [[usize; 3]; 20]) {
    let golden = 0.5 * (1.0 + 5.0f32.sqrt());
    let corners: [Vec3; 12] = std::array::from_fn(|corner| {
        let (a, b) = [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)][corner % 4];
        [Vec3::new(a, b, 0.0), Vec3::new(0.0, a, b), Vec3::new(b, 0.0, a)][corner / 4].normalize()
    });
    // Neighbours have cosine 1/√5, the next nearest −1/√5.
    let near = |i: usize, j: usize| corners[i].dot(corners[j]) > 0.0;
    let mut triangles = [[0; 3]; 20];
    let mut count = 0;
    for i in 0..corners.len() {
        for j in i + 1..corners.len() {
            for k in (j + 1..corners.len()).filter(|&k| near(i, j) && near(j, k) && near(i, k)) {
                let [a, b, c] = [i, j, k].map(|corner| corners[corner]);
                let is_outwards = (b - a).cross(c - a).dot(a) > 0.0;
                triangles[count] = if is_outwards { [i, j, k] } else { [i, k, j] };
                count += 1;
            }
        }
    }
    (corners, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_corner_has_five_faces_of_equal_edges() {
        let (corners, triangles) = icosahedron();
        for corner in 0..12 {
            assert_eq!(triangles.iter().flatten().filter(|&&at| at == corner).count(), 5);
        }
        for [a, b, c] in triangles {
            let edges = [(a, b), (b, c), (c, a)].map(|(from, to)| corners[from].distance(corners[to]));
            // 4/√(10 + 2√5)
            assert!(edges.iter().all(|edge| (edge - 1.051_462_2).abs() <= 1e-6), "{edges:?}");
        }
    }
}
