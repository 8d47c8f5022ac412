//! Scrambled Sobol points in the unit square.

/// The first two dimensions of Sobol's sequence under Owen's nested scrambling, which `seed` draws.
///
/// Any 2^k points from the start are a (0, k, 2)-net: one in each of the dyadic boxes of area 2^−k. Different seeds are
/// independent, and each point alone is uniform, so that means over a sequence are unbiased.
/// [Burley 2020] "Practical Hash-based Owen Scrambling", with the hash of [Vegdahl 2021] "Building a Better LK Hash"
pub(super) fn point(index: u32, seed: u64) -> [f32; 2] {
    let mut second = 0;
    let mut direction = 1u32 << 31;
    let mut bits = index;
    while bits != 0 {
        if bits & 1 == 1 {
            second ^= direction;
        }
        bits >>= 1;
        direction ^= direction >> 1;
    }
    let scrambled = [scramble(index.reverse_bits(), seed as u32), scramble(second, (seed >> 32) as u32)];
    // 24 bits are what an f32 below 1 holds.
    scrambled.map(|bits| (bits >> 8) as f32 / (1u32 << 24) as f32)
}

/// As [`point`], from another place of the sequence for each seed: for a further dimension of samples that already have
/// others, which the same index in both would tie together.
pub(super) fn further_point(index: u32, seed: u64) -> [f32; 2] {
    // A permutation within every power of two, so that as many points are a net as before.
    point(scramble(index, (seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as u32), seed)
}

/// Flips each bit by a hash of those above it.
fn scramble(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// A seed of its own for each stream of each point. [Steele 2014] "Fast Splittable Pseudorandom Number Generators"
pub(super) fn seed(seed: u64, point: u64, stream: u64) -> u64 {
    let mix = |mut z: u64| {
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    const STEP: u64 = 0x9e37_79b9_7f4a_7c15;
    let with_point = mix(seed.wrapping_add(STEP)).wrapping_add(STEP.wrapping_mul(point + 1));
    mix(mix(with_point).wrapping_add(STEP.wrapping_mul(stream + 1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_dyadic_box_holds_one_point() {
        for stream in 0..8 {
            let seed = seed(5, 77, stream);
            for log in [0, 3, 6, 10] {
                for across in 0..=log {
                    let (columns, rows) = (1usize << across, 1usize << (log - across));
                    let mut hits = vec![0; columns * rows];
                    for index in 0..1u32 << log {
                        let [x, y] = point(index, seed);
                        hits[(y * rows as f32) as usize * columns + (x * columns as f32) as usize] += 1;
                    }
                    assert!(hits.iter().all(|&count| count == 1), "2^{log} points, {columns} columns");
                }
            }
        }
    }

    #[test]
    fn further_dimensions_are_independent_of_the_first() {
        // Pairs of first coordinates over 64 boxes. Chance would leave a χ² of 63; measured 121 at most, as the hash is not
        // chance. The same indices would leave 1024 · 7, all in eight boxes.
        for stream in 0..20 {
            let (first, further) = (seed(1, stream, 0), seed(1, stream, 1));
            let mut hits = [0; 64];
            for index in 0..1024 {
                let [a, b] = [point(index, first)[0], further_point(index, further)[0]];
                hits[8 * (8.0 * a) as usize + (8.0 * b) as usize] += 1;
            }
            let chi_squared: f64 = hits.iter().map(|&n| (n as f64 - 16.0).powi(2) / 16.0).sum();
            assert!(chi_squared <= 200.0, "stream {stream}: {chi_squared}");
        }
    }

    #[test]
    fn a_single_point_is_uniform_over_seeds() {
        // 4096 draws into 16 boxes: χ² with 15 degrees of freedom is below 44 with probability 0.9999.
        let mut hits = [0; 16];
        for draw in 0..4096 {
            let [x, y] = point(3, seed(1, draw, 0));
            hits[(4.0 * x) as usize * 4 + (4.0 * y) as usize] += 1;
        }
        let chi_squared: f64 = hits.iter().map(|&n| (n as f64 - 256.0).powi(2) / 256.0).sum();
        assert!(chi_squared <= 44.0, "{chi_squared}");
    }
}
