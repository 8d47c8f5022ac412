//! Pictures of the whole sphere: which texel shows which direction, and how much of the sphere it covers.
//!
//! Directions are those of the picture's own axes, y up, and are taken as they are. `+Z +X +Y` below says which axis is
//! at the centre, to the right of it and above it.

mod cell;
mod project;

pub use cell::Cell;
pub use project::{accumulate, project_image};

use std::f64::consts::{PI, TAU};

use crate::error::{Error, Result};
use cell::Surface;

/// How a picture covers the sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Layout {
    /// Latitude–longitude: φ = 2πu, θ = πv, direction (sin θ cos φ, cos θ, −sin θ sin φ). Twice as wide as high by habit.
    LatLong,
    /// Angular map, +Z +X +Y: the angle from +Z is π · (distance from the centre / half the width). Square.
    ///
    /// [Debevec 1998] "Light Probe Image Gallery"
    AngularMap,
    /// Mirror ball seen from far away, +Z +X +Y: the angle from +Z is 2 asin(distance / half the width). Square.
    MirrorBall,
    /// Vertical cross, 3 × 4 faces: +Y; −X +Z +X; −Y; −Z turned by half a turn.
    VerticalCross,
    /// Horizontal cross, 4 × 3 faces: +Y above +Z; −X +Z +X −Z; −Y below +Z.
    HorizontalCross,
    /// Direct3D's faces +X −X +Y −Y +Z −Z, one below the other.
    CubeColumn,
    /// Direct3D's faces +X −X +Y −Y +Z −Z, side by side.
    CubeRow,
    /// OpenEXR's latitude–longitude map: samples on the border, +Z −X +Y, the first and last column the same meridian.
    OpenExrLatLong,
    /// OpenEXR's faces +X −X +Y −Y +Z −Z, one below the other, samples on the border of the faces.
    OpenExrCube,
}

impl Layout {
    /// The layout that pictures of this shape have by habit.
    ///
    /// 2:1 lat-long, 1:1 angular map, 3:4 and 4:3 cross, 1:6 and 6:1 faces in a column and in a row.
    pub fn of_shape(width: usize, height: usize) -> Option<Self> {
        let is = |columns: usize, rows: usize| width * rows == height * columns;
        [
            (2, 1, Self::LatLong),
            (1, 1, Self::AngularMap),
            (3, 4, Self::VerticalCross),
            (4, 3, Self::HorizontalCross),
            (1, 6, Self::CubeColumn),
            (6, 1, Self::CubeRow),
        ]
        .into_iter()
        .find_map(|(columns, rows, layout)| is(columns, rows).then_some(layout))
    }

    /// Columns and rows of square faces, or of the disc; `None` where any shape will do.
    fn shape(self) -> Option<[usize; 2]> {
        match self {
            Self::LatLong | Self::OpenExrLatLong => None,
            Self::AngularMap | Self::MirrorBall => Some([1, 1]),
            Self::VerticalCross => Some([3, 4]),
            Self::HorizontalCross => Some([4, 3]),
            Self::CubeColumn | Self::OpenExrCube => Some([1, 6]),
            Self::CubeRow => Some([6, 1]),
        }
    }

    fn samples_on_border(self) -> bool {
        matches!(self, Self::OpenExrLatLong | Self::OpenExrCube)
    }
}

/// One face of a cube: where it stands in the picture, in faces, and which way it is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Face {
    column: usize,
    row: usize,
    centre: [f64; 3],
    right: [f64; 3],
    down: [f64; 3],
}

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

fn negative(axis: [f64; 3]) -> [f64; 3] {
    axis.map(|x| 0.0 - x)
}

