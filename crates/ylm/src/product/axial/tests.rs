use super::*;
use crate::Workspace;
use crate::basis::basis_at;
use crate::eval::eval;
use crate::product::cap::CapProduct;
use crate::product::oracle::{error_of_norm, random};
use crate::product::zonal::ZonalProduct;
use crate::quadrature::gauss_legendre;

const AXES: [[f64; 3]; 6] = [
    [0.0, 0.0, 1.0],
    [0.0, 0.0, -2.0],
    [1.0, 0.0, 0.0],
    [-0.3, 0.5, -0.8],
    [1e-9, -1e-9, 1.0],
    [0.4, 0.4, 0.1],
];

/// A kernel's values, and the ends of the pieces on which it is smooth; 0 outside of them.
struct Shape {
    name: &'static str,
    zonal: fn(Bands) -> Zonal<f64>,
    value: fn(f64) -> f64,
    ends: &'static [f64],
}

/// GGX's distribution of normals of roughness 0.4, sampled.
const TABLE: [[f64; 2]; 5] = [[0.0, 0.0], [0.5, 0.051], [0.8, 0.236], [0.95, 1.12], [1.0, 1.99]];

fn table_value(x: f64) -> f64 {
    let piece = TABLE.windows(2).find(|piece| x <= piece[1][0]).unwrap();
    let [[x0, y0], [x1, y1]] = [piece[0], piece[1]];
    y0 + (x - x0) / (x1 - x0) * (y1 - y0)
}

const SHAPES: [Shape; 5] = [
    Shape { name: "cosine", zonal: Zonal::clamped_cosine, value: |x| x, ends: &[0.0, 1.0] },
    Shape {
        name: "Phong",
        zonal: |bands| Zonal::phong(20.0, bands).unwrap(),
        value: |x| x.powi(20),
        ends: &[0.0, 1.0],
    },
    Shape {
        name: "disc",
        zonal: |bands| Zonal::disc(0.6, bands).unwrap(),
        value: |_| 1.0,
        ends: &[0.825_335_614_909_678_3, 1.0],
    },
    Shape {
        name: "Henyey–Greenstein",
        zonal: |bands| Zonal::henyey_greenstein(-0.4, bands).unwrap(),
        value: |x| (1.0 - 0.16) / (4.0 * std::f64::consts::PI) / (1.0f64 + 0.16 + 0.8 * x).powf(1.5),
        ends: &[-1.0, 1.0],
    },
    Shape {
        name: "table",
        zonal: |bands| Zonal::tabulated(&TABLE, bands).unwrap(),
        value: table_value,
        ends: &[0.0, 0.5, 0.8, 0.95, 1.0],
    },
];

/// ∫ f k Y_i dω, point by point around the axis.
fn integral(f: &[f64], axis: [f64; 3], shape: &Shape) -> Vec<f64> {
    let bands = Bands::of_coeff_count(f.len()).unwrap();
    let around = FrameRotation::<f64>::new(Bands::new(2).unwrap());
    // The directions of a frame, by their own harmonics: Y₁ ∝ (−y, z, −x).
    let turn = |direction: [f64; 3]| {
        let (mut y, mut turned) = ([0.0; 4], [0.0; 4]);
        basis_at(direction, Bands::new(2).unwrap(), &mut y).unwrap();
        around.apply(&y, &[axis], &[[1.0, 0.0]], &mut turned).unwrap();
        [-turned[3], -turned[1], turned[2]]
    };
    let (nodes, weights) = gauss_legendre(2 * bands.count() + 40);
    let (mut out, mut y) = (vec![0.0; f.len()], vec![0.0; f.len()]);
    for ends in shape.ends.windows(2) {
        let length = ends[1] - ends[0];
        for (node, weight) in nodes.iter().zip(&weights) {
            let x = ends[0] + length * (node + 1.0) / 2.0;
            let s = ((1.0 - x) * (1.0 + x)).sqrt();
            let count = 2 * bands.count() + 1;
            for k in 0..count {
                let (sin, cos) = (std::f64::consts::TAU * (k as f64 + 0.3) / count as f64).sin_cos();
                let direction = turn([s * cos, s * sin, x]);
                basis_at(direction, bands, &mut y).unwrap();
                let area = weight * length / 2.0 * std::f64::consts::TAU / count as f64;
                let value = area * (shape.value)(x) * eval(f, direction).unwrap();
                out.iter_mut().zip(&y).for_each(|(out, y)| *out += value * y);
            }
        }
    }
    out
}

fn norm(f: &[f64]) -> f64 {
    f.iter().map(|v| v * v).sum::<f64>().sqrt()
}

fn wide<T: Real>(values: &[T]) -> Vec<f64> {
    values.iter().map(|v| v.to_f64()).collect()
}

