//! Polygons on the sphere: the SH of radiance 1 within one, as a flat area light is seen from a point.

use std::f64::consts::PI;

use crate::bands::{Bands, index};
use crate::basis::basis_at;
use crate::error::{Error, Result, check_length};
use crate::rotate::FrameRotation;

/// Projects spherical polygons in closed form, at any number of bands.
///
/// A harmonic of band l ≥ 1 is an eigenfunction of the Laplacian, ∇²Y = −l(l+1) Y, so by the divergence theorem
/// ∫_P Y dω = 1/(l(l+1)) Σ_edges ∫ ∂Y/∂N ds, with N the pole of the edge's great circle on the polygon's side. With N as
/// polar axis and φ measured from the edge's middle, ∂Y_lm/∂N is a constant times cos mφ along the edge, and sin terms
/// integrate to zero: n²/2 closed forms an edge, then one rotation from the edge's frame to the world.
/// The boundary integral is that of [Wang & Ramamoorthi 2018]; they expand band l in 2l+1 zonal lobes and recur along
/// the edge for each, which inverts a matrix of lobes a band. The rotation is orthogonal, so no band loses digits.
///
/// Error: 1e-13 of the largest coefficient at 32 bands, 2e-12 at 128, against quadrature over the polygon; polygons of
/// angular size s keep about 1e-16 / s of their own largest (tests/polygon.rs).
/// Cost: O(n³) to make; 2/3 n³ multiply-adds an edge to project.
///
/// [Wang & Ramamoorthi 2018] "Analytic Spherical Harmonic Coefficients for Polygonal Area Lights"
#[derive(Clone, Debug)]
pub struct PolygonProjection {
    rotation: FrameRotation<f64>,
    /// ∂Y_lm/∂z at +x over l(l+1), n²; zero but for m ≥ 0 with l − m odd.
    slopes: Vec<f64>,
}

impl PolygonProjection {
    /// Prepares polygons of `bands` bands. Cost: O(n³).
    pub fn new(bands: Bands) -> Self {
        let mut equator = vec![0.0; bands.coeff_count()];
        basis_at([1.0, 0.0, 0.0], bands, &mut equator).expect("+x is a direction");
        let mut slopes = vec![0.0; bands.coeff_count()];
        for l in 1..bands.count() {
            let lf = l as f64;
            // (1 − z²) P_lm′ = (l + m) P_{l−1,m} − l z P_lm, at z = 0 and orthonormal.
            for m in (0..l).filter(|m| (l - m) % 2 == 1) {
                let mf = m as f64;
                let ratio = ((2.0 * lf + 1.0) / (2.0 * lf - 1.0) * (lf - mf) * (lf + mf)).sqrt();
                slopes[index(l, m as isize)] = ratio * equator[index(l - 1, m as isize)] / (lf * (lf + 1.0));
            }
        }
        Self { rotation: FrameRotation::new(bands), slopes }
    }

    /// The number of bands.
    pub fn bands(&self) -> Bands {
        self.rotation.bands()
    }

    /// ∫ Y_i dω over the directions in which a polygon is seen from the origin.
    ///
    /// The polygon is simple, convex or not, and lies in a plane that does not hold the origin. The result is positive
    /// (that is, ∫ dω is) where the corners run counter-clockwise as seen from the origin, and its negative otherwise.
    ///
    /// Shapes: `corners` [corner, 3]; `out` n². Units: radiance 1 within the polygon.
    ///
    /// # Errors
    /// If `out` has another length, there are fewer than three corners, a corner is not finite or at the origin, or an
    /// edge passes through the origin; `out` is unspecified then.
    pub fn project(&self, corners: &[[f64; 3]], out: &mut [f64]) -> Result<()> {
        let width = self.bands().coeff_count();
        check_length("out", out.len(), width)?;
        if corners.len() < 3 {
            return Err(Error::Length { what: "corners", expected: 3, actual: corners.len() });
        }
        let edges = edges(corners)?;
        let mut local = vec![0.0; edges.len() * width];
        for (edge, coeffs) in edges.iter().zip(local.chunks_exact_mut(width)) {
            for m in 0..self.bands().count() {
                let arc = match m {
                    0 => edge.angle,
                    _ => 2.0 * (0.5 * m as f64 * edge.angle).sin() / m as f64,
                };
                for l in (m + 1..self.bands().count()).step_by(2) {
                    let i = index(l, m as isize);
                    coeffs[i] = self.slopes[i] * arc;
                }
            }
        }
        let normals: Vec<[f64; 3]> = edges.iter().map(|edge| edge.pole).collect();
        let spins: Vec<[f64; 2]> = edges.iter().map(Edge::spin).collect();
        let mut turned = vec![0.0; local.len()];
        self.rotation.apply(&local, &normals, &spins, &mut turned)?;
        out.fill(0.0);
        for coeffs in turned.chunks_exact(width) {
            out.iter_mut().zip(coeffs).for_each(|(sum, coeff)| *sum += coeff);
        }
        out[0] = solid_angle(corners) / (4.0 * PI).sqrt();
        Ok(())
    }
}

