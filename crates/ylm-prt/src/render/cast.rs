//! Primary rays: the picture of radiance that is given at lighting points.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::false_colour::Colours;
use crate::error::{Error, Result};
use crate::image::{Image, MAX_TEXELS};
use crate::scene::{Bvh, Camera, Hit, LightingPoints};

/// Size and anti-aliasing of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Raster {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Rays a pixel.
    pub samples: usize,
}

impl Default for Raster {
    fn default() -> Self {
        Self { width: 800, height: 600, samples: 16 }
    }
}

impl Raster {
    /// Width over height.
    pub fn aspect(&self) -> f32 {
        self.width as f32 / self.height as f32
    }

    fn check(&self) -> Result<()> {
        let texels = self.width.saturating_mul(self.height);
        if texels == 0 || texels > MAX_TEXELS {
            let (width, height) = (self.width, self.height);
            return Err(Error::Request(format!(
                "a picture of {width} × {height} cannot be rendered: it must have 1 to {MAX_TEXELS} texels"
            )));
        }
        if !(1..=4096).contains(&self.samples) {
            return Err(Error::Request(format!("{} samples a pixel: it must be 1 to 4096", self.samples)));
        }
        Ok(())
    }
}

/// Casts primary rays at `points` and interpolates their `radiance` over the triangle that each ray meets first,
/// from either side; where it meets none, `background` of its direction is seen.
///
/// A pixel is the tent filter of radius one pixel over linear radiance, sampled by [Ernst 2006] "Filter Importance
/// Sampling" with the same Hammersley points in every pixel: edges are smooth and free of noise. Since light is averaged
/// before tone mapping, an edge against a background far above white keeps a bright rim, as in a photograph.
///
/// Shapes: `radiance` has one value a lighting point; `bvh` is built from the points' positions and triangles.
/// Units: radiance in, radiance out. Cost: width · height · samples rays; rows in parallel. The same bytes for any
/// number of threads.
///
/// # Errors
/// If there are not as many radiances as points, or the raster is empty or beyond its range.
pub fn render(
    points: &LightingPoints,
    bvh: &Bvh,
    radiance: &[Vec3],
    camera: &Camera,
    raster: &Raster,
    background: &(dyn Fn(Vec3) -> Vec3 + Sync),
) -> Result<Image> {
    render_in(Colours::Radiance, points, bvh, radiance, camera, raster, background)
}

/// [`render`], with radiance shown in other colours, to be developed without exposure or tone map.
///
/// Interpolated radiance takes its colour before the pixel's filter, so edges are as smooth; the background is seen as it
/// is.
///
/// # Errors
/// As [`render`].
pub fn render_in(
    colours: Colours,
    points: &LightingPoints,
    bvh: &Bvh,
    radiance: &[Vec3],
    camera: &Camera,
    raster: &Raster,
    background: &(dyn Fn(Vec3) -> Vec3 + Sync),
) -> Result<Image> {
    if radiance.len() != points.positions.len() {
        return Err(Error::Request(format!(
            "{} radiances for {} lighting points",
            radiance.len(),
            points.positions.len()
        )));
    }
    let interpolate = |hits: &[Hit], out: &mut [Vec3]| {
        for (hit, out) in hits.iter().zip(out) {
            let corners = points.triangles[hit.triangle as usize];
            *out = colours.of(hit.interpolate(corners.map(|corner| radiance[corner as usize])));
        }
        Ok(())
    };
    render_hits(bvh, camera, raster, &interpolate, background)
}

/// Writes the radiance towards the camera of the places that rays meet.
pub type ShadeHits<'a> = dyn Fn(&[Hit], &mut [Vec3]) -> Result<()> + Sync + 'a;

/// [`render`], with the radiance of what each ray meets, given for a row of rays at once.
///
/// `shade` writes the radiance towards the camera of the places that it is given: [`Hit::interpolate`] tells what is there.
///
/// # Errors
/// If the raster is empty or beyond its range, or `shade` fails.
pub fn render_hits(
    bvh: &Bvh,
    camera: &Camera,
    raster: &Raster,
    shade: &ShadeHits,
    background: &(dyn Fn(Vec3) -> Vec3 + Sync),
) -> Result<Image> {
    raster.check()?;
    let offsets = tent_samples(raster.samples);
    let mut image = Image {
        width: raster.width,
        height: raster.height,
        pixels: vec![[0.0; 3]; raster.width * raster.height],
    };
    let rows = image.pixels.par_chunks_mut(raster.width).enumerate();
    rows.try_for_each_init(Row::default, |row, (y, pixels)| -> Result<()> {
        row.clear();
        for x in 0..raster.width {
            let centre = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            for &offset in &offsets {
                let ray = camera.ray(centre + offset, raster.width, raster.height);
                row.push(bvh.closest(&ray), || background(ray.direction));
            }
        }
        row.shade(shade)?;
        for (pixel, seen) in pixels.iter_mut().zip(row.radiance.chunks_exact(offsets.len())) {
            *pixel = (seen.iter().sum::<Vec3>() / offsets.len() as f32).to_array();
        }
        Ok(())
    })?;
    Ok(image)
}

