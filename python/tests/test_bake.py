"""Lights, meshes, bakes, relighting, pictures, files."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import ylm

TARGET = Path(os.environ.get("CARGO_TARGET_DIR", Path(__file__).parents[2] / "target"))


def box(size: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """A box around the origin whose sides do not share vertices."""
    positions, triangles = [], []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            u, v = np.roll(np.eye(3), 0, 0)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
            n = np.cross(u, v) * sign
            corners = [n - u - v, n + u - v, n + u + v, n - u + v]
            start = len(positions)
            order = [0, 1, 2, 3] if sign > 0 else [0, 3, 2, 1]
            positions += [size * corners[k] for k in order]
            triangles += [[start, start + 1, start + 2], [start, start + 2, start + 3]]
    return np.array(positions), np.array(triangles)


@pytest.fixture(scope="module")
def room() -> ylm.Baked:
    return ylm.bake(ylm.Mesh.demo("room"), bands=4, transfer="interreflected", bounces=2, rays=64, keep_bounces=True)


@pytest.fixture(scope="module")
def scene_file(tmp_path_factory) -> Path:
    """An OBJ of a box on a plate."""
    path = tmp_path_factory.mktemp("scene") / "box.obj"
    positions, triangles = box(0.5)
    plate = np.array([[-2, -0.5, 2], [2, -0.5, 2], [2, -0.5, -2], [-2, -0.5, -2]])
    lines = [f"v {x} {y} {z}" for x, y, z in np.concatenate([positions, plate]).tolist()]
    corners = np.concatenate([triangles, 24 + np.array([[0, 1, 2], [0, 2, 3]])]) + 1
    lines += [f"f {a} {b} {c}" for a, b, c in corners.tolist()]
    path.write_text("\n".join(lines) + "\n")
    return path


def test_an_open_box_under_white_light_shows_its_albedo():
    positions, triangles = box()
    mesh = ylm.Mesh(positions, triangles, albedo=[0.25, 0.5, 0.75])
    baked = ylm.bake(mesh, bands=5, rays=256)
    radiance = baked.shade(np.sqrt(4 * np.pi) * np.eye(25)[0])
    assert radiance.dtype == np.float32 and radiance.shape == (24, 3)
    # A convex body blocks nothing of itself: the shadowed transfer is the unshadowed one to rounding.
    assert np.abs(radiance - [0.25, 0.5, 0.75]).max() <= 1e-5
    open_transfer = ylm.zonal.rotate(ylm.zonal.clamped_cosine(5), baked.normals.astype(np.float64))
    assert np.abs(baked.transfer - open_transfer).max() <= 1e-5


def test_arrays_of_a_scene_are_views_that_nobody_changes(room):
    transfer = room.transfer
    assert transfer.__array_interface__["data"] == room.transfer.__array_interface__["data"]
    for array in [room.positions, room.normals, room.albedo, room.triangles, transfer, room.emission, *room.bounced]:
        assert not array.flags.owndata and not array.flags.writeable
        with pytest.raises(ValueError):
            array.flags.writeable = True
    # The view keeps the scene alive.
    kept = ylm.bake(ylm.Mesh(*box()), bands=3, transfer="unshadowed").transfer
    assert np.isfinite(kept).all() and kept.shape == (24, 9)


def test_shading_is_the_sum_that_the_documentation_says(room, random):
    light = random.normal(size=(2, 3, 16)).astype(np.float32)
    found = room.shade(light)
    received = np.einsum("pi,kci->kpc", room.transfer, light, dtype=np.float64)
    for layer in room.bounced:
        received += np.einsum("pci,kci->kpc", layer, light, dtype=np.float64)
    for layer in room.emitted:
        received += layer
    expected = room.albedo / np.pi * received + room.emission
    assert found.shape == (2, len(room.positions), 3)
    # n² roundings of float32, of sums of this size.
    assert np.abs(found - expected).max() <= 16 * 6e-8 * 10 * np.abs(expected).max()
    assert np.array_equal(found[1], room.shade(light[1]))
    parts = sum(room.only_bounce(bounce).shade(light[0]).astype(np.float64) for bounce in range(3))
    assert np.abs(parts - expected[0]).max() <= 1e-5 * np.abs(expected).max()
    assert room.bounce_energies.shape == (2, 3) and (room.bounce_energies > 0).all()


def test_the_same_seed_gives_the_same_bytes_for_any_number_of_threads(scene_file, tmp_path):
    one, two = tmp_path / "one", tmp_path / "two"
    ylm.bake(scene_file, bands=4, rays=100, seed=7, threads=1).save(one)
    ylm.bake(scene_file, bands=4, rays=100, seed=7, threads=3).save(two)
    assert one.read_bytes() == two.read_bytes()


@pytest.mark.parametrize("half", [False, True])
def test_bakes_and_lights_are_the_bytes_of_the_command_line(scene_file, tmp_path, half):
    program = TARGET / "debug" / "ylm"
    assert program.is_file(), f"{program} is not there: make python builds it"
    by_command, by_python = tmp_path / "command", tmp_path / "python"
    options = ["--bands", "4", "--rays", "100", "--seed", "3", "--blocker", scene_file, "--tmax", "5"]
    options += ["--half"] if half else []
    subprocess.run([program, "-q", "bake", scene_file, "-o", by_command, *options], check=True)
    baked = ylm.bake(scene_file, bands=4, rays=100, seed=3, blockers=[scene_file], t_max=5)
    baked.save(by_python, half=half)
    assert by_python.read_bytes() == by_command.read_bytes()
    words = "sky:clear?sun=30,120+disc?dir=0,1,1&angle=5"
    subprocess.run([program, "-q", "light", words, "--bands", "6", "-o", tmp_path / "light.json"], check=True)
    assert np.array_equal(ylm.light(tmp_path / "light.json", 6), ylm.light(words, 6))


def test_scenes_come_back_as_they_were_saved(room, tmp_path):
    path = tmp_path / "room.safetensors"
    room.save(path)
    again = ylm.load(path)
    assert np.array_equal(again.transfer, room.transfer)
    assert np.array_equal(again.bounced, room.bounced)
    assert again.record == room.record
    again.save(path)
    assert np.array_equal(ylm.load(path).transfer, room.transfer)


def test_pictures_show_the_radiance_of_the_surface(room):
    picture = room.render(np.full((len(room.positions), 3), 0.25), (40, 30), samples=4, background=(0, 0, 1))
    assert picture.shape == (30, 40, 3) and picture.dtype == np.float32
    assert np.allclose(picture[15, 20], 0.25)
    assert np.array_equal(picture[0, 0], [0, 0, 1])
    sky = ylm.Light("sky:overcast")
    assert (room.render(room.shade(sky), (8, 6), samples=1, background=sky)[0, 0] > 0).all()
    glossy = room.shade_glossy(sky, room.eye(), diffuse=0.0, specular=1.0)
    assert glossy.shape == (len(room.positions), 3) and np.isfinite(glossy).all()


def test_reprs_tell_what_is_there(room):
    text = repr(room)
    assert "interreflected, 4 bands, 64 rays a point" in text and f"{len(room.positions)}, " in text
    page = room._repr_html_()
    assert page.count("data:image/png;base64,") == 1 and "interreflected" in page
    assert repr(ylm.Mesh(*box())) == "<ylm.Mesh of 24 positions and 12 triangles>"
    assert repr(ylm.Light("white")) == "<ylm.Light white>"


def test_lights_add_scale_and_turn(directions):
    sun, sky = ylm.Light("disc?dir=0,0,1&angle=20"), ylm.Light("sky:overcast")
    both = (2 * sun + sky * [1, 0.5, 0]).project(5)
    expected = 2 * ylm.light(sun, 5) + ylm.light(sky, 5) * np.array([[1], [0.5], [0]])
    assert np.abs(both - expected).max() <= 2e-6
    turn = ylm.Turn.from_axis_angle([1, 2, 3], 1.0)
    turned = sun.rotated(turn)
    assert np.abs(turned.project(5) - ylm.rotate(sun.project(5), turn)).max() <= 2e-6
    inside = turn.apply([0.1, 0, 1])
    assert np.array_equal(turned.radiance(inside), [1, 1, 1])
    assert np.array_equal(sun.radiance(directions).shape, directions.shape)
    lamp = ylm.Light("sphere?pos=0,2,0&radius=0.5")
    assert lamp.is_local and not sun.is_local
    # A sphere of radiance 1 that fills sin² = (r/d)² of the hemisphere.
    plate = ylm.Mesh([[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]], [[0, 1, 2], [0, 2, 3]])
    baked = ylm.bake(plate, bands=20, transfer="unshadowed")
    distance = math.sqrt(6)
    expected = (0.5 / distance) ** 2 * 2 / distance
    # What 20 bands make of the lamp: measured 0.3 %.
    assert np.abs(baked.shade(lamp) / expected - 1).max() <= 0.01


def test_a_callback_watches_and_stops_a_bake():
    told = []
    mesh = ylm.Mesh.demo("room")
    ylm.bake(mesh, bands=4, transfer="interreflected", bounces=1, rays=64, progress=lambda *a: told.append(a))
    assert told[-1][1] == told[-1][2] > 0
    assert all(0 <= done <= count for _, done, count in told)
    scene = ylm.Mesh.demo()
    with pytest.raises(ylm.Cancelled, match="progress callback"):
        ylm.bake(scene, bands=12, rays=1 << 20, progress=lambda stage, done, count: False)

    def fail(stage, done, count):
        raise ZeroDivisionError(stage)

    with pytest.raises(ZeroDivisionError, match="direct"):
        ylm.bake(scene, bands=12, rays=1 << 20, progress=fail)


def test_ctrl_c_stops_a_bake():
    """A bake of hours, interrupted as a terminal does it."""
    sent = []

    def interrupt():
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.2, interrupt)
    # What is started in the background of a shell ignores it.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            ylm.bake(ylm.Mesh.demo(), bands=12, rays=1 << 20)
        timer.join()
    finally:
        signal.signal(signal.SIGINT, before)
    assert sent


REFUSED = [
    (lambda: ylm.load("absent.safetensors"), FileNotFoundError, "absent.safetensors"),
    (lambda: ylm.load(__file__), ylm.FileError, "test_bake.py: "),
    (lambda: ylm.Mesh.open("absent.ply"), FileNotFoundError, "absent.ply"),
    (lambda: ylm.Mesh.open(__file__), ylm.FileError, "must be PLY, OBJ, STL, glTF or GLB"),
    (lambda: ylm.read_image("absent.hdr"), FileNotFoundError, "absent.hdr"),
    (lambda: ylm.Light("absent.hdr"), FileNotFoundError, "absent.hdr"),
    (lambda: ylm.save_light("/absent/light.json", np.zeros(4)), OSError, "there is no folder"),
    (lambda: ylm.Light("moonshine"), FileNotFoundError, "No such file or directory: 'moonshine'"),
    (lambda: ylm.Light("disc?angle=5&dir=0,0,0"), ValueError, "dir"),
    (lambda: ylm.bake(ylm.Mesh(*box()), transfer="glossy"), ValueError, "expected one of unshadowed, shadowed, interreflected"),
    (lambda: ylm.bake(ylm.Mesh(*box()), rays="many"), ValueError, "expected a number, preview, medium, final"),
    (lambda: ylm.bake(ylm.Mesh(*box()), rays=0), ValueError, "ray"),
    (lambda: ylm.bake(ylm.Mesh(*box()), bands=300), ValueError, "300 bands asked for"),
    (lambda: ylm.bake(ylm.Mesh(*box()), bias=-1), ValueError, "bias"),
    (lambda: ylm.bake(ylm.Mesh(*box()), transfer="unshadowed", t_max=3), ValueError, "no effect"),
    (lambda: ylm.bake(ylm.Mesh(*box()), seed=-1), ValueError, "seed is -1"),
    (lambda: ylm.Mesh(*box()[:1], [[0, 1, 24]]), ValueError, "triangles name position 24; there are 24"),
    (lambda: ylm.Mesh(*box()[:1], [[0, 1, -1]]), ValueError, "triangles name position -1"),
    (lambda: ylm.Mesh(*box()[:1], [[0.0, 1, 2]]), TypeError, "expected whole numbers"),
    (lambda: ylm.Mesh(box()[0] * np.nan, box()[1]), ValueError, "row 0 of positions is .*must be finite"),
    (lambda: ylm.Mesh(*box(), albedo=[2, 0, 0]), ValueError, "each must be 0 to 1"),
    (lambda: ylm.Mesh(*box(), normals=np.ones((3, 3))), ValueError, r"normals has shape \(3, 3\); expected \(24, 3\)"),
    (lambda: ylm.bake(ylm.Mesh(np.zeros((3, 3)), [[0, 1, 2]])), ValueError, "nothing to light"),
    (lambda: ylm.develop(np.zeros((2, 2))), ValueError, r"\(height, width, 3\)"),
    (lambda: ylm.save_image("picture.gif", np.zeros((2, 2, 3))), ValueError, "as .exr or .png"),
]


@pytest.mark.parametrize("call, error, message", REFUSED)
def test_faults_name_what_is_wrong_and_where(call, error, message):
    with pytest.raises(error, match=message):
        call()
    assert issubclass(ylm.FileError, OSError)


def test_faults_of_relighting(room):
    with pytest.raises(ValueError, match=r"light has shape \(2, 9\); expected \(\.\.\., 3, n²\)"):
        room.shade(np.zeros((2, 9)))
    with pytest.raises(ValueError, match="must be finite"):
        room.shade(np.full(9, np.inf))
    with pytest.raises(ValueError, match="3 is not there"):
        room.only_bounce(3)
    with pytest.raises(ValueError, match="radiance has shape"):
        room.render(np.zeros((2, 3)))
    with pytest.raises(ValueError, match="samples a pixel"):
        room.render(room.shade(np.zeros(4)), (4, 4), samples=0)
    with pytest.raises(ValueError, match="specular"):
        room.shade_glossy(np.zeros(4), room.eye(), specular=-1)
    with pytest.raises(OSError, match="there is no folder"):
        room.save("/absent/room.safetensors")


def test_real_meshes_and_probes_light_up(shared_data):
    light = ylm.light(shared_data / "probes" / "grace_ict_latlong_256.hdr", 4)
    assert light.shape == (3, 16) and (light[:, 0] > 0).all()
    meshes = sorted((shared_data / "meshes").glob("*.ply"), key=lambda path: path.stat().st_size)
    baked = ylm.bake(meshes[0], bands=4, rays=64)
    assert np.isfinite(baked.shade(light)).all()