/// The faces +X −X +Y −Y +Z −Z of a cube layout.
fn faces(layout: Layout) -> [Face; 6] {
    let (nx, ny, nz) = (negative(X), negative(Y), negative(Z));
    let mut frames = [(X, nz, ny), (nx, Z, ny), (Y, X, Z), (ny, X, nz), (Z, X, ny), (nz, nx, ny)];
    let places = match layout {
        Layout::VerticalCross => {
            frames[5] = (nz, X, Y);
            [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [1, 3]]
        }
        Layout::HorizontalCross => [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]],
        Layout::CubeRow => std::array::from_fn(|face| [face, 0]),
        _ => std::array::from_fn(|face| [0, face]),
    };
    if layout == Layout::OpenExrCube {
        frames = [(X, Z, ny), (nx, nz, ny), (Y, X, nz), (ny, X, Z), (Z, nx, ny), (nz, X, ny)];
    }
    std::array::from_fn(|face| {
        let (centre, right, down) = frames[face];
        let [column, row] = places[face];
        Face { column, row, centre, right, down }
    })
}

/// A layout at a size: texels and directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    layout: Layout,
    width: usize,
    height: usize,
    /// Texels along a face of a cube.
    edge: usize,
    faces: [Face; 6],
}

impl Grid {
    /// A picture of width × height texels.
    ///
    /// # Errors
    /// If the picture is empty or has not the shape that the layout calls for.
    pub fn new(layout: Layout, width: usize, height: usize) -> Result<Self> {
        let [columns, rows] = layout.shape().unwrap_or([1, 1]);
        if layout.shape().is_some() && width * rows != height * columns {
            let range = match [columns, rows] {
                [1, 1] => "it must be 1 for an angular map or a mirror ball",
                [3, 4] => "it must be 3/4 for a vertical cross",
                [4, 3] => "it must be 4/3 for a horizontal cross",
                [1, 6] => "it must be 1/6 for a column of cube faces",
                _ => "it must be 6 for a row of cube faces",
            };
            let value = width as f64 / height as f64;
            return Err(Error::Range { what: "width / height of the picture", value, range });
        }
        let (least, range) = match layout.samples_on_border() {
            true => (2, "samples on the border need at least two a side"),
            false => (1, "it must have at least one texel a side"),
        };
        for (what, value, least) in [("width", width, least * columns), ("height", height, least * rows)] {
            if value < least {
                return Err(Error::Range { what, value: value as f64, range });
            }
        }
        Ok(Self { layout, width, height, edge: width / columns, faces: faces(layout) })
    }

    /// The layout.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The part of the sphere that texel (x, y) shows; `None` where the picture shows nothing: beside a cross or a disc.
    pub fn cell(&self, x: usize, y: usize) -> Option<Cell> {
        let unit = |at: usize, count: usize| [at as f64 / count as f64, (at + 1) as f64 / count as f64];
        let signed = |at: usize, count: usize| unit(at, count).map(|edge| 2.0 * edge - 1.0);
        // A border sample stands for the half of the interval on either side that is inside.
        let border = |at: usize, count: usize| {
            let last = (count - 1) as f64;
            [(at as f64 - 0.5).max(0.0) / last, (at as f64 + 0.5).min(last) / last]
        };
        match self.layout {
            Layout::LatLong => {
                let phi = unit(x, self.width).map(|u| TAU * u);
                Cell::new(Surface::LatLong, phi, unit(y, self.height).map(|v| PI * v))
            }
            Layout::OpenExrLatLong => {
                // The longitude of ImfEnvmap is −2π(u − ½), from +Z towards +X; this φ grows with u from −Z.
                let phi = border(x, self.width).map(|u| TAU * u);
                Cell::new(Surface::OpenExrLatLong, phi, border(y, self.height).map(|v| PI * v))
            }
            Layout::AngularMap => {
                Cell::new(Surface::AngularMap, signed(x, self.width), signed(y, self.height))
            }
            Layout::MirrorBall => {
                Cell::new(Surface::MirrorBall, signed(x, self.width), signed(y, self.height))
            }
            _ => {
                let (column, row) = (x / self.edge, y / self.edge);
                let face = self.faces.iter().find(|face| (face.column, face.row) == (column, row))?;
                let interval = |at: usize| {
                    if self.layout.samples_on_border() {
                        border(at, self.edge).map(|edge| 2.0 * edge - 1.0)
                    } else {
                        signed(at, self.edge)
                    }
                };
                Cell::new(Surface::Face(*face), interval(x % self.edge), interval(y % self.edge))
            }
        }
    }

