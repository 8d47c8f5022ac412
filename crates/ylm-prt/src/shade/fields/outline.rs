//! Which objects can be in front of each other as a point sees them.
//!
//! What two objects block has no part in common where a plane through the point parts them: A·B = 0, and (1 − A)(1 − B) = 1 − A − B, a sum in
//! the place of a product. And what lies below a point's tangent plane is hidden already. n bands blur what is blocked by about π/n, so both are
//! said of objects only that stay clear of the plane by half of that on each side: what bands leave of the product beyond is not to be seen, and
//! nothing jumps where an object comes nearer than that.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3;
use ylm::Bands;

use crate::field::OcclusionField;
use crate::scene::Pose;

/// How far an object stays clear of a plane: half of what n bands blur.
#[derive(Clone, Copy)]
pub struct Margin {
    angle: f32,
    sine: f32,
}

impl Margin {
    pub fn of(bands: Bands) -> Self {
        let angle = (0.5 * PI / bands.count() as f32).min(FRAC_PI_2);
        Self { angle, sine: angle.sin() }
    }
}

/// Where an object is in the world: within a sphere and within a box.
pub struct Extent {
    center: Vec3,
    radius: f32,
    /// Unit vectors along the edges of the box.
    axes: [Vec3; 3],
    corners: [Vec3; 8],
}

impl Extent {
    pub fn new(field: &OcclusionField, pose: &Pose) -> Self {
        let bounds = field.bounds();
        let corner = |k: usize| {
            let at = std::array::from_fn(|axis| bounds[k >> axis & 1][axis]);
            pose.apply(Vec3::from_array(at))
        };
        Self {
            center: pose.apply(field.center()),
            radius: pose.scale * field.radius(),
            axes: [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| pose.rotation * axis),
            corners: std::array::from_fn(corner),
        }
    }

    /// The object as a place sees it.
    pub fn seen_from(&self, place: Vec3) -> Outline {
        let towards = self.center - place;
        let distance = towards.length();
        let is_outside = distance > self.radius;
        let corners = self.corners.map(|corner| corner - place);
        Outline {
            direction: if is_outside { towards / distance } else { Vec3::ZERO },
            half_angle: if is_outside { (self.radius / distance).asin() } else { PI },
            axes: self.axes,
            corners: [0, 1, 2].map(|axis| corners.map(|corner| corner[axis])),
            lengths: corners.map(Vec3::length),
        }
    }
}

/// An object as a place sees it.
pub struct Outline {
    /// Of the sphere's middle; zero from within.
    direction: Vec3,
    half_angle: f32,
    axes: [Vec3; 3],
    /// Of the box, from the place: [axis, corner].
    corners: [[f32; 8]; 3],
    lengths: [f32; 8],
}

impl Outline {
    /// Whether all of the object is below the plane of a unit normal through the place, and clear of it.
    pub fn is_below(&self, normal: Vec3, margin: Margin) -> bool {
        self.sine_above(-normal) >= margin.sine
            || self.direction.dot(normal) <= -(self.half_angle + margin.angle).min(FRAC_PI_2).sin()
                && self.half_angle + margin.angle < FRAC_PI_2
    }

    /// Whether a plane through the place parts this object from another, and both are clear of it.
    pub fn is_apart_from(&self, other: &Self, margin: Margin) -> bool {
        let needed = self.half_angle + other.half_angle + 2.0 * margin.angle;
        if needed < PI && self.direction.dot(other.direction) <= needed.cos() {
            return true;
        }
        let parts = |normal: Vec3| {
            let Some(normal) = normal.try_normalize() else { return false };
            let normal = if self.direction.dot(normal) < other.direction.dot(normal) { -normal } else { normal };
            self.sine_above(normal) >= margin.sine && other.sine_above(-normal) >= margin.sine
        };
        // The plane midway between the middles, and planes along the edges of either box.
        let between = self.direction + other.direction;
        parts(self.direction - other.direction)
            || self.axes.iter().chain(&other.axes).any(|axis| parts(axis.cross(between)))
    }

    /// The least sine of the corners' angles above a plane: of all directions to the box where it is not negative, as those above an angle
    /// are a convex cone.
    fn sine_above(&self, normal: Vec3) -> f32 {
        let [x, y, z] = &self.corners;
        let mut least = f32::INFINITY;
        for k in 0..8 {
            let height = x[k] * normal.x + y[k] * normal.y + z[k] * normal.z;
            least = least.min(height / self.lengths[k].max(f32::MIN_POSITIVE));
        }
        least
    }
}
