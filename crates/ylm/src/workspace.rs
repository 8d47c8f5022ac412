//! Memory that a batch kernel needs besides its arguments, kept from one call to the next.

use crate::simd::Lanes;

/// Scratch memory of the batch functions: grows to what the largest call needed, and is then reused.
///
/// One a thread; its content means nothing between calls.
#[derive(Default)]
pub struct Workspace {
    lines: Vec<Line>,
}

/// A cache line, as wide as the widest vector and aligned for it.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Line([u8; 64]);

impl Workspace {
    /// An empty workspace.
    pub fn new() -> Self {
        Self::default()
    }

    /// `count` vectors of unspecified finite or non-finite content, left by an earlier call.
    pub(crate) fn vectors<T, V: Lanes<T>>(&mut self, count: usize) -> &mut [V] {
        const { assert!(size_of::<V>() <= size_of::<Line>() && align_of::<V>() <= align_of::<Line>()) };
        let line_count = (count * size_of::<V>()).div_ceil(size_of::<Line>());
        if self.lines.len() < line_count {
            self.lines.resize(line_count, Line([0; 64]));
        }
        // SAFETY: the lines hold that many vectors and are aligned for them; a vector is plain numbers (`Lanes`), valid
        // for all bits; the borrow of `self` lasts as long as the slice.
        unsafe { std::slice::from_raw_parts_mut(self.lines.as_mut_ptr().cast::<V>(), count) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Level;
    use crate::simd::Kernel;

    struct Fill<'a>(&'a mut Workspace);

    impl Kernel<f32> for Fill<'_> {
        type Output = bool;
        fn run<V: Lanes<f32>>(self) -> bool {
            self.0.vectors::<f32, V>(33).fill(V::splat(3.0));
            let mut lanes = [0.0; 16];
            self.0.vectors::<f32, V>(5)[4].store(&mut lanes);
            lanes[..V::COUNT].iter().all(|&x| x == 3.0)
        }
    }

    #[test]
    fn a_workspace_serves_every_level_and_keeps_its_size() {
        let mut workspace = Workspace::new();
        for level in Level::available() {
            assert!(level.run::<f32, _>(Fill(&mut workspace)));
        }
        assert!(workspace.lines.len() <= 33);
    }
}