/// What the rays of a row of pixels see.
#[derive(Default)]
struct Row {
    hits: Vec<Hit>,
    /// Of each hit, its ray.
    rays: Vec<usize>,
    of_hits: Vec<Vec3>,
    /// Of each ray.
    radiance: Vec<Vec3>,
}

impl Row {
    fn clear(&mut self) {
        self.hits.clear();
        self.rays.clear();
        self.radiance.clear();
    }

    fn push(&mut self, hit: Option<Hit>, background: impl FnOnce() -> Vec3) {
        match hit {
            Some(hit) => {
                self.hits.push(hit);
                self.rays.push(self.radiance.len());
                self.radiance.push(Vec3::ZERO);
            }
            None => self.radiance.push(background()),
        }
    }

    fn shade(&mut self, shade: &ShadeHits) -> Result<()> {
        self.of_hits.clear();
        self.of_hits.resize(self.hits.len(), Vec3::ZERO);
        shade(&self.hits, &mut self.of_hits)?;
        for (&ray, &radiance) in self.rays.iter().zip(&self.of_hits) {
            self.radiance[ray] = radiance;
        }
        Ok(())
    }
}

/// Points around the middle of a pixel whose density is the tent of radius 1: (1 − |x|) (1 − |y|).
fn tent_samples(count: usize) -> Vec<Vec2> {
    (0..count as u32)
        .map(|k| {
            let along = (k as f32 + 0.5) / count as f32;
            // Centred in its cell as the first coordinate is, so that the mean is the middle.
            let across =
                k.reverse_bits() as f32 / 2.0_f32.powi(32) + 0.5 / (count as f32).log2().ceil().exp2();
            Vec2::new(tent_quantile(along), tent_quantile(across))
        })
        .collect()
}

/// Inverse of the tent's cumulative distribution.
fn tent_quantile(u: f32) -> f32 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 * (1.0 - u)).max(0.0).sqrt() }
}

