//! The pinhole camera.

use glam::{Quat, Vec2, Vec3};

use crate::error::{Error, Result};
use crate::scene::Ray;

/// A direction to look from: y is up, azimuth 0 looks at the model's +z side, azimuth 90° at its +x side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Around the y axis, in radians.
    pub azimuth: f32,
    /// Above the horizon, in radians; ±π/2 looks straight down or up.
    pub elevation: f32,
    /// Vertical field of view, in radians.
    pub field_of_view: f32,
}

impl Default for View {
    /// From the front, a little to the right and above: shows three sides of a box.
    fn default() -> Self {
        let [azimuth, elevation, field_of_view] = [30.0_f32, 18.0, 35.0].map(f32::to_radians);
        Self { azimuth, elevation, field_of_view }
    }
}

impl View {
    /// Unit vector from the model to the camera.
    pub fn direction(&self) -> Vec3 {
        let (sin, cos) = self.azimuth.sin_cos();
        Vec3::new(sin * self.elevation.cos(), self.elevation.sin(), cos * self.elevation.cos())
    }

    /// Axes of the camera: right, up, and back towards the eye.
    ///
    /// Right is taken from the azimuth alone, so that looking straight down or up is no special case.
    fn axes(&self) -> [Vec3; 3] {
        let (sin, cos) = self.azimuth.sin_cos();
        let (right, back) = (Vec3::new(cos, 0.0, -sin), self.direction());
        [right, back.cross(right), back]
    }

    fn check(&self) -> Result<()> {
        let angles = [self.azimuth, self.elevation, self.field_of_view];
        if angles.iter().any(|angle| !angle.is_finite()) {
            return Err(Error::Request("the camera's angles must be finite".into()));
        }
        let degrees = self.field_of_view.to_degrees();
        if !(0.1..=170.0).contains(&degrees) {
            return Err(Error::Request(format!("field of view {degrees}°: it must be from 0.1° to 170°")));
        }
        Ok(())
    }
}

/// A point of view with a picture in front of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    eye: Vec3,
    right: Vec3,
    up: Vec3,
    back: Vec3,
    half_height: f32,
}

impl Camera {
    /// Looks at the centre of the box around `positions`, from `distance` times the radius of their sphere about it.
    ///
    /// # Errors
    /// If there are no positions, the distance is not positive, or the view is outside its ranges.
    pub fn orbit(positions: &[Vec3], view: &View, distance: f32) -> Result<Self> {
        view.check()?;
        if !(distance > 0.0 && distance.is_finite()) {
            return Err(Error::Request(format!("camera distance {distance}: it must be positive")));
        }
        let centre = centre(positions)?;
        let radius = positions.iter().map(|p| p.distance(centre)).fold(0.0, f32::max).max(f32::MIN_POSITIVE);
        Ok(Self::new(centre + view.direction() * (distance * radius), view))
    }

    /// Shows all of `positions` as large as a picture of `aspect` (width over height) allows, less `margin`.
    ///
    /// The eye is the point from which the four sides of the view touch the model on both sides of the wider
    /// extent, and the narrower extent is centred. `margin` is the free part of the half picture: 0.06 leaves 3 % at
    /// either side.
    ///
    /// # Errors
    /// If there are no positions, `aspect` is not positive, `margin` is not in [0, 1), or the view is outside its
    /// ranges.
    pub fn fit(positions: &[Vec3], view: &View, aspect: f32, margin: f32) -> Result<Self> {
        view.check()?;
        if !(aspect > 0.0 && aspect.is_finite()) {
            return Err(Error::Request(format!("aspect {aspect}: it must be positive")));
        }
        if !(0.0..1.0).contains(&margin) {
            return Err(Error::Request(format!("margin {margin}: it must be from 0 to below 1")));
        }
        let centre = centre(positions)?;
        let [right, up, back] = view.axes();
        let half_height = (view.field_of_view / 2.0).tan() * (1.0 - margin);
        let half = Vec2::new(half_height * aspect, half_height);
        // In camera axes about the centre, a point is inside the four sides of a view from e where
        // |x − e.x| ≤ (e.z − z) · half.x, and likewise in y: each side bounds e by the farthest point along it.
        let mut low = Vec2::NEG_INFINITY;
        let mut high = Vec2::NEG_INFINITY;
        let mut nearest = f32::NEG_INFINITY;
        for &position in positions {
            let p = position - centre;
            let (xy, z) = (Vec2::new(p.dot(right), p.dot(up)), p.dot(back));
            high = high.max(xy + z * half);
            low = low.max(z * half - xy);
            nearest = nearest.max(z);
        }
        let distance = ((high + low) / (2.0 * half)).max_element();
        // A flat or single-point model may touch the eye: keep it in front by its own size.
        let size = positions.iter().map(|p| p.distance(centre)).fold(0.0, f32::max);
        let distance = distance.max(nearest + (1e-3 * size).max(f32::MIN_POSITIVE));
        let offset = (high - low) / 2.0;
        Ok(Self::new(centre + right * offset.x + up * offset.y + back * distance, view))
    }

    fn new(eye: Vec3, view: &View) -> Self {
        let [right, up, back] = view.axes();
        Self { eye, right, up, back, half_height: (view.field_of_view / 2.0).tan() }
    }

    /// The camera turned with the world around the origin: it sees a turned world as it saw the world before.
    pub fn rotated(&self, rotation: Quat) -> Self {
        Self {
            eye: rotation * self.eye,
            right: rotation * self.right,
            up: rotation * self.up,
            back: rotation * self.back,
            ..*self
        }
    }

