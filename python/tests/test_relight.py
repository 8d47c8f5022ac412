"""Shading beyond one dot product: the command line's pictures, rays, and identities."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import ylm

TARGET = Path(os.environ.get("CARGO_TARGET_DIR", Path(__file__).parents[2] / "target"))
PROGRAM = TARGET / "debug" / "ylm"
SIZE = (48, 36)


def run(*arguments):
    assert PROGRAM.is_file(), f"{PROGRAM} is not there: make python builds it"
    subprocess.run([PROGRAM, "-q", *map(str, arguments)], check=True)


@pytest.fixture(scope="module")
def room() -> ylm.Baked:
    return ylm.bake(ylm.Mesh.demo("room"), bands=5, transfer="interreflected", bounces=1, rays=64, visibility=True, keep_bounces=True)


@pytest.fixture(scope="module")
def room_file(room, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("room") / "room.baked"
    room.save(path)
    return path


SKY = "sky:clear?sun=35,100"
LAMP = "sky:overcast+sphere?pos=0.5,1,2&radius=0.3&intensity=8"
EYE = {"diffuse": 0.7, "specular": 0.3, "shininess": 30}
GLOSS = ["--diffuse", "0.7", "--specular", "0.3", "--shininess", "30"]
BALL = [0.4, 0.6, 1.5, 0.35]
BALLS = ["--ball", ",".join(map(str, BALL))]
WAYS = {
    "diffuse": (SKY, [], lambda b: b.shade(SKY)),
    "window": (SKY, ["--window", "hann:5"], lambda b: b.shade(SKY, window=("hann", 5))),
    "lamp": (LAMP, [], lambda b: b.shade(LAMP)),
    "samples": (
        LAMP,
        ["--light-blend", "volume", "--light-samples", "8"],
        lambda b: b.shade(LAMP, blend="volume", samples=8),
    ),
    "glossy": (SKY, ["--shading", "glossy", *GLOSS], lambda b: b.shade_glossy(SKY, b.eye(), **EYE)),
    "adaptive": (
        SKY,
        ["--shading", "adaptive", *GLOSS, "--thresholds", "0.02,0.05"],
        lambda b: b.shade_adaptive(SKY, b.eye(), **EYE, thresholds=(0.02, 0.05)).radiance,
    ),
    "foreseen": (
        SKY,
        ["--shading", "adaptive", *GLOSS, "--stages", "foreseen"],
        lambda b: b.shade_adaptive(SKY, b.eye(), **EYE, stages="foreseen").radiance,
    ),
    "psnr": (
        SKY,
        ["--shading", "adaptive", *GLOSS, "--psnr", "40"],
        lambda b: b.shade_adaptive(SKY, b.eye(), **EYE, psnr=40).radiance,
    ),
    "brdf": (SKY, ["--brdf", "ward:0.2,0.5"], lambda b: b.shade_brdf(SKY, b.eye(), "ward:0.2,0.5")),
    "brdf under a lamp": (
        LAMP,
        ["--brdf", "ggx:0.4,0.5", "--product-window", "hann:6"],
        lambda b: b.shade_brdf(LAMP, b.eye(), "ggx:0.4,0.5", product_window=("hann", 6)),
    ),
    "reference": (SKY, ["--shading", "reference", "--rays", "32"], lambda b: b.reference(SKY, 32).radiance),
    "glossy reference": (
        SKY,
        ["--shading", "reference", "--rays", "32", *GLOSS],
        lambda b: b.reference(SKY, 32, eye=b.eye(), material=tuple(EYE.values())).radiance,
    ),
    "brdf reference": (
        SKY,
        ["--shading", "reference", "--rays", "32", "--brdf", "phong:12"],
        lambda b: b.reference(SKY, 32, eye=b.eye(), material="phong:12").radiance,
    ),
}


def assert_same_pictures(drawn, path):
    """Bit by bit, but where bands ring: what is negative, no picture's reader leaves as it is."""
    expected, positive = ylm.read_image(path, repair=True), (drawn >= 0).all(axis=-1)
    assert np.array_equal(drawn[positive], expected[positive])
    assert positive.mean() > 0.7 and expected.max() > 0


