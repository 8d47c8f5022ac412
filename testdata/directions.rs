//! Directions for tests: `#[path]` into those that need them.

/// Unit vectors that cover the sphere evenly: a spherical Fibonacci set around y.
pub fn spiral(count: usize) -> Vec<glam::Vec3> {
    (0..count)
        .map(|k| {
            let y = 1.0 - 2.0 * (k as f32 + 0.5) / count as f32;
            let (sin, cos) = (2.399_963 * k as f32).sin_cos();
            glam::Vec3::new(cos * (1.0 - y * y).sqrt(), y, sin * (1.0 - y * y).sqrt())
        })
        .collect()
}