/// A background for pictures without one: a quiet vertical gradient around `level`, darker below.
pub fn backdrop(level: f32) -> impl Fn(Vec3) -> Vec3 + Sync {
    move |direction| {
        let height = 0.5 + 0.5 * direction.y;
        level * Vec3::new(0.9, 0.97, 1.05).lerp(Vec3::ONE, height) * (0.55 + 0.9 * height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::View;

    /// A unit square in the plane z = 0, one lighting point a corner.
    fn square() -> (LightingPoints, Bvh) {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        let triangles = vec![[0, 1, 2], [0, 2, 3]];
        let bvh = Bvh::build(&positions, &triangles);
        let points =
            LightingPoints { normals: vec![Vec3::Z; 4], positions, triangles, ..LightingPoints::default() };
        (points, bvh)
    }

    fn front() -> View {
        View { azimuth: 0.0, elevation: 0.0, field_of_view: 0.5 }
    }

    #[test]
    fn radiance_that_is_linear_in_position_is_linear_in_the_picture() {
        let (points, bvh) = square();
        let radiance: Vec<Vec3> = points.positions.iter().map(|p| Vec3::new(p.x, p.y, 1.0)).collect();
        let camera = Camera::fit(&points.positions, &front(), 1.0, 0.0).unwrap();
        let raster = Raster { width: 64, height: 64, samples: 16 };
        let image = render(&points, &bvh, &radiance, &camera, &raster, &|_| Vec3::ZERO).unwrap();
        // Away from the edge; the sample points' mean is within 0.03 pixels of the middle.
        for row in 1..63 {
            for column in 1..63 {
                let [x, y, one] = image.pixels[row * 64 + column];
                let expected = [(column as f32 + 0.5) / 64.0, 1.0 - (row as f32 + 0.5) / 64.0];
                assert!(
                    (x - expected[0]).abs() <= 1e-3 && (y - expected[1]).abs() <= 1e-3,
                    "{column}, {row}"
                );
                assert!((one - 1.0).abs() <= 1e-5);
            }
        }
    }

    #[test]
    fn both_sides_are_seen_and_what_is_missed_shows_the_background() {
        let (points, bvh) = square();
        let radiance = vec![Vec3::ONE; 4];
        let raster = Raster { width: 9, height: 9, samples: 4 };
        for azimuth in [0.0, std::f32::consts::PI] {
            let view = View { azimuth, ..front() };
            let camera = Camera::orbit(&points.positions, &view, 8.0).unwrap();
            let image = render(&points, &bvh, &radiance, &camera, &raster, &|d| d).unwrap();
            assert!((image.pixels[40][0] - 1.0).abs() <= 1e-6);
            let away = Vec3::from(image.pixels[0]);
            assert!((away.normalize() - camera.ray(Vec2::splat(0.5), 9, 9).direction).length() <= 0.02);
        }
    }

    #[test]
    fn false_colours_fill_the_surface_and_leave_the_background() {
        let (points, bvh) = square();
        let camera = Camera::orbit(&points.positions, &front(), 8.0).unwrap();
        let raster = Raster { width: 9, height: 9, samples: 4 };
        let colours = Colours::Signed { full: 2.0 };
        let image =
            render_in(colours, &points, &bvh, &[-Vec3::ONE; 4], &camera, &raster, &|_| Vec3::ONE).unwrap();
        assert_eq!(image.pixels[40], colours.of(-Vec3::ONE).to_array());
        assert_eq!(image.pixels[0], [1.0; 3]);
    }

    #[test]
    fn an_edge_across_a_pixel_gives_the_tents_share() {
        let (points, bvh) = square();
        // The middle column's centre looks along the square's left edge: half of the tent sees the square.
        let view = front();
        let camera =
            Camera::orbit(&[Vec3::new(0.0, 0.5, 0.0), Vec3::new(0.0, 0.5, 1e-3)], &view, 2000.0).unwrap();
        let raster = Raster { width: 33, height: 33, samples: 64 };
        let image = render(&points, &bvh, &[Vec3::ONE; 4], &camera, &raster, &|_| Vec3::ZERO).unwrap();
        assert!(
            (image.pixels[16 * 33 + 16][0] - 0.5).abs() <= 1.0 / 64.0,
            "{:?}",
            image.pixels[16 * 33 + 16]
        );
    }

    #[test]
    fn samples_have_the_tents_mean_and_variance() {
        for count in [1, 4, 16, 64, 256] {
            let samples = tent_samples(count);
            let mean: Vec2 = samples.iter().sum::<Vec2>() / count as f32;
            assert!(mean.abs().max_element() <= 1e-5, "{count}: {mean}");
            // 1/6 by integration; midpoints of strata fall short of it in proportion to their width.
            let variance: Vec2 = samples.iter().map(|s| s * s).sum::<Vec2>() / count as f32;
            assert!(
                (variance - 1.0 / 6.0).abs().max_element() <= 1.0 / 6.0 / count as f32,
                "{count}: {variance}"
            );
        }
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bytes() {
        let (points, bvh) = square();
        let radiance: Vec<Vec3> = points.positions.iter().map(|p| p + 0.1).collect();
        let camera = Camera::fit(&points.positions, &View::default(), 1.5, 0.1).unwrap();
        let raster = Raster { width: 60, height: 40, samples: 5 };
        let draw = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| render(&points, &bvh, &radiance, &camera, &raster, &backdrop(1.0)).unwrap())
        };
        assert_eq!(draw(1), draw(3));
    }

    #[test]
    fn what_cannot_be_rendered_is_refused() {
        let (points, bvh) = square();
        let camera = Camera::fit(&points.positions, &front(), 1.0, 0.0).unwrap();
        let draw = |count: usize, raster: Raster| {
            render(&points, &bvh, &vec![Vec3::ONE; count], &camera, &raster, &|_| Vec3::ZERO).is_err()
        };
        let small = Raster { width: 2, height: 2, samples: 1 };
        assert!(!draw(4, small));
        assert!(draw(3, small));
        assert!(draw(4, Raster { width: 0, ..small }));
        assert!(draw(4, Raster { width: usize::MAX, ..small }));
        assert!(draw(4, Raster { samples: 0, ..small }));
    }
}