@pytest.mark.parametrize("way", WAYS)
def test_shading_is_that_of_the_command_line(way, room, room_file, tmp_path):
    light, options, shade = WAYS[way]
    picture = tmp_path / "picture.exr"
    size = ["--size", f"{SIZE[0]}x{SIZE[1]}", "--samples", "2", "--background", "black"]
    run("render", room_file, "--light", light, "-o", picture, *size, *options)
    assert_same_pictures(room.render(shade(room), SIZE, samples=2), picture)


def test_a_ball_overhead_takes_its_disc_of_the_sky():
    corners = [[0, 0, 0], [-3, 0, 3], [3, 0, 3], [3, 0, -3], [-3, 0, -3]]
    plate = ylm.bake(ylm.Mesh(corners, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]]), bands=8, transfer="unshadowed")
    ball = [0, 2, 0, 1]
    # A disc of half-angle a takes sin² a of the irradiance of a sky of one radiance.
    under = plate.shade("white", balls=[ball])[0]
    # What eight bands of the cosine leave: measured 3e-4.
    assert np.abs(under - 0.75).max() <= 1e-3
    judged = plate.reference("white", 4096, balls=[ball])
    assert np.abs(judged.radiance[0] - 0.75).max() <= 5 * judged.standard_error.max() + 2e-3


def test_the_shadow_of_a_ball_seen_from_the_object_is_that_of_the_dimmed_light(room):
    shadowed = room.shade(SKY, balls=[BALL], ball_shadow="object")
    low, high = room.positions.min(axis=0), room.positions.max(axis=0)
    dimmed = ylm.dim(ylm.light(SKY, 5), [BALL], (low + high) / 2)
    assert np.abs(room.shade(dimmed) - shadowed).max() <= 1e-6 * shadowed.max()
    assert (room.shade(SKY) - shadowed).sum() > 0
    # A lamp behind the ball is dimmed, one before it is not.
    lamp = "sphere?pos=0.4,0.6,{}&radius=0.1"
    for depth, is_dimmed in [(2.5, True), (0.2, False)]:
        open_light, behind = room.shade(lamp.format(depth)), room.shade(lamp.format(depth), balls=[BALL], ball_shadow="object")
        assert np.array_equal(open_light, behind) != is_dimmed


def test_pictures_of_pixels_are_those_of_the_command_line(room, room_file, tmp_path):
    picture = tmp_path / "picture.exr"
    size = ["--size", f"{SIZE[0]}x{SIZE[1]}", "--samples", "2", "--background", "black"]
    run("render", room_file, "--light", LAMP, "-o", picture, *size, "--shading", "per-pixel", *GLOSS)
    drawn = ylm.render_per_pixel(room, LAMP, SIZE, samples=2, **EYE)
    assert_same_pictures(drawn, picture)
    # Without visibility, a mesh as it is: an open plate under white light shows its albedo.
    plate = ylm.Mesh([[-9, 0, 9], [9, 0, 9], [9, 0, -9], [-9, 0, -9]], [[0, 1, 2], [0, 2, 3]], albedo=[0.2, 0.4, 0.6])
    shown = ylm.render_per_pixel(plate, "white", (9, 7), diffuse=1, specular=0, distance=0.5, samples=1)
    assert np.abs(shown[3, 4] - [0.2, 0.4, 0.6]).max() <= 1e-5


