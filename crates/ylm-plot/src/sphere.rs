//! Spherical plots: the surface r = |f(ω)|, coloured by sign. [Green03] "The SH Basis Functions", Figure 5

use glam::{Mat3, Vec3};
use ylm_prt::error::Result;
use ylm_prt::image::Picture;
use ylm_prt::render::{linear_from_srgb, srgb_from_linear};

use crate::function::Function;

/// Where a spherical plot is looked at from, and which axis points up in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Eye {
    /// The columns are right, up and towards the eye.
    axes: Mat3,
}

impl Eye {
    /// World directions with y up, from an azimuth (from +z towards +x) and elevation in degrees.
    pub fn world(azimuth: f32, elevation: f32) -> Self {
        let (sin, cos) = azimuth.to_radians().sin_cos();
        let (rise, run) = elevation.to_radians().sin_cos();
        let (right, back) = (Vec3::new(cos, 0.0, -sin), Vec3::new(run * sin, rise, run * cos));
        Self { axes: Mat3::from_cols(right, back.cross(right), back) }
    }

    /// The basis' own axes with z up, from an azimuth (from +x towards +y) and elevation in degrees.
    pub fn polar(azimuth: f32, elevation: f32) -> Self {
        let (sin, cos) = azimuth.to_radians().sin_cos();
        let (rise, run) = elevation.to_radians().sin_cos();
        let (right, back) = (Vec3::new(-sin, cos, 0.0), Vec3::new(run * cos, run * sin, rise));
        Self { axes: Mat3::from_cols(right, back.cross(right), back) }
    }

    /// A point as the eye has it: right, up, towards it.
    pub fn view(&self, point: Vec3) -> Vec3 {
        self.axes.transpose() * point
    }
}

/// A surface r = |f| around the origin, scaled so that its farthest point is at 1.
pub(crate) struct Surface {
    rows: usize,
    columns: usize,
    /// (rows + 1) × columns, row 0 at +z.
    points: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// f over its largest magnitude.
    values: Vec<f32>,
    /// The largest magnitude; 0 for a function that is 0.
    pub most: f32,
}

/// What positive and negative values look like.
pub(crate) const POSITIVE: [u8; 3] = [222, 108, 62];
pub(crate) const NEGATIVE: [u8; 3] = [58, 122, 186];

/// Samples a pixel and axis.
const FINE: usize = 3;

impl Surface {
    /// The surface of a function of one channel.
    ///
    /// # Errors
    /// As [`Function::values`].
    pub fn new(function: &Function) -> Result<Self> {
        // Eight samples a wave of the highest band, and enough for a smooth outline.
        let columns = (8 * function.bands().count()).clamp(160, 1024);
        let rows = columns / 2;
        let directions: Vec<[f32; 3]> = (0..=rows)
            .flat_map(|row| (0..columns).map(move |column| (row, column)))
            .map(|(row, column)| {
                let (sin, cos) = (std::f32::consts::PI * row as f32 / rows as f32).sin_cos();
                let (sin_phi, cos_phi) = (std::f32::consts::TAU * column as f32 / columns as f32).sin_cos();
                // The last row's sine is not quite 0; z decides.
                [sin * cos_phi, sin * sin_phi, cos]
            })
            .collect();
        let mut values: Vec<f32> = function.values(&directions)?.iter().map(|value| value.x).collect();
        let most = values.iter().map(|value| value.abs()).fold(0.0, f32::max);
        if most > 0.0 {
            values.iter_mut().for_each(|value| *value /= most);
        }
        let points: Vec<Vec3> = directions
            .iter()
            .zip(&values)
            .map(|(&direction, value)| value.abs() * Vec3::from(direction))
            .collect();
        let mut surface =
            Self { rows, columns, normals: vec![Vec3::ZERO; points.len()], points, values, most };
        surface.find_normals();
        Ok(surface)
    }

    /// Sums of the normals of the triangles around each point, poles as one point.
    fn find_normals(&mut self) {
        let mut normals = vec![Vec3::ZERO; self.points.len()];
        self.for_each_triangle(|triangle| {
            let [a, b, c] = triangle.map(|i| self.points[i]);
            let normal = (b - a).cross(c - a);
            triangle.iter().for_each(|&i| normals[i] += normal);
        });
        for row in [0, self.rows] {
            let pole = row * self.columns..(row + 1) * self.columns;
            let sum: Vec3 = normals[pole.clone()].iter().sum();
            normals[pole].fill(sum);
        }
        self.normals = normals.into_iter().map(|normal| normal.normalize_or(Vec3::Z)).collect();
    }

