//! Sums of functions that are spun about z.

/// A function to be added: its weight, the spin [cos ψ, sin ψ] up to a positive factor, and its coefficients in the order of
/// [`super::shell::PlaneOrder`]. Without a direction it is not spun.
pub type Term<'a> = (f32, [f32; 2], &'a [f32]);

/// Buffers of [`Blend::add`].
#[derive(Clone, Debug, Default)]
pub struct Blend {
    /// Weight times cos mψ and sin mψ, at each place of the cosines.
    cos: Vec<f32>,
    sin: Vec<f32>,
}

impl Blend {
    /// Adds terms of n bands to `sum`.
    ///
    /// Shapes: `sum` and each term's function n². The order of operations is fixed, so every instruction set gives the same sum.
    pub fn add(&mut self, n: usize, terms: &[Term<'_>], sum: &mut [f32]) {
        let half = n * (n - 1) / 2;
        self.cos.resize(half, 0.0);
        self.sin.resize(half, 0.0);
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            // SAFETY: just detected.
            return unsafe { add_avx2(n, terms, &mut self.cos, &mut self.sin, sum) };
        }
        add_in(n, terms, &mut self.cos, &mut self.sin, sum);
    }
}

/// # Safety
/// The machine has AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn add_avx2(n: usize, terms: &[Term<'_>], cos: &mut [f32], sin: &mut [f32], sum: &mut [f32]) {
    add_in(n, terms, cos, sin, sum);
}

// The compiler vectorises the loops over places for the instruction set at hand.
#[inline(always)]
fn add_in(n: usize, terms: &[Term<'_>], cos: &mut [f32], sin: &mut [f32], sum: &mut [f32]) {
    let half = cos.len();
    let (zonal, rest) = sum.split_at_mut(n);
    let (sum_cos, sum_sin) = rest.split_at_mut(half);
    for &(weight, spin, function) in terms {
        let length = (spin[0] * spin[0] + spin[1] * spin[1]).sqrt();
        let [turn_cos, turn_sin] = if length > 0.0 { spin.map(|x| x / length) } else { [1.0, 0.0] };
        let (mut c, mut s) = (weight, 0.0);
        let (mut cosines, mut sines) = (&mut cos[..half], &mut sin[..half]);
        for m in 1..n {
            (c, s) = (c * turn_cos - s * turn_sin, s * turn_cos + c * turn_sin);
            let (head, tail) = cosines.split_at_mut(n - m);
            head.fill(c);
            cosines = tail;
            let (head, tail) = sines.split_at_mut(n - m);
            head.fill(s);
            sines = tail;
        }
        let (own_cos, own_sin) = function[n..].split_at(half);
        zonal.iter_mut().zip(function).for_each(|(sum, value)| *sum += weight * value);
        let (cos, sin) = (&cos[..half], &sin[..half]);
        let (sum_cos, sum_sin) = (&mut sum_cos[..half], &mut sum_sin[..half]);
        let (own_cos, own_sin) = (&own_cos[..half], &own_sin[..half]);
        for i in 0..half {
            sum_cos[i] += cos[i] * own_cos[i] - sin[i] * own_sin[i];
            sum_sin[i] += sin[i] * own_cos[i] + cos[i] * own_sin[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::shell::PlaneOrder;
    use super::*;
    use ylm::Bands;

    #[test]
    fn a_function_is_spun_as_rotations_about_z_have_it() {
        let bands = Bands::new(6).unwrap();
        let coeffs: Vec<f32> = (0..36).map(|i| ((i * 29 % 17) as f32) - 8.0).collect();
        let order = PlaneOrder::new(bands);
        let (mut planes, mut sum, mut spun) = (vec![0.0; 36], vec![0.0; 36], vec![0.0; 36]);
        order.to_planes(&coeffs, &mut planes);
        let (sin, cos) = 0.7f32.sin_cos();
        Blend::default().add(6, &[(2.0, [3.0 * cos, 3.0 * sin], &planes)], &mut sum);
        order.to_bands(&sum, 0.5, &mut spun);
        let mut expected = coeffs.clone();
        ylm::rotate::rotate_z(0.7, bands, &mut expected).unwrap();
        for (spun, expected) in spun.iter().zip(expected) {
            assert!((spun - expected).abs() <= 1e-5, "{spun} {expected}");
        }
    }

    #[test]
    fn every_instruction_set_gives_the_same_sum() {
        for n in [1, 2, 5, 12] {
            let number = |i: usize| ((i * 7919 % 1009) as f32 - 500.0) / 37.0;
            let functions: Vec<Vec<f32>> =
                (0..3).map(|f| (0..n * n).map(|i| number(i + 31 * f)).collect()).collect();
            let terms: Vec<Term<'_>> = (functions.iter().enumerate())
                .map(|(f, function)| (0.3 * f as f32, [number(f), number(f + 5)], function.as_slice()))
                .collect();
            let (mut best, mut portable) = (vec![1.0; n * n], vec![1.0; n * n]);
            Blend::default().add(n, &terms, &mut best);
            let (mut cos, mut sin) = (vec![0.0; n * (n - 1) / 2], vec![0.0; n * (n - 1) / 2]);
            add_in(n, &terms, &mut cos, &mut sin, &mut portable);
            assert_eq!(best, portable);
        }
    }
}
