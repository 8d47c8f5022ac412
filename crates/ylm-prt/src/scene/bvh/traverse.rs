//! One ray at a time: eight boxes or eight triangles in the lanes.
//!
//! [Woop et al. 2013] "Watertight Ray/Triangle Intersection"

use std::mem::MaybeUninit;

use glam::Vec3;

#[cfg(target_arch = "x86_64")]
use super::lanes::Avx2;
use super::lanes::{Isa, Lanes, Portable};
use super::node::{LEAF, Node, STACK, TriangleBlock, WIDTH};
use super::{Bvh, Hit, Ray};

/// Components of the direction smaller than this times the largest are taken as this for boxes: over the extent of the
/// scene that moves the ray by far less than the boxes are padded.
pub const MIN_COMPONENT: f32 = 1.0 / (1u64 << 40) as f32;

/// Boxes are padded by this much of the coordinates at hand: sixteen roundings. A box test has three (plane · inverse −
/// origin · inverse, the inverse itself), a hit lies within four of its triangle (difference to the origin, shear).
pub const PAD: f32 = 16.0 * 0.5 * f32::EPSILON;

/// Origins farther away than this many scene extents see nothing: f32 no longer tells the scene from a point.
pub const MAX_ORIGIN: f32 = (1u64 << 60) as f32;

/// A ray in the coordinates of the nodes, with what both tests need of it.
pub struct LocalRay {
    origin: [f32; 3],
    /// Axis along which the direction is longest, and the other two.
    axes: [usize; 3],
    /// Shear that takes the direction to the longest axis, and 1 / its length there.
    shear: [f32; 3],
    /// 1 / direction.
    inverse: [f32; 3],
    /// Origin · inverse, moved so that padded boxes are met: for near planes, for far planes.
    near: [f32; 3],
    far: [f32; 3],
    t_min: f32,
    t_max: f32,
    /// t of the caller = t in here · this.
    t_scale: f32,
}

impl LocalRay {
    /// `None` if no hit is possible: not finite, no direction, empty range.
    pub fn new(ray: &Ray, scale: f32) -> Option<Self> {
        let longest = ray.direction.abs().max_element();
        if !(longest > 0.0 && longest.is_finite() && ray.origin.is_finite() && ray.t_min <= ray.t_max) {
            return None;
        }
        // Powers of two only, so that nothing rounds: scene and direction to about unit size.
        let direction_scale = power_of_two_below(1.0 / longest);
        let direction = (ray.direction * direction_scale).to_array();
        let origin = (ray.origin * scale).to_array();
        let reach = origin.iter().fold(1.0f32, |reach, o| reach.max(o.abs()));
        if reach > MAX_ORIGIN {
            return None;
        }
        let x = (0..3).fold(0, |best, i| if direction[i].abs() > direction[best].abs() { i } else { best });
        let axes = [(x + 1) % 3, (x + 2) % 3, x];
        let shear_z = 1.0 / direction[axes[2]];
        let floor = MIN_COMPONENT;
        let inverse = direction.map(|d| 1.0 / if d.abs() < floor { floor.copysign(d) } else { d });
        let pad = PAD * reach;
        // t_local · d_local = t · d · scale, with d_local = d · direction_scale.
        let t_scale = direction_scale / scale;
        Some(Self {
            origin,
            axes,
            shear: [direction[axes[0]] * shear_z, direction[axes[1]] * shear_z, shear_z],
            inverse,
            near: std::array::from_fn(|i| origin[i] * inverse[i] + pad * inverse[i].abs()),
            far: std::array::from_fn(|i| origin[i] * inverse[i] - pad * inverse[i].abs()),
            t_min: ray.t_min / t_scale,
            t_max: ray.t_max / t_scale,
            t_scale,
        })
    }
}

/// The power of two at or below a positive number, within what f32 can invert.
pub fn power_of_two_below(value: f32) -> f32 {
    let exponent = (value.clamp(f32::MIN_POSITIVE, f32::MAX).to_bits() >> 23).clamp(2, 252);
    f32::from_bits(exponent << 23)
}

/// The nearest hit.
pub fn closest(bvh: &Bvh, ray: &LocalRay) -> Option<Hit> {
    match bvh.isa {
        Isa::Portable => closest_in::<Portable>(bvh, ray),
        // SAFETY: `Isa::available` made these after detecting the features.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => unsafe { closest_avx2(bvh, ray) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => unsafe { closest_avx512(bvh, ray) },
    }
}