def test_frames_of_adaptive_shading_are_independent_and_tell_what_was_done(room):
    lights = np.stack([ylm.light(f"sky:clear?sun={elevation},60", 5) for elevation in (20, 50)])
    eyes = np.array([room.eye(), room.eye(azimuth=0.1)])
    frames = room.shade_adaptive(lights, eyes, thresholds=(0.05, 0.05), **EYE)
    assert frames.radiance.shape == (2, len(room.positions), 3)
    alone = room.shade_adaptive(lights[1], eyes[1], thresholds=(0.05, 0.05), **EYE)
    assert np.array_equal(alone.radiance, frames.radiance[1])
    assert np.array_equal(alone.specular.bands, frames.specular.bands[1])
    assert sum(frames.diffuse.count_of(stage) for stage in ylm.STAGES) == 2 * len(room.positions)
    assert 0 < frames.diffuse.filtered_share(5) <= 1
    assert frames.diffuse.bands.dtype == np.uint8 and frames.diffuse.bands.max() <= 5
    full = room.shade_adaptive(lights, eyes, thresholds=(0, 0), **EYE)
    expected = np.stack([room.shade_glossy(light, eye, **EYE) for light, eye in zip(lights, eyes)])
    # Emission is no part of adaptive frames' regions only if it is of shade_glossy's.
    assert np.abs(full.radiance - expected).max() <= 1e-5 * expected.max()
    wanted = room.shade_adaptive(lights[0], eyes[0], psnr=50, **EYE)
    rmse = np.sqrt(((wanted.radiance - full.radiance[0]).astype(np.float64) ** 2).mean())
    assert 20 * np.log10(1 / rmse) >= 49.9
    assert wanted.thresholds[0] > 0


def test_materials_reflect_what_their_formulas_say(room):
    lambert = ylm.Brdf("lambert")
    assert lambert.is_grey and lambert.is_isotropic and not ylm.Brdf("ward:0.1,0.4").is_isotropic
    light, view = [0.6, 0.0, 0.8], [[-0.6, 0, 0.8], [0, 0, 1], [0, 0, -1]]
    phong = ylm.Brdf("phong:10").value(light, view)
    assert np.allclose(phong[:, 0], [12 / (2 * np.pi), 12 / (2 * np.pi) * 0.8**10, 0], rtol=1e-12)
    # A Lambertian material is a diffuse surface of albedo 1, but for bands of the cosine.
    coeffs = ylm.light(SKY, 5)
    by_material = room.shade_brdf(coeffs, room.eye(), lambert)
    batch = room.shade_brdf(np.stack([coeffs, 2 * coeffs]), room.eye(), lambert)
    assert np.array_equal(batch[0], by_material)
    white = room.only_bounce(0)
    by_transfer = (white.transfer @ coeffs.T) / np.pi
    # Products of visibility and cosine, each of five bands, against their product's five bands: measured 10 %.
    assert np.linalg.norm(by_material - by_transfer) <= 0.15 * np.linalg.norm(by_transfer)
    projected = ylm.Brdf("phong:10").project([0.6, 0, 0.8], 6)
    assert projected.shape == (1, 36)
    directions, weights = ylm.sphere_grid(200)
    values = ylm.Brdf("phong:10").value(directions, [0.6, 0, 0.8])[:, 0] * np.maximum(directions[:, 2], 0)
    expected = ylm.project_values(values * weights, directions, 6)
    # Measured 1e-6.
    assert np.abs(projected[0] - expected).max() <= 1e-5 * np.abs(expected).max()


def test_what_a_surface_receives_is_the_same_by_every_packing_of_few_bands(random):
    light, visibility = np.zeros((2, 3, 81), np.float32)
    light[:, :4], visibility[:, :4] = random.normal(size=(2, 3, 4))
    expected = ylm.AxialProduct.clamped_cosine(9).in_frame(ylm.product(light, visibility))
    for packing in ("apart", "with-light", "with-visibility"):
        found = ylm.receive(light, visibility, packing)
        # Of two bands each: in the first bands nothing is cut between two products. Measured 1e-7.
        assert np.abs(found - expected)[:, :25].max() <= 2e-6 * np.abs(expected).max()
    assert np.array_equal(ylm.receive(light, visibility), ylm.receive(light, visibility, "apart"))
    cut = ylm.receive(light, cosine_bands=3)
    kernel = np.zeros(9)
    kernel[:3] = ylm.zonal.clamped_cosine(3)
    assert np.allclose(cut, ylm.zonal.product(light, kernel.astype(np.float32)), atol=1e-5)


