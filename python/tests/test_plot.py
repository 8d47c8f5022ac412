"""Figures: what they show is what was asked for; how they look is seen by eye."""

from __future__ import annotations

import base64
import io
import warnings

import numpy as np
import pytest

import ylm

pyplot = pytest.importorskip("matplotlib.pyplot")
import ylm.plot  # noqa: E402


@pytest.fixture(scope="module")
def room() -> ylm.Baked:
    return ylm.bake(ylm.Mesh.demo("room"), bands=4, transfer="unshadowed")


@pytest.fixture(autouse=True)
def closed_figures():
    yield
    pyplot.close("all")


def test_a_sphere_map_shows_the_function_where_it_is():
    axes = ylm.plot.sphere_map(ylm.zonal.rotate(ylm.zonal.phong(40, 8), [0, 1, 0]), height=20)
    values = np.asarray(axes.images[0].get_array())
    assert values.shape == (20, 40) and values.argmax() // 40 == 0
    coloured = ylm.plot.sphere_map(ylm.light("disc?dir=0,1,0&angle=10", 4), height=20)
    # A light of few bands rings: magenta.
    assert (np.asarray(coloured.images[0].get_array()) == (255, 0, 255)).all(axis=-1).any()
    with pytest.raises(ValueError, match=r"coeffs has shape \(2, 9\); expected \(n²,\), or \(3, n²\)"):
        ylm.plot.sphere_map(np.zeros((2, 9)))


def test_coefficients_stand_by_band_and_order():
    coeffs = np.arange(9.0)
    shown = ylm.plot.coefficients(coeffs).images[0].get_array()
    assert shown[0, 2] == 0 and shown[1, 1:4].tolist() == [1, 2, 3] and shown[2].tolist() == [4, 5, 6, 7, 8]
    assert shown.mask[0, 0] and shown.mask[1, 4]
    with pytest.raises(ValueError, match=r"coeffs has shape \(3, 9\); expected \(n²,\)"):
        ylm.plot.coefficients(np.zeros((3, 9)))


def test_band_energies_are_drawn_for_each_function():
    lines = ylm.plot.band_energies(np.eye(9)[[0, 3]]).lines
    assert [np.nanargmax(line.get_ydata()) for line in lines] == [0, 1]


def test_a_mesh_shows_its_radiance_and_what_is_negative(room):
    radiance = np.full((len(room.positions), 3), 0.5)
    shown = np.asarray(ylm.plot.mesh(room, radiance, size=(20, 15), samples=1).images[0].get_array())
    assert (shown[7, 10] == 255).all()
    radiance[:] = -1
    shown = np.asarray(ylm.plot.mesh(room, radiance, size=(20, 15), samples=1).images[0].get_array())
    assert shown[7, 10].tolist() == [255, 0, 255]


def test_stages_of_a_frame_are_counted_in_the_legend(room):
    frame = room.shade_adaptive("sky:clear?sun=40,60", room.eye(), thresholds=(0.05, 0.05))
    legend = ylm.plot.stages(room, frame.diffuse, size=(20, 15), samples=1).get_legend()
    counts = {text.get_text() for text in legend.get_texts()}
    assert counts == {f"{stage} ({count})" for stage in ylm.STAGES if (count := frame.diffuse.count_of(stage))}
    with pytest.raises(ValueError, match="of one frame"):
        both = room.shade_adaptive(np.zeros((2, 3, 16)), room.eye())
        ylm.plot.stages(room, both.diffuse)


def test_scenes_show_themselves_in_notebooks(room):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        page = room._repr_html_()
    assert page.count("<tr>") == len(room._facts()) and "data:image/png;base64," in page
    assert "unshadowed, 4 bands" in repr(room)


def picture_of(page: str) -> np.ndarray:
    """The thumbnail of a page."""
    png = base64.b64decode(page.split("base64,", 1)[1].split('"', 1)[0])
    return pyplot.imread(io.BytesIO(png), format="png")[..., :3]


def test_lights_and_stages_show_themselves_in_notebooks():
    page = ylm.Light("disc?dir=0,1,0&angle=20")._repr_html_()
    picture = picture_of(page)
    assert picture.shape == (90, 180, 3) and (picture[2] == 1).all() and (picture[40:] == 0).all()
    assert "far away" in page and "disc?dir=0,1,0&amp;angle=20" in page
    plate = ylm.Mesh([[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]], [[0, 1, 2], [0, 2, 3]])
    baked = ylm.bake(plate, bands=2, rays=16, visibility=True)
    page = ylm.Stage([ylm.Actor(baked, name="a <plate>")], "sky:overcast")._repr_html_()
    assert "a &lt;plate&gt;" in page and picture_of(page).shape == (180, 240, 3)
