//! Rotations of space: every description against elementary matrices, and back, with gimbal lock.

use std::f64::consts::{FRAC_PI_2, PI};

use proptest::prelude::*;
use ylm::Error;
use ylm::rotate::{EulerOrder, Turn};

type Matrix = [[f64; 3]; 3];

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// The textbook matrices of turns about x, y and z.
fn about(axis: usize, angle: f64) -> Matrix {
    let (s, c) = angle.sin_cos();
    match axis {
        0 => [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]],
        1 => [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]],
        _ => [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]],
    }
}

fn difference(a: &Matrix, b: &Matrix) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.fold(0.0, |largest, (a, b)| {
        let error = (a - b).abs();
        if error <= largest { largest } else { error }
    })
}

/// Angles that are ordinary, locked in either kind of order, and nearly locked.
fn angles() -> Vec<[f64; 3]> {
    let mut list = Vec::new();
    for middle in [0.0, 0.7, FRAC_PI_2, 2.5, PI, -0.7, -FRAC_PI_2] {
        for nudge in [0.0, 1e-16, 1e-14, -1e-12, 1e-9, -1e-6, 1e-3] {
            for (first, last) in [(0.3, -2.0), (3.0, 3.0), (-PI, 0.0), (0.0, 0.0)] {
                list.push([first, middle + nudge, last]);
            }
        }
    }
    list
}

#[test]
fn euler_angles_are_turns_about_the_named_axes_in_turn() {
    let names = ["xyz", "xzy", "yxz", "yzx", "zxy", "zyx", "xyx", "xzx", "yxy", "yzy", "zxz", "zyz"];
    for (order, name) in EulerOrder::ALL.into_iter().zip(names) {
        assert_eq!(format!("{order:?}").to_lowercase(), name);
        let [i, j, k] = order.axes();
        assert_eq!([i, j, k].map(|axis| b"xyz"[axis]), name.as_bytes());
        for [a, b, c] in angles() {
            let expected = times(&times(&about(i, a), &about(j, b)), &about(k, c));
            let error = difference(&Turn::from_euler(order, [a, b, c]).unwrap().matrix(), &expected);
            assert!(error <= 4e-16, "{name} {a} {b} {c}: {error:e}");
        }
    }
}

#[test]
fn intrinsic_turns_are_about_axes_that_turn_along() {
    // After Z(90°) the body's x axis is the world's y: the second turn of `Zxy` is about it.
    let turn = Turn::from_euler(EulerOrder::Zxy, [FRAC_PI_2, 0.4, 0.0]).unwrap();
    let z = turn.apply([0.0, 0.0, 1.0]);
    let expected = [0.4f64.sin(), 0.0, 0.4f64.cos()];
    assert!(z.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 1e-15), "{z:?}");
}

#[test]
fn euler_angles_of_a_turn_give_it_back_locked_or_not() {
    for order in EulerOrder::ALL {
        let proper = order.axes()[0] == order.axes()[2];
        for angles in angles() {
            let turn = Turn::from_euler(order, angles).unwrap();
            let [a, b, c] = turn.euler(order);
            let range = if proper { 0.0..=PI } else { -FRAC_PI_2 - 1e-15..=FRAC_PI_2 + 1e-15 };
            assert!(range.contains(&b), "{order:?} {angles:?}: {b}");
            assert!([a, c].iter().all(|angle| -PI < *angle && *angle <= PI));
            let back = Turn::from_euler(order, [a, b, c]).unwrap();
            let error = difference(&back.matrix(), &turn.matrix());
            // Measured 2e-15.
            assert!(error <= 4e-15, "{order:?} {angles:?} as {a} {b} {c}: {error:e}");
        }
    }
}

#[test]
fn in_gimbal_lock_the_third_angle_is_0() {
    for order in EulerOrder::ALL {
        let proper = order.axes()[0] == order.axes()[2];
        let locked = if proper { [0.0, PI] } else { [FRAC_PI_2, -FRAC_PI_2] };
        for middle in locked {
            let turn = Turn::from_euler(order, [0.4, middle, 0.5]).unwrap();
            let [a, b, c] = turn.euler(order);
            assert!(c == 0.0 && (b - middle).abs() <= 1e-15, "{order:?}: {a} {b} {c}");
            assert!([0.9f64, -0.1].iter().any(|sum| (a - sum).abs() <= 4e-15), "{order:?}: {a}");
        }
    }
}

