//! The part of the sphere that one texel shows, as the image of the unit square.

use std::f64::consts::PI;

use super::Face;
use crate::quadrature::gauss_legendre;

/// Keeps densities finite on the rim of a disc, where a texel's column has no length.
const LEAST: f64 = 1e-15;

/// How much wider a texel cut by the rim of a disc counts; with it a white 7 × 7 disc projects to 1e-4 (tests/layout.rs).
const CUT: f64 = 4.0;

/// How two coordinates (p, q) of a picture become a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Surface {
    /// p = φ, q = θ.
    LatLong,
    /// p = φ from −Z towards +X, q = θ.
    OpenExrLatLong,
    /// p to the right, q down, −1 … 1.
    Face(Face),
    /// p to the right, q down, −1 … 1.
    AngularMap,
    /// p to the right, q down, −1 … 1.
    MirrorBall,
}

/// The part of the sphere that one texel shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    surface: Surface,
    p: [f64; 2],
    q: [f64; 2],
}

impl Cell {
    /// The cell over a rectangle of coordinates; `None` if it is outside the disc.
    pub(crate) fn new(surface: Surface, p: [f64; 2], q: [f64; 2]) -> Option<Self> {
        if !surface.is_disc() {
            return Some(Self { surface, p, q });
        }
        // Of a texel cut by the rim only the columns that reach into the disc are kept.
        let nearest = if q[0] <= 0.0 && q[1] >= 0.0 { 0.0 } else { q[0].abs().min(q[1].abs()) };
        let half_width = (1.0 - nearest * nearest).max(0.0).sqrt();
        let p = [p[0].max(-half_width), p[1].min(half_width)];
        (p[0] < p[1]).then_some(Self { surface, p, q })
    }

    /// The direction of point (s, t) of the unit square, and dω / ds dt there.
    pub fn at(&self, [s, t]: [f64; 2]) -> ([f64; 3], f64) {
        let p = self.p[0] + s * (self.p[1] - self.p[0]);
        let [start, end] = self.column(p);
        let q = start + t * (end - start);
        let (direction, density) = self.surface.direction(p, q);
        (direction, density * (self.p[1] - self.p[0]) * (end - start).max(0.0))
    }

    /// A direction of the cell for (s, t) uniform in the unit square, and its density a steradian within the cell.
    ///
    /// Uniform over the solid angle for lat-long and mirror ball, over the texel's area for the others.
    pub fn sample(&self, [s, t]: [f64; 2]) -> ([f64; 3], f64) {
        if self.surface.is_lat_long() {
            let [north, south] = self.q.map(f64::cos);
            let theta = (north + t * (south - north)).clamp(-1.0, 1.0).acos();
            let t = ((theta - self.q[0]) / (self.q[1] - self.q[0])).clamp(0.0, 1.0);
            return (self.at([s, t]).0, 1.0 / self.solid_angle());
        }
        let (direction, density) = self.at([s, t]);
        (direction, 1.0 / density.max(LEAST))
    }

    /// The density of [`Cell::sample`] at a unit direction of the cell.
    pub fn density(&self, direction: [f64; 3]) -> f64 {
        let [x, y, z] = direction;
        match &self.surface {
            Surface::LatLong | Surface::OpenExrLatLong => 1.0 / self.solid_angle(),
            Surface::Face(face) => {
                let depth = face.centre[0] * x + face.centre[1] * y + face.centre[2] * z;
                let area = (self.p[1] - self.p[0]) * (self.q[1] - self.q[0]);
                1.0 / (area * depth.abs().powi(3))
            }
            Surface::AngularMap | Surface::MirrorBall => {
                let across = x.hypot(y);
                let angle = across.atan2(z);
                let radius = if matches!(self.surface, Surface::AngularMap) {
                    angle / PI
                } else {
                    (0.5 * angle).sin()
                };
                let p = if across > 0.0 { x / across * radius } else { radius };
                let p = p.clamp(self.p[0], self.p[1]);
                let [start, end] = self.column(p);
                let area = (self.p[1] - self.p[0]) * (end - start).max(0.0);
                1.0 / (area * self.surface.disc_density(radius)).max(LEAST)
            }
        }
    }

    /// The solid angle; see [`super::Grid::solid_angle`].
    pub fn solid_angle(&self) -> f64 {
        match self.surface {
            Surface::LatLong | Surface::OpenExrLatLong => {
                // cos a − cos b without cancellation.
                let [a, b] = self.q;
                (self.p[1] - self.p[0]) * 2.0 * (0.5 * (a + b)).sin() * (0.5 * (b - a)).sin()
            }
            Surface::Face(_) => {
                let corner = |p: f64, q: f64| (p * q).atan2((1.0 + p * p + q * q).sqrt());
                let ([p0, p1], [q0, q1]) = (self.p, self.q);
                corner(p1, q1) - corner(p0, q1) - corner(p1, q0) + corner(p0, q0)
            }
            Surface::MirrorBall => {
                let ([p0, p1], [q0, q1]) = (self.p, self.q);
                4.0 * (area_below(p0, p1, q1) - area_below(p0, p1, q0))
            }
            Surface::AngularMap => self.integrated_solid_angle(),
        }
    }

