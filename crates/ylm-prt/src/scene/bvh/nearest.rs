//! The nearest triangle along each of many rays from one point: as [`super::bundle`], with the distances kept.
//!
//! Children are visited from near to far. All rays start in one place, so that the distance of a box from there orders
//! them for every ray, and cuts off rays that have hit something nearer.

use std::mem::MaybeUninit;

use glam::Mat3;

use super::bundle::{Directions, Rays, SIZE, Start, around, meet, triangles_at};
#[cfg(target_arch = "x86_64")]
use super::lanes::Avx2;
use super::lanes::{Isa, Lanes, Portable};
use super::node::{LEAF, Node, STACK, TriangleBlock, WIDTH};
use super::traverse::{MAX_ORIGIN, PAD};
use super::{Bvh, Hit};
use crate::scene::Vantage;

/// Writes the nearest hit of each direction.
pub fn nearest(
    bvh: &Bvh,
    vantage: &Vantage,
    world_from_local: &Mat3,
    set: &Directions,
    hits: &mut [Option<Hit>],
) {
    assert_eq!(hits.len(), set.count(), "a hit for each direction");
    hits.fill(None);
    let start = Start::new(bvh, vantage);
    if start.reach > MAX_ORIGIN || !start.reach.is_finite() {
        return;
    }
    match bvh.isa {
        Isa::Portable => nearest_in::<Portable>(bvh, &start, world_from_local, set, hits),
        // SAFETY: `Isa::available` made these after detecting the features.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => unsafe { nearest_avx2(bvh, &start, world_from_local, set, hits) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => unsafe { nearest_avx512(bvh, &start, world_from_local, set, hits) },
    }
}

/// # Safety
/// The machine has AVX2, FMA and BMI1.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1")]
unsafe fn nearest_avx2(bvh: &Bvh, start: &Start, frame: &Mat3, set: &Directions, hits: &mut [Option<Hit>]) {
    nearest_in::<Avx2>(bvh, start, frame, set, hits)
}

/// # Safety
/// The machine has AVX2, FMA, BMI1 and AVX-512 F, VL and DQ.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,avx512f,avx512vl,avx512dq")]
unsafe fn nearest_avx512(bvh: &Bvh, start: &Start, frame: &Mat3, set: &Directions, hits: &mut [Option<Hit>]) {
    nearest_in::<Avx2>(bvh, start, frame, set, hits)
}

/// The nearest hits so far.
struct Best {
    t: [f32; SIZE],
    /// Where boxes end that may hold a nearer one.
    box_end: [f32; SIZE],
    triangle: [u32; SIZE],
    barycentric: [[f32; 2]; SIZE],
}

impl Best {
    fn new(start: &Start) -> Self {
        Self {
            t: [start.t_max; SIZE],
            box_end: [start.box_end; SIZE],
            triangle: [u32::MAX; SIZE],
            barycentric: [[0.0; 2]; SIZE],
        }
    }

    /// Those rays for which something at this distance may be nearer than what they have hit.
    #[inline(always)]
    fn reach<V: Lanes>(&self, distance: f32) -> u64 {
        let distance = V::splat(distance);
        let mut rays = 0;
        for (group, ends) in self.box_end.as_chunks::<WIDTH>().0.iter().enumerate() {
            rays |= u64::from(distance.le(V::load(ends))) << (WIDTH * group);
        }
        rays
    }
}

#[derive(Clone, Copy)]
struct Entry {
    child: u32,
    rays: u64,
    /// No ray enters it nearer than this.
    distance: f32,
}

