//! Many rays from one point: 64 at a time go through the hierarchy together.
//!
//! A node is visited once for all rays of the bundle that reach it, which spreads the cost of its memory, of the
//! difference to the origin and of mispredicted branches. Boxes and triangles are in the lanes, as for single rays, and
//! the triangle test is the same, so that the hits are.

use std::mem::MaybeUninit;

use glam::{Mat3, Vec3};

use super::Bvh;
#[cfg(target_arch = "x86_64")]
use super::lanes::Avx2;
use super::lanes::{Isa, Lanes, Portable};
use super::node::{LEAF, Node, STACK, TriangleBlock, WIDTH};
use super::traverse::{Candidates, MAX_ORIGIN, MIN_COMPONENT, PAD, inside, sheared};
use crate::scene::Vantage;

/// Rays of a bundle: a bit each.
pub const SIZE: usize = u64::BITS as usize;

/// Sine of the angle by which a triangle at a vertex must rise above its tangent plane to block anything: below it the
/// irradiance that a blocker can take away is under sin² = 1e-6 of the whole.
const RISE: f32 = 1e-3;

/// Directions in a frame of their own, for [`Bvh::blocked`]. Neighbours in this order share most of the work if they
/// are neighbours on the sphere.
#[derive(Clone, Debug, Default)]
pub struct Directions {
    /// Components, padded with zeros to whole bundles.
    components: [Vec<f32>; 3],
    count: usize,
}

impl Directions {
    /// Takes unit vectors.
    pub fn new(directions: &[Vec3]) -> Self {
        let mut components = [(); 3].map(|()| vec![0.0; directions.len().next_multiple_of(SIZE)]);
        for (i, direction) in directions.iter().enumerate() {
            for axis in 0..3 {
                components[axis][i] = direction[axis];
            }
        }
        Self { components, count: directions.len() }
    }

    /// One of them.
    pub fn get(&self, index: usize) -> Vec3 {
        Vec3::from_array(self.components.each_ref().map(|component| component[index]))
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Words of 64 bits that hold a bit for each.
    pub fn word_count(&self) -> usize {
        self.count.div_ceil(SIZE)
    }
}

/// Sets a bit of `blocked` for each direction that is blocked.
pub fn blocked(bvh: &Bvh, vantage: &Vantage, world_from_local: &Mat3, set: &Directions, blocked: &mut [u64]) {
    assert_eq!(blocked.len(), set.word_count(), "a bit for each direction");
    blocked.fill(0);
    let start = Start::new(bvh, vantage);
    if start.reach > MAX_ORIGIN || !start.reach.is_finite() {
        return;
    }
    match bvh.isa {
        Isa::Portable => blocked_in::<Portable>(bvh, &start, world_from_local, set, blocked),
        // SAFETY: `Isa::available` made these after detecting the features.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => unsafe { blocked_avx2(bvh, &start, world_from_local, set, blocked) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => unsafe { blocked_avx512(bvh, &start, world_from_local, set, blocked) },
    }
}

/// # Safety
/// The machine has AVX2, FMA and BMI1.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1")]
unsafe fn blocked_avx2(bvh: &Bvh, start: &Start, frame: &Mat3, set: &Directions, blocked: &mut [u64]) {
    blocked_in::<Avx2>(bvh, start, frame, set, blocked)
}

/// # Safety
/// The machine has AVX2, FMA, BMI1 and AVX-512 F, VL and DQ.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,avx512f,avx512vl,avx512dq")]
unsafe fn blocked_avx512(bvh: &Bvh, start: &Start, frame: &Mat3, set: &Directions, blocked: &mut [u64]) {
    blocked_in::<Avx2>(bvh, start, frame, set, blocked)
}

/// Where the rays start, in the coordinates of the nodes.
pub struct Start {
    pub origin: [f32; 3],
    pub vertex: [f32; 3],
    pub normal: Vec3,
    /// Largest coordinate of origin and scene.
    pub reach: f32,
    pub t_min: f32,
    pub t_max: f32,
    /// Boxes end later, by what a hit's distance may be off.
    pub box_end: f32,
}

impl Start {
    pub fn new(bvh: &Bvh, vantage: &Vantage) -> Self {
        let vertex = vantage.position * bvh.scale;
        let origin = vertex + vantage.offset() * bvh.diagonal;
        let reach = origin.abs().max_element().max(1.0);
        let reach = if origin.is_finite() { reach } else { f32::INFINITY };
        let (origin, vertex) = (origin.to_array(), vertex.to_array());
        let t_max = vantage.t_max * bvh.scale;
        let t_min = f32::MIN_POSITIVE;
        let mut start = Self { origin, vertex, normal: vantage.normal, reach, t_min, t_max, box_end: 0.0 };
        start.box_end = start.box_end(t_max);
        start
    }