    fn for_each_triangle(&self, mut visit: impl FnMut([usize; 3])) {
        for row in 0..self.rows {
            for column in 0..self.columns {
                let next = (column + 1) % self.columns;
                let [a, b] = [column, next].map(|column| row * self.columns + column);
                let [c, d] = [column, next].map(|column| (row + 1) * self.columns + column);
                visit([a, c, d]);
                visit([a, d, b]);
            }
        }
    }

    /// The lowest and highest point of the surface as the eye has it.
    pub fn extent(&self, eye: &Eye) -> [f32; 2] {
        let heights = self.points.iter().map(|&point| eye.view(point).y);
        heights.fold([0.0; 2], |[low, high], y| [y.min(low), y.max(high)])
    }

    /// The surface in parallel projection on white, `size` pixels square, the unit sphere inscribed with a small margin.
    pub fn draw(&self, eye: &Eye, size: usize) -> Drawn {
        let fine = size * FINE;
        let scale = 0.5 * fine as f32 * FILL;
        let seen: Vec<Vec3> = self.points.iter().map(|&point| eye.view(point)).collect();
        let place = |p: Vec3| [0.5 * fine as f32 + scale * p.x, 0.5 * fine as f32 - scale * p.y];
        let mut depth = vec![f32::NEG_INFINITY; fine * fine];
        let mut colours = vec![[1.0f32; 3]; fine * fine];
        self.for_each_triangle(|triangle| {
            let corners = triangle.map(|i| place(seen[i]));
            cover(corners, fine, |at, weights| {
                let mix =
                    |of: &dyn Fn(usize) -> f32| (0..3).map(|k| weights[k] * of(triangle[k])).sum::<f32>();
                let z = mix(&|i| seen[i].z);
                if z > depth[at] {
                    depth[at] = z;
                    let normal: Vec3 = (0..3).map(|k| weights[k] * self.normals[triangle[k]]).sum();
                    colours[at] = shaded(eye.view(normal), mix(&|i| self.values[i]));
                }
            });
        });
        let pixels = (0..size * size).map(|at| {
            let (row, column) = (at / size, at % size);
            let block = (0..FINE * FINE)
                .map(|k| (row * FINE + k / FINE) * fine + column * FINE + k % FINE)
                .map(|at| Vec3::from(colours[at]));
            let mean = block.sum::<Vec3>() / (FINE * FINE) as f32;
            mean.to_array().map(|value| (srgb_from_linear(value.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8)
        });
        Drawn { picture: Picture { width: size, height: size, pixels: pixels.collect() }, depth, fine }
    }
}

/// The share of the picture that the unit sphere takes.
pub(crate) const FILL: f32 = 0.84;

/// A drawn surface, which knows what it hides.
pub(crate) struct Drawn {
    pub picture: Picture,
    depth: Vec<f32>,
    fine: usize,
}

impl Drawn {
    /// Whether a point, as the eye has it, lies before the surface.
    pub fn shows(&self, p: Vec3) -> bool {
        let scale = 0.5 * FILL * self.fine as f32;
        let at = [0.5 * self.fine as f32 + scale * p.x, 0.5 * self.fine as f32 - scale * p.y];
        if at.iter().any(|&x| !(0.0..self.fine as f32).contains(&x)) {
            return true;
        }
        p.z >= self.depth[at[1] as usize * self.fine + at[0] as usize]
    }
}

/// The rows of a square picture between two heights as the eye has them.
pub(crate) fn cropped(picture: &Picture, [low, high]: [f32; 2]) -> Picture {
    let size = picture.width as f32;
    let row = |y: f32| (0.5 * size * (1.0 - FILL * y)).clamp(0.0, size) as usize;
    let rows = row(high)..row(low);
    let pixels = picture.pixels[rows.start * picture.width..rows.end * picture.width].to_vec();
    Picture { width: picture.width, height: rows.len(), pixels }
}

/// Visits the pixels whose centre a triangle covers, with the weights of its corners.
fn cover(corners: [[f32; 2]; 3], size: usize, mut visit: impl FnMut(usize, [f32; 3])) {
    let [a, b, c] = corners;
    let edge =
        |p: [f32; 2], q: [f32; 2], r: [f32; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let area = edge(a, b, c);
    if area == 0.0 {
        return;
    }
    let bounds = |axis: usize| {
        let values = corners.map(|corner| corner[axis]);
        let least = values.into_iter().fold(f32::INFINITY, f32::min).floor().max(0.0) as usize;
        let most = values.into_iter().fold(0.0, f32::max).ceil().min(size as f32) as usize;
        least..most
    };
    for row in bounds(1) {
        for column in bounds(0) {
            let p = [column as f32 + 0.5, row as f32 + 0.5];
            let weights = [edge(b, c, p), edge(c, a, p), edge(a, b, p)].map(|part| part / area);
            if weights.iter().all(|&weight| weight >= 0.0) {
                visit(row * size + column, weights);
            }
        }
    }
}

/// Lit from the upper left of the eye, with a soft fill and a small gloss; both sides alike.
fn shaded(normal: Vec3, value: f32) -> [f32; 3] {
    let normal = normal.normalize_or(Vec3::Z);
    let normal = if normal.z < 0.0 { -normal } else { normal };
    let light = Vec3::new(-0.45, 0.65, 0.62).normalize();
    let wrapped = (0.5 + 0.5 * normal.dot(light)).powi(2);
    let gloss = 0.12 * normal.dot((light + Vec3::Z).normalize()).max(0.0).powi(40);
    let base = if value < 0.0 { NEGATIVE } else { POSITIVE };
    base.map(|code| linear_from_srgb(f32::from(code) / 255.0) * (0.22 + 1.0 * wrapped) + gloss)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_is_a_ball_that_fills_the_picture() {
        let surface = Surface::new(&Function::basis(0, 0).unwrap()).unwrap();
        assert!((surface.most - 0.282_094_8).abs() <= 1e-6);
        let drawn = surface.draw(&Eye::world(30.0, 20.0), 100);
        let covered = drawn.picture.pixels.iter().filter(|&&pixel| pixel != [255; 3]).count() as f64;
        let expected = std::f64::consts::PI * (50.0 * f64::from(FILL)).powi(2);
        // Pixels on the outline count whole: half of some 2πr of them too many.
        assert!((covered / expected - 1.0).abs() <= 0.05, "{covered} {expected}");
        assert!(!drawn.shows(Vec3::new(0.0, 0.0, 0.9)) && drawn.shows(Vec3::new(0.0, 0.0, 1.01)));
        assert!(drawn.shows(Vec3::new(1.1, 0.0, 0.0)));
        for normal in &surface.normals {
            assert!((normal.length() - 1.0).abs() <= 1e-4);
        }
    }

    #[test]
    fn lobes_lie_where_the_function_is_and_have_its_sign() {
        // Y_1,-1 = −0.4886 y: negative above, positive below, nothing beside.
        let surface = Surface::new(&Function::basis(1, -1).unwrap()).unwrap();
        let picture = surface.draw(&Eye::world(0.0, 0.0), 90).picture;
        let at = |x: usize, y: usize| picture.pixels[y * 90 + x];
        assert!(at(45, 25)[2] > at(45, 25)[0], "{:?}", at(45, 25));
        assert!(at(45, 65)[0] > at(45, 65)[2]);
        assert_eq!((at(10, 45), at(80, 45)), ([255; 3], [255; 3]));
        // +x is to the right of an eye on +z.
        let picture =
            Surface::new(&Function::basis(1, 1).unwrap()).unwrap().draw(&Eye::world(0.0, 0.0), 90).picture;
        assert!(picture.pixels[45 * 90 + 65][2] > picture.pixels[45 * 90 + 65][0], "Y_1,1 = −0.4886 x");
        // z is up for the basis' own eye: Y_1,0 = 0.4886 z.
        let picture =
            Surface::new(&Function::basis(1, 0).unwrap()).unwrap().draw(&Eye::polar(0.0, 0.0), 90).picture;
        assert!(picture.pixels[25 * 90 + 45][0] > picture.pixels[25 * 90 + 45][2]);
    }

    #[test]
    fn a_function_that_is_zero_is_a_blank_picture() {
        let surface = Surface::new(&Function::grey(vec![0.0; 4]).unwrap()).unwrap();
        assert!(surface.most == 0.0);
        assert!(
            surface.draw(&Eye::world(0.0, 0.0), 20).picture.pixels.iter().all(|&pixel| pixel == [255; 3])
        );
    }
}