def test_cheap_forms_are_what_their_documentation_says(room):
    light = ylm.light(SKY, 5)
    linear = ylm.linear_irradiance(light)
    normals = np.concatenate([room.normals, np.ones((len(room.normals), 1), np.float32)], axis=1)
    assert np.allclose(room.shade_linear(light), room.albedo / np.pi * (normals @ linear.T), atol=1e-4)
    grey = room.shade_monochrome(light)
    # What its walls colour of one bounce: measured 0.3 %.
    assert np.linalg.norm(grey - room.shade(light)) <= 0.01 * np.linalg.norm(grey)
    direct = room.only_bounce(0)
    assert np.abs(direct.shade_monochrome(light) - direct.shade(light)).max() <= 1e-5 * direct.shade(light).max()
    shares = room.visible_shares(256)
    # The mean of transfer is the same share by 64 rays, this one is by 256 others: measured 0.009.
    assert np.abs(room.transfer[:, 0] * np.sqrt(4 * np.pi) / np.pi - shares).mean() <= 0.02
    part = room.only_points(0, 24)
    assert np.array_equal(part.transfer, room.transfer[:24])


def octahedron(size: float = 0.4) -> ylm.Mesh:
    corners = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]]) * size
    faces = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    return ylm.Mesh(corners, faces)


@pytest.fixture(scope="module")
def flying() -> tuple[ylm.Baked, ylm.Field]:
    mesh = octahedron()
    return ylm.bake(mesh, bands=4, rays=64, visibility=True), ylm.bake_field(mesh, bands=4, error=0.05)


def test_a_field_blocks_the_solid_angle_of_its_object(flying):
    _, field = flying
    assert field.radius == pytest.approx(0.4, rel=1e-4) and np.abs(field.center).max() <= 1e-6
    places = np.array([[0, 0, 1.5], [0.9, 0.6, -0.5], [0, 0, 2 * field.reach]])
    blocked = field.blocked(places)
    # The directions that meet the octahedron, by rays of numpy's own.
    directions, weights = ylm.sphere_grid(120)
    along = np.linspace(0, 4, 400)
    for place, coeffs in zip(places[:2], blocked):
        inside = (np.abs(place + along[:, None, None] * directions).sum(axis=-1) <= 0.4).any(axis=0)
        expected = ylm.project_values(inside * weights, directions, 4)
        # The field's own error, as a root mean square over directions; measured 0.041 and 0.031.
        assert np.linalg.norm(coeffs - expected) <= 0.05 * np.sqrt(4 * np.pi)
    assert not blocked[2].any()
    assert field.record["error_outside"] <= 0.05


def test_fields_and_scenes_are_the_bytes_of_the_command_line(tmp_path):
    model = tmp_path / "block.obj"
    mesh = octahedron()
    lines = [f"v {x} {y} {z}" for x, y, z in mesh.positions.tolist()] + [f"f {a} {b} {c}" for a, b, c in (mesh.triangles + 1).tolist()]
    model.write_text("\n".join(lines) + "\n")
    run("field", model, "-o", tmp_path / "command.field", "--bands", "3", "--error", "0.1")
    ylm.bake_field(model, bands=3, error=0.1).save(tmp_path / "python.field")
    assert (tmp_path / "python.field").read_bytes() == (tmp_path / "command.field").read_bytes()
    again = ylm.load_field(tmp_path / "command.field")
    assert np.array_equal(again.blocked([0, 1, 0]), ylm.load_field(tmp_path / "python.field").blocked([0, 1, 0]))
    scene = {
        "format": "scene", "format_version": 1, "bands": 3, "rays": 32, "field_error": 0.1, "light": SKY, "seconds": 2,
        "objects": [
            {"model": "block.obj", "motion": [{"time": 0, "position": [-1, 0.6, 0]}, {"time": 2, "position": [1, 0.6, 0]}]},
            {"model": "block.obj", "name": "other", "position": [0, 0.5, 1], "spin": {"period": 2}},
        ],
        "ground": {"size": 5, "cells": 6},
    }  # fmt: skip
    one, two = tmp_path / "one", tmp_path / "two"
    for folder in (one, two):
        folder.mkdir()
        (folder / "block.obj").write_bytes(model.read_bytes())
        (folder / "scene.json").write_text(json.dumps(scene))
    run("scene", one / "scene.json")
    stage = ylm.load_stage(two / "scene.json", bake_missing=True)
    assert {path.name for path in two.iterdir()} == {path.name for path in one.iterdir()}
    for path in one.iterdir():
        assert path.read_bytes() == (two / path.name).read_bytes(), path.name
    size = ["--size", f"{SIZE[0]}x{SIZE[1]}", "--samples", "2", "--background", "black", "--time", "0.5", "--camera", "20,30,3"]
    for shading, product in [("field-exact", "exact"), ("field-chain", "chain"), ("shexp", "exponential")]:
        picture = tmp_path / f"{shading}.exr"
        run("render", one / "scene.json", "-o", picture, "--shading", shading, *size)
        frame = stage.shade(0.5, product)
        # The command's camera looks at the time that is shown, this one at all times: the radiance is what is compared.
        shown = ylm.read_image(picture)
        assert frame.radiance.shape[0] == len(stage.surface(0.5).positions)
        low, high = frame.radiance.min(), frame.radiance.max()
        assert low - 1e-5 <= shown[shown > 0].min() and shown.max() <= high + 1e-5
    assert stage.names == ["block", "other", "ground"] and stage.seconds == 2
    # What moves at a time of the animation.
    assert np.allclose(stage.poses(1.0)[0][0], [0, 0.6, 0])


