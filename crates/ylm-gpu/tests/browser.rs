//! The kernels run by a browser through WebGPU, where a Chromium is installed: what they write is what their twins write.

#[path = "../../../testdata/browser.rs"]
mod browser;
mod by_twin;
mod scenes;

use browser::Buffer;
use by_twin::{by_diffuse, by_lobe, by_received, by_unshadowed};
use scenes::{balls, bands, light, room};
use serde_json::{Value, json};
use ylm_gpu::{Access, Frame, Kernel, PackedScene, pack};
use ylm_prt::shade::GlossyMaterial;
use ylm_prt::transfer::{Baked, TransferKind};

/// A kernel's run in the browser, and what its twin writes.
struct Run {
    kernel: Kernel,
    job: Value,
    expected: Vec<f32>,
}

impl Run {
    /// `given` are the buffers that are read, `before` is what the last one holds before the run.
    fn new(kernel: Kernel, frame: &Frame, given: &[&[f32]], before: &[f32], expected: Vec<f32>) -> Self {
        let mut buffers = vec![Buffer::uniform(bytemuck::cast_slice(&[*frame]))];
        buffers.extend(given.iter().map(|numbers| Buffer::numbers(numbers)));
        buffers.push(Buffer::numbers(before));
        let (last, read) = kernel.bindings()[1..].split_last().unwrap();
        assert!(read.len() == given.len() && last.access == Access::Write);
        let job = browser::compute(kernel.source(), &buffers, kernel.workgroups(frame));
        Self { kernel, job, expected }
    }

    /// Fails unless the numbers are the twin's; gives the largest difference over the largest number.
    fn check(&self, found: &[f32]) -> f32 {
        let name = self.kernel.name();
        assert_eq!(found.len(), self.expected.len(), "{name}");
        let largest = self.expected.iter().fold(0.0f32, |largest, value| largest.max(value.abs()));
        assert!(largest > 0.05 && found.iter().all(|value| value.is_finite()), "{name}");
        let pairs = found.iter().zip(&self.expected);
        let error = pairs.fold(0.0f32, |most, (a, b)| most.max((a - b).abs())) / largest;
        // Where a GPU fuses what the twin rounds twice, and its own inverse square root: 2 units in the last place.
        assert!(error <= 4e-6, "{name}: {error:e}");
        error
    }
}

/// Every kernel on a scene.
fn runs(baked: &Baked) -> Vec<Run> {
    let scene = PackedScene::new(baked);
    let (light, material) = (light(scene.bands), GlossyMaterial::default());
    let frame = Frame { eye: [3.0, 1.0, 2.0], diffuse: material.diffuse, ..scene.frame(light.bands) };
    let coeffs = pack::light(&light, scene.bands);
    let [coeffs, recurrence] = [bytemuck::cast_slice(&coeffs), bytemuck::cast_slice(&scene.recurrence)];
    let [surfaces, places] = [bytemuck::cast_slice(&scene.surfaces), bytemuck::cast_slice(&scene.places)];
    let cosine = pack::clamped_cosine(scene.bands);
    let (matrix, lobe) = (pack::matrix(&light, scene.bands), pack::lobe(&material, scene.bands).unwrap());
    let bounced = scene.bounced.as_deref().unwrap_or(&[0.0]);

    let black = vec![0.0; 3 * scene.point_count];
    let diffuse = by_diffuse(&scene, &frame, &light);
    let received = by_received(&scene, &frame, &light);
    let mut glossy = diffuse.clone();
    by_lobe(&scene, &frame, &material, &received, &mut glossy);
    let open = by_unshadowed(&scene, &frame, &light);
    let run = |kernel, given: &[&[f32]], before: &[f32], expected| {
        Run::new(kernel, &frame, given, before, expected)
    };
    vec![
        run(Kernel::Diffuse, &[coeffs, &scene.transfer, bounced, surfaces], &black, diffuse.clone()),
        run(Kernel::Unshadowed, &[recurrence, &cosine, coeffs, places, surfaces], &black, open),
        run(
            Kernel::Received,
            &[&matrix.unwrap(), &scene.transfer],
            &vec![0.0; received.len()],
            received.clone(),
        ),
        run(Kernel::Lobe, &[recurrence, &lobe, places, &received], &diffuse, glossy),
    ]
}

#[test]
fn a_browser_runs_every_kernel_to_the_numbers_of_its_twin() {
    let scenes =
        [room(bands(4)), balls(bands(1), TransferKind::Shadowed), balls(bands(9), TransferKind::Shadowed)];
    let runs: Vec<Run> = scenes.iter().flat_map(runs).collect();
    let jobs = json!({ "wgsl": runs.iter().map(|run| run.job.clone()).collect::<Vec<_>>() });
    let Some(results) = browser::run(&jobs) else { return };
    let Some(results) = results["wgsl"].as_array() else { return };
    assert_eq!(results.len(), runs.len());
    let errors = runs.iter().zip(results).map(|(run, result)| run.check(&browser::numbers(result)));
    println!("the largest difference is {:e}", errors.fold(0.0, f32::max));
}
