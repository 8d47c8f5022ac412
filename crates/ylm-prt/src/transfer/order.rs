//! Orders in which neighbours in space stand near one another, so that their rays find the same nodes in the cache.

use glam::Vec3;

/// Indices of points along a Morton curve through their bounding box.
pub fn by_morton_code(points: &[Vec3]) -> Vec<u32> {
    let (low, high) =
        points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
    // Halves, so that the extent of any finite box is finite.
    let extent = (0.5 * high - 0.5 * low).max_element();
    let cell = |p: Vec3| ((0.5 * p - 0.5 * low) / extent * 1023.0).to_array();
    let mut keyed: Vec<(u32, u32)> = points
        .iter()
        .enumerate()
        .map(|(i, &p)| {
            let [x, y, z] = cell(p).map(|c| spread3(c as u32));
            (x | y << 1 | z << 2, i as u32)
        })
        .collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, i)| i).collect()
}

/// Puts two zeros between the lowest ten bits.
fn spread3(x: u32) -> u32 {
    let mut x = x & 0x3ff;
    for (shift, mask) in [(16, 0x0300_00ff), (8, 0x0300_f00f), (4, 0x030c_30c3), (2, 0x0924_9249)] {
        x = (x | x << shift) & mask;
    }
    x
}

/// Place of a point of the square [−1, 1]² along a Hilbert curve.
///
/// [Warren 2012] "Hacker's Delight", 16-2
pub fn hilbert_code(x: f32, y: f32) -> u32 {
    const BITS: u32 = 12;
    let cell = |v: f32| ((0.5 + 0.5 * v) * (1 << BITS) as f32).clamp(0.0, ((1 << BITS) - 1) as f32) as u32;
    let (mut x, mut y) = (cell(x), cell(y));
    let mut code = 0;
    for bit in (0..BITS).rev() {
        let (right, up) = (x >> bit & 1, y >> bit & 1);
        code = code << 2 | ((3 * right) ^ up);
        if up == 0 {
            if right == 1 {
                (x, y) = (!x, !y);
            }
            (x, y) = (y, x);
        }
    }
    code
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hilbert_curve_visits_neighbours_one_after_the_other() {
        let at = |i: u32, j: u32| hilbert_code((i as f32 + 0.5) / 8.0 - 1.0, (j as f32 + 0.5) / 8.0 - 1.0);
        let mut cells: Vec<(u32, u32, u32)> =
            (0..16).flat_map(|i| (0..16).map(move |j| (at(i, j), i, j))).collect();
        cells.sort_unstable();
        for pair in cells.windows(2) {
            let distance = pair[0].1.abs_diff(pair[1].1) + pair[0].2.abs_diff(pair[1].2);
            assert_eq!(distance, 1, "{pair:?}");
        }
    }

    #[test]
    fn an_order_names_every_point_once() {
        let points: Vec<Vec3> =
            (0..1000).map(|i| Vec3::new((i % 7) as f32, (i % 31) as f32, i as f32) * 1e37).collect();
        for points in [&points[..], &points[..1], &[], &[Vec3::ONE; 5]] {
            let mut order = by_morton_code(points);
            order.sort_unstable();
            assert!(order.into_iter().eq(0..points.len() as u32));
        }
    }
}