def test_stages_made_in_code_are_those_of_files_and_near_what_rays_say(flying):
    baked, field = flying
    turned = ylm.Turn.from_axis_angle([0, 1, 0], 0.3)
    actors = [
        ylm.Actor(baked, field, position=(0, 0.8, 0), rotation=turned, albedo=(0.9, 0.2, 0.2)),
        ylm.Actor(baked, None, position=(1.2, 0.6, 0), scale=0.5, spin=((0, 1, 0), 4), name="small"),
    ]
    stage = ylm.Stage(actors, "sky:overcast", ground=ylm.Ground(4, cells=10))
    frame = stage.shade(0.25)
    assert [len(part) for part in frame.by_object] == [len(baked.positions)] * 2 + [121]
    assert np.array_equal(np.concatenate(frame.by_object), frame.radiance)
    assert frame.pair_count > 0 and frame.thread_seconds >= frame.product_seconds > 0
    judged = stage.reference(0.25, 256)
    error = np.linalg.norm(frame.radiance - judged.radiance) / np.linalg.norm(judged.radiance)
    # The object without a field hides nothing from others here, and of the rest four bands are left: measured 3.3 %.
    assert error <= 0.05
    # One occluder is one product by every way; balls in its place are off by 6 %.
    for product, most in [("chain", 1e-6), ("sparse-chain", 1e-6), ("exponential", 0.1)]:
        other = stage.shade(0.25, product).radiance
        assert np.linalg.norm(other - frame.radiance) <= most * np.linalg.norm(frame.radiance)
    multiplied = stage.shade(0.25, apart="multiplied").radiance
    assert 0 < np.linalg.norm(multiplied - frame.radiance) <= 0.05 * np.linalg.norm(frame.radiance)
    surface = stage.surface(0.25)
    assert np.allclose(surface.positions[: len(baked.positions)], turned.apply(baked.positions) + [0, 0.8, 0], atol=1e-5)
    assert stage.lit_by("white").shade(0.25).radiance.max() <= 1.3
    assert stage.render(frame.radiance, 0.25, (16, 12), samples=1).shape == (12, 16, 3)
    assert stage.times(4).tolist() == [0, 0.25, 0.5, 0.75]