#[test]
fn a_turn_about_an_axis_is_rodrigues_formula() {
    let (axis, angle) = ([2.0 / 7.0, 3.0 / 7.0, -6.0 / 7.0], 1.3f64);
    let cross = [[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]];
    let expected = [0, 1, 2].map(|i| {
        [0, 1, 2].map(|j| {
            let unit = if i == j { angle.cos() } else { 0.0 };
            unit + (1.0 - angle.cos()) * axis[i] * axis[j] + angle.sin() * cross[i][j]
        })
    });
    for scale in [1.0, 7.0, 1e-300, 1e300] {
        let turn = Turn::from_axis_angle(axis.map(|v| v * scale), angle).unwrap();
        assert!(difference(&turn.matrix(), &expected) <= 4e-16);
        let (found, by) = turn.axis_angle();
        assert!(found.iter().zip(axis).all(|(a, b)| (a - b).abs() <= 4e-16) && (by - angle).abs() <= 4e-16);
    }
    let narrow = Turn::from_axis_angle(axis.map(|v| v as f32), angle as f32).unwrap();
    assert!(difference(&narrow.matrix(), &expected) <= 2e-7);
    assert_eq!(Turn::IDENTITY.axis_angle(), ([0.0, 0.0, 1.0], 0.0));
}

#[test]
fn half_turns_have_a_quaternion_and_an_axis() {
    for axis in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.6, -0.8, 0.0], [1.0, 1.0, -1.0]] {
        let turn = Turn::from_axis_angle(axis, PI).unwrap();
        let back = Turn::from_quaternion(turn.quaternion()).unwrap();
        assert!(difference(&turn.matrix(), &back.matrix()) <= 1e-15);
        let (found, angle) = turn.axis_angle();
        let again = Turn::from_axis_angle(found, angle).unwrap();
        assert!((angle - PI).abs() <= 1e-15 && difference(&turn.matrix(), &again.matrix()) <= 1e-15);
    }
}

#[test]
fn what_describes_no_turn_is_an_error() {
    assert!(matches!(Turn::from_axis_angle([0.0; 3], 1.0), Err(Error::Direction { .. })));
    assert!(matches!(Turn::from_axis_angle([0.0, f64::NAN, 1.0], 1.0), Err(Error::Direction { .. })));
    assert!(matches!(Turn::from_axis_angle([0.0, 0.0, 1.0], f64::INFINITY), Err(Error::Range { .. })));
    assert!(matches!(Turn::from_euler(EulerOrder::Zyz, [0.0, f64::NAN, 0.0]), Err(Error::Range { .. })));
    assert!(Turn::from_matrix([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0f32]]).is_err());
}

proptest! {
    #[test]
    fn every_description_of_a_turn_gives_it_back(q in prop::array::uniform4(-1f64..1.0), p in prop::array::uniform4(-1f64..1.0)) {
        prop_assume!(q.iter().chain(&p).any(|v| v.abs() > 1e-3));
        let (Ok(turn), Ok(next)) = (Turn::from_quaternion(q), Turn::from_quaternion(p)) else { return Ok(()) };
        let close = |other: Turn| difference(&other.matrix(), &turn.matrix()) <= 4e-15;
        prop_assert!(close(Turn::from_quaternion(turn.quaternion()).unwrap()));
        prop_assert!(close(Turn::from_matrix(turn.matrix()).unwrap()));
        let (axis, angle) = turn.axis_angle();
        prop_assert!(close(Turn::from_axis_angle(axis, angle).unwrap()));
        for order in EulerOrder::ALL {
            prop_assert!(close(Turn::from_euler(order, turn.euler(order)).unwrap()), "{order:?}");
        }
        prop_assert!(close(turn.then(&next).then(&next.inverse())));
        let both = times(&next.matrix(), &turn.matrix());
        prop_assert!(difference(&turn.then(&next).matrix(), &both) <= 4e-15);
    }
}