#[inline(always)]
fn nearest_in<V: Lanes>(bvh: &Bvh, start: &Start, frame: &Mat3, set: &Directions, hits: &mut [Option<Hit>]) {
    let frame = frame.to_cols_array();
    let mut rays = Rays::NONE;
    let mut stack = [MaybeUninit::<Entry>::uninit(); STACK];
    for (bundle, hits) in hits.chunks_mut(SIZE).enumerate() {
        rays.load(&frame, set, bundle);
        let mut best = Best::new(start);
        stack[0].write(Entry { child: 0, rays: u64::MAX >> (SIZE - hits.len()), distance: 0.0 });
        let mut height = 1;
        while height > 0 {
            height -= 1;
            // SAFETY: entries below the height were written.
            let Entry { child, rays: active, distance } = unsafe { stack[height].assume_init() };
            let active = active & best.reach::<V>(distance);
            if active == 0 {
                continue;
            }
            if child & LEAF != 0 {
                let block = &bvh.blocks[(child & !LEAF) as usize];
                hit::<V>(block, start, &rays, active, &mut best);
                continue;
            }
            let node = &bvh.nodes[child as usize];
            let met = meet::<V>(node, start, &rays, active, |ray| V::splat(best.box_end[ray]));
            let distances = distances::<V>(node, start);
            let bottom = height;
            for c in 0..(node.child_count as usize).min(WIDTH) {
                if met[c] == 0 {
                    continue;
                }
                // Insertion keeps the nearest on top.
                let mut place = height;
                while place > bottom {
                    // SAFETY: written when it was pushed.
                    let below = unsafe { stack[place - 1].assume_init() };
                    if below.distance >= distances[c] {
                        break;
                    }
                    stack[place].write(below);
                    place -= 1;
                }
                stack[place].write(Entry { child: node.children[c], rays: met[c], distance: distances[c] });
                height += 1;
            }
        }
        for (ray, hit) in hits.iter_mut().enumerate() {
            if best.triangle[ray] != u32::MAX {
                let (t, triangle) = (best.t[ray] / bvh.scale, best.triangle[ray]);
                *hit = Some(Hit { t, triangle, barycentric: best.barycentric[ray] });
            }
        }
    }
}

/// How far the boxes of a node are from the start of the rays, at least.
#[inline(always)]
fn distances<V: Lanes>(node: &Node, start: &Start) -> [f32; WIDTH] {
    let zero = V::splat(0.0);
    let pad = PAD * start.reach;
    let mut square = zero;
    for axis in 0..3 {
        let below = V::load(&node.bounds[axis]).sub(V::splat(start.origin[axis] + pad));
        let above = V::splat(start.origin[axis] - pad).sub(V::load(&node.bounds[axis + 3]));
        let beside = below.max(above).max(zero);
        square = square.add(beside.mul(beside));
    }
    let mut distances = [0.0; WIDTH];
    square.store(&mut distances);
    // A few roundings less; the directions have them as well.
    distances.map(|square| square.sqrt() * (1.0 - 16.0 * f32::EPSILON))
}

/// Notes the triangles of a block that are nearer than what the rays have hit; of several at the same distance the one
/// of smallest index.
#[inline(always)]
fn hit<V: Lanes>(block: &TriangleBlock, start: &Start, rays: &Rays, mut active: u64, best: &mut Best) {
    let counting = !around::<V>(block, start.vertex, start.normal);
    let relative = super::bundle::relative::<V>(block, start);
    let t_min = V::splat(start.t_min);
    while active != 0 {
        let ray = active.trailing_zeros() as usize % SIZE;
        active &= active - 1;
        let Some(candidates) = triangles_at::<V>(&relative, rays, ray, counting) else { continue };
        let mut hit = candidates.within(t_min, V::splat(best.t[ray]));
        if hit == 0 {
            continue;
        }
        let [t, v, w, det] = candidates.values();
        while hit != 0 {
            let lane = hit.trailing_zeros() as usize;
            hit &= hit - 1;
            let triangle = block.triangles[lane];
            if t[lane] < best.t[ray] || (t[lane] == best.t[ray] && triangle < best.triangle[ray]) {
                best.t[ray] = t[lane];
                best.box_end[ray] = start.box_end(t[lane]);
                best.triangle[ray] = triangle;
                best.barycentric[ray] = [v[lane] / det[lane], w[lane] / det[lane]];
            }
        }
    }
}