    /// An upper bound of the cell's angular width, for choosing a quadrature.
    pub(crate) fn extent(&self) -> f64 {
        let (width, height) = (self.p[1] - self.p[0], self.q[1] - self.q[0]);
        if !self.surface.is_disc() {
            return width.max(height);
        }
        let far = |[a, b]: [f64; 2]| a.abs().max(b.abs());
        let near = |[a, b]: [f64; 2]| if a * b <= 0.0 { 0.0 } else { a.abs().min(b.abs()) };
        let outer = far(self.p).hypot(far(self.q));
        let extent = if matches!(self.surface, Surface::AngularMap) {
            PI * width.max(height)
        } else {
            let inner = near(self.p).hypot(near(self.q)).min(1.0);
            (2.0 * (outer.min(1.0).asin() - inner.asin())).max(2.0 * width.max(height))
        };
        // The rim cuts the texel with a kink, which takes more nodes than a harmonic does.
        if outer > 1.0 { CUT * extent.max(0.1) } else { extent }
    }

    /// The interval of q inside the picture at p.
    fn column(&self, p: f64) -> [f64; 2] {
        if !self.surface.is_disc() {
            return self.q;
        }
        let half = (1.0 - p * p).max(0.0).sqrt();
        [self.q[0].max(-half), self.q[1].min(half)]
    }

    /// ∫ dω by Gauss–Legendre between the columns where the rim enters or leaves, where the integrand has kinks.
    fn integrated_solid_angle(&self) -> f64 {
        let mut breaks = vec![self.p[0], self.p[1]];
        let crossings = self.q.iter().map(|q| (1.0 - q * q).max(0.0).sqrt()).flat_map(|p| [-p, p]);
        breaks.extend(crossings.filter(|p| *p > self.p[0] && *p < self.p[1]));
        breaks.sort_by(f64::total_cmp);
        let (nodes, weights) = gauss_legendre(8);
        let mut sum = 0.0;
        for piece in breaks.windows(2) {
            for (x, weight) in nodes.iter().zip(&weights) {
                let p = 0.5 * (piece[0] + piece[1]) + 0.5 * x * (piece[1] - piece[0]);
                let [start, end] = self.column(p);
                let column: f64 = nodes
                    .iter()
                    .zip(&weights)
                    .map(|(y, weight)| {
                        let q = 0.5 * (start + end) + 0.5 * y * (end - start);
                        weight * self.surface.disc_density(p.hypot(q))
                    })
                    .sum();
                sum += weight * column * 0.25 * (piece[1] - piece[0]) * (end - start);
            }
        }
        sum
    }
}

impl Surface {
    fn is_disc(&self) -> bool {
        matches!(self, Self::AngularMap | Self::MirrorBall)
    }

    fn is_lat_long(&self) -> bool {
        matches!(self, Self::LatLong | Self::OpenExrLatLong)
    }

    /// dω / dp dq of a disc at a distance from its centre.
    fn disc_density(&self, radius: f64) -> f64 {
        match self {
            // The ball's map keeps areas: dω = 4 dp dq.
            Self::MirrorBall => 4.0,
            _ if radius > 0.0 => PI * (PI * radius).sin().max(0.0) / radius,
            _ => PI * PI,
        }
    }

    /// The unit direction at (p, q), and dω / dp dq.
    fn direction(&self, p: f64, q: f64) -> ([f64; 3], f64) {
        match self {
            Self::LatLong => {
                let (sin, cos) = q.sin_cos();
                ([sin * p.cos(), cos, -sin * p.sin()], sin)
            }
            Self::OpenExrLatLong => {
                let (sin, cos) = q.sin_cos();
                ([sin * p.sin(), cos, -sin * p.cos()], sin)
            }
            Self::Face(face) => {
                let length = (1.0 + p * p + q * q).sqrt();
                let axis = |i: usize| (face.centre[i] + p * face.right[i] + q * face.down[i]) / length;
                (std::array::from_fn(axis), 1.0 / (length * length * length))
            }
            Self::AngularMap => {
                let radius = p.hypot(q);
                let (sin, cos) = (PI * radius).sin_cos();
                let across = if radius > 0.0 { sin / radius } else { PI };
                ([across * p, -across * q, cos], self.disc_density(radius))
            }
            Self::MirrorBall => {
                let squared = p * p + q * q;
                let across = 2.0 * (1.0 - squared).max(0.0).sqrt();
                ([across * p, -across * q, 1.0 - 2.0 * squared], 4.0)
            }
        }
    }
}

/// ∫ over [a, b] ⊂ [−1, 1] of `q` cut to the unit disc: the height of the disc's part below q, measured from its middle.
fn area_below(a: f64, b: f64, q: f64) -> f64 {
    let height = q.abs().min(1.0);
    let corner = (1.0 - height * height).sqrt();
    let under_arc = |x: f64| 0.5 * (x * (1.0 - x * x).max(0.0).sqrt() + x.min(1.0).asin());
    let primitive = |x: f64| {
        let (sign, x) = (x.signum(), x.abs());
        let flat = height * x.min(corner);
        sign * if x > corner { flat + under_arc(x) - under_arc(corner) } else { flat }
    };
    q.signum() * (primitive(b) - primitive(a))
}