    /// The direction that texel (x, y) shows; `None` beside a cross or a disc.
    ///
    /// Its centre, but for OpenEXR's samples: those of the border look along the border. A texel cut by the rim of a
    /// disc looks along the middle of what is inside.
    pub fn direction(&self, x: usize, y: usize) -> Option<[f64; 3]> {
        let cell = self.cell(x, y)?;
        if !self.layout.samples_on_border() {
            return Some(cell.at([0.5, 0.5]).0);
        }
        let middle = |at: usize, count: usize| match at {
            0 => 0.0,
            at if at + 1 == count => 1.0,
            _ => 0.5,
        };
        let (columns, rows) = match self.layout {
            Layout::OpenExrLatLong => (self.width, self.height),
            _ => (self.edge, self.edge),
        };
        Some(cell.at([middle(x % columns, columns), middle(y % rows, rows)]).0)
    }

    /// The solid angle of texel (x, y), 0 beside a cross or a disc. All together they are 4π.
    ///
    /// Error: closed forms for lat-long, cube faces and mirror ball; high-order quadrature for the angular map, 1e-9 of 4π
    /// in the sum over all texels (test `solid_angles_sum_to_the_whole_sphere`).
    pub fn solid_angle(&self, x: usize, y: usize) -> f64 {
        self.cell(x, y).map_or(0.0, |cell| cell.solid_angle())
    }

    /// The texel (x, y) that shows a direction, which need not be of unit length.
    pub fn locate(&self, direction: [f64; 3]) -> (usize, usize) {
        let [x, y, z] = direction;
        let texel = |unit: f64, count: usize| ((unit * count as f64) as usize).min(count - 1);
        let border = |unit: f64, count: usize| ((unit * (count - 1) as f64).round() as usize).min(count - 1);
        let disc = |radius: f64| {
            let across = x.hypot(y);
            let (u, v) =
                if across > 0.0 { (x / across * radius, -y / across * radius) } else { (radius, 0.0) };
            self.nearest_covered(texel(0.5 + 0.5 * u, self.width), texel(0.5 + 0.5 * v, self.height))
        };
        match self.layout {
            Layout::LatLong => {
                let phi = (-z).atan2(x);
                let u = if phi < 0.0 { phi / TAU + 1.0 } else { phi / TAU };
                (texel(u, self.width), texel(x.hypot(z).atan2(y) / PI, self.height))
            }
            Layout::OpenExrLatLong => {
                let u = 0.5 - x.atan2(z) / TAU;
                (border(u, self.width), border(x.hypot(z).atan2(y) / PI, self.height))
            }
            Layout::AngularMap => disc(x.hypot(y).atan2(z) / PI),
            Layout::MirrorBall => disc((0.5 * x.hypot(y).atan2(z)).sin()),
            _ => {
                let dot = |a: [f64; 3]| a[0] * x + a[1] * y + a[2] * z;
                let nearest = |a: &&Face, b: &&Face| dot(a.centre).total_cmp(&dot(b.centre));
                let face = self.faces.iter().max_by(nearest).unwrap_or(&self.faces[0]);
                let depth = dot(face.centre);
                let unit = |axis| 0.5 + 0.5 * dot(axis) / depth;
                let place = |unit: f64| {
                    if self.layout.samples_on_border() {
                        border(unit, self.edge)
                    } else {
                        texel(unit, self.edge)
                    }
                };
                (
                    face.column * self.edge + place(unit(face.right)),
                    face.row * self.edge + place(unit(face.down)),
                )
            }
        }
    }

    /// Rounding can put a direction at the rim of a disc into a texel that is just outside; its inner neighbour has it.
    fn nearest_covered(&self, x: usize, y: usize) -> (usize, usize) {
        let inward = |at: usize, count: usize| match (2 * at + 1).cmp(&count) {
            std::cmp::Ordering::Less => at + 1,
            std::cmp::Ordering::Equal => at,
            std::cmp::Ordering::Greater => at - 1,
        };
        let (inner_x, inner_y) = (inward(x, self.width), inward(y, self.height));
        [(x, y), (inner_x, y), (x, inner_y)]
            .into_iter()
            .find(|&(x, y)| self.cell(x, y).is_some())
            .unwrap_or((inner_x, inner_y))
    }
}
