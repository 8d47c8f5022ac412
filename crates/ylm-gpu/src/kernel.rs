//! The kernels' texts, and what they are bound to.

use crate::layout::{BLOCK, Frame, ROWS};

/// How a kernel uses a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// A [`Frame`].
    Uniform,
    /// Storage that is read.
    Read,
    /// Storage that is written, and may be read.
    Write,
}

/// A buffer of group 0; its binding is its place in [`Kernel::bindings`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// The variable in the shader, and the parameter of the twin.
    pub name: &'static str,
    /// How it is used.
    pub access: Access,
}

/// One compute shader; its entry point is `main`, its workgroups are [`BLOCK`] wide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// Radiance of diffuse points: [`crate::twin::diffuse`].
    Diffuse,
    /// Radiance of diffuse points that nothing shadows: [`crate::twin::unshadowed`].
    Unshadowed,
    /// Light times transfer: [`crate::twin::received`].
    Received,
    /// Specular radiance, added: [`crate::twin::lobe`].
    Lobe,
}

const FRAME: Binding = Binding { name: "frame", access: Access::Uniform };
const RADIANCE: Binding = Binding { name: "radiance", access: Access::Write };

const fn read(name: &'static str) -> Binding {
    Binding { name, access: Access::Read }
}

impl Kernel {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Diffuse, Self::Unshadowed, Self::Received, Self::Lobe];

    /// That of the shader's file and of the twin.
    pub fn name(self) -> &'static str {
        match self {
            Self::Diffuse => "diffuse",
            Self::Unshadowed => "unshadowed",
            Self::Received => "received",
            Self::Lobe => "lobe",
        }
    }

    /// The whole text in WGSL.
    pub fn source(self) -> &'static str {
        macro_rules! text {
            ($($file:literal),*) => { concat!($(include_str!(concat!("../shaders/", $file, ".wgsl")), "\n"),*) };
        }
        match self {
            Self::Diffuse => text!("frame", "diffuse"),
            Self::Unshadowed => text!("frame", "zonal", "unshadowed"),
            Self::Received => text!("frame", "received"),
            Self::Lobe => text!("frame", "zonal", "lobe"),
        }
    }

    /// The buffers, in the order of their bindings; the twin's parameters say what each holds.
    pub fn bindings(self) -> &'static [Binding] {
        const RECEIVED: Binding = Binding { name: "received", access: Access::Write };
        const DIFFUSE: &[Binding] =
            &[FRAME, read("light"), read("transfer"), read("bounced"), read("surfaces"), RADIANCE];
        const UNSHADOWED: &[Binding] = &[
            FRAME,
            read("recurrence"),
            read("zonal"),
            read("light"),
            read("places"),
            read("surfaces"),
            RADIANCE,
        ];
        const LOBE: &[Binding] =
            &[FRAME, read("recurrence"), read("zonal"), read("places"), read("received"), RADIANCE];
        match self {
            Self::Diffuse => DIFFUSE,
            Self::Unshadowed => UNSHADOWED,
            Self::Received => const { &[FRAME, read("matrix"), read("transfer"), RECEIVED] },
            Self::Lobe => LOBE,
        }
    }

    /// Workgroups to dispatch.
    pub fn workgroups(self, frame: &Frame) -> [u32; 3] {
        let blocks = frame.point_count.div_ceil(BLOCK as u32);
        match self {
            Self::Received => [blocks, (frame.bands * frame.bands).div_ceil(ROWS as u32), 3],
            _ => [blocks, 1, 1],
        }
    }
}
