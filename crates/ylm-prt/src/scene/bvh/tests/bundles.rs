//! Many directions from one place at once, against rays one by one.

use std::f32::consts::PI;

use glam::{Mat3, Quat, Vec3, vec3};

use super::super::{Bvh, Directions, Hit, Ray};
use super::{Numbers, Verdict, every_isa, scattered, sphere, verdict};
use crate::scene::Vantage;

/// The blocked directions of a vantage, one by one.
fn blocked(bvh: &Bvh, vantage: &Vantage, frame: &Mat3, directions: &[Vec3]) -> Vec<bool> {
    let set = Directions::new(directions);
    let mut words = vec![u64::MAX; set.word_count()];
    bvh.blocked(vantage, frame, &set, &mut words);
    let beyond = (directions.len()..64 * words.len()).filter(|i| words[i / 64] >> (i % 64) & 1 == 1).count();
    assert_eq!(beyond, 0, "bits beyond the directions are clear");
    (0..directions.len()).map(|i| words[i / 64] >> (i % 64) & 1 == 1).collect()
}

#[test]
fn bundles_hit_what_single_rays_hit() {
    let mut numbers = Numbers(5);
    for soup in [sphere(12), scattered(400, 0.2, &mut numbers), scattered(3000, 0.02, &mut numbers)] {
        let bvhs = every_isa(&soup);
        for count in [0, 1, 63, 64, 65, 300] {
            let directions: Vec<Vec3> = (0..count).map(|_| numbers.direction()).collect();
            let turn = Mat3::from_quat(Quat::from_xyzw(0.3, 0.1, -0.7, 0.4).normalize());
            for frame in [Mat3::IDENTITY, turn] {
                let vantage = Vantage {
                    position: 1.2 * numbers.point(),
                    normal: Vec3::Y,
                    inward: Vec3::ZERO,
                    bias: 0.0,
                    t_max: f32::INFINITY,
                };
                let found: Vec<Vec<bool>> =
                    bvhs.iter().map(|bvh| blocked(bvh, &vantage, &frame, &directions)).collect();
                assert!(found.iter().all(|f| *f == found[0]), "every instruction set finds the same");
                for (&local, &found) in directions.iter().zip(&found[0]) {
                    let ray = Ray::new(vantage.position, frame * local);
                    // The same test; only the direction may be rounded otherwise, off the identity.
                    let single = bvhs[0].occluded(&ray);
                    assert!(frame != Mat3::IDENTITY || single == found, "{ray:?}");
                    let corners = |triangle: &[u32; 3]| triangle.map(|i| soup.0[i as usize]);
                    let verdicts: Vec<Verdict> =
                        soup.1.iter().map(|triangle| verdict(&ray, corners(triangle), 1e-4)).collect();
                    let is_hit = verdicts.iter().any(|v| matches!(v, Verdict::Hit(_)));
                    assert!(found == is_hit || verdicts.contains(&Verdict::Unclear), "{ray:?}");
                }
            }
        }
    }
}

#[test]
fn the_nearest_hits_of_bundles_are_those_of_single_rays() {
    let mut numbers = Numbers(71);
    // Twice the same triangles: of two at one distance the first counts.
    let mut doubled = scattered(300, 0.3, &mut numbers);
    doubled.1.extend(doubled.1.clone());
    for (soup, t_max) in [
        (scattered(3000, 0.2, &mut numbers), f32::INFINITY),
        (sphere(40), f32::INFINITY),
        (doubled, 0.8),
        (scattered(5, 1.0, &mut numbers), f32::INFINITY),
    ] {
        let bvhs = every_isa(&soup);
        let mut hit_count = 0;
        for count in [1, 64, 300] {
            for _ in 0..20 {
                // Away from all corners, so that no triangle is left out.
                let (position, normal) = (0.7 * numbers.point(), numbers.direction());
                let vantage = Vantage { position, normal, inward: Vec3::ZERO, bias: 0.0, t_max };
                let frame = Mat3::from_quat(Quat::from_rotation_arc(Vec3::Z, normal));
                let directions: Vec<Vec3> = (0..count).map(|_| numbers.direction()).collect();
                let set = Directions::new(&directions);
                let mut hits = vec![None; count];
                let mut expected = None;
                for bvh in &bvhs {
                    bvh.nearest(&vantage, &frame, &set, &mut hits);
                    let blocked = blocked(bvh, &vantage, &frame, &directions);
                    assert!(blocked.iter().zip(&hits).all(|(&blocked, hit)| blocked == hit.is_some()));
                    assert_eq!(*expected.get_or_insert_with(|| hits.clone()), hits);
                }
                for (direction, hit) in directions.iter().zip(&hits) {
                    let ray = Ray { t_max, ..Ray::new(position, frame * *direction) };
                    let single = bvhs[0].closest(&ray);
                    hit_count += usize::from(hit.is_some());
                    let (Some(hit), Some(single)) = (hit, single) else {
                        assert_eq!(hit.is_some(), single.is_some(), "{ray:?}");
                        continue;
                    };
                    // The directions differ by their roundings.
                    assert!((hit.t - single.t).abs() <= 2e-6 * (1.0 + single.t), "{hit:?} {single:?}");
                    let at = |hit: &Hit| {
                        let [a, b, c] = soup.1[hit.triangle as usize].map(|i| soup.0[i as usize]);
                        let [v, w] = hit.barycentric;
                        a + v * (b - a) + w * (c - a)
                    };
                    assert!(
                        (at(hit) - at(&single)).length() <= 1e-5 * (1.0 + single.t),
                        "{hit:?} {single:?}"
                    );
                }
            }
        }
        assert!(hit_count > 1000, "{hit_count}");
    }
}