    /// Where the camera is.
    pub fn eye(&self) -> Vec3 {
        self.eye
    }

    /// The ray through the point `at` of a picture, in pixels from its top left corner; its direction has unit length.
    pub fn ray(&self, at: Vec2, width: usize, height: usize) -> Ray {
        let size = Vec2::new(width as f32, height as f32);
        let plane = (at * 2.0 - size) * (self.half_height / size.y);
        let direction = (plane.x * self.right - plane.y * self.up - self.back).normalize();
        Ray { origin: self.eye, direction, t_min: 0.0, t_max: f32::INFINITY }
    }
}

/// Centre of the box around `positions`.
fn centre(positions: &[Vec3]) -> Result<Vec3> {
    let low = positions.iter().copied().reduce(Vec3::min);
    let high = positions.iter().copied().reduce(Vec3::max);
    match (low, high) {
        // Halved first: the sum of two large numbers is no number.
        (Some(low), Some(high)) if (low / 2.0 + high / 2.0).is_finite() => Ok(low / 2.0 + high / 2.0),
        (Some(_), Some(_)) => Err(Error::Request("a position is not a finite number".into())),
        _ => Err(Error::Request("there is nothing to look at: the model has no positions".into())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> Vec<Vec3> {
        (0..8).map(|k| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32) * 2.0 + 5.0).collect()
    }

    /// Picture coordinates in [−1, 1] of a point; the inverse of `Camera::ray`.
    fn seen_at(camera: &Camera, aspect: f32, point: Vec3) -> Vec2 {
        let p = point - camera.eye;
        let depth = -p.dot(camera.back);
        Vec2::new(p.dot(camera.right) / aspect, p.dot(camera.up)) / (depth * camera.half_height)
    }

    #[test]
    fn a_fitted_model_touches_the_margin_on_both_sides_and_stays_within_it() {
        for aspect in [0.3, 1.0, 4.0 / 3.0, 5.0] {
            for elevation in [-90.0_f32, -40.0, 0.0, 18.0, 90.0] {
                let view = View { elevation: elevation.to_radians(), ..View::default() };
                let camera = Camera::fit(&cube(), &view, aspect, 0.1).unwrap();
                let seen: Vec<Vec2> = cube().iter().map(|&p| seen_at(&camera, aspect, p)).collect();
                let low = seen.iter().copied().fold(Vec2::INFINITY, Vec2::min);
                let high = seen.iter().copied().fold(Vec2::NEG_INFINITY, Vec2::max);
                let touches = |low: f32, high: f32| (low + 0.9).abs() <= 1e-4 && (high - 0.9).abs() <= 1e-4;
                assert!(
                    touches(low.x, high.x) || touches(low.y, high.y),
                    "{aspect} {elevation}: {low} {high}"
                );
                assert!(low.min_element() >= -0.9001 && high.max_element() <= 0.9001);
            }
        }
    }

    #[test]
    fn the_middle_ray_of_an_orbit_goes_through_the_centre() {
        for elevation in [-90.0_f32, 0.0, 30.0, 90.0] {
            let view = View { elevation: elevation.to_radians(), ..View::default() };
            let camera = Camera::orbit(&cube(), &view, 3.0).unwrap();
            let ray = camera.ray(Vec2::new(40.0, 30.0), 80, 60);
            // The cube's corners are √3 from its centre at (6, 6, 6).
            let reached = ray.origin + ray.direction * (3.0 * 3.0_f32.sqrt());
            assert!(reached.distance(Vec3::splat(6.0)) <= 1e-5, "{reached}");
        }
    }

    #[test]
    fn rows_go_down_and_columns_go_right() {
        let view = View { azimuth: 0.0, elevation: 0.0, field_of_view: 1.0 };
        let camera = Camera::orbit(&cube(), &view, 3.0).unwrap();
        let corner = camera.ray(Vec2::ZERO, 80, 60).direction;
        assert!(corner.x < 0.0 && corner.y > 0.0 && corner.z < 0.0, "{corner}");
    }

    #[test]
    fn a_turned_camera_sees_a_turned_world_alike() {
        let turn = Quat::from_rotation_y(0.7) * Quat::from_rotation_x(1.9);
        let camera = Camera::orbit(&cube(), &View::default(), 2.5).unwrap();
        let at = Vec2::new(13.0, 44.0);
        let (before, after) = (camera.ray(at, 80, 60), camera.rotated(turn).ray(at, 80, 60));
        assert!((turn * before.direction).distance(after.direction) <= 1e-6);
        assert!((turn * before.origin).distance(after.origin) <= 1e-5);
    }

    #[test]
    fn what_cannot_be_seen_is_refused() {
        let view = View::default();
        assert!(Camera::fit(&[], &view, 1.0, 0.1).is_err());
        assert!(Camera::fit(&cube(), &view, f32::NAN, 0.1).is_err());
        assert!(Camera::orbit(&cube(), &view, 0.0).is_err());
        assert!(Camera::orbit(&cube(), &View { field_of_view: 0.0, ..view }, 1.0).is_err());
        assert!(Camera::fit(&[Vec3::NAN], &view, 1.0, 0.1).is_err());
        assert!(Camera::fit(&[Vec3::ONE], &view, 1.0, 0.1).is_ok());
    }
}