    /// Where boxes end that may hold a hit before `t`.
    pub fn box_end(&self, t: f32) -> f32 {
        t + PAD * (self.reach + t)
    }
}

/// What the tests need of each ray.
pub struct Rays {
    inverse: [[f32; SIZE]; 3],
    shear: [[f32; SIZE]; 3],
    /// Which axis comes first: the direction is longest along the third from it.
    first_axis: [u8; SIZE],
}

impl Rays {
    pub const NONE: Self = Self { inverse: [[0.0; SIZE]; 3], shear: [[0.0; SIZE]; 3], first_axis: [0; SIZE] };

    /// Bundle number `bundle` of a set.
    // Loops over arrays without calls or branches: the compiler vectorises them for the instruction set at hand.
    #[inline(always)]
    pub fn load(&mut self, frame: &[f32; 9], set: &Directions, bundle: usize) {
        let range = bundle * SIZE..(bundle + 1) * SIZE;
        let (x, y, z) =
            (&set.components[0][range.clone()], &set.components[1][range.clone()], &set.components[2][range]);
        let mut direction = [[0.0f32; SIZE]; 3];
        for axis in 0..3 {
            for r in 0..SIZE {
                let d = frame[axis] * x[r] + frame[3 + axis] * y[r] + frame[6 + axis] * z[r];
                direction[axis][r] = d;
                let floored = if d.abs() < MIN_COMPONENT { MIN_COMPONENT.copysign(d) } else { d };
                self.inverse[axis][r] = 1.0 / floored;
            }
        }
        for r in 0..SIZE {
            let (dx, dy, dz) = (direction[0][r], direction[1][r], direction[2][r]);
            let (ix, iy, iz) = (self.inverse[0][r], self.inverse[1][r], self.inverse[2][r]);
            let is_x = dx.abs() >= dy.abs() && dx.abs() >= dz.abs();
            let is_y = !is_x && dy.abs() >= dz.abs();
            let along = if is_x {
                ix
            } else if is_y {
                iy
            } else {
                iz
            };
            let first = if is_x {
                dy
            } else if is_y {
                dz
            } else {
                dx
            };
            let second = if is_x {
                dz
            } else if is_y {
                dx
            } else {
                dy
            };
            self.shear[0][r] = first * along;
            self.shear[1][r] = second * along;
            self.shear[2][r] = along;
            self.first_axis[r] = if is_x {
                1
            } else if is_y {
                2
            } else {
                0
            };
        }
    }
}

#[derive(Clone, Copy)]
struct Entry {
    child: u32,
    rays: u64,
}

#[inline(always)]
fn blocked_in<V: Lanes>(bvh: &Bvh, start: &Start, frame: &Mat3, set: &Directions, blocked: &mut [u64]) {
    let frame = frame.to_cols_array();
    let mut rays = Rays::NONE;
    let mut stack = [MaybeUninit::<Entry>::uninit(); STACK];
    for (bundle, blocked) in blocked.iter_mut().enumerate() {
        rays.load(&frame, set, bundle);
        let count = (set.count - bundle * SIZE).min(SIZE);
        let all = u64::MAX >> (SIZE - count);
        stack[0].write(Entry { child: 0, rays: all });
        let mut height = 1;
        while height > 0 {
            height -= 1;
            // SAFETY: entries below the height were written.
            let Entry { child, rays: active } = unsafe { stack.get_unchecked(height).assume_init() };
            let active = active & !*blocked;
            if active == 0 {
                continue;
            }
            if child & LEAF != 0 {
                // SAFETY: children flagged so are indices of blocks, by construction.
                let block = unsafe { bvh.blocks.get_unchecked((child & !LEAF) as usize) };
                *blocked |= hit::<V>(block, start, &rays, active);
                continue;
            }
            // SAFETY: children are indices of nodes, by construction.
            let node = unsafe { bvh.nodes.get_unchecked(child as usize) };
            let box_end = V::splat(start.box_end);
            let met = meet::<V>(node, start, &rays, active, |_| box_end);
            for c in 0..(node.child_count as usize).min(WIDTH) {
                // SAFETY: a node leaves seven entries behind at most, and there are no more than MAX_DEPTH above it.
                unsafe {
                    stack.get_unchecked_mut(height).write(Entry { child: node.children[c], rays: met[c] })
                };
                height += usize::from(met[c] != 0);
            }
            if *blocked == all {
                break;
            }
        }
    }
}

/// For each child the rays that meet its box before it ends for them.
#[inline(always)]
pub fn meet<V: Lanes>(
    node: &Node,
    start: &Start,
    rays: &Rays,
    mut active: u64,
    box_end: impl Fn(usize) -> V,
) -> [u64; WIDTH] {
    let pad = PAD * start.reach;
    let [x, y, z] = start.origin;
    let low_x = V::load(&node.bounds[0]).sub(V::splat(x + pad));
    let low_y = V::load(&node.bounds[1]).sub(V::splat(y + pad));
    let low_z = V::load(&node.bounds[2]).sub(V::splat(z + pad));
    let high_x = V::load(&node.bounds[3]).sub(V::splat(x - pad));
    let high_y = V::load(&node.bounds[4]).sub(V::splat(y - pad));
    let high_z = V::load(&node.bounds[5]).sub(V::splat(z - pad));
    let zero = V::splat(0.0);
    let mut met = [0u8; SIZE];
    while active != 0 {
        let r = active.trailing_zeros() as usize % SIZE;
        active &= active - 1;
        let inverse = V::splat(rays.inverse[0][r]);
        let (x0, x1) = (low_x.mul(inverse), high_x.mul(inverse));
        let inverse = V::splat(rays.inverse[1][r]);
        let (y0, y1) = (low_y.mul(inverse), high_y.mul(inverse));
        let inverse = V::splat(rays.inverse[2][r]);
        let (z0, z1) = (low_z.mul(inverse), high_z.mul(inverse));
        let begin = x0.min(x1).max(y0.min(y1)).max(z0.min(z1).max(zero));
        let end = x0.max(x1).min(y0.max(y1)).min(z0.max(z1).min(box_end(r)));
        met[r] = begin.le(end) as u8;
    }
    V::transpose(&met)
}

/// The rays that hit a triangle of the block which counts.
#[inline(always)]
fn hit<V: Lanes>(block: &TriangleBlock, start: &Start, rays: &Rays, mut active: u64) -> u64 {
    let around = around::<V>(block, start.vertex, start.normal);
    let relative = relative::<V>(block, start);
    let (t_min, t_max) = (V::splat(start.t_min), V::splat(start.t_max));
    let mut hit = 0;
    while active != 0 {
        let r = active.trailing_zeros() as usize % SIZE;
        active &= active - 1;
        if let Some(candidates) = triangles_at::<V>(&relative, rays, r, !around) {
            hit |= u64::from(candidates.within(t_min, t_max) != 0) << r;
        }
    }
    hit
}

/// The corners of a block's triangles, relative to where the rays start.
#[inline(always)]
pub fn relative<V: Lanes>(block: &TriangleBlock, start: &Start) -> [V; 9] {
    let mut relative = [V::splat(0.0); 9];
    for row in 0..9 {
        relative[row] = V::load(&block.corners[row]).sub(V::splat(start.origin[row % 3]));
    }
    relative
}

/// Which of the triangles `lanes` with these corners the line of ray `r` passes through.
#[inline(always)]
pub fn triangles_at<V: Lanes>(relative: &[V; 9], rays: &Rays, r: usize, lanes: u32) -> Option<Candidates<V>> {
    let (shear_x, shear_y) = (V::splat(rays.shear[0][r]), V::splat(rays.shear[1][r]));
    let (a, b, c) = match rays.first_axis[r] {
        0 => corners::<V, 0, 1, 2>(relative, shear_x, shear_y),
        1 => corners::<V, 1, 2, 0>(relative, shear_x, shear_y),
        _ => corners::<V, 2, 0, 1>(relative, shear_x, shear_y),
    };
    inside(&a, &b, &c, V::splat(rays.shear[2][r]), lanes)
}

/// The corners of eight triangles, sheared along axis `Z`.
#[inline(always)]
fn corners<V: Lanes, const X: usize, const Y: usize, const Z: usize>(
    relative: &[V; 9],
    shear_x: V,
    shear_y: V,
) -> ([V; 3], [V; 3], [V; 3]) {
    (
        sheared(relative[X], relative[Y], relative[Z], shear_x, shear_y),
        sheared(relative[3 + X], relative[3 + Y], relative[3 + Z], shear_x, shear_y),
        sheared(relative[6 + X], relative[6 + Y], relative[6 + Z], shear_x, shear_y),
    )
}

/// The triangles of a block that have a corner at `vertex` and do not rise above its tangent plane.
#[inline(always)]
pub fn around<V: Lanes>(block: &TriangleBlock, vertex: [f32; 3], normal: Vec3) -> u32 {
    let mut touching = 0;
    for first in [0, 3, 6] {
        touching |= !(V::load(&block.corners[first]).ne(V::splat(vertex[0]))
            | V::load(&block.corners[first + 1]).ne(V::splat(vertex[1]))
            | V::load(&block.corners[first + 2]).ne(V::splat(vertex[2])));
    }
    touching &= (1 << WIDTH) - 1;
    if touching == 0 { 0 } else { touching & !rising(block, touching, Vec3::from(vertex), normal) }
}

/// Those triangles of `lanes` with a corner that stands above the tangent plane of the vertex.
#[inline(never)]
fn rising(block: &TriangleBlock, mut lanes: u32, vertex: Vec3, normal: Vec3) -> u32 {
    let mut rising = 0;
    while lanes != 0 {
        let lane = lanes.trailing_zeros() as usize;
        lanes &= lanes - 1;
        for corner in block.corners.chunks_exact(3) {
            let edge = Vec3::new(corner[0][lane], corner[1][lane], corner[2][lane]) - vertex;
            rising |= u32::from(edge.dot(normal) > RISE * edge.length()) << lane;
        }
    }
    rising
}
