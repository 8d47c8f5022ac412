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
    /// Of twice the angle.
    cosine_of_both: f32,
}

impl Margin {
    pub fn of(bands: Bands) -> Self {
        Self::of_angle((0.5 * PI / bands.count() as f32).min(FRAC_PI_2))
    }

    fn of_angle(angle: f32) -> Self {
        Self { angle, sine: angle.sin(), cosine_of_both: (2.0 * angle).cos() }
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
        let corners = self.corners.map(|corner| (corner - place).normalize_or_zero());
        Outline {
            is_outside,
            direction: if is_outside { towards / distance } else { Vec3::ZERO },
            half_angle: if is_outside { (self.radius / distance).asin() } else { PI },
            axes: self.axes,
            corners: [0, 1, 2].map(|axis| corners.map(|corner| corner[axis])),
        }
    }
}

/// An object as a place sees it.
pub struct Outline {
    /// Whether the place is outside of the sphere.
    is_outside: bool,
    /// Of the sphere's middle; zero from within.
    direction: Vec3,
    half_angle: f32,
    axes: [Vec3; 3],
    /// Unit vectors to those of the box: [axis, corner].
    corners: [[f32; 8]; 3],
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
        // The middles lie within, and are clear of the plane as well.
        if self.direction.dot(other.direction) > margin.cosine_of_both {
            return false;
        }
        let parts = |normal: Vec3| {
            let Some(normal) = normal.try_normalize() else { return false };
            let [own, others] = [self, other].map(|outline| outline.direction.dot(normal));
            let (normal, own, others) =
                if own < others { (-normal, -own, -others) } else { (normal, own, others) };
            // The middles first, which lie within.
            let (least, most) =
                if self.is_outside && other.is_outside { (margin.sine, -margin.sine) } else { (-2.0, 2.0) };
            own >= least
                && others <= most
                && self.sine_above(normal) >= margin.sine
                && other.sine_above(-normal) >= margin.sine
        };
        // The plane midway between the middles, and planes along the edges of either box.
        let between = self.direction + other.direction;
        let others: &[Vec3] = if self.axes == other.axes { &[] } else { &other.axes };
        parts(self.direction - other.direction)
            || self.axes.iter().chain(others).any(|axis| parts(axis.cross(between)))
    }

    /// The least sine of the corners' angles above a plane: of all directions to the box where it is not negative, as those above an angle
    /// are a convex cone.
    fn sine_above(&self, normal: Vec3) -> f32 {
        let [x, y, z] = &self.corners;
        let mut sines = [0.0f32; 8];
        for k in 0..8 {
            sines[k] = x[k] * normal.x + y[k] * normal.y + z[k] * normal.z;
        }
        sines.into_iter().fold(f32::INFINITY, f32::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    /// A box of these half sides around a place, turned.
    fn extent(center: Vec3, half: Vec3, turn: Quat) -> Extent {
        let sign = |k: usize, axis: usize| if k >> axis & 1 == 1 { 1.0 } else { -1.0 };
        let corner = |k| center + turn * (half * Vec3::from_array(std::array::from_fn(|axis| sign(k, axis))));
        Extent {
            center,
            radius: half.length(),
            axes: [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| turn * axis),
            corners: std::array::from_fn(corner),
        }
    }

    /// Some directions from the origin to a box.
    fn directions(extent: &Extent) -> Vec<Vec3> {
        let weights = (0..64).map(|i| -> [f32; 8] {
            let share: [f32; 8] = std::array::from_fn(|k| ((i * 8 + k) as f32 * 0.618).fract().powi(4));
            let sum: f32 = share.iter().sum();
            share.map(|share| share / sum)
        });
        let inner = weights.map(|w| (0..8).map(|k| w[k] * extent.corners[k]).sum::<Vec3>());
        inner.chain(extent.corners).map(Vec3::normalize).collect()
    }

    #[test]
    fn what_is_apart_has_no_directions_within_the_margins_in_common() {
        let margin = Margin::of_angle(0.1);
        let (mut apart, mut below) = (0, 0);
        for i in 0..4000 {
            let number =
                |k: i32| ((f64::from(i * 16 + k) * 0.754_877_666_246_693).fract() * 2.0 - 1.0) as f32;
            let any = |k: i32| Vec3::new(number(k), number(k + 1), number(k + 2));
            let turn =
                |k: i32| Quat::from_euler(glam::EulerRot::XYZ, 3.0 * number(k), 3.0 * number(k + 1), 0.3);
            let [a, b] =
                [0, 7].map(|k| extent(3.0 * any(k), Vec3::splat(0.1) + any(k + 3).abs(), turn(k + 5)));
            let [seen_a, seen_b] = [&a, &b].map(|extent| extent.seen_from(Vec3::ZERO));
            assert_eq!(seen_a.is_apart_from(&seen_b, margin), seen_b.is_apart_from(&seen_a, margin));
            let (of_a, of_b) = (directions(&a), directions(&b));
            if seen_a.is_apart_from(&seen_b, margin) {
                apart += 1;
                let nearest = of_a.iter().flat_map(|p| of_b.iter().map(|q| p.dot(*q))).fold(-1.0, f32::max);
                assert!(nearest <= 0.2f32.cos() + 1e-5, "{i}: {}", nearest.acos());
            }
            if seen_a.is_below(Vec3::Y, margin) {
                below += 1;
                assert!(of_a.iter().all(|d| d.y <= -0.1f32.sin() + 1e-5), "{i}");
            }
        }
        assert!(apart > 500 && below > 200, "{apart} {below}");
    }

    #[test]
    fn balls_are_parted_by_their_cones_and_columns_by_upright_planes() {
        let margin = Margin::of_angle(0.1);
        let seen = |center: Vec3, half: Vec3| extent(center, half, Quat::IDENTITY).seen_from(Vec3::ZERO);
        let column = Vec3::new(0.2, 1.5, 0.2);
        // Columns side by side, whose spheres overlap; and one behind the other.
        assert!(
            seen(Vec3::new(-1.0, 2.0, 2.0), column)
                .is_apart_from(&seen(Vec3::new(1.0, 0.0, 2.0), column), margin)
        );
        assert!(
            !seen(Vec3::new(0.0, 2.0, 2.0), column)
                .is_apart_from(&seen(Vec3::new(0.1, 0.0, 4.0), column), margin)
        );
        // Within a box nothing is apart.
        assert!(!seen(Vec3::ZERO, column).is_apart_from(&seen(Vec3::new(9.0, 0.0, 0.0), column), margin));
    }
}