def test_materials_of_stages_are_those_of_bakes_and_near_what_rays_say(flying):
    baked, field = flying
    glossy = ylm.Actor(baked, field, position=(0, 0.6, 0), material=ylm.Brdf("phong:6"))
    stage = ylm.Stage([glossy], SKY, ground=ylm.Ground(4, cells=10, material="lambert"))
    eye = stage.eye()
    frame = stage.shade(0, eye=eye)
    # Alone and unmoved it is the baked scene, whose albedo of 1 a material does not know.
    alone = ylm.Stage([ylm.Actor(baked, material="phong:6")], SKY).shade(0, eye=[2, 1, 3]).radiance
    expected = baked.shade_brdf(SKY, [2, 1, 3], "phong:6")
    assert np.abs(alone - expected).max() <= 1e-5 * np.abs(expected).max()
    # A Lambertian ground is a diffuse one: measured 6e-8.
    diffuse = ylm.Stage([glossy], SKY, ground=ylm.Ground(4, cells=10)).shade(0, eye=eye)
    assert np.linalg.norm(frame.by_object[1] - diffuse.by_object[1]) <= 1e-6 * np.linalg.norm(diffuse.by_object[1])
    blurred = stage.lit_by(ylm.light(SKY, 4))
    judged = blurred.reference(0, 256, eye=eye)
    assert judged.noise < 0.02
    error = np.linalg.norm(blurred.shade(0, eye=eye).radiance - judged.radiance) / np.linalg.norm(judged.radiance)
    # Four bands of visibility and material: measured 2.6 %, 0.8 % of it noise.
    assert error <= 0.05


def test_balls_cover_what_they_stand_for():
    mesh = ylm.Mesh.demo()
    balls = ylm.sphere_set(mesh, 12)
    assert balls.shape == (12, 4)
    away = np.linalg.norm(mesh.positions[:, None] - balls[:, :3], axis=-1) - balls[:, 3]
    assert away.min(axis=1).max() <= 1e-4
    center, radius = ylm.enclosing_sphere(mesh.positions)
    assert np.linalg.norm(mesh.positions - center, axis=1).max() <= radius * (1 + 1e-5)
    seen = ylm.cap_visibility([0, 1, 0], 0.5, 5)
    assert seen[0] / np.sqrt(4 * np.pi) == pytest.approx(1 - (1 - np.cos(0.5)) / 2, rel=1e-12)


def test_the_window_for_points_leaves_none_negative(room):
    light = ylm.light("disc?dir=0,1,0.2&angle=4", 5)
    direct = room.only_bounce(0)
    radius = direct.least_nonnegative_radius(light)
    assert 0 < radius < 1
    mean = direct.shade(light).clip(0).mean()
    assert direct.shade(light, window=("poisson", radius)).min() >= -2e-6 * mean
    assert direct.least_nonnegative_radius("white") == 1.0


def test_work_of_rays_can_be_watched_and_stopped(flying):
    baked, _ = flying
    told = []
    baked.reference("sky:overcast", 16, progress=lambda *now: told.append(now))
    assert told[-1] == ("reference", len(baked.positions), len(baked.positions))
    with pytest.raises(ylm.Cancelled):
        ylm.bake(ylm.Mesh.demo(), bands=2, rays=16).reference("sky:overcast", 1 << 20, progress=lambda *now: False)
    with pytest.raises(ylm.Cancelled):
        ylm.bake_field(ylm.Mesh.demo(), bands=8, error=1e-3, progress=lambda stage, done, count: False)