fn check<T: Real>(n: usize, shape: &Shape, tolerance: f64) {
    let (bands, width) = (Bands::new(n).unwrap(), n * n);
    // More than a whole chunk; functions repeat, so that few integrals are enough.
    let count = if n <= 5 { 19 } else { 17 };
    let few: Vec<T> = random(2 * width, n as u64);
    let coeffs: Vec<T> = (0..count).flat_map(|k| &few[k % 2 * width..][..width]).copied().collect();
    let axes: Vec<[T; 3]> = (0..count).map(|k| AXES[k % 6].map(T::from_f64)).collect();
    let largest = shape.ends.iter().map(|x| (shape.value)(*x)).fold(1.0, f64::max);
    let expected_in = |axes: &[[T; 3]]| -> Vec<Vec<f64>> {
        let functions = few.chunks(width).cycle().zip(axes);
        functions.map(|(f, axis)| integral(&wide(f), axis.map(T::to_f64), shape)).collect()
    };
    let around_z = expected_in(&[AXES[0].map(T::from_f64); 2]);
    let in_world = expected_in(&axes[..6]);
    for level in Level::available() {
        let product = AxialProduct::<T>::of(bands, shape.zonal).unwrap().with_level(level);
        let mut out = vec![T::from_f64(f64::NAN); coeffs.len()];
        let assert_close = |out: &[T], expected: &[Vec<f64>], what: &str| {
            for (k, out) in out.chunks(width).enumerate() {
                let (f, expected) = (wide(&coeffs[k * width..][..width]), &expected[k % expected.len()]);
                let error = error_of_norm(out, expected, norm(&f) * largest);
                assert!(error <= tolerance, "{} {what} {n} {} {k}: {error:e}", shape.name, level.name());
            }
        };
        product.in_frame(&coeffs, &mut out).unwrap();
        assert_close(&out, &around_z, "in its frame");
        let mut one = vec![T::ZERO; width];
        product.in_frame(&coeffs[..width], &mut one).unwrap();
        assert_eq!(one, out[..width], "one alone");
        product.in_world(&coeffs, &axes, &mut out).unwrap();
        assert_close(&out, &in_world, "in the world");
        // In the frames it is the same, turned back.
        let mut turned = vec![T::ZERO; coeffs.len()];
        FrameRotation::<T>::new(bands).undo(&out, &axes, &mut turned).unwrap();
        product.into_frames(&coeffs, &axes, &mut out).unwrap();
        let turned: Vec<Vec<f64>> = turned.chunks(width).map(wide).collect();
        assert_close(&out, &turned, "in frames");
    }
}

#[test]
fn products_equal_quadrature_whatever_the_kernel() {
    for shape in &SHAPES {
        for n in [1, 2, 3, 5, 9] {
            check::<f32>(n, shape, 2e-6);
            check::<f64>(n, shape, 1e-13);
        }
    }
    check::<f64>(14, &SHAPES[0], 1e-13);
}

#[test]
fn a_disc_is_a_cap() {
    let (bands, half_angle) = (Bands::new(8).unwrap(), 0.9);
    let f: Vec<f64> = random(6 * 64, 7);
    let (mut by_cap, mut found) = (f.clone(), f.clone());
    CapProduct::new(bands).inside(&f, &AXES, &[half_angle; 6], &mut by_cap).unwrap();
    let disc = AxialProduct::of(bands, |bands| Zonal::disc(half_angle, bands).unwrap()).unwrap();
    disc.in_world(&f, &AXES, &mut found).unwrap();
    assert!(error_of_norm(&found, &by_cap, norm(&f)) <= 1e-13);
}

#[test]
fn a_kernel_of_few_bands_is_a_zonal_factor_of_them() {
    let bands = Bands::new(6).unwrap();
    let (f, zonal): (Vec<f64>, Vec<f64>) = (random(2 * 36, 3), random(6, 4));
    let by_zonal = ZonalProduct::<f64>::new(bands).unwrap();
    let (mut expected, mut found) = (f.clone(), f.clone());
    let values = by_zonal.values(&zonal).unwrap();
    by_zonal.product(&values, &f, &mut expected, &mut Workspace::new()).unwrap();
    let product = AxialProduct::new(bands, &Zonal::new(zonal).unwrap()).unwrap();
    product.in_frame(&f, &mut found).unwrap();
    assert!(error_of_norm(&found, &expected, norm(&f)) <= 1e-14);
}

#[test]
fn operations_follow_from_the_bands_of_the_kernel() {
    let bands = Bands::new(9).unwrap();
    let of = |kernel: &[f64]| {
        AxialProduct::<f32>::new(bands, &Zonal::new(kernel.to_vec()).unwrap()).unwrap().operations()
    };
    // Every coefficient by one number; by its two neighbours in degree; by all of its order.
    assert_eq!(of(&[2.0]).multiplications, 81);
    assert_eq!(of(&[0.0, 1.0]).multiplications, 2 * (8 + 2 * (7 + 6 + 5 + 4 + 3 + 2 + 1)));
    let all: u64 = (1..=9u64).map(|size| if size == 9 { size * size } else { 2 * size * size }).sum();
    assert_eq!(of(&[1.0; 17]).multiplications, all);
    assert_eq!(of(&[1.0; 99]).multiplications, all);
    assert_eq!(of(&[0.0]).multiplications, 0);
}

#[test]
fn what_does_not_fit_is_an_error() {
    let product = AxialProduct::<f32>::of(Bands::new(2).unwrap(), Zonal::clamped_cosine).unwrap();
    let mut out = [0.0; 8];
    assert!(product.in_frame(&[1.0; 8], &mut out).is_ok() && product.in_frame(&[], &mut []).is_ok());
    assert!(
        product.in_frame(&[1.0; 7], &mut out[..7]).is_err() && product.in_frame(&[1.0; 4], &mut out).is_err()
    );
    let z = [0.0, 0.0, 1.0];
    assert!(product.into_frames(&[1.0; 8], &[z], &mut out).is_err());
    assert!(product.in_world(&[1.0; 8], &[z, [f32::NAN, 0.0, 1.0]], &mut out).is_err());
    let infinite = Zonal::new(vec![1.0, f64::INFINITY]).unwrap();
    let error = AxialProduct::<f64>::new(Bands::new(2).unwrap(), &infinite).unwrap_err();
    assert_eq!(error.to_string(), "a coefficient of the kernel is inf; it must be finite");
}