/// The solid angle of a plane polygon as seen from the origin, signed as [`PolygonProjection::project`] says.
///
/// The sum of triangles between an apex and the edges. The apex is a corner, or the plane's normal where the polygon
/// reaches over more than 90°: triangles from a corner would then have sides that pass close to the origin.
///
/// Error: relative 1e-15 / (angular size) up to 90°, absolute 1e-15 beyond (tests/polygon.rs). Cost: O(corners).
///
/// [Van Oosterom & Strackee 1983] "The Solid Angle of a Plane Triangle"
pub fn solid_angle(corners: &[[f64; 3]]) -> f64 {
    let Some(&first) = corners.first() else { return 0.0 };
    let edges = || corners.iter().zip(corners.iter().cycle().skip(1));
    let mut apex = first;
    if corners.iter().any(|&corner| dot(first, corner) < 0.0) {
        let sum = edges().fold([0.0; 3], |sum, (&p, &q)| add(sum, cross(sub(p, first), sub(q, first))));
        apex = scaled(sum, dot(sum, first).signum() / length(sum));
    }
    let a = length(apex);
    let triangle = |(&p, &q): (&[f64; 3], &[f64; 3])| {
        let (b, c) = (length(p), length(q));
        // Differences of corners first: they are exact where the polygon is small and far.
        let volume = dot(apex, cross(sub(q, p), sub(p, apex)));
        let below = a * b * c + dot(apex, p) * c + dot(apex, q) * b + dot(p, q) * a;
        2.0 * volume.atan2(below)
    };
    edges().map(triangle).sum()
}

/// One edge as an arc of a great circle.
struct Edge {
    /// The unit pole of its circle, on the side of a counter-clockwise polygon.
    pole: [f64; 3],
    /// The unit direction of the arc's middle.
    middle: [f64; 3],
    angle: f64,
}

fn edges(corners: &[[f64; 3]]) -> Result<Vec<Edge>> {
    for (index, &direction) in corners.iter().enumerate() {
        if !(direction.iter().all(|x| x.is_finite()) && length(direction) > 0.0) {
            return Err(Error::Direction { index, direction });
        }
    }
    let mut edges = Vec::with_capacity(corners.len());
    for (k, &start) in corners.iter().enumerate() {
        let end = corners[(k + 1) % corners.len()];
        // start × end, but with the short side first, which the viewpoint's distance does not round away.
        let pole = cross(sub(end, start), start);
        let (across, along) = (length(pole), dot(start, end));
        if across == 0.0 && along < 0.0 {
            let range = "no edge of a polygon may pass through the point that sees it";
            return Err(Error::Range { what: "the angle of an edge", value: PI, range });
        }
        if across == 0.0 {
            continue;
        }
        let pole = scaled(pole, 1.0 / across);
        let (a, b) = (scaled(start, 1.0 / length(start)), scaled(end, 1.0 / length(end)));
        // Of the sum and the chord of two unit vectors, the longer one has all its digits.
        let middle = if along >= 0.0 { add(a, b) } else { cross(sub(a, b), pole) };
        let middle = sub(middle, scaled(pole, dot(pole, middle)));
        let middle = scaled(middle, 1.0 / length(middle));
        edges.push(Edge { pole, middle, angle: across.atan2(along) });
    }
    Ok(edges)
}

impl Edge {
    /// The spin about z of [`FrameRotation`] that takes +x to the middle of the arc.
    fn spin(&self) -> [f64; 2] {
        let [x, y, z] = self.pole;
        let across = x.hypot(y);
        let (cos, sin) = if across > 0.0 { (x / across, y / across) } else { (1.0, 0.0) };
        [dot(self.middle, [z * cos, z * sin, -across]), dot(self.middle, [-sin, cos, 0.0])]
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + b[i])
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn scaled(a: [f64; 3], factor: f64) -> [f64; 3] {
    a.map(|x| x * factor)
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}