def test_faults_of_shading_name_what_is_wrong(room, flying, tmp_path):
    baked, field = flying
    open_room = ylm.bake(ylm.Mesh.demo("room"), bands=2, transfer="unshadowed")
    eye = room.eye()
    refused = [
        (lambda: room.shade(SKY, balls=[[0, 0, 0]]), r"balls has shape \(1, 3\); expected \(\.\.\., 4\)"),
        (lambda: room.shade(SKY, balls=[[0, 0, 0, -1]]), "the radius must be positive"),
        (lambda: room.shade(SKY, balls=[BALL], ball_shadow="pixel"), 'ball_shadow is "pixel"; expected vertex or object'),
        (lambda: room.shade(LAMP, blend="nearest"), 'blend is "nearest"; expected exact, inverse:P, proxy or volume'),
        (lambda: room.shade(SKY, window=("blackman", 3)), 'kind is "blackman"'),
        (lambda: room.shade_glossy(LAMP, eye), "stands somewhere; glossy shading"),
        (lambda: room.shade_glossy(SKY, [0, 1]), r"eye has shape \(2,\); expected \(3,\)"),
        (lambda: room.shade_adaptive(SKY, eye, stages="magic"), 'stages is "magic"; expected paper, filter, steady or foreseen'),
        (lambda: room.shade_adaptive(SKY, eye, thresholds=(-1, 0)), "threshold of -1"),
        (lambda: room.shade_adaptive(SKY, eye, base_bands=0), "0 base bands"),
        (lambda: room.shade_adaptive(np.zeros((2, 3, 25)), np.zeros((3, 3))), r"leading axes do not go together: light \(2,\), eye \(3,\)"),
        (lambda: open_room.shade_brdf(SKY, eye, "lambert"), "the scene has no visibility"),
        (lambda: ylm.Brdf("mirror:1"), 'no BRDF "mirror:1"'),
        (lambda: room.reference(SKY, eye=eye), "eye and material go together"),
        (lambda: room.reference(LAMP), "no reference with bounces"),
        (lambda: room.shade_monochrome(SKY, np.zeros((3, 3))), r"has shape \(3, 3\); expected"),
        (lambda: room.only_points(5, 2), "points 5 to 2 asked for"),
        (lambda: ylm.receive(np.zeros(4), packing="apart"), "open if and only if there is no visibility"),
        (lambda: ylm.dim(np.zeros((3, 4)), [[0, 0, 0, 1]], [0, 1]), r"point has shape \(2,\); expected \(3,\)"),
        (lambda: ylm.render_per_pixel(room, SKY, bands=6), "6 bands asked for; the visibility that was baked has 5"),
        (lambda: ylm.bake_field(octahedron(), error=0.7), "it must be from 0.0001 to below 0.5"),
        (lambda: ylm.bake_field(octahedron(), bands=0), "bands is 0"),
        (lambda: field.blocked([[np.nan, 0, 0]]), "it must be finite"),
        (lambda: ylm.Stage([], SKY), "there are no objects"),
        (lambda: ylm.Stage([ylm.Actor(open_room)], SKY), "object 1 has no visibility; bake it with visibility=True"),
        (lambda: ylm.Stage([ylm.Actor(baked), ylm.Actor(room)], SKY), "the baked of object 2 has 5 bands; expected 4"),
        (lambda: ylm.Stage([ylm.Actor(baked, scale=0)], SKY), "its scale is 0; it must be positive"),
        (
            lambda: ylm.Stage([ylm.Actor(baked, motion=[(1, (0, 0, 0), (0, 0, 0, 1))] * 2)], SKY),
            "time 1 comes after 1; times must rise",
        ),
        (lambda: ylm.Stage([ylm.Actor(baked)], SKY).shade(np.inf), "time is inf"),
        (lambda: ylm.Stage([ylm.Actor(baked, material="ggx:0.4")], SKY).shade(0), "1 has a material.*give an eye"),
        (lambda: ylm.Stage([ylm.Actor(baked, material="mirror")], SKY), 'no BRDF "mirror"'),
        (lambda: ylm.Stage([ylm.Actor(baked)], SKY).shade(0, apart="left"), 'apart is "left"; expected added or multiplied'),
        (lambda: ylm.Stage([ylm.Actor(baked)], SKY).shade(0, "sum"), 'product is "sum"; expected exact, chain'),
    ]
    for call, message in refused:
        with pytest.raises(ValueError, match=message):
            call()
    broken = tmp_path / "broken.binary"
    broken.write_bytes(b"\0" * 12)
    with pytest.raises(ylm.FileError, match="it has 12 bytes"):
        ylm.Brdf(broken)
    with pytest.raises(FileNotFoundError, match="absent.field"):
        ylm.load_field("absent.field")
    with pytest.raises(FileNotFoundError, match="absent.json"):
        ylm.load_stage("absent.json")
    with pytest.raises(ylm.FileError, match="test_relight.py"):
        ylm.load_field(__file__)
    with pytest.raises(ylm.FileError):
        ylm.load_stage(__file__)


def test_other_threads_run_while_a_reference_is_traced(flying):
    import threading

    done = threading.Event()
    worker = threading.Thread(target=lambda: (flying[0].reference("sky:overcast", 4096), done.set()))
    steps = 0
    worker.start()
    while not done.is_set():
        steps += 1
    worker.join()
    assert steps > 1000
