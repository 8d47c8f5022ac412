//! Where an object is when.

use std::f32::consts::TAU;

use glam::{Quat, Vec3};

use crate::scene::Pose;

/// The way of an object: from key to key, and around itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// At least one, at rising times.
    pub keys: Vec<Key>,
    /// Turns the object in its own axes besides.
    pub spin: Option<Spin>,
    /// One for all times.
    pub scale: f32,
}

/// A place on the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// Seconds.
    pub time: f32,
    /// Where the object's origin is.
    pub position: Vec3,
    /// How it is turned.
    pub rotation: Quat,
}

/// A steady turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spin {
    /// In the object's own axes, of unit length.
    pub axis: Vec3,
    /// Seconds of one turn.
    pub period: f32,
}

impl Motion {
    /// An object that stands still.
    pub fn still(pose: Pose) -> Self {
        let key = Key { time: 0.0, position: pose.position, rotation: pose.rotation };
        Self { keys: vec![key], spin: None, scale: pose.scale }
    }

    /// Where the object is: between keys on a straight way, turning evenly; before the first and after the last key there.
    pub fn at(&self, time: f32) -> Pose {
        let above = self.keys.partition_point(|key| key.time <= time);
        let low = self.keys[above.saturating_sub(1)];
        let high = self.keys[above.min(self.keys.len() - 1)];
        let share = if high.time > low.time { (time - low.time) / (high.time - low.time) } else { 0.0 };
        let share = share.clamp(0.0, 1.0);
        let mut rotation = low.rotation.slerp(high.rotation, share);
        if let Some(Spin { axis, period }) = self.spin {
            rotation *= Quat::from_axis_angle(axis, TAU * (time / period).fract());
        }
        let position = low.position.lerp(high.position, share);
        Pose { rotation: rotation.normalize(), position, scale: self.scale }
    }

    /// Whether the object is the same at all times.
    pub fn is_still(&self) -> bool {
        self.spin.is_none() && self.keys.len() == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_keys_the_way_is_straight_and_the_turn_even() {
        let key = |time: f32, x: f32, angle: f32| Key {
            time,
            position: Vec3::new(x, 0.0, 0.0),
            rotation: Quat::from_rotation_y(angle),
        };
        let motion = Motion { keys: vec![key(1.0, 0.0, 0.0), key(3.0, 4.0, 1.0)], spin: None, scale: 2.0 };
        assert_eq!(motion.at(0.0).position.x, 0.0);
        assert_eq!(motion.at(9.0).position.x, 4.0);
        let half = motion.at(2.0);
        assert_eq!((half.position.x, half.scale), (2.0, 2.0));
        assert!((half.rotation * Vec3::Z - Quat::from_rotation_y(0.5) * Vec3::Z).length() <= 1e-6);
        let spinning = Motion { spin: Some(Spin { axis: Vec3::X, period: 4.0 }), ..motion };
        // A quarter turn takes y to z, before the object is turned itself.
        let turned = spinning.at(1.0).rotation * Vec3::Y;
        assert!((turned - Vec3::Z).length() <= 1e-6, "{turned}");
        assert!(!spinning.is_still() && Motion::still(Pose::IDENTITY).is_still());
    }
}