/// Whether anything is hit, triangles with a corner at `corner` aside.
pub fn occluded(bvh: &Bvh, ray: &LocalRay, corner: Option<Vec3>) -> bool {
    match bvh.isa {
        Isa::Portable => occluded_in::<Portable>(bvh, ray, corner),
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => unsafe { occluded_avx2(bvh, ray, corner) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => unsafe { occluded_avx512(bvh, ray, corner) },
    }
}

/// # Safety
/// The machine has AVX2, FMA and BMI1.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1")]
unsafe fn closest_avx2(bvh: &Bvh, ray: &LocalRay) -> Option<Hit> {
    closest_in::<Avx2>(bvh, ray)
}

/// # Safety
/// The machine has AVX2, FMA and BMI1.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1")]
unsafe fn occluded_avx2(bvh: &Bvh, ray: &LocalRay, corner: Option<Vec3>) -> bool {
    occluded_in::<Avx2>(bvh, ray, corner)
}

/// # Safety
/// The machine has AVX2, FMA, BMI1 and AVX-512 F, VL and DQ.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,avx512f,avx512vl,avx512dq")]
unsafe fn closest_avx512(bvh: &Bvh, ray: &LocalRay) -> Option<Hit> {
    closest_in::<Avx2>(bvh, ray)
}

/// # Safety
/// The machine has AVX2, FMA, BMI1 and AVX-512 F, VL and DQ.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,avx512f,avx512vl,avx512dq")]
unsafe fn occluded_avx512(bvh: &Bvh, ray: &LocalRay, corner: Option<Vec3>) -> bool {
    occluded_in::<Avx2>(bvh, ray, corner)
}

#[inline(always)]
fn occluded_in<V: Lanes>(bvh: &Bvh, ray: &LocalRay, corner: Option<Vec3>) -> bool {
    let boxes = BoxTest::<V>::new(ray);
    let test = TriangleTest::<V>::new(ray);
    let t_max = V::splat(ray.t_max);
    let mut stack = [MaybeUninit::<u32>::uninit(); STACK];
    let mut height = 0;
    let mut child = 0;
    loop {
        if child & LEAF == 0 {
            // SAFETY: children are indices of nodes, by construction.
            let node = unsafe { bvh.nodes.get_unchecked(child as usize) };
            let (mut met, _) = boxes.meet(node, t_max);
            if met != 0 {
                // SAFETY: a lane is below WIDTH; the stack holds WIDTH − 1 entries of each level at most.
                unsafe {
                    child = *node.children.get_unchecked(met.trailing_zeros() as usize);
                    met &= met - 1;
                    while met != 0 {
                        stack
                            .get_unchecked_mut(height)
                            .write(*node.children.get_unchecked(met.trailing_zeros() as usize));
                        height += 1;
                        met &= met - 1;
                    }
                }
                continue;
            }
        } else {
            // SAFETY: children flagged so are indices of blocks, by construction.
            let block = unsafe { bvh.blocks.get_unchecked((child & !LEAF) as usize) };
            if let Some(candidates) = test.intersect(block) {
                let hit = candidates.within(V::splat(ray.t_min), t_max);
                if hit != 0 && counts(block, hit, corner) {
                    return true;
                }
            }
        }
        if height == 0 {
            return false;
        }
        height -= 1;
        // SAFETY: entries below the height were written.
        child = unsafe { stack.get_unchecked(height).assume_init() };
    }
}

/// Whether one of the triangles `hit` of a block does not touch `corner`.
#[inline(never)]
pub fn counts(block: &TriangleBlock, mut hit: u32, corner: Option<Vec3>) -> bool {
    let Some(corner) = corner else { return true };
    while hit != 0 {
        if !block.touches(hit.trailing_zeros() as usize, corner.to_array()) {
            return true;
        }
        hit &= hit - 1;
    }
    false
}

#[inline(always)]
fn closest_in<V: Lanes>(bvh: &Bvh, ray: &LocalRay) -> Option<Hit> {
    let boxes = BoxTest::<V>::new(ray);
    let test = TriangleTest::<V>::new(ray);
    let mut best = Hit { t: ray.t_max, triangle: u32::MAX, barycentric: [0.0; 2] };
    let mut stack = Stack::new();
    // Distance at which the box of each stack entry begins.
    let mut entries = [MaybeUninit::<f32>::uninit(); STACK];
    entries[0].write(0.0);
    while let Some(child) = stack.pop() {
        // SAFETY: written when the entry of that height was pushed.
        if unsafe { entries[stack.height].assume_init() } > best.t {
            continue;
        }
        if child & LEAF == 0 {
            let node = &bvh.nodes[child as usize];
            let (mut met, begin) = boxes.meet(node, V::splat(best.t));
            let mut distances = [0.0; WIDTH];
            begin.store(&mut distances);
            let bottom = stack.height;
            while met != 0 {
                let lane = met.trailing_zeros() as usize;
                met &= met - 1;
                // Insertion keeps the nearest on top.
                let mut place = stack.height;
                stack.push(0);
                while place > bottom {
                    // SAFETY: both were written when this entry was pushed.
                    let (below, distance) =
                        unsafe { (stack.entries[place - 1].assume_init(), entries[place - 1].assume_init()) };
                    if distance >= distances[lane] {
                        break;
                    }
                    stack.entries[place].write(below);
                    entries[place].write(distance);
                    place -= 1;
                }
                stack.entries[place].write(node.children[lane]);
                entries[place].write(distances[lane]);
            }
            continue;
        }
        let block = &bvh.blocks[(child & !LEAF) as usize];
        if let Some(candidates) = test.intersect(block) {
            let mut hit = candidates.within(V::splat(ray.t_min), V::splat(best.t));
            let values = candidates.values();
            while hit != 0 {
                let lane = hit.trailing_zeros() as usize;
                hit &= hit - 1;
                let (t, triangle) = (values[0][lane], block.triangles[lane]);
                if t < best.t || (t == best.t && triangle < best.triangle) {
                    let det = values[3][lane];
                    best = Hit { t, triangle, barycentric: [values[1][lane] / det, values[2][lane] / det] };
                }
            }
        }
    }
    (best.triangle != u32::MAX).then_some(Hit { t: best.t * ray.t_scale, ..best })
}

/// Nodes and blocks still to visit.
struct Stack {
    entries: [MaybeUninit<u32>; STACK],
    height: usize,
}

impl Stack {
    /// Holds the root.
    #[inline(always)]
    fn new() -> Self {
        let mut stack = Self { entries: [MaybeUninit::uninit(); STACK], height: 0 };
        stack.push(0);
        stack
    }

    #[inline(always)]
    fn push(&mut self, child: u32) {
        self.entries[self.height].write(child);
        self.height += 1;
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<u32> {
        self.height = self.height.checked_sub(1)?;
        // SAFETY: every entry below the height was written by `push`.
        Some(unsafe { self.entries[self.height].assume_init() })
    }
}

/// One ray against eight boxes.
struct BoxTest<V> {
    inverse: [V; 3],
    near: [V; 3],
    far: [V; 3],
    /// Rows of [`Node::bounds`] that hold the near and the far planes.
    near_rows: [usize; 3],
    far_rows: [usize; 3],
    t_min: V,
}

impl<V: Lanes> BoxTest<V> {
    #[inline(always)]
    fn new(ray: &LocalRay) -> Self {
        let row =
            |axis: usize, far: usize| axis + 3 * (usize::from(ray.inverse[axis].is_sign_negative()) ^ far);
        Self {
            inverse: splat3(ray.inverse),
            near: splat3(ray.near),
            far: splat3(ray.far),
            near_rows: [row(0, 0), row(1, 0), row(2, 0)],
            far_rows: [row(0, 1), row(1, 1), row(2, 1)],
            t_min: V::splat(ray.t_min),
        }
    }

    /// Which boxes the ray meets before `t_max`, and where it enters them.
    #[inline(always)]
    fn meet(&self, node: &Node, t_max: V) -> (u32, V) {
        let begin = self.near(node, 0).max(self.near(node, 1)).max(self.near(node, 2).max(self.t_min));
        let end = self.far(node, 0).min(self.far(node, 1)).min(self.far(node, 2).min(t_max));
        (begin.le(end), begin)
    }

    #[inline(always)]
    fn near(&self, node: &Node, axis: usize) -> V {
        V::load(&node.bounds[self.near_rows[axis]]).mul_sub(self.inverse[axis], self.near[axis])
    }

    #[inline(always)]
    fn far(&self, node: &Node, axis: usize) -> V {
        V::load(&node.bounds[self.far_rows[axis]]).mul_sub(self.inverse[axis], self.far[axis])
    }
}

#[inline(always)]
fn splat3<V: Lanes>(values: [f32; 3]) -> [V; 3] {
    [V::splat(values[0]), V::splat(values[1]), V::splat(values[2])]
}

/// One ray against eight triangles.
struct TriangleTest<V> {
    origin: [V; 3],
    axes: [usize; 3],
    shear: [V; 3],
}

/// Triangles of a block that the line of the ray passes through, some of them.
pub struct Candidates<V> {
    mask: u32,
    t: V,
    /// Unnormalised weights of the second and third corner.
    v: V,
    w: V,
    /// What normalises them.
    det: V,
}

impl<V: Lanes> TriangleTest<V> {
    #[inline(always)]
    fn new(ray: &LocalRay) -> Self {
        let [x, y, z] = ray.axes;
        Self {
            origin: splat3([ray.origin[x], ray.origin[y], ray.origin[z]]),
            axes: ray.axes,
            shear: splat3(ray.shear),
        }
    }

    #[inline(always)]
    fn intersect(&self, block: &TriangleBlock) -> Option<Candidates<V>> {
        let (a, b, c) = (self.corner(block, 0), self.corner(block, 3), self.corner(block, 6));
        inside(&a, &b, &c, self.shear[2], u32::MAX)
    }

    /// The corners that begin at row `first`, relative to the origin and sheared.
    #[inline(always)]
    fn corner(&self, block: &TriangleBlock, first: usize) -> [V; 3] {
        let [x, y, z] = self.axes;
        let x = V::load(&block.corners[first + x]).sub(self.origin[0]);
        let y = V::load(&block.corners[first + y]).sub(self.origin[1]);
        let z = V::load(&block.corners[first + z]).sub(self.origin[2]);
        sheared(x, y, z, self.shear[0], self.shear[1])
    }
}

/// A corner relative to the ray's origin, sheared so that the ray runs along the third axis.
#[inline(always)]
pub fn sheared<V: Lanes>(x: V, y: V, z: V, shear_x: V, shear_y: V) -> [V; 3] {
    [x.sub(shear_x.mul(z)), y.sub(shear_y.mul(z)), z]
}

/// Which of the triangles `lanes` with these sheared corners the ray's line passes through.
///
/// Signs of 2D edge functions decide. They are right or zero, never wrong: products round monotonically and are not
/// fused with the difference. Zero counts as inside for both triangles of an edge, so nothing leaks between them.
#[inline(always)]
pub fn inside<V: Lanes>(a: &[V; 3], b: &[V; 3], c: &[V; 3], shear_z: V, lanes: u32) -> Option<Candidates<V>> {
    let (u, v, w) = (edge(c, b), edge(a, c), edge(b, a));
    let zero = V::splat(0.0);
    let det = u.add(v).add(w);
    let inside = zero.le(u.min(v).min(w)) | u.max(v).max(w).le(zero);
    let mask = inside & det.ne(zero) & lanes;
    if mask == 0 {
        return None;
    }
    let z = u.mul(a[2]).add(v.mul(b[2])).add(w.mul(c[2]));
    Some(Candidates { mask, t: z.mul(shear_z).div(det), v, w, det })
}

/// Twice the signed area of the origin and two points.
#[inline(always)]
fn edge<V: Lanes>(p: &[V; 3], q: &[V; 3]) -> V {
    p[0].mul(q[1]).sub(p[1].mul(q[0]))
}

impl<V: Lanes> Candidates<V> {
    /// t, the unnormalised weights of the second and third corner, and what normalises them.
    #[inline(always)]
    pub fn values(&self) -> [[f32; WIDTH]; 4] {
        let mut values = [[0.0; WIDTH]; 4];
        for (value, to) in [self.t, self.v, self.w, self.det].iter().zip(&mut values) {
            value.store(to);
        }
        values
    }

    /// Those with `t_min` ≤ t ≤ `t_max`.
    #[inline(always)]
    pub fn within(&self, t_min: V, t_max: V) -> u32 {
        self.mask & t_min.le(self.t) & self.t.le(t_max)
    }
}