#[test]
fn bundles_do_not_leak_through_a_closed_mesh() {
    let (positions, triangles) = sphere(16);
    let vantage = Vantage {
        position: vec3(0.2, -0.3, 0.1),
        normal: Vec3::X,
        inward: Vec3::ZERO,
        bias: 0.0,
        t_max: f32::INFINITY,
    };
    let mut directions = Vec::new();
    for triangle in &triangles {
        let [a, b, c] = triangle.map(|i| positions[i as usize] - vantage.position);
        directions.extend([a, b, c, a + b, b + c, c + a].map(Vec3::normalize));
    }
    for bvh in every_isa(&(positions, triangles)) {
        assert!(blocked(&bvh, &vantage, &Mat3::IDENTITY, &directions).into_iter().all(|blocked| blocked));
    }
}

#[test]
fn bundles_end_where_they_are_told_to() {
    let mut numbers = Numbers(7);
    let soup = scattered(600, 0.15, &mut numbers);
    let bvhs = every_isa(&soup);
    let directions: Vec<Vec3> = (0..300).map(|_| numbers.direction()).collect();
    for t_max in [1e-3, 0.2, 0.5, 1.0, 3.0] {
        let vantage = Vantage {
            position: 1.2 * numbers.point(),
            normal: Vec3::Y,
            inward: Vec3::ZERO,
            bias: 0.0,
            t_max,
        };
        let found: Vec<Vec<bool>> =
            bvhs.iter().map(|bvh| blocked(bvh, &vantage, &Mat3::IDENTITY, &directions)).collect();
        assert!(found.iter().all(|f| *f == found[0]), "every instruction set finds the same");
        for (&direction, &found) in directions.iter().zip(&found[0]) {
            let ray = Ray { t_max, ..Ray::new(vantage.position, direction) };
            let corners = |triangle: &[u32; 3]| triangle.map(|i| soup.0[i as usize]);
            let verdicts: Vec<Verdict> =
                soup.1.iter().map(|triangle| verdict(&ray, corners(triangle), 1e-4)).collect();
            let is_hit = verdicts.iter().any(|v| matches!(v, Verdict::Hit(_)));
            assert!(found == is_hit || verdicts.contains(&Verdict::Unclear), "{ray:?}");
        }
    }
}

#[test]
fn a_closed_mesh_within_reach_does_not_leak_and_one_beyond_does_not_block() {
    let (positions, triangles) = sphere(16);
    // The nearest point of the polyhedron, in f64, and the farthest, a vertex. Through edges and vertices as well.
    let centre =
        Vantage { position: Vec3::ZERO, normal: Vec3::X, inward: Vec3::ZERO, bias: 0.0, t_max: 1.0 + 1e-6 };
    let nearest = triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.map(|i| positions[i as usize].as_dvec3());
        a.dot((b - a).cross(c - a).normalize()).abs()
    });
    let nearest = nearest.fold(f64::INFINITY, f64::min);
    let mut directions = Vec::new();
    for triangle in &triangles {
        let [a, b, c] = triangle.map(|i| positions[i as usize]);
        directions.extend([a, b, c, a + b, b + c, c + a, a + b + c].map(Vec3::normalize));
    }
    for bvh in every_isa(&(positions, triangles)) {
        let all = blocked(&bvh, &centre, &Mat3::IDENTITY, &directions);
        assert!(all.into_iter().all(|blocked| blocked));
        let short = Vantage { t_max: nearest as f32 * (1.0 - 1e-6), ..centre };
        let none = blocked(&bvh, &short, &Mat3::IDENTITY, &directions);
        assert!(none.into_iter().all(|blocked| !blocked));
    }
}

#[test]
fn a_vertex_is_not_blocked_by_its_own_surface_but_by_walls_around_it() {
    // A fan around the origin whose rim is at height `rise`, open below.
    for (rise, sees_up, sees_low) in [(-0.5, true, true), (0.0, true, true), (1.0, true, false)] {
        let rim = (0..6).map(|i| (i as f32 * PI / 3.0).sin_cos()).map(|(s, c)| vec3(s, rise, c));
        let positions: Vec<Vec3> = [Vec3::ZERO].into_iter().chain(rim).collect();
        let triangles: Vec<[u32; 3]> = (0..6).map(|i| [0, 1 + i, 1 + (i + 1) % 6]).collect();
        let low = (0..40).map(|i| (i as f32 * 0.9).sin_cos()).map(|(s, c)| vec3(s, 0.02, c).normalize());
        let directions: Vec<Vec3> = low.collect();
        let vantage = Vantage {
            position: Vec3::ZERO,
            normal: Vec3::Y,
            inward: Vec3::ZERO,
            bias: 1e-5,
            t_max: f32::INFINITY,
        };
        for bvh in every_isa(&(positions, triangles)) {
            let up = blocked(&bvh, &vantage, &Mat3::IDENTITY, &[Vec3::Y, vec3(0.1, 0.99, -0.1).normalize()]);
            assert!(up.iter().all(|&blocked| blocked != sees_up), "rise {rise}");
            let low = blocked(&bvh, &vantage, &Mat3::IDENTITY, &directions);
            assert!(low.iter().all(|&blocked| blocked != sees_low), "rise {rise}: {low:?}");
        }
    }
}
