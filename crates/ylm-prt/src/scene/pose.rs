//! Where a rigid object stands.

use glam::{Quat, Vec3};

/// Takes an object's own axes to the world's: x ↦ position + rotation · scale · x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Of unit length.
    pub rotation: Quat,
    /// Where the object's origin is.
    pub position: Vec3,
    /// One for all axes, above 0: shadows of a stretched object would need another field.
    pub scale: f32,
}

impl Pose {
    /// As the object is.
    pub const IDENTITY: Self = Self { rotation: Quat::IDENTITY, position: Vec3::ZERO, scale: 1.0 };

    /// A point of the object in the world.
    pub fn apply(&self, point: Vec3) -> Vec3 {
        self.position + self.rotation * (self.scale * point)
    }

    /// A point of the world in the object's axes.
    pub fn undo(&self, point: Vec3) -> Vec3 {
        self.rotation.conjugate() * (point - self.position) / self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_is_undone() {
        let pose = Pose {
            rotation: Quat::from_euler(glam::EulerRot::XYZ, 0.3, -1.0, 2.0),
            position: Vec3::new(3.0, -2.0, 0.5),
            scale: 0.25,
        };
        let point = Vec3::new(-1.0, 4.0, 2.0);
        assert!(pose.undo(pose.apply(point)).distance(point) <= 2e-6);
        assert_eq!(Pose::IDENTITY.apply(point), point);
        assert!((pose.apply(Vec3::ZERO) - pose.apply(Vec3::X)).length() - 0.25 <= 1e-6);
    }
}
