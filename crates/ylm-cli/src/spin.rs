//! A turntable: numbered pictures of the model as it spins before a camera and a light that stand still.

use std::path::{Path, PathBuf};

use glam::{Quat, Vec3};
use serde_json::{Value, json};

/// A frame of the turntable.
pub struct Turn {
    /// What turns the camera and the light around the model, to the same picture as a turned model.
    pub rotation: Quat,
    /// The picture of the frame.
    pub output: PathBuf,
}

/// `FRAMES` turns of 360° in all about the world's y axis, the first not turned: `name.png` becomes `name-0001.png` and so on.
///
/// The model turns from +z towards +x, as azimuths do.
pub fn turns(frame_count: u32, output: &Path) -> Vec<Turn> {
    let frames = (0..frame_count).zip(numbered(frame_count, output));
    let angle = |frame: u32| std::f32::consts::TAU * frame as f32 / frame_count as f32;
    frames.map(|(frame, output)| Turn { rotation: Quat::from_rotation_y(-angle(frame)), output }).collect()
}

/// The names of the pictures of an animation: `name.png` becomes `name-0001.png` and so on.
pub fn numbered(frame_count: u32, output: &Path) -> Vec<PathBuf> {
    let digits = frame_count.to_string().len().max(4);
    let stem = output.file_stem().unwrap_or_default().to_os_string();
    (0..frame_count)
        .map(|frame| {
            let mut name = stem.clone();
            name.push(format!("-{:0digits$}", frame + 1));
            if let Some(extension) = output.extension() {
                name.push(".");
                name.push(extension);
            }
            output.with_file_name(name)
        })
        .collect()
}

/// What is measured over the frames.
#[derive(Default)]
pub struct Measures {
    shade_seconds: Vec<f64>,
    render_seconds: Vec<f64>,
    last: Option<[Vec<Vec3>; 2]>,
    jump: f32,
    excess: f32,
    has_full: bool,
    /// Of adaptive pictures: what `--coherence` says.
    pub coherence: Option<f32>,
}

impl Measures {
    /// Takes a frame: its radiance as displayed, and that of the full calculation where it is another.
    pub fn take(
        &mut self,
        shade_seconds: f64,
        render_seconds: f64,
        shown: Vec<Vec3>,
        full: Option<Vec<Vec3>>,
    ) {
        self.shade_seconds.push(shade_seconds);
        self.render_seconds.push(render_seconds);
        self.has_full = full.is_some();
        let full = full.unwrap_or_else(|| shown.clone());
        if let Some([last_shown, last_full]) = &self.last {
            for point in 0..shown.len() {
                let jump = (shown[point] - last_shown[point]).abs().max_element();
                let own = (full[point] - last_full[point]).abs().max_element();
                self.jump = self.jump.max(jump);
                self.excess = self.excess.max(jump - own);
            }
        }
        self.last = Some([shown, full]);
    }

    /// One line.
    pub fn text(&self) -> String {
        let excess = if self.has_full {
            format!(", {:.2}/255 above the full calculation's own", 255.0 * self.excess)
        } else {
            String::new()
        };
        format!(
            "{} frames; shading {:.2} ms, drawing {:.1} ms (median); from frame to frame a point changes by at most {:.2}/255{excess}",
            self.shade_seconds.len(),
            1e3 * median(&self.shade_seconds),
            1e3 * median(&self.render_seconds),
            255.0 * self.jump,
        )
    }

    /// For `--json`.
    pub fn value(&self) -> Value {
        let times = |seconds: &[f64]| {
            let slowest = seconds.iter().copied().fold(0.0, f64::max);
            json!({ "median": median(seconds), "slowest": slowest })
        };
        json!({
            "frames": self.shade_seconds.len(), "shade_seconds": times(&self.shade_seconds),
            "render_seconds": times(&self.render_seconds), "largest_change": self.jump,
            "excess_over_full": self.has_full.then_some(self.excess), "coherence": self.coherence,
        })
    }
}

fn median(seconds: &[f64]) -> f64 {
    let mut sorted = seconds.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_numbered_and_turn_once_around() {
        let turns = turns(4, Path::new("out/spin.x.png"));
        let names: Vec<_> = turns.iter().map(|turn| turn.output.to_str().unwrap()).collect();
        assert_eq!(names, [1, 2, 3, 4].map(|k| format!("out/spin.x-000{k}.png")));
        // The camera goes round the other way: what the model turns towards +x, it meets from there.
        assert!((turns[1].rotation * Vec3::X - Vec3::Z).length() <= 1e-6);
        assert_eq!(turns[0].rotation, Quat::IDENTITY);
    }

    #[test]
    fn jumps_are_measured_against_the_full_calculations_own() {
        let mut measures = Measures::default();
        let frame = |value: f32| vec![Vec3::ZERO, Vec3::new(0.0, value, 0.0)];
        measures.take(0.1, 1.0, frame(0.5), Some(frame(0.5)));
        measures.take(0.3, 1.0, frame(0.75), Some(frame(0.625)));
        measures.take(0.2, 1.0, frame(0.625), Some(frame(0.625)));
        assert_eq!((measures.jump, measures.excess), (0.25, 0.125));
        assert_eq!(measures.value()["shade_seconds"]["median"], 0.2);
        assert!(measures.text().contains("31.88/255 above"), "{}", measures.text());
    }
}
